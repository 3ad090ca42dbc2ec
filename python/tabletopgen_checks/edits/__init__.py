"""Edits of scenes: commands, and whether the edited scene is what the command says."""
