"""A thousand scenes in one batch, and the dataset that is frozen of them."""

DEPENDS_ON = (
    "crates/data/batches", "crates/data/datasets", "crates/models/embedded", "crates/method/physics",
    "crates/server/store", "src/cli/batch", "src/cli/batch.rs", "src/freezer", "src/freezer.rs", "src/pipeline",
    "src/pipeline.rs", "src/worker", "src/worker.rs",
)
