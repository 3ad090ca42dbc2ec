//! Layout from a top view (in progress).
