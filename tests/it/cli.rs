//! Commands of the program.

mod commands;
mod batch;
mod backups;
mod deployment;
mod telemetry;
