//! Where things go on the table (in progress).
