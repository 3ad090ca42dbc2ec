//! `queue`: shows the queue, or pauses and resumes the claiming of jobs, datasets and recordings, beside the processes
//! that run.

use clap::{Args, Subcommand};
use serde_json::json;

use super::place::Place;
use super::{Exit, Failure, runtime, terminal};
use crate::app;
use store::queue::QueueStatus;

/// Arguments of `queue`.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Show how many jobs, datasets and recordings wait and run, and whether claiming is paused
    Status {
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        place: Place,
    },
    /// Let every worker finish the work it holds (jobs, datasets, attempts at episodes) and claim no other, until
    /// `resume`; submissions go on
    Pause {
        /// Reason, for `status`
        #[arg(long, value_name = "TEXT", default_value = "")]
        reason: String,
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        place: Place,
    },
    /// Let workers claim work again
    Resume {
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        place: Place,
    },
}

/// Does it, and prints what holds now.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let (place, as_json) = match &arguments.action {
        Action::Status { json, place }
        | Action::Pause { json, place, .. }
        | Action::Resume { json, place } => (place, *json),
    };
    let resolved = place.settings()?;
    let status = runtime()?.block_on(async {
        let mut operator = app::operator(&place.data_dir, &resolved.config).await?;
        match &arguments.action {
            Action::Status { .. } => {}
            Action::Pause { reason, .. } => {
                operator.pause_queue(reason).await.map_err(app::AppError::from)?
            }
            Action::Resume { .. } => operator.resume_queue().await.map_err(app::AppError::from)?,
        }
        let status = operator.queue_status().await.map_err(app::AppError::from)?;
        Ok::<QueueStatus, Failure>(status)
    })?;
    terminal::print(&if as_json { format!("{:#}\n", json!(status)) } else { as_text(&status) });
    Ok(Exit::Success)
}

fn as_text(status: &QueueStatus) -> String {
    let mut text = match &status.paused {
        None => "claiming: running\n".to_owned(),
        Some(pause) if pause.reason.is_empty() => "claiming: paused\n".to_owned(),
        Some(pause) => format!("claiming: paused ({})\n", pause.reason),
    };
    text.push_str(&format!("queued: {}\n", status.queued));
    text.push_str(&format!("  waiting for their time: {}\n", status.delayed));
    text.push_str(&format!("  to run alone: {}\n", status.suspects));
    if let Some(oldest_ms) = status.oldest_ms {
        text.push_str(&format!("  oldest, seconds: {}\n", oldest_ms / 1000));
    }
    text.push_str(&format!("active: {}, held by {} workers\n", status.active, status.workers));
    for (name, work) in [("datasets", status.datasets), ("recordings", status.recordings)] {
        text.push_str(&format!("{name}: {} queued, {} active\n", work.queued, work.active));
    }
    for job_id in &status.poisoned {
        text.push_str(&format!("failed as their processes died: {job_id}\n"));
    }
    text
}
