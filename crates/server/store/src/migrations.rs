//! Migrations of both databases: the files below `migrations/`, which the program holds.
//!
//! `sqlx::migrate!` finds the files by itself, but has the compiler build both drivers and SQLite a second time for its
//! own use.

use std::sync::LazyLock;

use sqlx::migrate::{Migration, MigrationType, Migrator};
use sqlx::{SqlSafeStr, SqlStr};

/// Names and texts of the files of a database.
macro_rules! files {
    ($folder:literal) => {
        files! { $folder:
            "0001_initial"
            "0002_calls"
            "0003_tasks"
            "0004_answers"
            "0005_queue"
            "0007_retention"
            "0012_lists"
            "0034_batches"
            "0035_datasets"
            "0036_recordings"
            "0037_recording_events"
            "0038_indexes"
            "0039_deaths"
            "0040_setbacks_and_labels"
            "0041_datasets_are_jobs"
            "0042_recordings_are_jobs"
            "0043_executions"
            "0044_principals"
            "0045_deletion"
            "0046_limits"
            "0047_webhooks"
            "0048_scene_facts"
            "0049_event_positions"
        }
    };
    ($folder:literal: $($name:literal)+) => {
        [$(($name, include_str!(concat!("../../../../migrations/", $folder, "/", $name, ".sql")))),+]
    };
}

pub(super) static SQLITE: LazyLock<Migrator> = LazyLock::new(|| migrator(&files!("sqlite")));

#[cfg(feature = "postgres")]
pub(super) static POSTGRES: LazyLock<Migrator> = LazyLock::new(|| migrator(&files!("postgres")));

/// The migrations of files whose names are a version, `_` and a description, as sqlx reads them from a folder.
fn migrator(files: &[(&'static str, &'static str)]) -> Migrator {
    let migration = |(name, sql): &(&'static str, &'static str)| {
        let (version, description) = name.split_once('_')?;
        let (description, sql): (_, SqlStr) = (description.replace('_', " ").into(), (*sql).into_sql_str());
        Some(Migration::new(version.parse().ok()?, description, MigrationType::Simple, sql, false))
    };
    Migrator::with_migrations(files.iter().filter_map(migration).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[tokio::test]
    async fn the_program_holds_every_file() {
        let databases = [
            ("sqlite", &SQLITE),
            #[cfg(feature = "postgres")]
            ("postgres", &POSTGRES),
        ];
        for (folder, held) in databases {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../migrations").join(folder);
            let found = Migrator::new(path.as_path()).await.expect("reads the folder");
            let facts = |migrator: &Migrator| -> Vec<_> {
                let fact = |m: &Migration| {
                    (m.version, m.description.to_string(), m.migration_type, m.checksum.to_vec(), m.no_tx)
                };
                migrator.iter().map(fact).collect()
            };
            assert_eq!(facts(held), facts(&found), "{folder}");
        }
    }
}
