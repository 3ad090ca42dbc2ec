//! `serve`: the job server until SIGTERM or Ctrl-C.

use std::path::PathBuf;

use clap::Args;

use super::options::ConfigOptions;
use super::{Exit, Failure, runtime, signals, terminal};
use crate::app::{self, logging, service};

/// Arguments of `serve`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Address and port; port 0 takes a free one [default: server.listen, 127.0.0.1:8080]
    #[arg(long, value_name = "ADDR")]
    listen: Option<String>,
    /// Where scenes, jobs and blobs are kept
    #[arg(long, value_name = "DIR", default_value = "data")]
    data_dir: PathBuf,
    /// What this process does; one SQLite data directory has one process, which does it all
    #[arg(long, default_value = "all", value_parser = role)]
    role: String,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Runs the server.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let listen = arguments.listen.map(|address| ("server.listen".to_owned(), address, "--listen"));
    let resolved = arguments.options.load(listen.into_iter().collect())?;
    logging::start(&resolved.config.log);
    let build = app::pipeline::build_pipeline(&resolved)?;
    runtime()?.block_on(async {
        let stop = signals::stop_on_signal("draining: running stages finish, jobs go back to the queue")?;
        let service = service::start(&resolved, &arguments.data_dir, build).await?;
        tracing::info!(address = %service.address, data_dir = %arguments.data_dir.display(), "serving");
        terminal::print(&format!("listening on http://{}\n", service.address));
        service.run_until(stop.cancelled()).await?;
        tracing::info!("stopped in good order");
        Ok(Exit::Success)
    })
}

fn role(text: &str) -> Result<String, String> {
    match text {
        "all" => Ok(text.to_owned()),
        "api" | "worker" => Err("separate roles need a database that several processes can share; this one \
                                 keeps everything in one SQLite file, so use --role all"
            .to_owned()),
        _ => Err("use --role all".to_owned()),
    }
}
