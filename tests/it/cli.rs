//! Commands of the program.

mod commands;
