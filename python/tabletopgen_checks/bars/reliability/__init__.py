"""What the service guarantees while processes die, networks break and disks fill, on SQLite and on PostgreSQL with
S3.
"""
