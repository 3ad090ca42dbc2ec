//! The databases that a store may have: a test about several workers runs on each.

use store::{BlobPlace, DatabaseAddress, Intent, Settings, Store};

use crate::harness::server::settings;

/// Runs a test on a new SQLite file and on a new PostgreSQL database. Clones of the store share its blobs, as processes
/// share a bucket.
pub async fn on_each_database(test: impl AsyncFn(Store)) {
    for database in [DatabaseAddress::Sqlite, DatabaseAddress::Postgres(test_postgres::database().await)] {
        let directory = tempfile::tempdir().expect("temporary directory");
        let settings = Settings { database, blobs: BlobPlace::Memory, ..settings(&[]).config.store };
        test(Store::open(directory.path(), &settings, Intent::Create).await.expect("opens")).await;
    }
}
