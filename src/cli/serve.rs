//! `serve`: the job server until SIGTERM or Ctrl-C.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::options::ConfigOptions;
use super::worker::take_jobs;
use super::{Exit, Failure, block_on, private_mode, signals, terminal};
use crate::app::remote::Remote;
use crate::app::{App, pipeline, telemetry};
use crate::service;
use crate::service::role::Role;

/// Arguments of `serve`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Address and port; port 0 takes a free one [default: server.listen, 127.0.0.1:8080]
    #[arg(long, value_name = "ADDR")]
    listen: Option<String>,
    /// Listen beyond loopback although clients are not authenticated (server.allow_unauthenticated)
    #[arg(long)]
    allow_unauthenticated: bool,
    /// Folder in which scenes, jobs and blobs are kept
    #[arg(long, value_name = "DIR", default_value = "data")]
    data_dir: PathBuf,
    /// Role of this process; separate roles need PostgreSQL and an S3 bucket
    #[arg(long, value_enum, default_value_t = Role::All)]
    role: Role,
    /// Print the address as a JSON document
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Runs the server.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let Arguments { listen, allow_unauthenticated, data_dir, role, json, options } = arguments;
    private_mode::keep_private();
    let key = if role == Role::Worker { "worker.listen" } else { "server.listen" };
    let listen = listen.map(|address| (key.to_owned(), address, "--listen"));
    let allowed = allow_unauthenticated
        .then(|| ("server.allow_unauthenticated".to_owned(), "true".to_owned(), "--allow-unauthenticated"));
    let resolved = options.load(listen.into_iter().chain(allowed).collect())?;
    role.check(&resolved.config).map_err(|error| Failure::usage(error.to_string()))?;
    if role == Role::Worker {
        return take_jobs(&resolved, &data_dir, json);
    }
    // Kept to the end: dropping it sends the spans that wait.
    let _traces = telemetry::start(&resolved.config).map_err(|error| Failure::usage(error.to_string()))?;
    let remote = Remote::load(&resolved)?;
    let app = App::reading_with(&resolved, &remote);
    let build = match role {
        Role::Api => None,
        _ => Some(pipeline::build_pipeline_with(&resolved, &remote)?),
    };
    block_on(async {
        let stop = signals::stop_on_signal("draining: running stages finish, jobs go back to the queue")?;
        let service = match build {
            Some(build) => service::start(&app, &data_dir, build).await?,
            None => service::start_api(&app, &data_dir).await?,
        };
        let role = role.as_str();
        tracing::info!(address = %service.address, role, data_dir = %data_dir.display(), "serving");
        terminal::print(&listening(service.address, json));
        service.run_until(stop.cancelled()).await?;
        tracing::info!("stopped in good order");
        Ok(Exit::Success)
    })
}

/// The address of a process, for people or as JSON.
pub(super) fn listening(address: SocketAddr, as_json: bool) -> String {
    let url = format!("http://{address}");
    if as_json { format!("{}\n", json!({ "url": url })) } else { format!("listening on {url}\n") }
}
