//! Commands of the program.

mod commands;
mod edits;
mod backups;
mod deployment;
mod telemetry;
