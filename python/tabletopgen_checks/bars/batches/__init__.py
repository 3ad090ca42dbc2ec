"""A thousand scenes in one batch, and the dataset that is frozen of them."""

DEPENDS_ON = (
    "crates/batches", "crates/datasets", "crates/embedded", "crates/physics", "crates/store", "src/cli/batch",
    "src/cli/batch.rs", "src/freezer", "src/freezer.rs", "src/pipeline", "src/pipeline.rs", "src/worker",
    "src/worker.rs",
)
