//! The record of changes: who asked for what, from where, and with which answer. Rows are added and never changed; the
//! database itself refuses that.

use serde::Serialize;
use sqlx::any::AnyRow;
use sqlx::{AnyConnection, AssertSqlSafe, Row};
use uuid::Uuid;

use super::database::Dialect;
use super::keys::KeyRow;
use super::list_query::{ListQuery, Statement};
use super::{Store, StoreError, database};
use crate::boxed;
use scene::TenantId;

/// Clocks of the processes that write differ by less than this, milliseconds.
const MAX_SKEW_MS: i64 = 3_600_000;

/// A change, or an attempt at one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AuditEntry {
    pub tenant_id: TenantId,
    /// Name of who asked, such as `key:` and the id of a key. Never a secret.
    pub principal: String,
    /// Address of the client; empty for the command line.
    pub address: String,
    /// Id of the operation in the contract.
    pub action: String,
    /// Path of the request.
    pub subject: String,
    /// Status of the answer.
    pub status: u16,
}

/// A row of the record.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AuditRow {
    pub id: String,
    /// Milliseconds since 1970.
    pub at_ms: i64,
    #[serde(flatten)]
    pub entry: AuditEntry,
}

/// Rows of a list, newest first.
#[derive(Clone, Debug, Default)]
pub struct AuditFilter {
    /// Only rows of this time or later, milliseconds since 1970.
    pub since_ms: Option<i64>,
    /// Only rows before this one in the list.
    pub before_id: Option<String>,
    pub limit: u32,
}

impl AuditEntry {
    /// An action of the command line on a key.
    pub(super) fn of_operator(action: &str, key: &KeyRow, status: u16) -> Self {
        Self {
            tenant_id: key.tenant_id.clone(),
            principal: "command line".to_owned(),
            address: String::new(),
            action: action.to_owned(),
            subject: format!("/keys/{}", key.id),
            status,
        }
    }
}

impl AuditFilter {
    /// The rows that meet further conditions, too.
    pub(super) fn of(self, query: ListQuery) -> Statement {
        let first_id = self.since_ms.map(|since| first_id_after(since.saturating_sub(MAX_SKEW_MS)));
        let query = query.text("id <", self.before_id).text("id >=", first_id).number("at >=", self.since_ms);
        query.select("audit", self.limit)
    }
}

impl Store {
    /// Adds a row.
    #[boxed]
    pub async fn record(&self, entry: AuditEntry) -> Result<(), StoreError> {
        self.writer
            .write("record a change", move |connection| {
                Box::pin(async move { insert(connection, &entry).await })
            })
            .await
    }

    /// Rows of a tenant, newest first.
    #[boxed]
    pub async fn audit(
        &self,
        tenant_id: &TenantId,
        filter: AuditFilter,
    ) -> Result<Vec<AuditRow>, StoreError> {
        let rows = filter.of(ListQuery::of(tenant_id)).rows(&self.readers).await?;
        rows.iter().map(row_of).collect()
    }
}

pub(super) async fn insert(connection: &mut AnyConnection, entry: &AuditEntry) -> Result<(), StoreError> {
    let now = Dialect::of(connection).now_ms();
    let query = format!(
        "INSERT INTO audit (id, at, tenant_id, principal, address, action, subject, status)
         VALUES ($1, {now}, $2, $3, $4, $5, $6, $7)"
    );
    sqlx::query(AssertSqlSafe(query))
        .bind(Uuid::now_v7().to_string())
        .bind(entry.tenant_id.as_str())
        .bind(&entry.principal)
        .bind(&entry.address)
        .bind(&entry.action)
        .bind(&entry.subject)
        .bind(i64::from(entry.status))
        .execute(connection)
        .await?;
    Ok(())
}

pub(super) fn row_of(row: &AnyRow) -> Result<AuditRow, StoreError> {
    let status: i64 = row.try_get("status")?;
    Ok(AuditRow {
        id: row.try_get("id")?,
        at_ms: row.try_get("at")?,
        entry: AuditEntry {
            tenant_id: database::id(row, "audit", "tenant_id")?,
            principal: row.try_get("principal")?,
            address: row.try_get("address")?,
            action: row.try_get("action")?,
            subject: row.try_get("subject")?,
            status: u16::try_from(status).unwrap_or_default(),
        },
    })
}

/// The lowest id that a row of this time can have: ids begin with the time in milliseconds (RFC 9562, version 7).
fn first_id_after(time_ms: i64) -> String {
    let ms = u64::try_from(time_ms).unwrap_or(0) & ((1 << 48) - 1);
    Uuid::from_u128(u128::from(ms) << 80).to_string()
}
