//! The mesh generator over Hunyuan3D's own server, against one that speaks as that does.

use std::sync::Arc;
use std::time::Duration;

use futures::future::join_all;
use ports::ledger::OnUnknown;
use ports::{Call, MeshGenerator, Port, ProviderError, RawMesh, ReconstructionRequest};
use remote::hunyuan3d;
use remote::hunyuan3d::Hunyuan3dMeshGenerator;
use remote::settings::Hunyuan3dSettings;
use remote::vendor_job::JobSlots;
use serde_json::json;

use crate::harness::server::settings;
use crate::remote::bench::{self, Book, class};
use crate::remote::hunyuan3d_server::{Hunyuan3dServer, PollFault};
use crate::remote::predictions::{bottle, file, request};
use crate::remote::wire_faults::WireFault;

struct Bench {
    server: Hunyuan3dServer,
    book: Arc<Book>,
    call: Call,
    generator: Hunyuan3dMeshGenerator,
}

impl Bench {
    async fn new() -> Self {
        Self::with(|_| {}, false).await
    }

    async fn with(change: impl Fn(&mut Hunyuan3dSettings), fails: bool) -> Self {
        let server = Hunyuan3dServer::start(file(), fails).await;
        let mut settings = settings(&[]).config.providers.hunyuan3d;
        settings.endpoint.base_url = server.base_url.clone();
        settings.task.poll_interval_ms = 10;
        bench::make_quick(&mut settings.endpoint.limits);
        change(&mut settings);
        let (port, name) = (Port::MeshGenerator, hunyuan3d::NAME);
        let endpoint = bench::endpoint(port, name, &settings.endpoint, "", OnUnknown::Resend);
        let (endpoint, slots) = (Arc::new(endpoint), JobSlots::new(&settings.task));
        let generator = Hunyuan3dMeshGenerator { settings, endpoint, slots };
        let book = Book::with_budget(0);
        Self { server, call: book.call(), book, generator }
    }

    async fn reconstruct(&self, request: ReconstructionRequest) -> Result<RawMesh, ProviderError> {
        let asked = self.generator.reconstruct(&self.call, request);
        tokio::time::timeout(Duration::from_secs(60), asked).await.expect("nothing hangs")
    }
}

#[tokio::test]
async fn image_becomes_a_mesh_at_no_cost() {
    let bench = Bench::new().await;
    bench.server.polls.script([PollFault::Texturing]);
    let raw = bench.reconstruct(request()).await.unwrap();
    assert_eq!(raw.mesh.triangle_count(), bottle().triangle_count());
    assert!((raw.mesh.size_m().max_element() - 1.0).abs() < 1e-6);
    assert_eq!(raw.made_by, "hunyuan3d/server, a-model");
    let asked = &bench.server.asked()[0];
    assert_eq!(
        (&asked["texture"], &asked["type"], &asked["seed"]),
        (&json!(true), &json!("glb"), &json!(11))
    );
    assert_eq!((bench.book.outcomes(), bench.book.spent()), (vec![Some("answered")], 0));
}

#[tokio::test]
async fn each_fault_ends_in_its_class() {
    use WireFault::*;
    let wire = PollFault::Wire;
    let cases: Vec<(Vec<WireFault>, Vec<PollFault>, &str, usize)> = vec![
        (vec![Status(500, "{}")], vec![], "ok", 1),
        (
            vec![Status(404, r#"{"text": "**NETWORK ERROR**", "error_code": 1}"#)],
            vec![],
            "misconfigured provider_not_found",
            0,
        ),
        (vec![ResetMidBody], vec![], "ok", 2),
        (vec![Page], vec![], "ok", 2),
        (vec![], vec![wire(ResetMidBody), wire(Status(502, "bad gateway"))], "ok", 1),
        (vec![], vec![wire(Silence)], "ok", 1),
        (vec![], vec![PollFault::HalfWritten], "ok", 1),
        (vec![], vec![PollFault::HalfWritten; 3], "transient provider_bad_answer", 1),
        (vec![], vec![PollFault::Error("CUDA out of memory")], "transient provider_task_failed", 1),
        (vec![], vec![wire(Endless)], "transient provider_answer_too_large", 1),
        (vec![], vec![wire(Page); 3], "transient provider_bad_answer", 1),
    ];
    for (submissions, polls, expected, begun) in cases {
        let bench = Bench::new().await;
        let message = format!("{submissions:?} {polls:?}");
        bench.server.submissions.script(submissions);
        bench.server.polls.script(polls);
        let result = bench.reconstruct(request()).await.map_or_else(|error| class(&error), |_| "ok".into());
        assert_eq!((result.as_str(), bench.server.begun()), (expected, begun), "{message}");
        assert!(bench.book.outcomes().iter().all(Option::is_some), "{message}");
    }
}

#[tokio::test]
async fn a_job_that_failed_in_silence_ends_with_the_time_limit_and_is_sent_anew() {
    let bench = Bench::with(|settings| settings.task.task_timeout_secs = 0, true).await;
    for begun in 1..=2 {
        let error = bench.reconstruct(request()).await.unwrap_err();
        assert_eq!(
            (class(&error).as_str(), bench.server.begun()),
            ("transient provider_task_timeout", begun)
        );
    }
}

#[tokio::test]
async fn next_worker_after_a_crash_sends_nothing_twice() {
    let bench = Bench::new().await;
    bench.server.polls.script([PollFault::Wire(WireFault::Silence)]);
    let asked = bench.generator.reconstruct(&bench.call, request());
    assert!(tokio::time::timeout(Duration::from_millis(300), asked).await.is_err(), "it waits");
    bench.reconstruct(request()).await.unwrap();
    bench.reconstruct(request()).await.unwrap();
    assert_eq!(bench.server.begun(), 1);
}

#[tokio::test]
async fn the_server_gets_one_job_after_the_other() {
    for (vendor_jobs, highest) in [(1, 1), (3, 3)] {
        let bench = Bench::with(|settings| settings.task.vendor_jobs = vendor_jobs, false).await;
        let asked = (0..6).map(|seed| bench.reconstruct(ReconstructionRequest { seed, ..request() }));
        assert!(join_all(asked).await.iter().all(Result::is_ok));
        assert_eq!(bench.server.begun(), 6);
        assert!(bench.server.max_at_once() <= highest, "{}", bench.server.max_at_once());
    }
}
