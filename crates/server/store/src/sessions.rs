//! Sessions of browsers: a cookie stands for a key for some hours. The key decides tenant and scopes at every request,
//! and the session ends with it.

use sqlx::AssertSqlSafe;

use super::database::Dialect;
use super::keys::{Grant, Validity, grant_of, key_query};
use super::{Digest, Store, StoreError};
use crate::boxed;

impl Store {
    /// Begins a session with the key of a digest, for so long or until the key expires. The grant is that of the
    /// session if the key is valid, else that of the key; `None` without such a key. Sessions that have ended are
    /// removed.
    #[boxed]
    pub async fn begin_session(
        &self,
        key: &Digest,
        session: &Digest,
        lifetime_ms: i64,
    ) -> Result<Option<Grant>, StoreError> {
        let (key, session) = (key.clone(), session.clone());
        self.writer
            .write("begin a session", move |connection| {
                Box::pin(async move {
                    let query = key_query(Dialect::of(connection));
                    let query = sqlx::query(AssertSqlSafe(query)).bind(key.as_str());
                    let row = query.fetch_optional(&mut *connection).await?;
                    let Some(mut grant) = row.as_ref().map(grant_of).transpose()? else { return Ok(None) };
                    if grant.validity != Validity::Valid {
                        return Ok(Some(grant));
                    }
                    let now = grant.now_ms;
                    let end = now.saturating_add(lifetime_ms);
                    let end = grant.expires_at_ms.map_or(end, |key_ends| key_ends.min(end));
                    grant.expires_at_ms = Some(end);
                    sqlx::query("DELETE FROM sessions WHERE expires_at <= $1")
                        .bind(now)
                        .execute(&mut *connection)
                        .await?;
                    sqlx::query(
                        "INSERT INTO sessions (digest, key_id, created_at, expires_at) VALUES ($1, $2, $3, $4)",
                    )
                    .bind(session.as_str())
                    .bind(grant.key_id.as_str())
                    .bind(now)
                    .bind(end)
                    .execute(connection)
                    .await?;
                    Ok(Some(grant))
                })
            })
            .await
    }

    /// The grant of a session with this digest.
    #[boxed]
    pub async fn session_grant(&self, digest: &Digest) -> Result<Option<Grant>, StoreError> {
        let query = format!(
            "SELECT api_keys.*, sessions.expires_at AS session_ends, {} AS now
             FROM sessions JOIN api_keys ON api_keys.id = sessions.key_id WHERE sessions.digest = $1",
            self.readers.dialect().now_ms()
        );
        let row =
            sqlx::query(AssertSqlSafe(query)).bind(digest.as_str()).fetch_optional(&self.readers).await?;
        let grant = row.as_ref().map(grant_of).transpose()?;
        self.note_use(grant.as_ref());
        Ok(grant)
    }

    /// Ends a session, if there is one.
    #[boxed]
    pub async fn end_session(&self, digest: &Digest) -> Result<(), StoreError> {
        let digest = digest.clone();
        self.writer
            .write("end a session", move |connection| {
                Box::pin(async move {
                    let query = sqlx::query("DELETE FROM sessions WHERE digest = $1").bind(digest.as_str());
                    query.execute(connection).await?;
                    Ok(())
                })
            })
            .await
    }
}
