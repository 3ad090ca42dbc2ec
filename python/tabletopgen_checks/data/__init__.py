"""Datasets of episodes, judged by the programs that read them."""
