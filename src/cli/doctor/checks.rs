//! The checks, each of which tries what the program will do later.

use std::net::TcpListener;
use std::path::Path;
use std::time::Instant;

use tokio_util::sync::CancellationToken;

use super::{Finding, State};
use crate::app::config::{Config, Resolved};
use crate::app::local::{self, Ended};
use crate::app::submission::SceneOrder;
use crate::app::terms::Terms;
use crate::app::{self, App, AppError};
use crate::cli::local_job::adapt;
use gpu::{DeviceChoice, Gpu};
use store::lifecycle::JobState;
use store::{BlobPlace, DatabaseAddress, Intent, StoreError};

/// Space below which a warning is due: about ten thousand scenes.
const LITTLE_SPACE_BYTES: u64 = 10 << 30;

/// The smallest scene that passes every stage.
const TEXT: &str = "A desk with a mug";

/// Version, features and processor.
pub fn program() -> Finding {
    let features: Vec<&str> = [
        ("gpu", cfg!(feature = "gpu")),
        ("otel", cfg!(feature = "otel")),
        ("postgres", cfg!(feature = "postgres")),
        ("s3", cfg!(feature = "s3")),
        ("video", cfg!(feature = "video")),
    ]
    .into_iter()
    .filter_map(|(name, is_built)| is_built.then_some(name))
    .collect();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let detail = format!(
        "tabletopgen {} for {} ({}), with {}; {cores} cores",
        env!("CARGO_PKG_VERSION"),
        std::env::consts::OS,
        std::env::consts::ARCH,
        if features.is_empty() { "no optional part".to_owned() } else { features.join(", ") },
    );
    Finding::new("program", State::Ok, detail)
}

/// The file, if there is one; every value has been checked.
pub fn configuration(file: Option<&Path>, resolved: &Resolved) -> Finding {
    let own = resolved.entries().filter(|(.., origin)| **origin != app::config::Origin::Default).count();
    let detail = match file {
        Some(file) => format!("{}; {own} settings differ from the defaults", file.display()),
        None => format!("no file; {own} settings differ from the defaults"),
    };
    Finding::new("configuration", State::Ok, detail)
}

/// Weights, keys and addresses of the models, which are read and not called.
pub fn models(resolved: &Resolved) -> Finding {
    let made = app::pipeline::build_pipeline(resolved).map(|_| {
        if resolved.config.calls_remote_models() {
            "remote models with the keys that they need; none was called".to_owned()
        } else {
            "embedded ones: no key, network or GPU is needed".to_owned()
        }
    });
    Finding::of("models", made)
}

/// The adapter that kernels would run on.
pub fn gpu(resolved: &Resolved) -> Finding {
    let choice = resolved.config.compute.device;
    match Gpu::open(choice) {
        Ok(Some(gpu)) => Finding::new("gpu", State::Ok, gpu.name()),
        Ok(None) => Finding::new("gpu", State::Skipped, "the CPU computes everything (compute.device = cpu)"),
        Err(error) if choice == DeviceChoice::Auto => {
            Finding::new("gpu", State::Ok, format!("none, so the CPU computes everything ({error})"))
        }
        Err(error) => Finding::of("gpu", Err(error)),
    }
}

/// Free space where data will lie.
pub fn space(data_dir: &Path) -> Finding {
    let absolute = std::path::absolute(data_dir).unwrap_or_else(|_| data_dir.to_owned());
    let Some(existing) = absolute.ancestors().find(|folder| folder.is_dir()) else {
        return Finding::new("disk", State::Failed, format!("{} has no folder above it", absolute.display()));
    };
    match rustix::fs::statvfs(existing) {
        Ok(about) => {
            let bytes = about.f_bavail.saturating_mul(about.f_frsize);
            let gib = bytes as f64 / f64::from(1 << 30);
            let detail = format!("{gib:.1} GiB free at {}", existing.display());
            match bytes < LITTLE_SPACE_BYTES {
                true => Finding::new("disk", State::Warning, format!("{detail}; a scene takes about 1 MB")),
                false => Finding::new("disk", State::Ok, detail),
            }
        }
        Err(error) => Finding::of("disk", Err(std::io::Error::from(error))),
    }
}

/// The database and the place of blobs: a write to each, unless a process uses them now. A database of an older version
/// is not migrated.
pub async fn store(data_dir: &Path, config: &Config) -> Finding {
    match counted(data_dir, config).await {
        Ok(detail) => Finding::new("store", State::Ok, detail),
        Err(AppError::Store(StoreError::NoDatabase { .. })) => {
            let detail = format!("no database in {} yet; `serve` makes one", data_dir.display());
            Finding::new("store", State::Ok, detail)
        }
        Err(error) => Finding::of("store", Err(error)),
    }
}

async fn counted(data_dir: &Path, config: &Config) -> Result<String, AppError> {
    let queue = app::operator(data_dir, config).await?.queue_status().await?;
    let place = place(data_dir, config);
    match app::open(data_dir, config, Intent::Existing).await {
        Ok(store) => {
            store.is_healthy().await?;
            Ok(format!("{place} takes writes; {} jobs wait", queue.queued))
        }
        Err(AppError::Store(StoreError::Locked { .. })) => {
            Ok(format!("{place} is in use by a process; {} jobs wait, {} run", queue.queued, queue.active))
        }
        Err(error) => Err(error),
    }
}

fn place(data_dir: &Path, config: &Config) -> String {
    let database = match &config.store.database {
        DatabaseAddress::Sqlite => format!("SQLite in {}", data_dir.display()),
        DatabaseAddress::Postgres(_) => "PostgreSQL".to_owned(),
    };
    let blobs = match &config.store.blobs {
        BlobPlace::S3 => "a bucket",
        BlobPlace::Memory => "memory",
        BlobPlace::Files => "files",
    };
    format!("{database} with blobs in {blobs}")
}

/// The address of the server, which is bound and let go.
pub fn address(listen: &str) -> Finding {
    match TcpListener::bind(listen) {
        Ok(_) => Finding::new("address", State::Ok, format!("{listen} is free")),
        Err(error) if error.kind() == std::io::ErrorKind::AddrInUse => {
            let detail = format!(
                "{listen} is in use, perhaps by a server of ours; choose another with `serve --listen`"
            );
            Finding::new("address", State::Warning, detail)
        }
        Err(error) => Finding::new("address", State::Failed, format!("cannot listen on {listen}: {error}")),
    }
}

/// A scene, made as `generate` makes it, in a temporary directory.
pub async fn scene(resolved: &Resolved) -> Finding {
    if resolved.config.calls_remote_models() {
        let detail = "the configured models may cost money; try them with `tabletopgen generate`";
        return Finding::new("scene", State::Skipped, detail);
    }
    let began = Instant::now();
    match made(resolved).await {
        Ok(None) => {
            Finding::new("scene", State::Ok, format!("\"{TEXT}\" in {:.1} s", began.elapsed().as_secs_f64()))
        }
        Ok(Some(failure)) => Finding::new("scene", State::Failed, failure),
        Err(error) => Finding::of("scene", Err(error)),
    }
}

/// Makes it; the reason why it does not pass.
async fn made(resolved: &Resolved) -> Result<Option<String>, AppError> {
    let mut resolved = resolved.clone();
    adapt(&mut resolved, false);
    let folder = match tempfile::Builder::new().prefix("tabletopgen-").tempdir() {
        Ok(folder) => folder,
        Err(error) => {
            let place = std::env::temp_dir();
            return Ok(Some(format!("cannot make a directory in {}: {error}; set TMPDIR", place.display())));
        }
    };
    let config = resolved.config.clone();
    let build = match app::pipeline::build_pipeline(&resolved) {
        Ok(build) => build,
        Err(errors) => return Ok(Some(errors.to_string())),
    };
    let terms = Terms { seed: Some(7), ..Terms::default() };
    let order = SceneOrder { text: Some(TEXT.to_owned()), image: None, depth: None, terms };
    let submission = match App::new(&resolved).check_scene(order) {
        Ok(submission) => submission,
        Err(problem) => return Ok(Some(problem.detail)),
    };
    let store = app::open(folder.path(), &config, Intent::Create).await?;
    let ended = local::run(&store, &config, build, submission, CancellationToken::new(), |_| {}).await?;
    Ok(match ended {
        Ended::Storage(outage) => Some(format!("{} takes no writes ({outage:?})", folder.path().display())),
        Ended::Job { job, .. } if job.state == JobState::Succeeded => None,
        Ended::Job { job, .. } => Some(job.failure_message.unwrap_or_else(|| "it was cancelled".to_owned())),
    })
}
