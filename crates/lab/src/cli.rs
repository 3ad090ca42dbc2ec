//! The command line of `tabletopgen-lab`.
//!
//! Results go to standard output, progress and complaints to standard error. Exit codes are those of `tabletopgen`.

pub mod dev_providers;
pub mod evaluate;
pub mod paint_pictures;
pub mod split;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Measures tabletopgen, paints synthetic images for training, and stands in for the remote models.
#[derive(Debug, Parser)]
#[command(name = "tabletopgen-lab", version, about, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a benchmark set and write its tables.
    Evaluate(evaluate::Arguments),
    /// Paint pictures of tables with the truth about them, to train and to judge readers of pictures.
    PaintPictures(paint_pictures::Arguments),
    /// Answer for all remote models, in their protocols, with the embedded adapters: for trying things without keys.
    DevProviders(dev_providers::Arguments),
}

/// Parses the process's arguments, runs the command, and reports the outcome.
pub fn main() -> ExitCode {
    tabletopgen::cli::run(Cli::try_parse(), |cli| match cli.command {
        Command::Evaluate(arguments) => evaluate::run(arguments),
        Command::PaintPictures(arguments) => paint_pictures::run(arguments),
        Command::DevProviders(arguments) => dev_providers::run(arguments),
    })
}
