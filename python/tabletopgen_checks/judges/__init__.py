"""The independent programs of tests/judges: their environments, and how they are asked."""
