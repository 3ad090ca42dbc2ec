//! Commands of the program.

mod commands;
mod doctor;
mod outputs;
mod own_categories;
mod messages;
mod edits;
mod episodes;
mod evaluations;
mod executions;
mod foreground;
mod keys;
mod signals;
mod batch;
mod backups;
mod tenants;
mod private_data;
mod deployment;
mod telemetry;
