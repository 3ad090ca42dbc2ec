//! A process that stops within a transaction. On PostgreSQL alone: SQLite has one process.

use std::sync::Arc;
use std::time::Instant;

use tokio::sync::Notify;

use super::*;

/// `store.postgres.idle_transaction_timeout_ms` of the default settings.
const MAX_SILENCE: Duration = Duration::from_secs(4);

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_process_that_stops_within_a_transaction_gives_its_jobs_up() {
    let place = Place::postgres().await;
    submitted(place.store()).await;
    let (stopped, heir) = (place.handle(0), place.handle(1));
    let locked = Arc::new(Notify::new());
    let has_locked = locked.clone();
    let began = Instant::now();
    tokio::spawn(async move {
        let stop = stopped.writer.write("stop", move |connection| {
            Box::pin(async move {
                sqlx::query("SELECT id FROM jobs FOR UPDATE").fetch_all(&mut *connection).await?;
                has_locked.notify_one();
                std::future::pending::<Result<(), StoreError>>().await
            })
        });
        let _ = stop.await;
    });
    locked.notified().await;
    let scope = Scope::all();
    let claim = || heir.claim("heir", Duration::from_secs(60), 3, &scope);
    assert!(claim().await.expect("answers").is_none(), "its row is locked");
    let claimed = tokio::time::timeout(3 * MAX_SILENCE, async {
        loop {
            if let Some(claimed) = claim().await.expect("answers") {
                return claimed;
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    });
    claimed.await.expect("the job is claimed although its row was locked");
    assert!(began.elapsed() >= MAX_SILENCE - Duration::from_millis(500), "not before its time");
}
