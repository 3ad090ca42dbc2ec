//! Commands of the program.

mod commands;
mod edits;
mod batch;
mod backups;
mod deployment;
mod telemetry;
