//! Paths between configurations that touch nothing.
