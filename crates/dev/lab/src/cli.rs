//! Command line of `tabletopgen-lab`.
//!
//! Results go to standard output, progress and errors to standard error. Exit codes are those of `tabletopgen`.

pub mod mock_vendors;
pub mod evaluate;
pub mod grasp_categories;
pub mod grasp_trials;
pub mod parse;
pub mod pick_place;
pub mod repeat_motion;
pub mod synthesize;
pub mod split;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Benchmarks tabletopgen, synthesizes training images, describes texts, and mocks the remote models.
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
    /// Synthesize table images with ground truth, to train and to evaluate image readers.
    Synthesize(synthesize::Arguments),
    /// Describe texts with the embedded parser, one JSON document per text, without building scenes.
    Parse(parse::Arguments),
    /// Make pick-and-place motion problems in the scene of a bundle and plan them, one JSON document per motion.
    PickPlace(pick_place::Arguments),
    /// Try to grasp the typical object of each category of the catalog, one JSON document per category.
    GraspCategories(grasp_categories::Arguments),
    /// Try grasps of the objects in the scene of a bundle, one JSON document per object.
    GraspTrials(grasp_trials::Arguments),
    /// Step the world of an execution along its recorded motion, for timing.
    RepeatMotion(repeat_motion::Arguments),
    /// Serve the protocols of all remote models with the embedded adapters, for use without keys.
    MockVendors(mock_vendors::Arguments),
}

/// Parses the process's arguments, runs the command, and reports the outcome.
pub fn main() -> ExitCode {
    tabletopgen::cli::run(Cli::try_parse(), |cli| match cli.command {
        Command::Evaluate(arguments) => evaluate::run(arguments),
        Command::Synthesize(arguments) => synthesize::run(arguments),
        Command::Parse(arguments) => parse::run(arguments),
        Command::PickPlace(arguments) => pick_place::run(arguments),
        Command::GraspCategories(arguments) => grasp_categories::run(arguments),
        Command::GraspTrials(arguments) => grasp_trials::run(arguments),
        Command::RepeatMotion(arguments) => repeat_motion::run(arguments),
        Command::MockVendors(arguments) => mock_vendors::run(arguments),
    })
}
