//! `keys`: makes, lists and revokes the keys of clients, beside the processes that run. A person who may write the
//! database is the operator, and may make a key for any tenant.

use std::time::Duration;

use clap::{Args, Subcommand};
use serde_json::{Value, json};

use super::duration::duration;
use super::place::Place;
use super::{Exit, Failure, runtime, terminal};
use crate::app;
use crate::schemas::values::Timestamp;
use scene::{KeyId, TenantId};
use store::Operator;
use store::keys::{KeyFilter, KeyRow, MAX_LIFETIME_SECS, MIN_LIFETIME_SECS, NewKey, RevokeOutcome, is_name};
use store::scopes::ScopeSet;

/// Keys that are read together.
const PAGE: u32 = 500;

/// Arguments of `keys`.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Make a key and print it; it is shown here alone
    Create {
        /// Name for people, such as the machine that uses it
        #[arg(long)]
        name: String,
        /// Tenant whose scenes it opens
        #[arg(long, value_name = "ID", default_value = "default")]
        tenant: TenantId,
        /// Uses, with commas between them: read, submit, delete, operate, admin
        #[arg(long, value_name = "LIST", default_value = "read,submit", value_parser = ScopeSet::parse)]
        scopes: ScopeSet,
        /// Time after which it opens nothing, such as 90d or 12h [default: never]
        #[arg(long, value_name = "TIME", value_parser = duration)]
        expires: Option<Duration>,
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        place: Place,
    },
    /// List keys, newest first, those that open nothing any more included
    List {
        /// Only keys of this tenant
        #[arg(long, value_name = "ID")]
        tenant: Option<TenantId>,
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        place: Place,
    },
    /// Revoke a key and end its sessions, from the next request on
    Revoke {
        /// Id of the key, as `list` prints it; not the key itself
        id: KeyId,
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        place: Place,
    },
}

/// Connects to the database of keys and of the record of changes.
pub(super) async fn connect(place: &Place) -> Result<Operator, Failure> {
    Ok(app::operator(&place.data_dir, &place.settings()?.config).await?)
}

/// Does it.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let text = runtime()?.block_on(async {
        match arguments.action {
            Action::Create { name, tenant, scopes, expires, json, place } => {
                create(checked(name, tenant, scopes, expires)?, json, &place).await
            }
            Action::List { tenant, json, place } => list(tenant, json, &place).await,
            Action::Revoke { id, json, place } => revoke(&id, json, &place).await,
        }
    })?;
    terminal::print(&text);
    Ok(Exit::Success)
}

fn checked(
    name: String,
    tenant_id: TenantId,
    scopes: ScopeSet,
    expires: Option<Duration>,
) -> Result<NewKey, Failure> {
    if !is_name(&name) {
        return Err(Failure::usage("give --name 1 to 100 characters, none of them a control character"));
    }
    if scopes.is_empty() {
        return Err(Failure::usage("give --scopes at least one of read, submit, delete, operate, admin"));
    }
    if expires.is_some_and(|time| !(MIN_LIFETIME_SECS..=MAX_LIFETIME_SECS).contains(&time.as_secs())) {
        return Err(Failure::usage("give --expires a time from 1m to 3650d"));
    }
    let lifetime_ms = expires.and_then(|time| i64::try_from(time.as_millis()).ok());
    Ok(NewKey { tenant_id, name, scopes, lifetime_ms })
}

async fn create(new: NewKey, as_json: bool, place: &Place) -> Result<String, Failure> {
    let (row, secret) = connect(place).await?.create_key(new).await.map_err(app::AppError::from)?;
    if as_json {
        let mut document = as_document(&row);
        document["key"] = secret.expose().into();
        return Ok(format!("{document:#}\n"));
    }
    terminal::note(&format!(
        "key {} of the tenant {}: {}; keep what follows, it is not shown again",
        row.id, row.tenant_id, row.scopes
    ));
    Ok(format!("{}\n", secret.expose()))
}

async fn list(tenant: Option<TenantId>, as_json: bool, place: &Place) -> Result<String, Failure> {
    let mut operator = connect(place).await?;
    let (mut rows, mut before_id): (Vec<KeyRow>, _) = (Vec::new(), None);
    loop {
        let filter = KeyFilter { before_id: before_id.take(), limit: PAGE };
        let page = operator.list_keys(tenant.as_ref(), filter).await.map_err(app::AppError::from)?;
        let is_last = page.len() < PAGE as usize;
        before_id = page.last().map(|row| row.id.clone());
        rows.extend(page);
        if is_last {
            break;
        }
    }
    if as_json {
        let keys: Vec<Value> = rows.iter().map(as_document).collect();
        return Ok(format!("{:#}\n", json!({ "keys": keys })));
    }
    Ok(rows.iter().map(as_line).collect())
}

async fn revoke(id: &KeyId, as_json: bool, place: &Place) -> Result<String, Failure> {
    let outcome = connect(place).await?.revoke_key(id).await.map_err(app::AppError::from)?;
    match outcome {
        RevokeOutcome::Revoked | RevokeOutcome::WasRevoked if as_json => {
            let was_revoked = outcome == RevokeOutcome::WasRevoked;
            Ok(format!("{:#}\n", json!({ "id": id, "was_revoked_before": was_revoked })))
        }
        RevokeOutcome::Revoked => Ok(format!("revoked: {id}\n")),
        RevokeOutcome::WasRevoked => Ok(format!("was revoked before: {id}\n")),
        RevokeOutcome::NotFound => Err(Failure::new(
            Exit::Error,
            format!("there is no key {id}; `tabletopgen keys list` lists their ids"),
        )),
    }
}

/// The key as the interface shows it.
fn as_document(row: &KeyRow) -> Value {
    json!({
        "id": row.id,
        "tenant": row.tenant_id,
        "name": row.name,
        "scopes": row.scopes,
        "created_at": Timestamp::of_ms(row.created_at_ms),
        "expires_at": row.expires_at_ms.map(Timestamp::of_ms),
        "revoked_at": row.revoked_at_ms.map(Timestamp::of_ms),
        "last_used_at": row.last_used_at_ms.map(Timestamp::of_ms),
    })
}

fn as_line(row: &KeyRow) -> String {
    let time = |ms: Option<i64>| ms.map_or("never".to_owned(), |ms| Timestamp::of_ms(ms).to_string());
    let revoked = row.revoked_at_ms.map_or_else(String::new, |_| "  revoked".to_owned());
    format!(
        "{}  {}  {}  {}  expires {}  used {}{revoked}\n",
        row.id,
        row.tenant_id,
        row.name,
        row.scopes,
        time(row.expires_at_ms),
        time(row.last_used_at_ms)
    )
}
