//! `mock-vendors`: serves every remote model's protocol on one address with the embedded adapters, until SIGTERM or
//! Ctrl-C.

use std::time::Duration;

use clap::Args;

use crate::app::mock_vendors;
use tabletopgen::app::logging;
use tabletopgen::cli::options::ConfigOptions;
use tabletopgen::cli::{Exit, Failure, runtime, signals, terminal};

/// Arguments of `mock-vendors`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Address and port; port 0 takes a free one
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1:8090")]
    listen: String,
    /// Seed of requests without one
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Minimum duration of every response and every job, milliseconds
    #[arg(long, value_name = "MS", default_value_t = 0)]
    latency_ms: u64,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Runs the server and prints a configuration that uses it.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let resolved = arguments.options.load(Vec::new())?;
    logging::start(&resolved.config.log);
    let latency = Duration::from_millis(arguments.latency_ms);
    let providers = mock_vendors::providers(&resolved, arguments.seed, latency)?;
    runtime()?.block_on(async {
        let stop = signals::stop_on_signal("stopping: what is being answered is answered")?;
        let running = mock_vendors::start(&resolved, &arguments.listen, providers).await?;
        terminal::print(&message(&running.address.to_string()));
        stop.cancelled().await;
        running.stop().await;
        Ok(Exit::Success)
    })
}

/// The address, and the settings of a server that uses it for every port.
fn message(address: &str) -> String {
    format!(
        "listening on http://{address}\n\
         [providers]\n\
         analyst = [\"chat\", \"embedded\"]\n\
         image_generator = [\"openai_images\", \"embedded\"]\n\
         segmenter = [\"sidecar\"]\n\
         mesh_generator = [\"replicate\", \"embedded\"]\n\
         allow_http = true\n\
         private_hosts = \"{address}\"\n\
         chat.base_url = \"http://{address}/v1\"\n\
         openai_images.base_url = \"http://{address}/v1\"\n\
         segmenter_sidecar.base_url = \"http://{address}\"\n\
         replicate.base_url = \"http://{address}/v1\"\n"
    )
}
