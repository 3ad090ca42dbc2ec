//! Keys of the API: made, listed, revoked, and found by the digest of their secret.
//!
//! Whether a key has expired or is revoked is decided by the database's clock at every look-up, so that a revocation
//! holds in every process from the next request on. The time of the last use is written at most once a minute.

use serde::Serialize;
use sqlx::any::AnyRow;
use sqlx::{AnyConnection, AssertSqlSafe, Connection, Row};
use uuid::Uuid;

use super::audit::{self, AuditEntry, AuditFilter, AuditRow};
use super::database::Dialect;
use super::list_query::ListQuery;
use super::scopes::ScopeSet;
use super::secret::Secret;
use super::{Digest, Operator, Store, StoreError, database};
use crate::boxed;
use scene::{KeyId, TenantId};

/// Shortest and longest time of a key, seconds: a minute, ten years.
pub const MIN_LIFETIME_SECS: u64 = 60;
pub const MAX_LIFETIME_SECS: u64 = 315_360_000;

/// Uses of a key within this time count as one.
const USE_PERIOD_MS: i64 = 60_000;

/// Whether a text may name a key: 1 to 100 characters without control characters.
pub fn is_name(text: &str) -> bool {
    (1..=100).contains(&text.chars().count()) && !text.chars().any(char::is_control)
}

/// A key to be made.
#[derive(Clone, Debug)]
pub struct NewKey {
    pub tenant_id: TenantId,
    /// For people.
    pub name: String,
    pub scopes: ScopeSet,
    /// Time from now after which it opens nothing, milliseconds.
    pub lifetime_ms: Option<i64>,
}

/// A key's row. The secret is in no row.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct KeyRow {
    pub id: KeyId,
    pub tenant_id: TenantId,
    pub name: String,
    pub scopes: ScopeSet,
    /// Milliseconds since 1970, as all times here.
    pub created_at_ms: i64,
    pub expires_at_ms: Option<i64>,
    pub revoked_at_ms: Option<i64>,
    /// To a minute.
    pub last_used_at_ms: Option<i64>,
}

/// Keys of a list.
#[derive(Clone, Debug, Default)]
pub struct KeyFilter {
    /// Only keys before this one in the list.
    pub before_id: Option<KeyId>,
    pub limit: u32,
}

/// Result of a revocation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RevokeOutcome {
    /// The key opens nothing any more, and its sessions have ended.
    Revoked,
    /// The key was revoked before.
    WasRevoked,
    NotFound,
}

/// Whether a secret opens anything now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Validity {
    Valid,
    Expired,
    Revoked,
}

/// Rights of whom a secret was given to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grant {
    pub key_id: KeyId,
    pub tenant_id: TenantId,
    pub scopes: ScopeSet,
    pub validity: Validity,
    /// Time until which it opens something, milliseconds since 1970; that of the session where it is one.
    pub expires_at_ms: Option<i64>,
    /// Milliseconds since 1970 by the database's clock.
    pub now_ms: i64,
    is_use_old: bool,
}

impl Store {
    /// Makes a key. Its secret is returned here alone.
    #[boxed]
    pub async fn create_key(&self, new: NewKey) -> Result<(KeyRow, Secret), StoreError> {
        let secret = Secret::new_key()?;
        let digest = secret.digest();
        let insert = self.writer.write("make a key", move |connection| {
            Box::pin(async move { insert(connection, &new, &digest).await })
        });
        Ok((insert.await?, secret))
    }

    /// Keys of a tenant, newest first, those that open nothing any more included.
    #[boxed]
    pub async fn keys(&self, tenant_id: &TenantId, filter: KeyFilter) -> Result<Vec<KeyRow>, StoreError> {
        let query = ListQuery::of(tenant_id).text("id <", filter.before_id);
        let rows = query.select("api_keys", filter.limit).rows(&self.readers).await?;
        rows.iter().map(key_of).collect()
    }

    /// Revokes a key of the tenant and ends its sessions.
    #[boxed]
    pub async fn revoke_key(&self, tenant_id: &TenantId, id: &KeyId) -> Result<RevokeOutcome, StoreError> {
        let (tenant_id, id) = (tenant_id.clone(), id.clone());
        self.writer
            .write("revoke a key", move |connection| {
                Box::pin(async move {
                    let row = find(connection, &id).await?.filter(|key| key.tenant_id == tenant_id);
                    revoke(connection, row.as_ref()).await
                })
            })
            .await
    }

    /// Whether any key was ever made.
    #[boxed]
    pub async fn has_keys(&self) -> Result<bool, StoreError> {
        let query = "SELECT 1 FROM api_keys LIMIT 1";
        Ok(sqlx::query(query).fetch_optional(&self.readers).await?.is_some())
    }

    /// The grant of a key with this digest.
    #[boxed]
    pub async fn key_grant(&self, digest: &Digest) -> Result<Option<Grant>, StoreError> {
        let query = key_query(self.readers.dialect());
        let row =
            sqlx::query(AssertSqlSafe(query)).bind(digest.as_str()).fetch_optional(&self.readers).await?;
        let grant = row.as_ref().map(grant_of).transpose()?;
        self.note_use(grant.as_ref());
        Ok(grant)
    }

    /// Writes that a key was used, in the background: a request does not wait for it.
    pub(super) fn note_use(&self, grant: Option<&Grant>) {
        let Some(grant) = grant.filter(|grant| grant.validity == Validity::Valid && grant.is_use_old) else {
            return;
        };
        let (store, id, now) = (self.clone(), grant.key_id.clone(), grant.now_ms);
        tokio::spawn(async move {
            let written = store.writer.write("note the use of a key", move |connection| {
                Box::pin(async move {
                    sqlx::query(
                        "UPDATE api_keys SET last_used_at = $1
                         WHERE id = $2 AND (last_used_at IS NULL OR last_used_at <= $3)",
                    )
                    .bind(now)
                    .bind(id.as_str())
                    .bind(now - USE_PERIOD_MS)
                    .execute(connection)
                    .await?;
                    Ok(())
                })
            });
            if let Err(error) = written.await {
                tracing::debug!(error = error.chain(), "the use of a key was not noted");
            }
        });
    }
}

/// The statement that reads a key by its digest, as [`grant_of`] wants the row.
pub(super) fn key_query(dialect: Dialect) -> String {
    let now = dialect.now_ms();
    format!("SELECT api_keys.*, NULL AS session_ends, {now} AS now FROM api_keys WHERE digest = $1")
}

impl Operator {
    /// Makes a key, and records that in the same transaction.
    #[boxed]
    pub async fn create_key(&mut self, new: NewKey) -> Result<(KeyRow, Secret), StoreError> {
        let secret = Secret::new_key()?;
        let mut transaction = self.connection.begin().await?;
        let key = insert(&mut transaction, &new, &secret.digest()).await?;
        audit::insert(&mut transaction, &AuditEntry::of_operator("createKey", &key, 201)).await?;
        transaction.commit().await?;
        Ok((key, secret))
    }

    /// Keys of a tenant or of all, newest first.
    #[boxed]
    pub async fn list_keys(
        &mut self,
        tenant_id: Option<&TenantId>,
        filter: KeyFilter,
    ) -> Result<Vec<KeyRow>, StoreError> {
        let query = tenant_id.map_or_else(ListQuery::of_all, ListQuery::of).text("id <", filter.before_id);
        let rows = query.select("api_keys", filter.limit).rows(&mut self.connection).await?;
        rows.iter().map(key_of).collect()
    }

    /// Revokes a key of any tenant, and records that in the same transaction.
    #[boxed]
    pub async fn revoke_key(&mut self, id: &KeyId) -> Result<RevokeOutcome, StoreError> {
        // A transaction of SQLite that reads before it writes fails where another process writes between.
        let key = find(&mut self.connection, id).await?;
        let mut transaction = self.connection.begin().await?;
        let outcome = revoke(&mut transaction, key.as_ref()).await?;
        if let Some(key) = &key {
            audit::insert(&mut transaction, &AuditEntry::of_operator("revokeKey", key, 204)).await?;
        }
        transaction.commit().await?;
        Ok(outcome)
    }

    /// The record of changes of a tenant or of all, newest first.
    #[boxed]
    pub async fn audit(
        &mut self,
        tenant_id: Option<&TenantId>,
        filter: AuditFilter,
    ) -> Result<Vec<AuditRow>, StoreError> {
        let query = tenant_id.map_or_else(ListQuery::of_all, ListQuery::of);
        let rows = filter.of(query).rows(&mut self.connection).await?;
        rows.iter().map(audit::row_of).collect()
    }
}

async fn insert(connection: &mut AnyConnection, new: &NewKey, digest: &Digest) -> Result<KeyRow, StoreError> {
    let now = database::now_ms(connection).await?;
    let id: KeyId = database::parse_id(&Uuid::now_v7().to_string(), "api_keys")?;
    let expires_at_ms = new.lifetime_ms.map(|lifetime| now.saturating_add(lifetime));
    sqlx::query(
        "INSERT INTO api_keys (id, tenant_id, name, digest, scopes, created_at, expires_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7)",
    )
    .bind(id.as_str())
    .bind(new.tenant_id.as_str())
    .bind(&new.name)
    .bind(digest.as_str())
    .bind(new.scopes.to_string())
    .bind(now)
    .bind(expires_at_ms)
    .execute(connection)
    .await?;
    Ok(KeyRow {
        id,
        tenant_id: new.tenant_id.clone(),
        name: new.name.clone(),
        scopes: new.scopes.clone(),
        created_at_ms: now,
        expires_at_ms,
        revoked_at_ms: None,
        last_used_at_ms: None,
    })
}

async fn find(connection: &mut AnyConnection, id: &KeyId) -> Result<Option<KeyRow>, StoreError> {
    let query = sqlx::query("SELECT * FROM api_keys WHERE id = $1").bind(id.as_str());
    query.fetch_optional(connection).await?.as_ref().map(key_of).transpose()
}

async fn revoke(connection: &mut AnyConnection, key: Option<&KeyRow>) -> Result<RevokeOutcome, StoreError> {
    let Some(key) = key else { return Ok(RevokeOutcome::NotFound) };
    let now = database::now_ms(connection).await?;
    sqlx::query("DELETE FROM sessions WHERE key_id = $1")
        .bind(key.id.as_str())
        .execute(&mut *connection)
        .await?;
    let revoked = sqlx::query("UPDATE api_keys SET revoked_at = $1 WHERE id = $2 AND revoked_at IS NULL")
        .bind(now)
        .bind(key.id.as_str())
        .execute(connection)
        .await?;
    Ok(if revoked.rows_affected() == 0 { RevokeOutcome::WasRevoked } else { RevokeOutcome::Revoked })
}

fn key_of(row: &AnyRow) -> Result<KeyRow, StoreError> {
    Ok(KeyRow {
        id: database::id(row, "api_keys", "id")?,
        tenant_id: database::id(row, "api_keys", "tenant_id")?,
        name: row.try_get("name")?,
        scopes: scopes_of(row)?,
        created_at_ms: row.try_get("created_at")?,
        expires_at_ms: row.try_get("expires_at")?,
        revoked_at_ms: row.try_get("revoked_at")?,
        last_used_at_ms: row.try_get("last_used_at")?,
    })
}

fn scopes_of(row: &AnyRow) -> Result<ScopeSet, StoreError> {
    let text: String = row.try_get("scopes")?;
    ScopeSet::parse(&text)
        .map_err(|error| StoreError::Corrupt { table: "api_keys", reason: error.to_string() })
}

/// The grant of a row of a key with `session_ends` and `now` beside it.
pub(super) fn grant_of(row: &AnyRow) -> Result<Grant, StoreError> {
    let now_ms: i64 = row.try_get("now")?;
    let key_ends: Option<i64> = row.try_get("expires_at")?;
    let session_ends: Option<i64> = row.try_get("session_ends")?;
    let revoked: Option<i64> = row.try_get("revoked_at")?;
    let last_used: Option<i64> = row.try_get("last_used_at")?;
    let expires_at_ms = [key_ends, session_ends].into_iter().flatten().min();
    let validity = match (revoked, expires_at_ms) {
        (Some(_), _) => Validity::Revoked,
        (None, Some(end)) if end <= now_ms => Validity::Expired,
        _ => Validity::Valid,
    };
    Ok(Grant {
        key_id: database::id(row, "api_keys", "id")?,
        tenant_id: database::id(row, "api_keys", "tenant_id")?,
        scopes: scopes_of(row)?,
        validity,
        expires_at_ms,
        now_ms,
        is_use_old: last_used.is_none_or(|last| last <= now_ms - USE_PERIOD_MS),
    })
}
