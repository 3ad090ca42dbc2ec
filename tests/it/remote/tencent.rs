//! The mesh generator over Tencent Cloud, against a server that speaks its protocol and checks its signatures.

use std::io::{Cursor, Write};
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use ports::ledger::OnUnknown;
use ports::{Call, MeshGenerator, Port, ProviderError, RawMesh};
use remote::TencentSettings;
use remote::endpoint::Auth;
use remote::tencent;
use remote::tencent::TencentMeshGenerator;
use remote::vendor_job::JobSlots;
use serde_json::json;

use crate::harness::server::settings;
use crate::remote::bench::{self, Book, class};
use crate::remote::predictions::{bottle, file, request};
use crate::remote::tencent_server::{Fault, SECRET_ID, SECRET_KEY, TencentServer};
use crate::remote::wire_faults::WireFault;

/// Price of a mesh in these tests, millionths of a dollar.
const PRICE: i64 = 400_000;

struct Bench {
    server: TencentServer,
    book: Arc<Book>,
    call: Call,
    generator: TencentMeshGenerator,
}

impl Bench {
    async fn new() -> Self {
        Self::with("GLB", file(), SECRET_KEY).await
    }

    async fn with(kind: &'static str, file: Bytes, key: &str) -> Self {
        let server = TencentServer::start(kind, file).await;
        let mut settings: TencentSettings = settings(&[]).config.providers.tencent;
        settings.endpoint.base_url = server.base_url.clone();
        settings.task.poll_interval_ms = 10;
        settings.usd_per_mesh = 0.4;
        bench::make_quick(&mut settings.endpoint.limits);
        let (port, name) = (Port::MeshGenerator, tencent::NAME);
        let mut endpoint = bench::endpoint(port, name, &settings.endpoint, key, OnUnknown::Resend);
        endpoint.auth = Auth::Tc3 { secret_id: SECRET_ID.into(), service: "127".into() };
        let (endpoint, slots) = (Arc::new(endpoint), JobSlots::new(&settings.task));
        let generator = TencentMeshGenerator { settings, endpoint, slots };
        let book = Book::with_budget(1_000_000_000);
        Self { server, call: book.call(), book, generator }
    }

    async fn reconstruct(&self) -> Result<RawMesh, ProviderError> {
        let asked = self.generator.reconstruct(&self.call, request());
        tokio::time::timeout(Duration::from_secs(60), asked).await.expect("nothing hangs")
    }
}

#[tokio::test]
async fn signed_requests_become_a_mesh_and_the_key_goes_nowhere() {
    let bench = Bench::new().await;
    let raw = bench.reconstruct().await.unwrap();
    assert_eq!(raw.mesh.triangle_count(), bottle().triangle_count());
    let asked = &bench.server.asked()[0];
    assert_eq!((&asked["Model"], &asked["EnablePBR"]), (&json!("3.0"), &json!(false)));
    assert_eq!(bench.server.proofs(), [""; 0], "files are fetched without a signature");
    assert_eq!((bench.book.outcomes(), bench.book.spent()), (vec![Some("answered")], PRICE));
    // The same question in the same job is answered by what was fetched.
    bench.reconstruct().await.unwrap();
    assert_eq!(bench.server.begun(), 1);
}

#[tokio::test]
async fn another_key_is_refused() {
    let bench = Bench::with("GLB", file(), "another-secret").await;
    let error = bench.reconstruct().await.unwrap_err();
    assert_eq!(class(&error), "misconfigured provider_denied");
    assert!(error.to_string().contains("SignatureFailure"), "{error}");
    assert_eq!((bench.server.begun(), bench.book.spent()), (0, 0));
}

#[tokio::test]
async fn an_archive_of_an_obj_file_is_a_mesh_too() {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    zip.start_file("model/box.obj", zip::write::SimpleFileOptions::default()).unwrap();
    let corners = "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 0 0 1\nv 1 0 1\nv 1 2 1\nv 0 2 1\n";
    let faces = "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n";
    zip.write_all(format!("{corners}{faces}").as_bytes()).unwrap();
    let archive = Bytes::from(zip.finish().unwrap().into_inner());
    let bench = Bench::with("OBJ", archive, SECRET_KEY).await;
    let raw = bench.reconstruct().await.unwrap();
    let size = raw.mesh.size_m();
    assert_eq!(raw.mesh.triangle_count(), 12);
    assert!((size - glam::DVec3::new(0.5, 0.5, 1.0)).length() < 1e-6, "{size}");
}

#[tokio::test]
async fn each_fault_ends_in_its_class() {
    use WireFault::*;
    let wire = Fault::Wire;
    let cases: Vec<(Vec<Fault>, Vec<Fault>, &str, usize)> = vec![
        (vec![Fault::Error("RequestLimitExceeded.JobNumExceed")], vec![], "ok", 1),
        (vec![Fault::Error("InternalError")], vec![], "ok", 1),
        (
            vec![Fault::Error("ResourceUnavailable.InArrears")],
            vec![],
            "misconfigured provider_quota_spent",
            0,
        ),
        (vec![Fault::Error("OperationDenied.ImageIllegalDetected")], vec![], "refused answer_refused", 0),
        (vec![Fault::Error("InvalidParameterValue")], vec![], "rejected provider_rejected_request", 0),
        (vec![wire(Status(500, "{}"))], vec![], "ok", 1),
        // The client cannot know that it was begun: both are paid for.
        (vec![wire(ResetMidBody)], vec![], "ok", 2),
        (vec![wire(Silence)], vec![], "ok", 2),
        (vec![wire(Page)], vec![], "ok", 2),
        (vec![], vec![wire(ResetMidBody), Fault::Error("InternalError")], "ok", 1),
        (vec![], vec![wire(Silence)], "ok", 1),
        (vec![], vec![Fault::Failed], "transient provider_task_failed", 1),
        (vec![], vec![Fault::Error("ResourceNotFound")], "transient provider_task_lost", 1),
        (vec![], vec![wire(Endless)], "transient provider_answer_too_large", 1),
    ];
    for (submissions, polls, expected, begun) in cases {
        let bench = Bench::new().await;
        let message = format!("{submissions:?} {polls:?}");
        bench.server.submissions.script(submissions);
        bench.server.polls.script(polls);
        let result = bench.reconstruct().await.map_or_else(|error| class(&error), |_| "ok".into());
        assert_eq!((result.as_str(), bench.server.begun()), (expected, begun), "{message}");
        assert!(bench.book.spent() >= begun as i64 * PRICE, "{message}");
        assert!(bench.book.outcomes().iter().all(Option::is_some), "{message}");
    }
}
