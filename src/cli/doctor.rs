//! `doctor`: what this machine and the configuration offer, found by trying each.

mod checks;

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use serde_json::json;

use super::options::ConfigOptions;
use super::{Exit, Failure, runtime, terminal};
use crate::app::config::Resolved;
use crate::app::logging;

/// Arguments of `doctor`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The data directory that `serve` is to use
    #[arg(long, value_name = "DIR", default_value = "data")]
    data_dir: PathBuf,
    /// Make no scene
    #[arg(long)]
    no_scene: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Result of one check.
#[derive(Debug, Serialize)]
struct Finding {
    check: &'static str,
    state: State,
    /// The finding, with advice where something is amiss.
    detail: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum State {
    Ok,
    /// Works, and not as well as it could.
    Warning,
    Failed,
    /// Not tried; the detail says why.
    Skipped,
}

impl Finding {
    fn new(check: &'static str, state: State, detail: impl Into<String>) -> Self {
        Self { check, state, detail: detail.into() }
    }

    /// The detail of a success, or a failure in full.
    fn of<E: std::error::Error>(check: &'static str, result: Result<String, E>) -> Self {
        match result {
            Ok(detail) => Self::new(check, State::Ok, detail),
            Err(error) => Self::new(check, State::Failed, ::runtime::error_chain(&error)),
        }
    }
}

/// Checks all, and fails if one of them does.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let resolved = arguments.options.load(Vec::new());
    let mut findings = vec![checks::program()];
    match resolved {
        Err(failure) => findings.push(Finding::new("configuration", State::Failed, failure.message)),
        Ok(mut resolved) => {
            super::local_job::adapt(&mut resolved, true);
            logging::start(&resolved.config.log);
            findings.extend(of_machine(&arguments, &resolved)?);
        }
    }
    terminal::print(&match arguments.json {
        true => format!("{:#}\n", json!({ "checks": findings })),
        false => findings.iter().map(line).collect(),
    });
    let has_failed = findings.iter().any(|finding| finding.state == State::Failed);
    Ok(if has_failed { Exit::Error } else { Exit::Success })
}

fn of_machine(arguments: &Arguments, resolved: &Resolved) -> Result<Vec<Finding>, Failure> {
    let runtime = runtime()?;
    Ok(vec![
        checks::configuration(arguments.options.file().as_deref(), resolved),
        checks::models(resolved),
        checks::gpu(resolved),
        checks::space(&arguments.data_dir),
        runtime.block_on(checks::store(&arguments.data_dir, &resolved.config)),
        checks::address(&resolved.config.server.listen),
        match arguments.no_scene {
            true => Finding::new("scene", State::Skipped, "left out by --no-scene"),
            false => runtime.block_on(checks::scene(resolved)),
        },
    ])
}

fn line(finding: &Finding) -> String {
    let state = match finding.state {
        State::Ok => "ok",
        State::Warning => "warning",
        State::Failed => "FAILED",
        State::Skipped => "skipped",
    };
    format!("{state:<8} {:<14} {}\n", finding.check, finding.detail)
}
