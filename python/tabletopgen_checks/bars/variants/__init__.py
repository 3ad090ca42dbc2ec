"""Variants: what they must keep, and how much they differ."""
