//! Files that are damaged or hostile.

mod hostile_files;
