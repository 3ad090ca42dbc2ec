"""The server, and the private PostgreSQL and S3 servers beside it."""
