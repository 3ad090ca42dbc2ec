//! The command line: what a person types, thin over [`crate::app`].
//!
//! Results go to standard output, progress and complaints to standard error. Exit codes are in
//! [`exit`].

pub mod exit;
pub mod options;
mod place;
pub mod number;
pub mod terminal;
pub mod signals;
pub mod foreground;
pub mod local_job;
pub mod generate;
pub mod bundle_input;
pub mod input_file;
pub mod edit;
pub mod variants;
pub mod tasks;
pub mod execute;
pub mod episodes;
pub mod regenerate_episode;
pub mod judge;
pub mod diff;
pub mod batch;
pub mod parse;
pub mod progress;
pub mod counting;
pub mod output;
pub mod scene_summary;
pub mod certificate;
pub mod text_account;
pub mod dataset;
mod private_mode;
pub mod serve;
pub mod worker;
pub mod queue;
pub mod tenants;
pub mod duration;
pub mod keys;
pub mod audit;
pub mod migrate;
pub mod backup;
pub mod restore;
pub mod sweep;
pub mod check_config;

use std::process::ExitCode;
use std::time::Duration;

use clap::{Parser, Subcommand};

pub use exit::{Exit, Failure};

/// Turns a sentence or one image into a tabletop scene a robot can be trained in.
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
    /// Make a scene from a finished one, by operations or by an instruction in words.
    Edit(edit::Arguments),
    /// Make scenes from a finished one that differ in layout, meshes, colors, light and more.
    Variants(variants::Arguments),
    /// Propose tasks for a robot in a finished scene, or read one from an instruction.
    Tasks(tasks::Arguments),
    /// Let a simulated robot do a task in a finished scene.
    Execute(execute::Arguments),
    /// Record many demonstrations of tasks as a dataset that policies are trained on.
    Episodes(Box<episodes::Arguments>),
    /// Make an episode of a dataset again from its record, and compare it.
    RegenerateEpisode(regenerate_episode::Arguments),
    /// Decide whether a task is done in poses that another simulator reports.
    Judge(judge::Arguments),
    /// Show what differs between the scenes of two bundles.
    Diff(diff::Arguments),
    /// Make many scenes from one file of requests or from a recipe, without a server.
    Batch(batch::Arguments),
    /// Show what a text is understood as, without making a scene.
    Parse(parse::Arguments),
    /// Freeze finished scenes as a dataset, verify it, print its statistics.
    Dataset(dataset::Arguments),
    /// Run the job server.
    Serve(serve::Arguments),
    /// Take jobs from a shared database, without the HTTP interface.
    Worker(worker::Arguments),
    /// Show the queue, or pause and resume the claiming of jobs.
    Queue(queue::Arguments),
    /// Show the limits of tenants and what is used of them, or give one limits of its own.
    Tenants(tenants::Arguments),
    /// Make, list and revoke the keys of clients, also while a server runs.
    Keys(keys::Arguments),
    /// Print the record of changes: who asked for what, from where, and with which answer.
    Audit(audit::Arguments),
    /// Bring the database up to date; `serve` and `worker` do so by themselves.
    Migrate(migrate::Arguments),
    /// Copy a data directory, also while a server uses it.
    Backup(backup::Arguments),
    /// Make a data directory of a backup, or check that every blob is there.
    Restore(restore::Arguments),
    /// Remove what the retention settings do not keep; a running server does so by itself.
    Sweep(sweep::Arguments),
    /// Print every setting with its value and where that came from, or what is wrong with them.
    CheckConfig(check_config::Arguments),
}

/// Parses the process's arguments, runs the command, and reports the outcome.
pub fn main() -> ExitCode {
    run(Cli::try_parse(), |cli| match cli.command {
        Command::Generate(arguments) => generate::run(arguments),
        Command::Edit(arguments) => edit::run(arguments),
        Command::Variants(arguments) => variants::run(arguments),
        Command::Tasks(arguments) => tasks::run(arguments),
        Command::Execute(arguments) => execute::run(arguments),
        Command::Episodes(arguments) => episodes::run(*arguments),
        Command::RegenerateEpisode(arguments) => regenerate_episode::run(arguments),
        Command::Judge(arguments) => judge::run(arguments),
        Command::Diff(arguments) => diff::run(arguments),
        Command::Batch(arguments) => batch::run(arguments),
        Command::Parse(arguments) => parse::run(arguments),
        Command::Dataset(arguments) => dataset::run(arguments),
        Command::Serve(arguments) => serve::run(arguments),
        Command::Worker(arguments) => worker::run(arguments),
        Command::Queue(arguments) => queue::run(arguments),
        Command::Tenants(arguments) => tenants::run(arguments),
        Command::Keys(arguments) => keys::run(arguments),
        Command::Audit(arguments) => audit::run(arguments),
        Command::Migrate(arguments) => migrate::run(arguments),
        Command::Backup(arguments) => backup::run(arguments),
        Command::Restore(arguments) => restore::run(arguments),
        Command::Sweep(arguments) => sweep::run(arguments),
        Command::CheckConfig(arguments) => check_config::run(arguments),
    })
}

/// Runs what the parsed arguments ask for. Help and version go to standard output, complaints to standard error.
pub fn run<C>(parsed: Result<C, clap::Error>, command: impl FnOnce(C) -> Result<Exit, Failure>) -> ExitCode {
    let arguments = match parsed {
        Ok(arguments) => arguments,
        Err(error) => {
            let code = if error.use_stderr() { Exit::Usage } else { Exit::Success };
            let _ = error.print();
            return code.into();
        }
    };
    match command(arguments) {
        Ok(exit) => exit.into(),
        Err(failure) => {
            terminal::complain(&failure.to_string());
            failure.exit.into()
        }
    }
}

/// The runtime everything that waits runs on. Its threads only wait: computation has its own pool.
pub fn runtime() -> Result<tokio::runtime::Runtime, Failure> {
    tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .map_err(|error| Failure::new(Exit::Error, format!("cannot start the runtime: {error}")))
}

/// Runs a long task. Computations that still run at its end do not hold the process up.
pub fn block_on<T>(task: impl Future<Output = Result<T, Failure>>) -> Result<T, Failure> {
    let runtime = runtime()?;
    let result = runtime.block_on(task);
    runtime.shutdown_timeout(Duration::from_secs(1));
    result
}
