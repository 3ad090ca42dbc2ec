//! The objects that a phrase means.
