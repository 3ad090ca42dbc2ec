"""Reference values of tests/golden, computed by the reference implementations."""
