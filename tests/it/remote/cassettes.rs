//! Recorded and played again: the same answers without a network, troubles of the way included, and at no cost.

use std::path::Path;
use std::sync::Arc;

use http_client::cassette::Cassette;
use http_client::{AddressPolicy, HttpClient};
use ports::ProviderError;
use ports::ledger::{MicroUsd, OnUnknown};
use remote::chat::ChatAnalyst;
use serde_json::json;

use crate::remote::bench::Book;
use crate::remote::chat::{Bench, endpoint};
use crate::remote::chat_server::{Fault, KEY};

/// The bench's analyst, speaking through this.
fn through(bench: &mut Bench, outbound: impl FnOnce(HttpClient) -> HttpClient) {
    let settings = bench.analyst.settings.clone();
    let mut endpoint = endpoint(&settings, KEY, OnUnknown::Fail);
    endpoint.client = outbound(endpoint.client.clone());
    bench.analyst = ChatAnalyst { settings, endpoint: Arc::new(endpoint) };
}

fn recording(folder: &Path) -> impl FnOnce(HttpClient) -> HttpClient {
    let cassette = Arc::new(Cassette::record_into(folder).unwrap());
    |live| live.recording(cassette)
}

fn playing(folder: &Path) -> impl FnOnce(HttpClient) -> HttpClient {
    let cassette = Arc::new(Cassette::replay(folder).unwrap());
    |_| HttpClient::replaying(AddressPolicy::new(true, "127.0.0.1"), cassette)
}

#[tokio::test]
async fn what_was_recorded_is_answered_again_without_a_network_and_costs_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut bench = Bench::new().await;
    bench.server.script([Fault::Status(503), Fault::Spoiled("/objects/0/width_m", json!(9))]);
    through(&mut bench, recording(folder.path()));
    let described = bench.describe().await.unwrap();
    let recognized = bench.recognize().await.unwrap();
    let billed = bench.server.bill().len();
    let outcomes = bench.book.outcomes();
    assert!(bench.book.spent() > 0);

    for _ in 0..2 {
        bench.book = Book::with_budget(0);
        bench.call = bench.book.call();
        through(&mut bench, playing(folder.path()));
        assert_eq!(bench.describe().await.unwrap(), described);
        assert_eq!(bench.recognize().await.unwrap(), recognized);
        assert_eq!(bench.book.outcomes(), outcomes, "the troubles too");
        assert_eq!(bench.book.spent(), 0);
        let rows = bench.book.rows.lock().unwrap();
        assert!(rows.iter().all(|(intent, _)| intent.reserved == MicroUsd::ZERO));
    }
    assert_eq!(bench.server.bill().len(), billed, "nobody was asked again");
}

#[tokio::test]
async fn what_was_not_recorded_is_an_error_that_no_other_provider_answers() {
    let folder = tempfile::tempdir().unwrap();
    let mut bench = Bench::new().await;
    through(&mut bench, recording(folder.path()));
    bench.describe().await.unwrap();
    through(&mut bench, playing(folder.path()));
    let error = bench.recognize().await.unwrap_err();
    let ProviderError::Rejected { code, reason, .. } = &error else { panic!("{error:?}") };
    assert_eq!(*code, "provider_not_recorded");
    assert!(reason.contains("/v1/chat/completions") && reason.contains("record"), "{reason}");
    assert!(!error.another_may_answer());
}
