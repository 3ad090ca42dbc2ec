//! The feeder's transaction: settle what has ended, then put pending items into the queue, at most a window of them.
//!
//! A batch takes no more than half of the queue, and of what its tenant may have in it, so that other submissions are
//! accepted while it runs. Where a limit of the tenant leaves no room, its items wait. With a budget,
//! every item gets a share of what is neither spent nor promised to another item ([`BatchBudget`]).

use ::batches::{BatchBudget, BatchState, Grant, OutputError};
use sqlx::{AnyConnection, Row};

use super::begin::{begin, end_early, pending_items, submitted};
use super::expansion::is_expanding;
use super::settle::settle;
use super::{BatchRow, locked};
use crate::boxed;
use crate::limits::{self, LimitSettings};
use crate::{Store, StoreError, database, queue, webhooks};
use scene::{BatchId, MicroUsd, TenantId};

/// Items of one transaction, so that other writers do not wait long: each makes a scene with a job.
const MAX_ITEMS: i64 = 20;

/// By what rules batches are fed.
#[derive(Clone, Debug, PartialEq)]
pub struct FeedRules {
    pub queue: queue::Settings,
    /// Requests of one batch that are in the queue or worked on at the same time.
    pub window: i64,
    /// Whether budgets of batches hold back items: something that makes scenes can cost money.
    pub counts_money: bool,
}

/// Result of one transaction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fed {
    /// Items that were put into the queue.
    pub submitted: u64,
    /// Items that got their final state.
    pub settled: u64,
    /// More can be done at once.
    pub has_more: bool,
}

impl Store {
    /// Batches that are fed, oldest first.
    #[boxed]
    pub async fn active_batches(&self) -> Result<Vec<BatchId>, StoreError> {
        let ids: Vec<String> =
            sqlx::query_scalar("SELECT id FROM batches WHERE state IN ('running', 'cancelling') ORDER BY id")
                .fetch_all(&self.readers)
                .await?;
        ids.iter().map(|id| database::parse_id(id, "batches")).collect()
    }

    /// Settles items of a batch that have ended, and puts pending ones into the queue.
    #[boxed]
    pub async fn feed_batch(&self, id: &BatchId, rules: FeedRules) -> Result<Fed, StoreError> {
        if !self.needs_feeding(id, rules.window).await? {
            return Ok(Fed::default());
        }
        let tenant: String = sqlx::query_scalar("SELECT tenant_id FROM batches WHERE id = $1")
            .bind(id.as_str())
            .fetch_one(&self.readers)
            .await?;
        let tenant_id: TenantId = database::parse_id(&tenant, "batches")?;
        // A tenant that may store no more makes no more; what it has in the queue ends.
        let is_full = self.full_quota(&tenant_id).await.is_some();
        let rules = FeedRules { window: if is_full { 0 } else { rules.window }, ..rules };
        let (id, limits) = (id.clone(), *self.admission.settings());
        let fed = self
            .writer
            .unhurried()
            .write("feed a batch", move |connection| {
                Box::pin(async move { feed(connection, &id, &tenant_id, &rules, &limits).await })
            })
            .await?;
        if fed != Fed::default() {
            self.announce();
        }
        Ok(fed)
    }

    /// A cheap question, for feeders that are woken by changes of other jobs.
    async fn needs_feeding(&self, id: &BatchId, window: i64) -> Result<bool, StoreError> {
        let row = sqlx::query(
            "SELECT (SELECT COUNT(*) FROM batch_items WHERE batch_id = $1 AND state = 'submitted') AS submitted,
                    (SELECT COUNT(*) FROM batch_items AS i LEFT JOIN scenes AS s ON s.id = i.scene_id
                     WHERE i.batch_id = $1 AND i.state = 'submitted' AND (s.state IS NULL OR s.state <> 'pending')) AS ended,
                    (SELECT COUNT(*) FROM (SELECT 1 FROM batch_items
                                           WHERE batch_id = $1 AND state = 'pending' LIMIT 1) AS waiting) AS pending",
        )
        .bind(id.as_str())
        .fetch_one(&self.readers)
        .await?;
        let number = |column: &str| row.try_get::<i64, _>(column);
        let (submitted, ended, pending) = (number("submitted")?, number("ended")?, number("pending")?);
        Ok(ended > 0 || (pending > 0 && submitted < window) || (pending == 0 && submitted == 0))
    }
}

async fn feed(
    connection: &mut AnyConnection,
    id: &BatchId,
    tenant_id: &TenantId,
    rules: &FeedRules,
    limits: &LimitSettings,
) -> Result<Fed, StoreError> {
    // Before the batch is locked, as submissions lock it before all else.
    limits::one_at_a_time(connection, &limits::submissions_of(tenant_id)).await?;
    let Some(_) = locked(connection, id).await?.filter(|batch| !batch.state.is_final()) else {
        return Ok(Fed::default());
    };
    let now = database::now_ms(connection).await?;
    let mut fed = Fed { settled: settle(connection, id, now).await?, ..Fed::default() };
    // Read again: settling has changed what is spent.
    let Some(batch) = locked(connection, id).await? else { return Ok(fed) };
    let active = count(connection, id, "submitted").await?;
    if batch.state == BatchState::Running {
        let room = room(connection, &batch, rules, limits, active).await?;
        refill(connection, &batch, rules, &room, &mut fed, now).await?;
    }
    let pending = count(connection, id, "pending").await?;
    let is_at_end = pending == 0 && count(connection, id, "submitted").await? == 0;
    if is_at_end && !is_expanding(connection, id).await? {
        sqlx::query("UPDATE batches SET state = $1, finished_at = $2 WHERE id = $3")
            .bind(batch.state.ended().as_str())
            .bind(now)
            .bind(id.as_str())
            .execute(&mut *connection)
            .await?;
        webhooks::batch_ended(connection, id, batch.state.ended().as_str(), now).await?;
        // The end is a change that others wait for.
        fed.settled += 1;
    }
    Ok(fed)
}

async fn count(connection: &mut AnyConnection, id: &BatchId, state: &str) -> Result<i64, StoreError> {
    Ok(sqlx::query_scalar("SELECT COUNT(*) FROM batch_items WHERE batch_id = $1 AND state = $2")
        .bind(id.as_str())
        .bind(state)
        .fetch_one(connection)
        .await?)
}

/// Puts pending items into the queue while there is room and money.
async fn refill(
    connection: &mut AnyConnection,
    batch: &BatchRow,
    rules: &FeedRules,
    room: &Room,
    fed: &mut Fed,
    now_ms: i64,
) -> Result<(), StoreError> {
    if room.items <= 0 {
        return Ok(());
    }
    let mut budget = match batch.budget.filter(|_| rules.counts_money) {
        Some(total) => Some(budget_of(connection, batch, total).await?),
        None => None,
    };
    let items = pending_items(connection, &batch.id, room.items.min(MAX_ITEMS)).await?;
    let mut taken = 0;
    for item in &items {
        let wanted = MicroUsd((item.budget.0 - item.spent.0).max(0));
        let granted = match budget.as_mut().map_or(Grant::Granted(wanted), |budget| budget.promise(wanted)) {
            Grant::Granted(granted) => granted,
            Grant::Wait => return Ok(()),
            Grant::Exhausted => {
                let message = "the budget of the batch is spent; retry the batch with a larger budget_usd";
                let error = OutputError::new("batch_budget_spent", message);
                end_early(connection, &batch.id, item.place, error, now_ms).await?;
                fed.settled += 1;
                taken += 1;
                continue;
            }
        };
        if room.per_minute > 0
            && limits::take_pace(connection, &batch.tenant_id, room.per_minute, 1, now_ms).await?.is_err()
        {
            break;
        }
        match begin(connection, batch, item, granted, &rules.queue).await? {
            Some((scene_id, job_id)) => {
                submitted(connection, &batch.id, item.place, &scene_id, &job_id).await?;
                fed.submitted += 1;
            }
            None => {
                let message = "the scene of the first run was deleted; submit the request again";
                end_early(
                    connection,
                    &batch.id,
                    item.place,
                    OutputError::new("scene_deleted", message),
                    now_ms,
                )
                .await?;
                fed.settled += 1;
            }
        }
        taken += 1;
    }
    // Items that ended at once took no room.
    fed.has_more = taken > 0 && (taken == MAX_ITEMS || fed.settled > 0);
    Ok(())
}

/// Room that the limits leave for items of a batch.
struct Room {
    /// Further items that may be in the queue: of the window, and of half of what the queue and the limits of the
    /// tenant take.
    items: i64,
    /// Submissions of the tenant in a minute; 0 = any number.
    per_minute: i64,
}

async fn room(
    connection: &mut AnyConnection,
    batch: &BatchRow,
    rules: &FeedRules,
    limits: &LimitSettings,
    active: i64,
) -> Result<Room, StoreError> {
    let limits = limits::of_tenant(connection, limits, &batch.tenant_id).await?;
    if limits::spent(connection, &batch.tenant_id, limits.micro_usd_per_month).await?.is_some() {
        return Ok(Room { items: 0, per_minute: 0 });
    }
    let all: i64 = sqlx::query_scalar("SELECT COUNT(*) FROM jobs WHERE state = 'queued'")
        .fetch_one(&mut *connection)
        .await?;
    let own = limits::waiting_work(connection, &batch.tenant_id).await?;
    let half = |limit: i64| limit / 2 + limit % 2;
    let own_room = if limits.waiting_jobs == 0 { i64::MAX } else { half(limits.waiting_jobs) - own };
    let items = (rules.window - active).min(half(rules.queue.max_jobs) - all).min(own_room);
    Ok(Room { items, per_minute: limits.submissions_per_minute })
}

/// The budget with what is spent, and what items in the queue may still spend.
async fn budget_of(
    connection: &mut AnyConnection,
    batch: &BatchRow,
    total: MicroUsd,
) -> Result<BatchBudget, StoreError> {
    let promised: i64 = sqlx::query_scalar(
        "SELECT CAST(COALESCE(SUM(CASE WHEN s.budget_micro_usd > i.spent_micro_usd
                                       THEN s.budget_micro_usd - i.spent_micro_usd ELSE 0 END), 0) AS BIGINT)
         FROM batch_items AS i JOIN scenes AS s ON s.id = i.scene_id
         WHERE i.batch_id = $1 AND i.state = 'submitted'",
    )
    .bind(batch.id.as_str())
    .fetch_one(connection)
    .await?;
    let mut budget = BatchBudget::new(total);
    budget.settle(MicroUsd::ZERO, batch.settled);
    budget.note_promise(MicroUsd(promised));
    Ok(budget)
}
