"""Texts, what the parser should make of them, and whether a scene is as its text says."""
