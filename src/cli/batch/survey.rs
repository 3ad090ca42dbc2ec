//! Takes stock at the start of a run: which requests are invalid, duplicates, finished earlier, or to be done.

use std::collections::HashMap;

use tokio_util::sync::CancellationToken;

use super::bundles::Bundles;
use super::checker::Checker;
use super::engine;
use super::money::Money;
use super::records::Records;
use super::report::Report;
use super::source::{Rejection, Source};
use crate::cli::backup::failed;
use crate::cli::{Exit, Failure};
use batches::request::MAX_REQUESTS;
use batches::{BatchRequest, OutputLine, Registry, RequestCounts, RequestDigest, RequestState};
use scene::{MicroUsd, SceneId};
use store::lifecycle::JobState;
use store::scenes::SceneFilter;
use store::{DEFAULT_TENANT, Store};

/// The label of scenes that belong to a request of a batch: its digest.
pub(super) const REQUEST_LABEL: &str = "batch_request";

/// Scenes that are read from the store at once.
const PAGE: u32 = 500;

/// Inputs of taking stock.
pub(super) struct Survey<'a> {
    pub(super) store: &'a Store,
    pub(super) checker: &'a Checker,
    pub(super) bundles: &'a Bundles,
    pub(super) retries_failed: bool,
    pub(super) report: &'a Report,
}

/// Work that is left to do.
#[derive(Default)]
pub(super) struct Stock {
    pub(super) counts: RequestCounts,
    /// Whether each entry of the file is to be done.
    pub(super) todo: Vec<bool>,
    /// Scenes of earlier runs by the digest of their request.
    pub(super) known: HashMap<RequestDigest, SceneId>,
}

impl Survey<'_> {
    /// Reads every request once and writes down what has come to its end already.
    pub(super) async fn take(
        &self,
        source: &Source,
        records: &mut Records,
        money: &mut Money,
        stop: &CancellationToken,
    ) -> Result<Stock, Failure> {
        let mut stock = Stock { known: self.known().await?, ..Stock::default() };
        let mut registry = Registry::default();
        for entry in source.entries()? {
            if stop.is_cancelled() {
                let message = "interrupted before the first request; nothing was changed";
                return Err(Failure::new(Exit::Interrupted, message));
            }
            let entry = entry?;
            let line = match entry.content {
                Err(Rejection { custom_id, error }) => {
                    Some(OutputLine::not_computed(custom_id, RequestState::Invalid, error))
                }
                Ok(request) => match self.refused(&mut registry, entry.place, &request) {
                    Some(line) => Some(line),
                    None => {
                        let finished = self.finished(&stock, &request, money).await?;
                        if finished.is_none() {
                            self.bundles.check_free(&request.custom_id)?;
                        }
                        finished
                    }
                },
            };
            if let Some(line) = &line {
                records.write(line)?;
                if line.state == RequestState::Invalid {
                    self.report
                        .wrong(&line.error.as_ref().map_or(String::new(), |error| source.shown(error)));
                }
            }
            stock.counts.add(line.as_ref().map_or(RequestState::Pending, |line| line.state));
            stock.todo.push(line.is_none());
            if stock.counts.total > MAX_REQUESTS {
                return Err(Failure::usage(format!(
                    "the file has more than {MAX_REQUESTS} requests; split it"
                )));
            }
        }
        if stock.counts.total == 0 {
            return Err(Failure::usage("the file has no requests"));
        }
        Ok(stock)
    }

    /// The line of a request that is not computed: an error, or a duplicate.
    fn refused(&self, registry: &mut Registry, place: u64, request: &BatchRequest) -> Option<OutputLine> {
        // What is invalid is no first of its kind.
        if let Err(error) = self.checker.submission(request) {
            let custom_id = Some(request.custom_id.clone());
            return Some(OutputLine::not_computed(custom_id, RequestState::Invalid, error.on_line(place)));
        }
        registry.refusal(place, request)
    }

    /// The line of a request that an earlier run finished.
    async fn finished(
        &self,
        stock: &Stock,
        request: &BatchRequest,
        money: &mut Money,
    ) -> Result<Option<OutputLine>, Failure> {
        let Some(scene_id) = stock.known.get(&request.digest()) else { return Ok(None) };
        let scene = self.store.scene(&DEFAULT_TENANT, scene_id).await.map_err(failed)?;
        let job = self.store.latest_job(&DEFAULT_TENANT, scene_id).await.map_err(failed)?;
        let Some((scene, job)) = scene.zip(job) else { return Ok(None) };
        let is_retried = self.retries_failed && job.state != JobState::Succeeded;
        if !job.state.is_final() || is_retried {
            return Ok(None);
        }
        if money.is_limited() {
            let spending = self.store.spending(&DEFAULT_TENANT, scene_id).await.map_err(failed)?;
            money.settle(MicroUsd::ZERO, MicroUsd(spending.spent));
        }
        let line = engine::line_of(self.store, self.bundles, &request.custom_id, &scene, &job).await?;
        Ok(Some(line))
    }

    /// Every scene of the data directory that belongs to a request of a batch; of several, the newest.
    async fn known(&self) -> Result<HashMap<RequestDigest, SceneId>, Failure> {
        let mut known = HashMap::new();
        let mut before_id = None;
        loop {
            let filter = SceneFilter { before_id, limit: PAGE, ..SceneFilter::default() };
            let page = self.store.scenes(&DEFAULT_TENANT, filter).await.map_err(failed)?;
            before_id = page.last().map(|(scene, _)| scene.id.clone());
            let is_last = page.len() < PAGE as usize;
            for (scene, _) in page {
                let digest =
                    scene.labels.get(REQUEST_LABEL).and_then(|hex| u128::from_str_radix(hex, 16).ok());
                if let Some(digest) = digest {
                    known.entry(RequestDigest(digest)).or_insert(scene.id);
                }
            }
            if is_last {
                return Ok(known);
            }
        }
    }
}
