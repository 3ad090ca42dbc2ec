//! Commands of the program.

mod commands;
mod backups;
mod deployment;
mod telemetry;
