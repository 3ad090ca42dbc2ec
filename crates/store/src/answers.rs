//! Answers of remote models, kept beside their calls until their stage is done: whoever comes after a dead worker reads
//! them in place of paying again.

use super::queue::guard;
use super::{Digest, Lease, Store, StoreError};

impl Store {
    /// The blob with an answer to a question in a job, leaving out the first `skip` that came.
    pub async fn answer_of(
        &self,
        job_id: &str,
        idempotency_key: &str,
        skip: u32,
    ) -> Result<Option<Digest>, StoreError> {
        let file: Option<String> = sqlx::query_scalar(
            "SELECT answer_file FROM calls
             WHERE job_id = ? AND idempotency_key = ? AND answer_file IS NOT NULL
             ORDER BY id LIMIT 1 OFFSET ?",
        )
        .bind(job_id)
        .bind(idempotency_key)
        .bind(skip)
        .fetch_optional(&self.readers)
        .await?;
        file.map(|digest| Digest::parse(&digest)).transpose()
    }

    /// What was answered to this stage (of this instance; empty = the whole scene) is not to be used again.
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
                    sqlx::query(
                        "UPDATE calls SET answer_file = NULL WHERE job_id = ? AND stage = ? AND instance = ?",
                    )
                    .bind(&lease.job_id)
                    .bind(stage)
                    .bind(&instance)
                    .execute(connection)
                    .await?;
                    Ok(())
                })
            })
            .await
    }
}
