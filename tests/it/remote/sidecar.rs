//! The segmenter over a sidecar, against a server that speaks its protocol.

use std::sync::Arc;
use std::time::Duration;

use geometry::Camera;
use glam::DVec3;
use http_client::HttpResponse;
use imaging::{Image, Mask};
use ports::ledger::{MicroUsd, OnUnknown};
use ports::{
    Call, Port, ProviderError, ReferenceImage, Segmentation, Segmenter, TopViewAnnotations, TopViewImage,
};
use remote::SidecarSettings;
use remote::sidecar;
use remote::sidecar::{SidecarSegmenter, wire};
use scene::{
    CameraKnowledge, InstanceId, InstanceMask, Recognition, RecognizedObject, RecognizedTable, StandsOn,
    TableShape,
};
use serde_json::json;

use crate::harness::server::settings;
use crate::remote::bench::{self, Book, class};
use crate::remote::sidecar_server::{Fault, OnImage, SidecarServer};
use crate::remote::wire_faults::{self, WireFault};

const ANSWERED: &str = "answered";

struct Bench {
    server: SidecarServer,
    book: Arc<Book>,
    call: Call,
    segmenter: SidecarSegmenter,
}

fn rectangle([x0, y0, x1, y1]: [u32; 4]) -> Mask {
    Mask::from_fn(80, 60, |x, y| (x0..x1).contains(&x) && (y0..y1).contains(&y))
}

const LEFT_MUG: [u32; 4] = [10, 20, 20, 34];
const RIGHT_MUG: [u32; 4] = [50, 22, 60, 36];
const PLATE: [u32; 4] = [5, 16, 40, 40];
const TABLE: [u32; 4] = [2, 10, 78, 58];

/// Two mugs, one of them on a plate, on a table.
fn objects() -> Vec<OnImage> {
    let object = |label, score, place| OnImage { label, score, mask: rectangle(place) };
    vec![
        object("mug", 0.6, LEFT_MUG),
        object("plate", 0.8, PLATE),
        object("mug", 0.9, RIGHT_MUG),
        object("table", 0.7, TABLE),
        object("mug", 0.1, [70, 50, 75, 55]),
    ]
}

fn recognition() -> Recognition {
    let object = |id: &str, label: &str, seen: [u32; 4]| RecognizedObject {
        id: InstanceId::new(id).unwrap(),
        label: label.into(),
        category: "mug".into(),
        size_m: DVec3::splat(0.1),
        tipped: None,
        color: None,
        material: None,
        seed: 1,
        stands_on: StandsOn::Table,
        seen_px: Some(seen.map(|side| f64::from(side) + 1.0)),
        seen_as: None,
        seen_like: None,
        mass_kg: None,
        stand_in: None,
    };
    Recognition {
        camera: Camera::orbit(80, 60, 0.6, DVec3::ZERO, 0.0, 0.7, 2.0),
        camera_is: CameraKnowledge::Judged,
        table: RecognizedTable {
            label: "table".into(),
            shape: TableShape::Rectangular,
            model: "dining_table".into(),
            outline_m: None,
            size_m: DVec3::new(1.4, 0.8, 0.74),
            color: None,
            material: None,
            seed: 1,
        },
        objects: vec![
            object("plate_1", "Plate", PLATE),
            object("mug_1", "mug", LEFT_MUG),
            object("mug_2", "mug", RIGHT_MUG),
        ],
        left_out_px: Vec::new(),
        depth: None,
    }
}

fn image() -> ReferenceImage {
    ReferenceImage { image: Arc::new(Image::filled(80, 60, [120, 110, 100, 255])), known: None, depth: None }
}

impl Bench {
    async fn new() -> Self {
        Self::with(|_| {}).await
    }

    async fn with(change: impl Fn(&mut SidecarSettings)) -> Self {
        let server = SidecarServer::start(objects()).await;
        let mut settings = settings(&[]).config.providers.segmenter_sidecar;
        settings.endpoint.base_url = server.base_url.clone();
        bench::make_quick(&mut settings.endpoint.limits);
        change(&mut settings);
        let book = Book::with_budget(1_000_000);
        let endpoint =
            bench::endpoint(Port::Segmenter, sidecar::NAME, &settings.endpoint, "", OnUnknown::Resend);
        let segmenter = SidecarSegmenter { endpoint: Arc::new(endpoint), settings };
        Self { server, call: book.call(), book, segmenter }
    }

    async fn segment(&self) -> Result<Segmentation, ProviderError> {
        let asked = self.segmenter.segment(&self.call, image(), Arc::new(recognition()));
        tokio::time::timeout(Duration::from_secs(60), asked).await.expect("nothing hangs")
    }
}

#[tokio::test]
async fn everything_recognized_is_found_and_no_pixel_belongs_to_two() {
    let bench = Bench::new().await;
    let found = bench.segment().await.unwrap();
    let shown: Vec<(&str, Option<[u32; 4]>, usize)> = found
        .masks
        .iter()
        .map(|mask| (mask.id.as_str(), mask.visible.bbox_px(), mask.visible.area_px()))
        .collect();
    assert_eq!(
        shown,
        [
            ("plate_1", Some(PLATE), 35 * 24 - 10 * 14),
            ("mug_1", Some(LEFT_MUG), 10 * 14),
            ("mug_2", Some(RIGHT_MUG), 10 * 14),
        ]
    );
    let (request, sent) = &bench.server.asked()[0];
    assert_eq!(
        *request,
        json!({ "labels": ["mug", "plate"], "box_threshold": 0.35, "text_threshold": 0.25 })
    );
    assert_eq!(*sent, *image().image);
    assert_eq!((bench.book.outcomes(), bench.book.spent()), (vec![Some(ANSWERED)], 0));
}

#[test]
fn the_example_of_the_document_is_read() {
    let document: serde_json::Value =
        serde_norway::from_str(include_str!("../../../docs/segmentation-sidecar.yaml")).unwrap();
    let answers = &document["paths"]["/v1/segment"]["post"]["responses"]["200"]["content"];
    let body = answers["application/json"]["example"].to_string().into();
    let reply =
        HttpResponse { status: 200, content_type: "application/json".into(), retry_after: None, body };
    let settings = settings(&[]).config.providers.segmenter_sidecar;
    let found = wire::read(&settings, &reply, [4, 4], &["mug".to_owned()]).result.unwrap();
    assert_eq!((found.len(), found[0].mask.bbox_px()), (1, Some([1, 1, 3, 3])));
}

#[tokio::test]
async fn the_table_is_found_or_is_not() {
    let bench = Bench::new().await;
    let table = bench.segmenter.table(&bench.call, image()).await.unwrap();
    assert_eq!(table.unwrap().bbox_px(), Some(TABLE));
    bench.server.faults.script([Fault::Blind]);
    assert_eq!(bench.segmenter.table(&bench.call, image()).await.unwrap(), None);
}

#[tokio::test]
async fn word_pieces_mean_what_was_asked_for() {
    let bench = Bench::new().await;
    bench.server.faults.script([Fault::Pieces]);
    let found = bench.segment().await.unwrap();
    assert_eq!(found.masks[2].visible.bbox_px(), Some(RIGHT_MUG));
}

#[tokio::test]
async fn each_fault_ends_in_its_class() {
    let bad = |pointer, value| vec![Fault::Spoiled(pointer, value)];
    let mut cases = wire_faults::cases(Fault::Wire);
    cases.extend([
        (
            vec![Fault::Wire(WireFault::Status(503, r#"{"detail": "CUDA out of memory"}"#))],
            "ok",
            vec!["provider_server_error", ANSWERED],
        ),
        (bad("/img_width", json!(81)), "ok", vec!["provider_bad_answer", ANSWERED]),
        (
            bad("/annotations/0/segmentation/counts", json!("oooooo")),
            "ok",
            vec!["provider_bad_answer", ANSWERED],
        ),
        (
            bad("/annotations/0/segmentation/size", json!([60000, 60000])),
            "ok",
            vec!["provider_bad_answer", ANSWERED],
        ),
        (bad("/annotations/0/score", json!(-1)), "ok", vec!["provider_bad_answer", ANSWERED]),
        (bad("/annotations/1/class_name", json!("giraffe")), "ok", vec![ANSWERED]),
        (vec![Fault::Blind], "rejected object_not_found", vec![ANSWERED]),
    ]);
    for (faults, expected, outcomes) in cases {
        let bench = Bench::new().await;
        bench.server.faults.script(faults.iter().cloned());
        let result = bench.segment().await.map_or_else(|error| class(&error), |_| "ok".into());
        let written: Vec<&str> = bench
            .book
            .outcomes()
            .into_iter()
            .map(|outcome| outcome.expect("everything is settled"))
            .collect();
        assert_eq!((result.as_str(), &written), (expected, &outcomes), "{faults:?}");
        assert_eq!(bench.server.faults.left(), 0, "{faults:?}");
    }
}

#[tokio::test]
async fn a_server_that_costs_something_is_paid_for() {
    let bench = Bench::with(|settings| settings.usd_per_call = 0.002).await;
    bench.server.faults.script([Fault::Wire(WireFault::ResetMidBody)]);
    bench.segment().await.unwrap();
    assert_eq!(bench.book.spent(), 4_000, "the lost one may have cost as much");
    assert_eq!(bench.book.rows.lock().unwrap()[1].0.reserved, MicroUsd(2_000));
}

#[tokio::test]
async fn boxes_on_a_view_from_above_are_its_makers() {
    let bench = Bench::new().await;
    let top = TopViewImage {
        image: Image::filled(80, 60, [255; 4]),
        known: Some(TopViewAnnotations {
            table: rectangle(TABLE),
            objects: vec![InstanceMask {
                id: InstanceId::new("mug_1").unwrap(),
                visible: rectangle(LEFT_MUG),
            }],
        }),
    };
    let recognition = Arc::new(recognition());
    let boxes = bench.segmenter.top_boxes(&bench.call, top.clone(), recognition.clone()).await.unwrap();
    assert_eq!((boxes.table_px, boxes.objects[0].box_px), (TABLE.map(f64::from), LEFT_MUG.map(f64::from)));
    assert!(bench.server.asked().is_empty());

    // In a generated top view the segmenter searches for them.
    let drawn = TopViewImage { known: None, ..top };
    let boxes = bench.segmenter.top_boxes(&bench.call, drawn.clone(), recognition.clone()).await.unwrap();
    assert!(bench.server.asked()[0].0["labels"].as_array().unwrap().contains(&json!("table")));
    assert_eq!(boxes.table_px, TABLE.map(f64::from));
    for (found, object) in boxes.objects.iter().zip(&recognition.objects) {
        // Here the view from above is the image itself, so that places are about the same.
        let seen = object.seen_px.unwrap();
        assert_eq!(found.id, object.id);
        assert!((found.box_px[0] - seen[0]).abs() < 2.0, "{found:?}");
    }
    bench.server.faults.script([Fault::Blind]);
    let refused = bench.segmenter.top_boxes(&bench.call, drawn, recognition).await.unwrap_err();
    assert_eq!(class(&refused), "rejected object_not_found");
}
