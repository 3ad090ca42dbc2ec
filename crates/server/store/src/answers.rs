//! Recorded answers of remote models. They are kept with their calls until the stage is done, so that the next worker
//! after a crash reads them instead of paying again.

use sqlx::AnyConnection;

use super::queue::guard;
use super::{Digest, Lease, Store, StoreError};
use crate::boxed;
use scene::JobId;

impl Store {
    /// The blob with the answer to a question of a job; the oldest `skip` answers are skipped.
    #[boxed]
    pub async fn answer_of(
        &self,
        job_id: &JobId,
        idempotency_key: &str,
        skip: u32,
    ) -> Result<Option<Digest>, StoreError> {
        let file: Option<String> = sqlx::query_scalar(
            "SELECT answer_file FROM calls
             WHERE job_id = $1 AND idempotency_key = $2 AND answer_file IS NOT NULL
             ORDER BY id LIMIT 1 OFFSET $3",
        )
        .bind(job_id.as_str())
        .bind(idempotency_key)
        .bind(i64::from(skip))
        .fetch_optional(&self.readers)
        .await?;
        file.map(|digest| Digest::parse(&digest)).transpose()
    }

    /// Discards the recorded answers of a stage (of one instance; empty = the whole scene).
    #[boxed]
    pub async fn forget_answers(
        &self,
        lease: &Lease,
        stage: &'static str,
        instance: &str,
    ) -> Result<(), StoreError> {
        let (lease, instance) = (lease.clone(), instance.to_owned());
        self.writer
            .write("forget answers", move |connection| {
                Box::pin(async move {
                    guard(connection, &lease).await?;
                    forget(connection, &lease.job_id, stage, &instance).await
                })
            })
            .await
    }

    /// The same of calls about a finished scene, which are booked in its last job.
    #[boxed]
    pub async fn forget_answers_about(&self, job_id: &JobId, stage: &'static str) -> Result<(), StoreError> {
        let job_id = job_id.clone();
        self.writer
            .write("forget answers about a scene", move |connection| {
                Box::pin(async move { forget(connection, &job_id, stage, "").await })
            })
            .await
    }
}

async fn forget(
    connection: &mut AnyConnection,
    job_id: &JobId,
    stage: &str,
    instance: &str,
) -> Result<(), StoreError> {
    sqlx::query("UPDATE calls SET answer_file = NULL WHERE job_id = $1 AND stage = $2 AND instance = $3")
        .bind(job_id.as_str())
        .bind(stage)
        .bind(instance)
        .execute(connection)
        .await?;
    Ok(())
}
