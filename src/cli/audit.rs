//! `audit`: prints the record of changes, newest first, beside the processes that run.

use clap::Args;
use serde_json::{Value, json};

use super::keys::connect;
use super::place::Place;
use super::{Exit, Failure, runtime, terminal};
use crate::app;
use crate::schemas::values::Timestamp;
use scene::TenantId;
use store::audit::{AuditFilter, AuditRow};

/// Rows that are read together.
const PAGE: u32 = 500;

/// Arguments of `audit`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Only what happened then or later, such as 2026-01-31T12:00:00Z
    #[arg(long, value_name = "TIME")]
    since: Option<jiff::Timestamp>,
    /// Only the record of this tenant
    #[arg(long, value_name = "ID")]
    tenant: Option<TenantId>,
    /// Print a JSON object a line
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    place: Place,
}

/// Prints it.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let Arguments { since, tenant, json, place } = arguments;
    runtime()?.block_on(async {
        let mut operator = connect(&place).await?;
        let mut before_id = None;
        loop {
            let since_ms = since.map(jiff::Timestamp::as_millisecond);
            let filter = AuditFilter { since_ms, before_id: before_id.take(), limit: PAGE };
            let rows = operator.audit(tenant.as_ref(), filter).await.map_err(app::AppError::from)?;
            let lines: String = rows.iter().map(|row| line(row, json)).collect();
            terminal::print(&lines);
            if rows.len() < PAGE as usize {
                return Ok(Exit::Success);
            }
            before_id = rows.last().map(|row| row.id.clone());
        }
    })
}

fn line(row: &AuditRow, as_json: bool) -> String {
    let entry = &row.entry;
    let at = Timestamp::of_ms(row.at_ms);
    if !as_json {
        return format!(
            "{at}  {}  {}  {}  {} {}  {}\n",
            entry.tenant_id, entry.principal, entry.address, entry.action, entry.subject, entry.status
        );
    }
    let document: Value = json!({
        "id": row.id,
        "at": at,
        "tenant": entry.tenant_id,
        "principal": entry.principal,
        "address": entry.address,
        "action": entry.action,
        "subject": entry.subject,
        "status": entry.status,
    });
    format!("{document}\n")
}
