"""What the service guarantees while processes die, networks break and disks fill, on SQLite and on PostgreSQL with
S3.
"""

DEPENDS_ON = (
    "crates/models/http_client", "crates/models/remote", "crates/server/store", "migrations", "src/api", "src/api.rs",
    "src/background.rs", "src/executor.rs", "src/freezer", "src/freezer.rs", "src/pipeline.rs", "src/pipeline/checkpoint",
    "src/pipeline/checkpoint.rs", "src/recorder", "src/recorder.rs", "src/service", "src/service.rs",
    "src/worker", "src/worker.rs",
)
