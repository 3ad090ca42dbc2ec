"""Finished scenes: made by the program, read from their bundles, and measured."""
