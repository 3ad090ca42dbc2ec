"""Tests, measurements and independent judges of tabletopgen."""
