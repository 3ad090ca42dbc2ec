//! The mesh generator over predictions against a server that speaks their protocol: what is asked, what is taken, what
//! a worker after a dead one does, what is written down.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use bytes::Bytes;
use geometry::{Camera, Material, Rgb, TexturedMesh, shapes};
use glam::DVec3;
use imaging::{Image, Mask};
use mesh_io::gltf::write_mesh_glb;
use ports::ledger::OnUnknown;
use ports::{
    Call, Completion, MeshGenerator, Port, ProviderError, RawMesh, ReconstructionRequest, TableRequest,
};
use remote::ReplicateSettings;
use remote::replicate;
use remote::replicate::ReplicateMeshGenerator;
use remote::vendor_job::JobSlots;
use runtime::CancelFlag;
use scene::{InstanceId, RecognizedObject, RecognizedTable, StandsOn, TableShape};
use serde_json::json;

use crate::harness::server::settings;
use crate::remote::bench::{self, Book, class};
use crate::remote::predictions_server::{KEY, PollFault, PredictionsServer};
use crate::remote::wire_faults::WireFault;

const ANSWERED: &str = "answered";

/// Price of a prediction in these tests, millionths of a dollar.
const PRICE: i64 = 170_000;

struct Bench {
    server: PredictionsServer,
    book: Arc<Book>,
    call: Call,
    generator: ReplicateMeshGenerator,
}

/// A bottle of 20 cm, standing somewhere.
pub fn bottle() -> TexturedMesh {
    let mut mesh = TexturedMesh::default();
    mesh.add(shapes::cylinder(0.04, 0.2, 0.003, 48), &Material::plain("glass", Rgb([0.2, 0.6, 0.3]), 0.1));
    mesh.translated(DVec3::new(3.0, -2.0, 1.0))
}

pub fn file() -> Bytes {
    write_mesh_glb(&bottle().snap_to_f32()).into()
}

impl Bench {
    async fn new() -> Self {
        Self::with(|_| {}, file()).await
    }

    async fn with(change: impl Fn(&mut ReplicateSettings), file: Bytes) -> Self {
        let server = PredictionsServer::start(file, 2).await;
        let mut settings = settings(&[]).config.providers.replicate;
        settings.endpoint.base_url = server.base_url.clone();
        settings.usd_per_prediction = 0.17;
        settings.task.poll_interval_ms = 10;
        bench::make_quick(&mut settings.endpoint.limits);
        change(&mut settings);
        let book = Book::with_budget(1_000_000_000);
        Self { call: book.call(), generator: generator(&settings, OnUnknown::Resend), book, server }
    }

    async fn reconstruct(&self) -> Result<RawMesh, ProviderError> {
        let asked = self.generator.reconstruct(&self.call, request());
        tokio::time::timeout(Duration::from_secs(60), asked).await.expect("nothing hangs")
    }

    /// Everything that was billed stands in the books.
    fn outcomes(&self) -> Vec<&'static str> {
        let billed = self.server.billed() as i64 * PRICE;
        assert!(self.book.spent() >= billed, "{} < {billed}", self.book.spent());
        self.book.outcomes().into_iter().map(|outcome| outcome.expect("everything is settled")).collect()
    }
}

fn generator(settings: &ReplicateSettings, on_unknown: OnUnknown) -> ReplicateMeshGenerator {
    let (port, name) = (Port::MeshGenerator, replicate::NAME);
    let endpoint = bench::endpoint(port, name, &settings.endpoint, KEY, on_unknown);
    ReplicateMeshGenerator {
        settings: settings.clone(),
        endpoint: Arc::new(endpoint),
        slots: JobSlots::new(&settings.task),
    }
}

pub fn request() -> ReconstructionRequest {
    ReconstructionRequest {
        object: RecognizedObject {
            id: InstanceId::new("bottle_1").unwrap(),
            label: "bottle".into(),
            category: "bottle".into(),
            size_m: DVec3::new(0.08, 0.08, 0.2),
            tipped: None,
            color: None,
            material: None,
            seed: 1,
            stands_on: StandsOn::Table,
            seen_px: None,
            seen_as: None,
            seen_like: None,
            mass_kg: None,
            stand_in: None,
        },
        completion: Completion {
            image: Image::filled(40, 100, [60, 160, 80, 255]),
            crop_px: [100.0, 50.0, 140.0, 150.0],
            silhouette: Mask::from_fn(320, 240, |x, y| (100..140).contains(&x) && (50..150).contains(&y)),
            completed_share: 0.25,
            completed_by: Vec::new(),
        },
        camera: Camera::orbit(320, 240, 0.6, DVec3::ZERO, 0.0, 0.7, 2.0),
        rendered: false,
        seed: 11,
    }
}

#[tokio::test]
async fn image_becomes_a_unit_sized_mesh_and_its_price_is_recorded() {
    let bench = Bench::new().await;
    let raw = bench.reconstruct().await.unwrap();
    let size = raw.mesh.size_m();
    assert!((size.z - 1.0).abs() < 1e-6 && (size.x - 0.4).abs() < 1e-3, "{size}");
    assert_eq!(raw.mesh.triangle_count(), bottle().triangle_count());
    assert_eq!(raw.licence, "LicenseRef-Tencent-Hunyuan-Community");
    assert!(raw.notes.iter().any(|note| note.contains("South Korea")), "{:?}", raw.notes);
    assert!(raw.notes.iter().any(|note| note.contains("25 %")), "{:?}", raw.notes);
    let input = &bench.server.inputs()[0];
    assert_eq!((&input["seed"], &input["remove_background"]), (&json!(11), &json!(false)));
    assert_eq!((bench.outcomes(), bench.book.spent()), (vec![ANSWERED], PRICE));
    assert_eq!(bench.server.downloaded(), [None], "files are fetched without a key");
}

#[tokio::test]
async fn each_fault_ends_in_its_class() {
    use WireFault::*;
    type Case = (Vec<WireFault>, Vec<PollFault>, Vec<WireFault>, &'static str, usize);
    let wire = PollFault::Wire;
    let server_error = r#"{"detail": "Internal server error"}"#;
    let cases: Vec<Case> = vec![
        (vec![Busy(0)], vec![], vec![], "ok", 1),
        (vec![Busy(3600)], vec![], vec![], "rate_limited 3600", 0),
        (vec![Status(500, server_error)], vec![], vec![], "ok", 1),
        (
            vec![Status(402, r#"{"title": "Insufficient credit"}"#)],
            vec![],
            vec![],
            "misconfigured provider_quota_spent",
            0,
        ),
        (
            vec![Status(422, r#"{"detail": "no such version"}"#)],
            vec![],
            vec![],
            "rejected provider_rejected_request",
            0,
        ),
        // The client cannot know that it was begun: both are paid for, and both are in the ledger.
        (vec![ResetMidBody], vec![], vec![], "ok", 2),
        (vec![Silence], vec![], vec![], "ok", 2),
        (vec![Page], vec![], vec![], "ok", 2),
        (vec![Body("{}")], vec![], vec![], "ok", 2),
        // Polls cost nothing, whatever becomes of them.
        (vec![], vec![wire(Status(500, server_error)), wire(ResetMidBody)], vec![], "ok", 1),
        (vec![], vec![wire(Busy(0)), wire(Silence)], vec![], "ok", 1),
        (vec![], vec![wire(Page), wire(Body("[]"))], vec![], "ok", 1),
        (vec![], vec![wire(Endless)], vec![], "transient provider_answer_too_large", 1),
        (vec![], vec![wire(Status(500, server_error)); 3], vec![], "transient provider_server_error", 1),
        (vec![], vec![wire(Status(401, server_error))], vec![], "misconfigured provider_denied", 1),
        (vec![], vec![PollFault::Failed("CUDA out of memory")], vec![], "transient provider_task_failed", 1),
        (vec![], vec![PollFault::Unknown], vec![], "transient provider_task_lost", 1),
        (
            vec![],
            vec![PollFault::Output(json!("https://a.example.org/a.png")); 3],
            vec![],
            "transient provider_bad_answer",
            1,
        ),
        (
            vec![],
            vec![PollFault::Output(json!("http://169.254.169.254/a.glb"))],
            vec![],
            "misconfigured provider_address_refused",
            1,
        ),
        (
            vec![],
            vec![PollFault::Output(json!("file:///etc/a.glb"))],
            vec![],
            "misconfigured provider_address_refused",
            1,
        ),
        (vec![], vec![], vec![ResetMidBody], "ok", 1),
        (vec![], vec![], vec![Silence], "ok", 1),
        (vec![], vec![], vec![Page], "ok", 1),
        (vec![], vec![], vec![Body("glTF")], "ok", 1),
        (vec![], vec![], vec![Page; 3], "transient provider_bad_answer", 1),
        (vec![], vec![], vec![Status(404, "{}")], "transient provider_task_lost", 1),
        (
            vec![],
            vec![],
            vec![Status(403, "<Error>Request has expired</Error>")],
            "transient provider_task_lost",
            1,
        ),
        (vec![], vec![], vec![Endless], "transient provider_answer_too_large", 1),
        (
            vec![],
            vec![],
            vec![Redirect("http://169.254.169.254/a.glb")],
            "misconfigured provider_address_refused",
            1,
        ),
    ];
    for (submissions, polls, downloads, expected, billed) in cases {
        let bench = Bench::new().await;
        let message = format!("{submissions:?} {polls:?} {downloads:?}");
        bench.server.submissions.script(submissions);
        bench.server.polls.script(polls);
        bench.server.downloads.script(downloads);
        let result = bench.reconstruct().await.map_or_else(|error| class(&error), |_| "ok".into());
        assert_eq!((result.as_str(), bench.server.billed()), (expected, billed), "{message}");
        bench.outcomes();
        assert_eq!(
            bench.server.submissions.left() + bench.server.polls.left() + bench.server.downloads.left(),
            0
        );
    }
}

#[tokio::test]
async fn files_that_are_no_mesh_are_refused() {
    let whole = file();
    let flat = write_mesh_glb(&bottle().scaled(DVec3::new(1.0, 1.0, 1e-9)).snap_to_f32());
    for (bad, message) in [
        (whole.slice(..whole.len() / 2), "cut short"),
        (Bytes::from_static(b"no mesh"), "glTF"),
        (Bytes::from_static(b"PK\x03\x04"), "ZIP archive"),
        (write_mesh_glb(&TexturedMesh::default()).into(), "no triangle"),
        (flat.into(), "flat"),
    ] {
        let bench = Bench::with(|_| {}, bad).await;
        let error = bench.reconstruct().await.unwrap_err();
        assert_eq!(class(&error), "transient provider_bad_answer");
        assert!(error.to_string().contains(message), "{error}");
        assert_eq!(bench.server.downloaded().len(), 3, "it may have been read while it was written");
        // The next try of the job begins anew.
        let _ = bench.reconstruct().await;
        assert_eq!(bench.server.billed(), 2);
    }
}

#[tokio::test]
async fn a_fine_mesh_is_reduced() {
    let mut ball = TexturedMesh::default();
    ball.add(shapes::sphere(0.1, 40), &Material::plain("clay", Rgb([0.6, 0.4, 0.3]), 0.9));
    let file = write_mesh_glb(&ball.clone().snap_to_f32()).into();
    let bench = Bench::with(|settings| settings.mesh.max_triangles = 1000, file).await;
    let raw = bench.reconstruct().await.unwrap();
    let (before, after) = (ball.triangle_count(), raw.mesh.triangle_count());
    assert!(before > 1500 && after <= 1000, "{before} {after}");
}

#[tokio::test]
async fn a_prediction_that_never_ends_is_called_off() {
    let bench = Bench::with(|settings| settings.task.task_timeout_secs = 0, file()).await;
    assert_eq!(class(&bench.reconstruct().await.unwrap_err()), "transient provider_task_timeout");
    assert_eq!((bench.server.billed(), bench.server.cancelled()), (1, 1));
}

#[tokio::test]
async fn next_worker_after_a_crash_submits_nothing_twice() {
    // Killed while the vendor works.
    let bench = Bench::new().await;
    bench.server.polls.script([PollFault::Wire(WireFault::Silence)]);
    let asked = bench.generator.reconstruct(&bench.call, request());
    assert!(tokio::time::timeout(Duration::from_millis(300), asked).await.is_err(), "it waits");
    bench.reconstruct().await.unwrap();
    assert_eq!((bench.server.billed(), bench.outcomes()), (1, vec![ANSWERED]));
    // Killed after the file was fetched, before the stage was written down: the vendor has deleted everything.
    bench.server.polls.script([PollFault::Unknown]);
    let downloads = bench.server.downloaded().len();
    bench.reconstruct().await.unwrap();
    assert_eq!((bench.server.billed(), bench.server.downloaded().len()), (1, downloads));
}

#[tokio::test]
async fn a_vendor_that_is_away_for_a_while_keeps_its_job() {
    let bench = Bench::new().await;
    bench.server.polls.script(vec![PollFault::Wire(WireFault::Status(503, "{}")); 3]);
    assert_eq!(class(&bench.reconstruct().await.unwrap_err()), "transient provider_server_error");
    bench.reconstruct().await.unwrap();
    assert_eq!(bench.server.billed(), 1);
}

#[tokio::test]
async fn cancelling_calls_the_prediction_off_and_draining_does_not() {
    for cancelled in [true, false] {
        let mut bench = Bench::new().await;
        bench.server.polls.script([PollFault::Wire(WireFault::Silence)]);
        bench.call.cancel = CancelFlag::default();
        bench.book.cancelled.store(cancelled, Ordering::Relaxed);
        let cancel = bench.call.cancel.clone();
        let raised = async {
            while bench.server.polls.left() > 0 {
                tokio::time::sleep(Duration::from_millis(5)).await;
            }
            cancel.cancel();
        };
        let (result, ()) = tokio::join!(bench.reconstruct(), raised);
        assert!(matches!(result, Err(ProviderError::Cancelled(_))));
        assert_eq!(bench.server.cancelled(), usize::from(cancelled));
    }
}

#[tokio::test]
async fn a_budget_that_is_too_small_submits_nothing() {
    let mut bench = Bench::new().await;
    bench.call = Book::with_budget(PRICE - 1).call();
    assert!(matches!(bench.reconstruct().await, Err(ProviderError::OverBudget { .. })));
    assert!(bench.server.inputs().is_empty());
}

#[tokio::test]
async fn tables_are_left_to_others() {
    let bench = Bench::new().await;
    let table = RecognizedTable {
        label: "table".into(),
        shape: TableShape::Rectangular,
        model: "dining_table".into(),
        outline_m: None,
        size_m: DVec3::new(1.4, 0.8, 0.74),
        color: None,
        material: None,
        seed: 1,
    };
    let request = TableRequest { table, photograph: None };
    let refused = bench.generator.table(&bench.call, request).await.unwrap_err();
    assert!(refused.to_string().contains("providers.mesh_generator"), "{refused}");
}
