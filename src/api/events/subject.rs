//! Subject of events: a job, a recording of episodes, or all of a tenant's.
//!
//! Each has numbered rows in the store; a job and a recording end, a tenant does not. Pages and streams know nothing
//! else of them.

use std::collections::BTreeMap;
use std::fmt;

use serde_json::{Value, json};

use crate::api::extract::TenantApi;
use crate::api::jobs;
use crate::api::views::{EventView, TenantEventView};
use crate::problem::Problem;
use scene::{JobId, RecordingId, TenantId};
use store::events::Event;
use store::tenant_events::TenantEvent;
use store::{Store, StoreError};

/// Subject of events.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    Job(JobId),
    Recording(RecordingId),
    /// All jobs and recordings of the tenant that asks.
    Tenant,
}

/// An event as clients see it.
#[derive(Clone, Debug)]
pub struct TellableEvent {
    /// Number within the subject.
    pub seq: i64,
    pub kind: String,
    pub view: Value,
}

impl From<Event> for TellableEvent {
    fn from(event: Event) -> Self {
        Self { seq: event.seq, kind: event.kind.clone(), view: json!(EventView::new(event)) }
    }
}

impl From<TenantEvent> for TellableEvent {
    fn from(event: TenantEvent) -> Self {
        let (seq, kind) = (event.position, event.event.kind.clone());
        Self { seq, kind, view: json!(TenantEventView::new(event)) }
    }
}

/// Progress of a subject.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SubjectProgress {
    pub last_seq: i64,
    /// No event will follow.
    pub is_final: bool,
}

impl Subject {
    /// Whether it has ended.
    ///
    /// # Errors
    ///
    /// The [`Problem`] 404 where it is not there.
    pub async fn has_ended(&self, api: &TenantApi) -> Result<bool, Problem> {
        Ok(match self {
            Self::Job(id) => jobs::find(api, id).await?.state.is_final(),
            Self::Recording(id) => crate::api::episodes::find(api, id).await?.state.is_final(),
            Self::Tenant => false,
        })
    }

    /// Number of its last event that is numbered now.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if the database does not answer.
    pub async fn last_seq(&self, api: &TenantApi) -> Result<i64, StoreError> {
        let key = (api.tenant_id.clone(), self.clone());
        let progress = Self::progress_of(&api.store, std::slice::from_ref(&key)).await?;
        Ok(progress.get(&key).map_or(0, |progress| progress.last_seq))
    }

    /// At most `limit` events after number `after`, in order.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if the database does not answer, or a row cannot be read.
    pub async fn events(
        &self,
        api: &TenantApi,
        after: i64,
        limit: u32,
    ) -> Result<Vec<TellableEvent>, StoreError> {
        let (store, tenant_id) = (&api.store, &api.tenant_id);
        let events = match self {
            Self::Job(id) => store.events(tenant_id, id, after, limit).await?,
            Self::Recording(id) => store.recording_events(tenant_id, id, after, limit).await?,
            Self::Tenant => {
                let events = store.tenant_events(tenant_id, after, limit).await?;
                return Ok(events.into_iter().map(TellableEvent::from).collect());
            }
        };
        Ok(events.into_iter().map(TellableEvent::from).collect())
    }

    /// Progress of some hundred subjects, in one query for each tenant and kind; subjects that their tenant does not
    /// have are left out.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if the database does not answer, or a row cannot be read.
    pub async fn progress_of(
        store: &Store,
        subjects: &[(TenantId, Self)],
    ) -> Result<BTreeMap<(TenantId, Self), SubjectProgress>, StoreError> {
        let mut by_tenant: BTreeMap<&TenantId, (Vec<JobId>, Vec<RecordingId>)> = BTreeMap::new();
        for (tenant_id, subject) in subjects {
            let (jobs, recordings) = by_tenant.entry(tenant_id).or_default();
            match subject {
                Self::Job(id) => jobs.push(id.clone()),
                Self::Recording(id) => recordings.push(id.clone()),
                Self::Tenant => {}
            }
        }
        let mut progress = BTreeMap::new();
        let tenants: Vec<_> = subjects.iter().filter(|(_, subject)| *subject == Self::Tenant).collect();
        if !tenants.is_empty() {
            store.number_events().await?;
        }
        for key in tenants {
            let last_seq = store.last_position(&key.0).await?;
            progress.insert(key.clone(), SubjectProgress { last_seq, is_final: false });
        }
        for (tenant_id, (jobs, recordings)) in by_tenant {
            for head in store.event_heads(tenant_id, &jobs).await? {
                let far = SubjectProgress { last_seq: head.last_seq, is_final: head.state.is_final() };
                progress.insert((tenant_id.clone(), Self::Job(head.job_id)), far);
            }
            for head in store.recording_event_heads(tenant_id, &recordings).await? {
                let far = SubjectProgress { last_seq: head.last_seq, is_final: head.state.is_final() };
                progress.insert((tenant_id.clone(), Self::Recording(head.id)), far);
            }
        }
        Ok(progress)
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Job(id) => write!(f, "job {}", id.as_str()),
            Self::Recording(id) => write!(f, "recording {}", id.as_str()),
            Self::Tenant => write!(f, "all of a tenant"),
        }
    }
}
