//! The upright pose of a raw mesh (in progress).
