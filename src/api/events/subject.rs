//! Subject of events: a job, or a recording of episodes.
//!
//! Both have numbered rows in the store, and end; pages and streams know nothing else of them.

use std::collections::BTreeMap;
use std::fmt;

use crate::api::extract::TenantApi;
use crate::api::jobs;
use crate::problem::Problem;
use scene::{JobId, RecordingId, TenantId};
use store::events::Event;
use store::{Store, StoreError};

/// Subject of events.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    Job(JobId),
    Recording(RecordingId),
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
        })
    }

    /// At most `limit` events after number `after`, in order.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if the database does not answer, or a row cannot be read.
    pub async fn events(&self, api: &TenantApi, after: i64, limit: u32) -> Result<Vec<Event>, StoreError> {
        match self {
            Self::Job(id) => api.store.events(&api.tenant_id, id, after, limit).await,
            Self::Recording(id) => api.store.recording_events(&api.tenant_id, id, after, limit).await,
        }
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
            }
        }
        let mut progress = BTreeMap::new();
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
        }
    }
}
