"""An expected failure of a program of this package."""


class Problem(Exception):
    """What went wrong and what to do about it, in words for the person who started the program."""
