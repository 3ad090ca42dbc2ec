//! Commands of the program.

mod commands;
mod edits;
mod executions;
mod batch;
mod backups;
mod deployment;
mod telemetry;
