//! `worker`: a process that takes jobs from a shared database, without the HTTP interface.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::options::ConfigOptions;
use super::serve::listening;
use super::{Exit, Failure, block_on, number, private_mode, signals, terminal};
use crate::app::config::Resolved;
use crate::app::{self, App, telemetry};
use crate::service;
use crate::service::role::Role;

/// Arguments of `worker`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Jobs worked on at the same time [default: worker.concurrency, 2]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number::whole::<usize>(1..=u64::MAX))]
    slots: Option<usize>,
    /// Address of /healthz, /readyz and /metrics; port 0 takes a free one [default: worker.listen, none]
    #[arg(long, value_name = "ADDR")]
    listen: Option<String>,
    /// Folder for what this process keeps on this machine
    #[arg(long, value_name = "DIR", default_value = "data")]
    data_dir: PathBuf,
    /// Print the address, or the number of jobs, as a JSON document
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Takes jobs until SIGTERM or Ctrl-C.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let Arguments { slots, listen, data_dir, json, options } = arguments;
    private_mode::keep_private();
    let slots = slots.map(|slots| ("worker.concurrency".to_owned(), slots.to_string(), "--slots"));
    let listen = listen.map(|address| ("worker.listen".to_owned(), address, "--listen"));
    let resolved = options.load(slots.into_iter().chain(listen).collect())?;
    Role::Worker.check(&resolved.config).map_err(|error| Failure::usage(error.to_string()))?;
    take_jobs(&resolved, &data_dir, json)
}

/// Works until a signal; the storage has been checked.
pub(super) fn take_jobs(resolved: &Resolved, data_dir: &Path, as_json: bool) -> Result<Exit, Failure> {
    // Kept to the end: dropping it sends the spans that wait.
    let _traces = telemetry::start(&resolved.config).map_err(|error| Failure::usage(error.to_string()))?;
    let build = app::pipeline::build_pipeline(resolved)?;
    block_on(async {
        let stop = signals::stop_on_signal("draining: running stages finish, jobs go back to the queue")?;
        let listen = resolved.config.worker.listen.as_str();
        let listen = (!listen.is_empty()).then_some(listen);
        let service = service::start_worker(&App::new(resolved), data_dir, listen, build).await?;
        let slots = resolved.config.worker.concurrency;
        tracing::info!(slots, "taking jobs");
        terminal::print(&match service.address {
            Some(address) => listening(address, as_json),
            None if as_json => format!("{}\n", json!({ "slots": slots })),
            None => format!("taking jobs, {slots} at a time\n"),
        });
        service.run_until(stop.cancelled()).await?;
        tracing::info!("stopped in good order");
        Ok(Exit::Success)
    })
}
