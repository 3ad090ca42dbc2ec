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
mod bundle_meshes;
pub mod input_file;
mod instructions;
pub mod edit;
pub mod variants;
pub mod tasks;
pub mod execute;
pub mod episodes;
mod evaluate;
pub mod regenerate_episode;
pub mod judge;
pub mod diff;
pub mod render;
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
pub mod catalog;
pub mod robots;
pub mod doctor;
pub mod completions;
pub mod man;
pub mod mcp;

use std::process::ExitCode;
use std::time::Duration;

use clap::{CommandFactory, Parser, Subcommand};

pub use exit::{Exit, Failure};

/// Turns a sentence or one image into a tabletop scene a robot can be trained in.
#[derive(Debug, Parser)]
#[command(name = "tabletopgen", version, about, propagate_version = true)]
struct Cli {
    /// Write results and complaints, and neither notes nor progress
    #[arg(long, short, global = true)]
    quiet: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make one scene here and now, without a server.
    #[command(
        after_help = "Example: tabletopgen generate --text \"A desk with a mug and two books\" --seed 7 --out out/desk"
    )]
    Generate(generate::Arguments),
    /// Make a scene from a finished one, by operations or by an instruction in words.
    #[command(
        after_help = "Example: tabletopgen edit --bundle out/desk --text \"move the mug to the left of the books\" --out out/desk2"
    )]
    Edit(edit::Arguments),
    /// Make scenes from a finished one that differ in layout, meshes, colors, light and more.
    #[command(
        after_help = "Example: tabletopgen variants --bundle out/desk --count 3 --vary layout,meshes,light --out out/desk_variants"
    )]
    Variants(variants::Arguments),
    /// Propose tasks for a robot in a finished scene, or read one from an instruction.
    #[command(
        after_help = "Example: tabletopgen tasks --bundle out/desk --robot panda --count 5 --out out/desk_tasks"
    )]
    Tasks(tasks::Arguments),
    /// Let a simulated robot do a task in a finished scene.
    #[command(
        after_help = "Example: tabletopgen execute --bundle out/desk --robot panda --task \"move the mug to the left\" --out out/desk_run --video"
    )]
    Execute(execute::Arguments),
    /// Record many demonstrations of tasks as a dataset that policies are trained on.
    #[command(
        after_help = "Example: tabletopgen episodes --scene out/desk --task \"put the mug on the plate\" --count 50 --out out/mug_on_plate"
    )]
    Episodes(Box<episodes::Arguments>),
    /// Make an episode of a dataset again from its record, and compare it.
    #[command(
        after_help = "Example: tabletopgen regenerate-episode --dataset out/mug_on_plate --episode 0 --scene out/desk --out out/again"
    )]
    RegenerateEpisode(regenerate_episode::Arguments),
    /// Decide whether a task is done in poses that another simulator reports.
    #[command(
        after_help = "Example: tabletopgen judge --bundle out/desk --task out/desk_run/task.json --state state.json"
    )]
    Judge(judge::Arguments),
    /// Show what differs between the scenes of two bundles.
    #[command(after_help = "Example: tabletopgen diff out/desk out/desk2")]
    Diff(diff::Arguments),
    /// Render an image of a finished scene, fast, as its previews, or exactly by a path tracer.
    #[command(
        after_help = "Example: tabletopgen render --bundle out/desk --quality reference --samples 256 --out desk.png"
    )]
    Render(render::Arguments),
    /// Compare finished scenes with the images that they were made from, by the paper's measures.
    #[command(
        after_help = "Example: tabletopgen evaluate scenes.json --weights weights --out evaluation.json --html evaluation.html"
    )]
    Evaluate(evaluate::Arguments),
    /// Make many scenes from one file of requests or from a recipe, without a server.
    #[command(after_help = "Example: tabletopgen batch requests.jsonl --out out/requests")]
    Batch(batch::Arguments),
    /// Show what a text is understood as, without making a scene.
    #[command(after_help = "Example: tabletopgen parse \"Two red mugs on a round table\"")]
    Parse(parse::Arguments),
    /// Freeze finished scenes as a dataset, verify it, print its statistics.
    #[command(
        after_help = "Example: tabletopgen dataset freeze --name kitchen --from out/ --out datasets --split train=0.7,test=0.3"
    )]
    Dataset(dataset::Arguments),
    /// Run the job server.
    #[command(after_help = "Example: tabletopgen serve --listen 127.0.0.1:8080 --data-dir data")]
    Serve(serve::Arguments),
    /// Take jobs from a shared database, without the HTTP interface.
    #[command(after_help = "Example: tabletopgen worker --slots 4 --config server.toml")]
    Worker(worker::Arguments),
    /// Show the queue, or pause and resume the claiming of jobs.
    #[command(after_help = "Example: tabletopgen queue pause --reason \"vendor is down\"")]
    Queue(queue::Arguments),
    /// Show the limits of tenants and what is used of them, or give one limits of its own.
    #[command(after_help = "Example: tabletopgen tenants limit lab --waiting-jobs 100 --usd-per-month 50")]
    Tenants(tenants::Arguments),
    /// Make, list and revoke the keys of clients, also while a server runs.
    #[command(
        after_help = "Example: tabletopgen keys create --name \"arm 1\" --tenant lab --scopes read,submit --expires 90d"
    )]
    Keys(keys::Arguments),
    /// Print the record of changes: who asked for what, from where, and with which answer.
    #[command(after_help = "Example: tabletopgen audit --since 2026-01-31T00:00:00Z --json")]
    Audit(audit::Arguments),
    /// Bring the database up to date; `serve` and `worker` do so by themselves.
    #[command(after_help = "Example: tabletopgen migrate --data-dir data")]
    Migrate(migrate::Arguments),
    /// Copy a data directory, also while a server uses it.
    #[command(after_help = "Example: tabletopgen backup backup/ --data-dir data")]
    Backup(backup::Arguments),
    /// Make a data directory of a backup, or check that every blob is there.
    #[command(after_help = "Example: tabletopgen restore backup/ --data-dir data2")]
    Restore(restore::Arguments),
    /// Remove what the retention settings do not keep; a running server does so by itself.
    #[command(after_help = "Example: tabletopgen sweep --dry-run")]
    Sweep(sweep::Arguments),
    /// Print every setting with its value and where that came from, or what is wrong with them.
    #[command(after_help = "Example: tabletopgen check-config --config server.toml")]
    CheckConfig(check_config::Arguments),
    /// List the objects that scenes are made of, or show one.
    #[command(after_help = "Example: tabletopgen catalog show teapot")]
    Catalog(catalog::Arguments),
    /// List the robots that tasks are done with.
    #[command(after_help = "Example: tabletopgen robots --json")]
    Robots(robots::Arguments),
    /// Check what this machine and the configuration offer, and make a small scene.
    #[command(after_help = "Example: tabletopgen doctor --data-dir data --json")]
    Doctor(doctor::Arguments),
    /// Offer the commands to assistants as tools of the Model Context Protocol, on standard input and output.
    #[command(after_help = "Example: tabletopgen mcp --out out")]
    Mcp(mcp::Arguments),
    /// Print what a shell needs to complete commands and options.
    #[command(
        after_help = "Example: tabletopgen completions bash > ~/.local/share/bash-completion/completions/tabletopgen"
    )]
    Completions(completions::Arguments),
    /// Write the manual: a page for each command.
    #[command(after_help = "Example: tabletopgen man --out ~/.local/share/man/man1")]
    Man(man::Arguments),
}

/// Parses the process's arguments, runs the command, and reports the outcome.
pub fn main() -> ExitCode {
    run(Cli::try_parse(), |cli| {
        if cli.quiet {
            terminal::be_quiet();
        }
        command(cli.command)
    })
}

fn command(command: Command) -> Result<Exit, Failure> {
    match command {
        Command::Generate(arguments) => generate::run(arguments),
        Command::Edit(arguments) => edit::run(arguments),
        Command::Variants(arguments) => variants::run(arguments),
        Command::Tasks(arguments) => tasks::run(arguments),
        Command::Execute(arguments) => execute::run(arguments),
        Command::Episodes(arguments) => episodes::run(*arguments),
        Command::RegenerateEpisode(arguments) => regenerate_episode::run(arguments),
        Command::Judge(arguments) => judge::run(arguments),
        Command::Diff(arguments) => diff::run(arguments),
        Command::Render(arguments) => render::run(arguments),
        Command::Evaluate(arguments) => evaluate::run(arguments),
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
        Command::Catalog(arguments) => catalog::run(arguments),
        Command::Robots(arguments) => robots::run(&arguments),
        Command::Doctor(arguments) => doctor::run(arguments),
        Command::Mcp(arguments) => mcp::run(arguments),
        Command::Completions(arguments) => completions::run(&arguments),
        Command::Man(arguments) => man::run(&arguments),
    }
}

/// The command line, as `completions` and `man` describe it.
fn description() -> clap::Command {
    Cli::command()
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The words of a command line, as a shell splits them; up to a redirection.
    fn words(line: &str) -> Vec<String> {
        let mut words = Vec::new();
        for (k, part) in line.split(" > ").next().unwrap_or_default().split('"').enumerate() {
            match k % 2 {
                0 => words.extend(part.split_whitespace().map(str::to_owned)),
                _ => words.push(part.to_owned()),
            }
        }
        words
    }

    #[test]
    fn every_command_has_an_example_that_it_accepts() {
        let description = description();
        assert!(description.get_subcommands().count() > 20);
        for command in description.get_subcommands() {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let example = help.strip_prefix("Example: ").unwrap_or_default();
            let words = words(example);
            assert_eq!(words.get(1).map(String::as_str), Some(command.get_name()), "{help:?}");
            if let Err(error) = Cli::try_parse_from(&words) {
                panic!("{example}: {error}");
            }
        }
    }

    #[test]
    fn the_user_guide_lists_every_command() {
        let guide = include_str!("../docs/user_guide.md");
        for command in description().get_subcommands() {
            let about = command.get_about().map(ToString::to_string).unwrap_or_default();
            let row = format!("| `{}` | {about} |", command.get_name());
            assert!(guide.lines().any(|line| line == row), "docs/user_guide.md has no row {row}");
        }
    }
}
