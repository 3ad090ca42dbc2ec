//! Datasets are written and read back.
