"""The asynchronous client, which is written by hand."""
