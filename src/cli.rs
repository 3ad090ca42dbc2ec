//! The command line: what a person types, thin over [`crate::app`].
//!
//! Results go to standard output, progress and complaints to standard error. Exit codes are in
//! [`exit`].

pub mod exit;
pub mod options;
pub mod terminal;
pub mod signals;
pub mod generate;
pub mod evaluate;
pub mod paint_pictures;
pub mod split;
pub mod progress;
pub mod folder;
pub mod outcome;
pub mod certificate;
pub mod serve;
pub mod dev_providers;
pub mod migrate;
pub mod check_config;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

pub use exit::{Exit, Failure};

/// Turns a sentence or one picture into a tabletop scene a robot can be trained in.
#[derive(Debug, Parser)]
#[command(name = "tabletopgen", version, about, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make one scene here and now, without a server.
    Generate(generate::Arguments),
    /// Run a benchmark set and write its tables.
    Evaluate(evaluate::Arguments),
    /// Paint pictures of tables with the truth about them, to train and to judge readers of pictures.
    PaintPictures(paint_pictures::Arguments),
    /// Run the job server.
    Serve(serve::Arguments),
    /// Answer for all remote models, in their protocols, with the embedded adapters: for trying things without keys.
    DevProviders(dev_providers::Arguments),
    /// Bring a data directory's database up to date; `serve` does so by itself.
    Migrate(migrate::Arguments),
    /// Print every setting with its value and where that came from, or what is wrong with them.
    CheckConfig(check_config::Arguments),
}

/// Parses the process's arguments, does what they say, and says how it went.
pub fn main() -> ExitCode {
    let command = match Cli::try_parse() {
        Ok(cli) => cli.command,
        Err(error) => {
            // Help and version go to standard output, complaints to standard error.
            let code = if error.use_stderr() { Exit::Usage } else { Exit::Success };
            let _ = error.print();
            return code.into();
        }
    };
    let done = match command {
        Command::Generate(arguments) => generate::run(arguments),
        Command::Evaluate(arguments) => evaluate::run(arguments),
        Command::PaintPictures(arguments) => paint_pictures::run(arguments),
        Command::Serve(arguments) => serve::run(arguments),
        Command::DevProviders(arguments) => dev_providers::run(arguments),
        Command::Migrate(arguments) => migrate::run(arguments),
        Command::CheckConfig(arguments) => check_config::run(arguments),
    };
    match done {
        Ok(exit) => exit.into(),
        Err(failure) => {
            terminal::complain(&failure.to_string());
            failure.exit.into()
        }
    }
}

/// The runtime everything that waits runs on. Its threads only wait: computation has its own pool.
fn runtime() -> Result<tokio::runtime::Runtime, Failure> {
    tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .map_err(|error| Failure::new(Exit::Error, format!("cannot start the runtime: {error}")))
}
