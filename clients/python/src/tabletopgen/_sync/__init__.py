"""The blocking client, which generate.py writes from the asynchronous one."""
