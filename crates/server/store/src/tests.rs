//! The conformance suite: every case runs on SQLite and on PostgreSQL.
//!
//! A case gets a [`Place`]: a new database with two handles. In SQLite both are of one process; in PostgreSQL each is
//! what a process of its own would open.

mod tenants;
mod keys;
mod submissions;
mod lists;
mod lineage;
mod batches;
mod datasets;
mod recordings;
mod recording_events;
mod tenant_events;
mod deletion;
mod labels;
mod claims;
mod turns;
mod deaths;
mod background_work;
mod stage_claims;
mod fences;
mod stages;
mod wake_ups;
mod frozen;
mod limits;
mod tenant_limits;
mod webhooks;
mod upgrade;

use std::collections::BTreeMap;
use std::time::Duration;

use serde_json::json;

use super::calls::NewCall;
use super::checkpoints::{Checkpoint, StageKey};
use super::queue::{Claim, Scope};
use super::scenes::{NewScene, SubmitOutcome};
use super::*;
use crate::lifecycle::{Failure, FailureClass, JobKind, JobState};
use scene::{JobId, SceneId};

/// Lone deaths without progress after which work fails.
const MAX_DEATHS: u32 = 3;

/// A new store and two handles on it.
pub(super) struct Place {
    handles: [Store; 2],
    _directories: [tempfile::TempDir; 2],
}

impl Place {
    async fn sqlite() -> Self {
        let directories = [(); 2].map(|()| tempfile::tempdir().expect("temporary directory"));
        let settings = settings(DatabaseAddress::Sqlite);
        let store = Store::open(directories[0].path(), &settings, Intent::Create).await.expect("opens");
        Self { handles: [store.clone(), store], _directories: directories }
    }

    async fn postgres() -> Self {
        let directories = [(); 2].map(|()| tempfile::tempdir().expect("temporary directory"));
        let settings = settings(DatabaseAddress::Postgres(test_postgres::database().await));
        let first = Store::open(directories[0].path(), &settings, Intent::Create).await.expect("opens");
        let second = Store::open(directories[1].path(), &settings, Intent::Create).await.expect("opens");
        Self { handles: [first, second], _directories: directories }
    }

    fn store(&self) -> &Store {
        &self.handles[0]
    }

    /// The handles in turn.
    fn handle(&self, index: usize) -> Store {
        self.handles[index % 2].clone()
    }
}

fn settings(database: DatabaseAddress) -> Settings {
    Settings {
        database,
        fsync: false,
        blobs: BlobPlace::Memory,
        readers: 1,
        connections: 8,
        busy_timeout_ms: 5000,
        ..test_settings::section("store")
    }
}

macro_rules! conformance {
    ($($module:ident::$case:ident,)+) => {
        mod sqlite {
            $(#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
            async fn $case() {
                super::$module::$case(super::Place::sqlite().await).await;
            })+
        }

        mod postgres {
            $(#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
            async fn $case() {
                super::$module::$case(super::Place::postgres().await).await;
            })+
        }
    };
}

conformance! {
    tenants::queries_of_another_tenant_find_and_change_nothing,
    keys::a_key_opens_until_it_expires_or_is_revoked,
    keys::keys_are_listed_by_tenant_newest_first_without_their_secrets,
    keys::the_use_of_a_key_is_noted_once_a_minute,
    keys::a_session_ends_by_its_time_its_end_or_its_key,
    keys::the_record_is_listed_by_tenant_and_never_changed,
    submissions::one_key_at_once_makes_one_scene,
    submissions::another_body_under_a_key_is_refused,
    submissions::one_key_at_once_makes_one_execution_of_each_tenant,
    submissions::lists_filter_by_state_label_and_age_newest_first,
    submissions::a_dropped_caller_leaves_a_whole_submission,
    lists::jobs_are_listed_by_state_kind_scene_and_age_newest_first,
    lists::scenes_are_filtered_and_counted_by_what_they_are,
    lists::places_follow_rank_and_age_and_ends_the_durations_so_far,
    lineage::ancestors_come_oldest_first_and_children_newest_first,
    batches::feeders_at_once_give_every_item_one_scene,
    batches::items_settle_as_their_scenes_end,
    batches::a_cancelled_batch_stops_and_a_retry_makes_the_rest,
    batches::items_together_stay_within_the_budget_of_their_batch,
    batches::a_key_makes_one_batch_which_appears_whole,
    batches::a_batch_leaves_half_of_the_queue_to_others,
    batches::requests_of_a_recipe_get_their_items_once_and_stop_with_their_batch,
    datasets::freezes_of_one_name_follow_each_other,
    datasets::of_claims_at_once_each_dataset_goes_to_one_process,
    datasets::a_dead_freezer_is_replaced_and_fenced,
    datasets::a_version_is_verified_on_request,
    datasets::a_freeze_is_cancelled_and_repeated_as_any_job,
    datasets::files_and_keys_belong_to_their_dataset_and_tenant,
    recordings::attempts_are_given_out_once_and_the_rest_goes_on_after_a_death,
    recordings::attempts_at_once_are_numbered_without_gaps,
    recordings::another_identity_begins_anew_and_too_often_fails,
    recordings::a_recording_ends_with_any_of_its_jobs,
    recordings::a_cancelled_recording_takes_nothing_more,
    recordings::a_dataset_is_assembled_by_one_process_and_outlives_sweeps,
    recordings::keys_and_lists_belong_to_their_tenant,
    recording_events::every_change_has_an_event_with_the_progress_after_it,
    recording_events::ends_and_new_beginnings_have_events,
    recording_events::attempts_kept_at_once_have_events_without_gaps,
    tenant_events::events_of_jobs_and_recordings_have_one_order,
    tenant_events::a_reader_skips_nothing_of_writers_at_once,
    deletion::a_dataset_that_is_deleted_stops_and_goes,
    deletion::a_version_stays_whole_when_others_and_its_scenes_go,
    deletion::a_number_of_a_version_is_not_used_again,
    deletion::a_recording_that_is_deleted_stops_and_goes,
    deletion::a_batch_that_is_deleted_leaves_its_scenes_unless_they_go_with_it,
    deletion::scenes_left_by_a_dead_process_go_with_their_batch,
    deletion::what_has_ended_goes_after_its_time,
    deletion::all_rows_and_blobs_go_with_what_is_deleted,
    labels::labels_are_replaced_and_found_by_their_new_values,
    labels::changes_at_once_follow_each_other,
    claims::jobs_are_claimed_oldest_first_and_once_each,
    claims::a_claim_may_be_restricted_to_one_job,
    claims::an_expired_lease_is_claimed_again_with_the_next_epoch,
    claims::a_job_whose_workers_died_too_often_fails,
    claims::only_charged_attempts_count,
    claims::a_delayed_job_waits,
    claims::a_scene_is_retried_once_at_a_time,
    claims::a_cancellation_and_an_end_at_once_leave_one_final_state,
    turns::priority_goes_before_age_within_a_tenant,
    turns::tenants_take_turns_however_many_jobs_one_has_queued,
    turns::the_tenant_with_fewer_active_jobs_goes_first,
    turns::a_job_starts_at_its_time_and_fails_after_its_deadline,
    turns::a_claim_knows_the_time_until_its_deadline,
    turns::a_request_of_a_newer_version_is_left_to_newer_workers,
    turns::a_pause_stops_claims_and_nothing_else,
    turns::a_full_queue_refuses_new_jobs_and_keeps_the_promise_of_keys,
    deaths::no_job_is_charged_for_a_shared_death,
    deaths::after_two_deaths_a_job_runs_alone_until_its_next_checkpoint,
    deaths::a_busy_worker_makes_room_for_a_suspect_while_others_go_on,
    deaths::a_job_that_kills_its_process_alone_is_failed_with_a_diagnosis,
    deaths::a_job_that_is_cancelled_while_its_worker_is_dead_needs_no_worker,
    background_work::a_success_of_any_kind_has_an_event,
    background_work::a_recording_that_kills_its_process_alone_waits_and_fails,
    background_work::a_freeze_that_kills_its_process_alone_waits_and_fails,
    background_work::a_freeze_that_fails_is_tried_again_after_a_delay_and_so_often,
    background_work::an_attempt_that_fails_is_tried_again_after_a_delay_and_so_often,
    background_work::assembling_that_fails_is_tried_again_after_a_delay_and_so_often,
    background_work::an_episode_that_is_lost_again_and_again_ends_its_recording,
    background_work::a_new_file_of_a_version_is_progress,
    background_work::a_pause_holds_datasets_and_recordings,
    background_work::work_of_any_kind_beside_other_work_is_not_blamed,
    background_work::suspects_of_any_kind_run_alone_in_their_process,
    stage_claims::a_claim_lasts_as_long_as_its_jobs_lease,
    stage_claims::of_many_jobs_one_gets_the_key,
    fences::a_lost_lease_refuses_every_write,
    fences::calls_at_once_stay_within_the_budget,
    fences::calls_of_a_dead_worker_have_an_unknown_outcome,
    stages::a_checkpoint_reads_back_and_can_be_forgotten,
    stages::stages_tell_whether_they_were_reused_and_how_often_they_ran,
    stages::events_are_numbered_without_gaps,
    stages::files_of_a_scene_are_listed_in_byte_order,
    wake_ups::a_change_of_one_handle_wakes_the_other,
    tenant_limits::work_at_once_stays_within_the_limit_of_what_waits,
    tenant_limits::a_refusal_counts_for_a_moment_or_until_there_is_room,
    tenant_limits::work_at_once_stays_within_the_submissions_of_a_minute,
    tenant_limits::no_claims_at_once_exceed_the_jobs_that_a_tenant_may_run,
    tenant_limits::tenants_take_turns_over_work_of_all_kinds,
    tenant_limits::spending_of_a_month_stays_within_its_limit_and_outlives_the_calls,
    tenant_limits::retries_and_verifications_count_as_submissions,
    tenant_limits::batches_at_once_stay_within_the_requests_of_their_tenant,
    tenant_limits::feeding_waits_for_the_limits_of_its_tenant,
    tenant_limits::an_operator_sees_and_changes_the_limits_of_a_tenant,
    webhooks::every_way_to_the_end_of_a_scene_has_one_message,
    webhooks::every_end_of_other_work_has_one_message,
    webhooks::every_end_of_a_recording_has_one_message,
    webhooks::a_change_and_its_message_are_one,
    webhooks::only_enabled_webhooks_that_want_an_event_get_it,
    webhooks::each_delivery_is_taken_by_one_process_and_given_again_after_a_death,
    webhooks::claims_at_once_give_each_delivery_out_once,
    webhooks::failures_to_the_end_disable_a_webhook,
    webhooks::a_new_secret_signs_beside_the_previous_one_for_a_day,
    webhooks::webhooks_belong_to_their_tenant,
    webhooks::deliveries_go_after_their_time,
}

/// A submission without a key and with a budget of 1,000 millionths.
fn new_scene() -> NewScene {
    NewScene {
        tenant_id: DEFAULT_TENANT.clone(),
        parent_id: None,
        request: json!({ "seed": 1 }),
        labels: BTreeMap::new(),
        budget_micro_usd: 1_000,
        idempotency: None,
    }
}

async fn submitted(store: &Store) -> (SceneId, JobId) {
    match store.submit(new_scene()).await.expect("submits") {
        SubmitOutcome::Created { scene_id, job_id, .. } => (scene_id, job_id),
        other => panic!("a submission without a key is {other:?}"),
    }
}

/// Claims a job for a minute.
async fn claimed(store: &Store, owner: &str) -> Claim {
    store
        .claim(owner, Duration::from_secs(60), 3, &Scope::all())
        .await
        .expect("claims")
        .expect("there is a job")
}

fn stage(name: &str) -> StageKey {
    StageKey {
        tenant_id: DEFAULT_TENANT.clone(),
        stage: name.into(),
        version: 1,
        instance: String::new(),
        key: Digest::of(name.as_bytes()),
    }
}

fn checkpoint() -> Checkpoint {
    Checkpoint { output: Digest::of(b"output"), artifacts: Vec::new(), elapsed_ms: 1 }
}

/// A call that reserves an amount.
fn call(reserved_micro_usd: i64) -> NewCall {
    NewCall {
        stage: "alpha".into(),
        instance: String::new(),
        port: "analyst".into(),
        provider: "p".into(),
        model: "m".into(),
        endpoint: "e".into(),
        operation: "o".into(),
        request_digest: "d".into(),
        idempotency_key: "k".into(),
        attempt: 1,
        reserved_micro_usd,
        sent_bytes: 1,
        refuse_after_unknown: false,
    }
}

#[tokio::test]
async fn a_database_of_a_newer_version_is_refused() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let url = test_postgres::database().await;
    for database in [DatabaseAddress::Sqlite, DatabaseAddress::Postgres(url)] {
        let settings = settings(database);
        let store = Store::open(directory.path(), &settings, Intent::Create).await.expect("opens");
        let insert = "INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time)
                      SELECT 9999, 'newer', success, checksum, 0 FROM _sqlx_migrations WHERE version = 1";
        let newer = store.writer.write("pretend a newer version", move |connection| {
            Box::pin(async move {
                sqlx::query(insert).execute(connection).await?;
                Ok(())
            })
        });
        newer.await.expect("inserts");
        drop(store);
        let error = loop {
            match Store::open(directory.path(), &settings, Intent::Create).await {
                // The writer's thread lets go of the lock a moment later.
                Err(StoreError::Locked { .. }) => tokio::time::sleep(Duration::from_millis(10)).await,
                Err(error) => break error,
                Ok(_) => panic!("a newer version opens"),
            }
        };
        assert!(matches!(error, StoreError::Migrate(_)), "{error:?}");
    }
}
