//! The images image generator against a server that speaks its protocol: what is asked, what is taken, what is written
//! down.

use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use geometry::Camera;
use glam::DVec3;
use imaging::codec::encode_png;
use imaging::{Image, Mask};
use ports::ledger::OnUnknown;
use ports::{
    Call, Completion, CompletionRequest, GeneratedReference, ImageGenerator, Port, ProviderError,
    ReferenceImage, TopViewRequest,
};
use remote::images::OpenAiImageGenerator;
use remote::{ImagesSettings, images};
use scene::{
    CameraKnowledge, InstanceId, Recognition, RecognizedObject, RecognizedTable, SceneDescription, StandsOn,
    TableShape, TableSpec,
};
use serde_json::json;

use crate::harness::server::settings;
use crate::remote::bench::{self, Book, class};
use crate::remote::images_server::{Artist, Fault, ImageRequest, ImagesServer, KEY};
use crate::remote::wire_faults::{self, WireFault};

/// Price of an answer of the server: 100 tokens at 5 dollars a million, 400 at 10, 1000 at 40.
const PRICE: i64 = 500 + 4_000 + 40_000;

const ANSWERED: &str = "answered";
const UNKNOWN: &str = "outcome_unknown";

/// An image generator on a server, quick to give up, with its books.
struct Bench {
    server: ImagesServer,
    book: Arc<Book>,
    call: Call,
    image_generator: OpenAiImageGenerator,
}

/// Renders a gray table, and redraws a red disk: whole, but elsewhere in the frame and larger than it was.
fn artist() -> Artist {
    Arc::new(|asked: &ImageRequest| {
        if asked.what == "generations" {
            return Image::filled(1536, 1024, [128, 128, 128, 255]);
        }
        let mut drawing = Image::filled(1024, 1024, [0; 4]);
        for y in 0..1024_u32 {
            for x in 0..1024_u32 {
                if (f64::from(x) - 560.0).hypot(f64::from(y) - 470.0) < 330.0 {
                    drawing.set_pixel(x, y, [200, 20, 20, 255]);
                }
            }
        }
        drawing
    })
}

impl Bench {
    async fn new() -> Self {
        Self::with(|_| {}, OnUnknown::Resend).await
    }

    async fn with(change: impl Fn(&mut ImagesSettings), on_unknown: OnUnknown) -> Self {
        let server = ImagesServer::start(artist()).await;
        let mut settings = settings(&[]).config.providers.openai_images;
        settings.endpoint.base_url = server.base_url.clone();
        bench::make_quick(&mut settings.endpoint.limits);
        settings.endpoint.limits.attempt_timeout_secs = 5;
        change(&mut settings);
        let book = Book::with_budget(1_000_000_000);
        let endpoint =
            bench::endpoint(Port::ImageGenerator, images::NAME, &settings.endpoint, KEY, on_unknown);
        let image_generator = OpenAiImageGenerator { endpoint: Arc::new(endpoint), settings };
        Self { server, call: book.call(), book, image_generator }
    }

    async fn reference(&self) -> Result<GeneratedReference, ProviderError> {
        let asked = self.image_generator.reference(&self.call, Arc::new(plain_description()), 7);
        tokio::time::timeout(Duration::from_secs(60), asked).await.expect("nothing hangs")
    }

    async fn complete(&self) -> Result<Completion, ProviderError> {
        let asked = self.image_generator.complete(&self.call, half_hidden_ball());
        tokio::time::timeout(Duration::from_secs(60), asked).await.expect("nothing hangs")
    }

    /// Everything that was billed stands in the books.
    fn outcomes(&self) -> Vec<&'static str> {
        let billed = self.server.billed() as i64 * PRICE;
        assert!(self.book.spent() >= billed, "{} < {billed}", self.book.spent());
        assert_eq!(self.server.faults.left(), 0);
        self.book.outcomes().into_iter().map(|outcome| outcome.expect("everything is settled")).collect()
    }
}

/// Words alone.
pub fn plain_description() -> SceneDescription {
    SceneDescription {
        theme: "t".into(),
        family: "dining_kitchen".into(),
        table: TableSpec::default(),
        table_size_is_stated: false,
        objects: Vec::new(),
        arrangements: Vec::new(),
        goal: None,
        excluded_categories: Vec::new(),
        understood: Vec::new(),
        unrecognized: Vec::new(),
        prose: "A red ball on a table.".into(),
    }
}

/// The view from above of a table where nothing was recognized.
pub fn view_from_above() -> TopViewRequest {
    let known = Recognition {
        camera: Camera::orbit(400, 300, 0.6, DVec3::ZERO, 0.0, 0.7, 2.0),
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
        objects: Vec::new(),
        left_out_px: Vec::new(),
        depth: None,
    };
    TopViewRequest {
        reference: half_hidden_ball().reference,
        recognition: Arc::new(known),
        masks: Arc::default(),
        rendered: None,
        refused: Vec::new(),
    }
}

/// A red disk of 40 pixels' radius at 200, 150, its right lower quarter behind a box.
pub fn half_hidden_ball() -> CompletionRequest {
    let inside = |x: u32, y: u32| (f64::from(x) + 0.5 - 200.0).hypot(f64::from(y) + 0.5 - 150.0) < 40.0;
    let others = Mask::from_fn(400, 300, |x, y| x >= 200 && y >= 150 && x < 280 && y < 260);
    let visible = Mask::from_fn(400, 300, |x, y| inside(x, y) && !others.contains(x, y));
    let mut image = Image::filled(400, 300, [90, 90, 90, 255]);
    for y in 0..300 {
        for x in 0..400 {
            if visible.contains(x, y) {
                image.set_pixel(x, y, [200, 20, 20, 255]);
            }
        }
    }
    CompletionRequest {
        reference: ReferenceImage { image: Arc::new(image), known: None, depth: None },
        object: RecognizedObject {
            id: InstanceId::new("ball_1").unwrap(),
            label: "red ball".into(),
            category: "ball".into(),
            size_m: DVec3::splat(0.08),
            tipped: None,
            color: None,
            material: None,
            stands_on: StandsOn::Table,
            seen_px: None,
            seen_as: None,
            seen_like: None,
            mass_kg: None,
            stand_in: None,
            seed: 1,
        },
        visible,
        others,
        camera: None,
        alone: None,
    }
}

#[tokio::test]
async fn image_generator_renders_description_and_records_price() {
    let bench = Bench::new().await;
    let generated = bench.reference().await.unwrap();
    assert_eq!((generated.image.width_px(), generated.image.height_px()), (1280, 853));
    assert!(generated.ground_truth.is_none(), "nobody knows what is on it");
    let asked = &bench.server.asked()[0];
    assert_eq!((&asked.fields["size"], &asked.fields["quality"]), (&"1536x1024".into(), &"high".into()));
    assert!(asked.fields["prompt"].as_str().unwrap().contains("A red ball on a table."));
    assert_eq!((bench.outcomes(), bench.book.spent()), (vec![ANSWERED], PRICE));
    let (intent, end) = bench.book.rows.lock().unwrap()[0].clone();
    assert_eq!((intent.operation, intent.port), ("paint", Port::ImageGenerator));
    assert_eq!(end.unwrap().output_tokens, Some(1000));
}

#[tokio::test]
async fn half_occluded_object_is_inpainted_whole_and_registered_in_place() {
    let bench = Bench::new().await;
    let completion = bench.complete().await.unwrap();
    let asked = &bench.server.asked()[0];
    assert_eq!((asked.what, asked.images.len()), ("edits", 2));
    assert_eq!(asked.fields["background"], "transparent");
    let [around, alone] = &asked.images[..] else { panic!("two pictures") };
    assert_eq!((around.width_px(), around.height_px()), (alone.width_px(), alone.height_px()));
    assert!(alone.as_rgba().chunks_exact(4).all(|pixel| pixel[3] == 0 || pixel[0] == 200));
    let area = std::f64::consts::PI * 1600.0;
    assert!((completion.silhouette.area_px() as f64 / area - 1.0).abs() < 0.04);
    assert!((0.18..0.29).contains(&completion.completed_share), "{}", completion.completed_share);
    let [x0, y0, x1, y1] = completion.crop_px;
    let (center_x, center_y) = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
    assert!((center_x - 200.0).abs() < 1.5 && (center_y - 150.0).abs() < 1.5, "{center_x} {center_y}");
    assert_eq!(completion.image.pixel(0, 0)[3], 0);
    let center = (completion.image.width_px() / 2, completion.image.height_px() / 2);
    assert_eq!(completion.image.pixel(center.0, center.1), [200, 20, 20, 255]);
}

#[tokio::test]
async fn completions_of_the_embedded_generator_cost_nothing() {
    let bench = Bench::new().await;
    let drawn = bench.complete().await.unwrap();
    let request = CompletionRequest { alone: Some(drawn.clone()), ..half_hidden_ball() };
    assert_eq!(bench.image_generator.complete(&bench.call, request).await.unwrap(), drawn);
    assert_eq!(bench.outcomes().len(), 1);
}

#[tokio::test]
async fn unusable_drawing_is_requested_again_with_the_reason() {
    for (fault, message) in [
        (Fault::Opaque, "its background is not transparent"),
        (Fault::AnotherObject, "another object"),
        (Fault::File(Bytes::from_static(b"GIF89a")), "no PNG, JPEG or WebP"),
    ] {
        let bench = Bench::new().await;
        bench.server.faults.script([fault.clone()]);
        bench.complete().await.unwrap();
        let prompts: Vec<String> = bench
            .server
            .asked()
            .iter()
            .map(|asked| asked.fields["prompt"].as_str().unwrap().into())
            .collect();
        assert_eq!(prompts.len(), 2, "{fault:?}");
        assert!(prompts[1].contains(message) && !prompts[0].contains("earlier"), "{}", prompts[1]);
        assert_eq!(bench.outcomes(), [ANSWERED; 2]);
    }
}

#[tokio::test]
async fn each_fault_ends_in_its_class() {
    let half = {
        let whole = encode_png(&Image::filled(1024, 1024, [1, 2, 3, 0]));
        Bytes::from(whole[..whole.len() / 2].to_vec())
    };
    let mut cases = wire_faults::cases(Fault::Wire);
    cases.extend([
        (vec![Fault::Wire(WireFault::Body("{\"data\": []}"))], "ok", vec!["provider_bad_answer", ANSWERED]),
        (vec![Fault::Blocked], "refused answer_refused", vec!["answer_refused"]),
        (
            vec![Fault::Address("http://169.254.169.254/latest"); 3],
            "transient provider_bad_answer",
            vec!["provider_bad_answer"; 3],
        ),
        (vec![Fault::File(half.clone())], "ok", vec![ANSWERED; 2]),
        (vec![Fault::File(half); 3], "transient provider_bad_answer", vec![ANSWERED; 3]),
        (vec![Fault::AnotherObject; 3], "transient provider_bad_answer", vec![ANSWERED; 3]),
    ]);
    for (faults, expected, outcomes) in cases {
        let bench =
            Bench::with(|settings| settings.endpoint.limits.attempt_timeout_secs = 2, OnUnknown::Resend)
                .await;
        bench.server.faults.script(faults.iter().cloned());
        let result = bench.complete().await.map_or_else(|error| class(&error), |_| "ok".into());
        assert_eq!((result.as_str(), &bench.outcomes()), (expected, &outcomes), "{faults:?}");
    }
}

#[tokio::test]
async fn lost_image_waits_for_a_person_where_configured() {
    let bench = Bench::with(|_| {}, OnUnknown::Fail).await;
    bench.server.faults.script([Fault::Wire(WireFault::ResetMidBody)]);
    assert_eq!(class(&bench.reference().await.unwrap_err()), "rejected outcome_unknown");
    assert_eq!(bench.outcomes(), [UNKNOWN]);
    assert_eq!(bench.server.billed(), 1, "nothing is sent twice");
}

#[tokio::test]
async fn a_budget_that_is_too_small_sends_nothing() {
    let mut bench = Bench::new().await;
    bench.call = Book::with_budget(10).call();
    assert!(matches!(bench.reference().await, Err(ProviderError::OverBudget { .. })));
    assert!(matches!(bench.complete().await, Err(ProviderError::OverBudget { .. })));
    assert!(bench.server.asked().is_empty());
}

#[tokio::test]
async fn views_from_above_are_drawn_until_too_many_were_refused() {
    let bench = Bench::new().await;
    let mut request = view_from_above();
    for _ in 0..=bench.image_generator.settings.redraws {
        let top = bench.image_generator.top_view(&bench.call, request.clone()).await.unwrap();
        assert_eq!(top.known, None, "somebody has to look at it");
        request.refused.push("the legs are seen".into());
    }
    let asked = bench.server.asked();
    let (first, second) = (&asked[0], &asked[1]);
    assert_eq!((first.what, first.images.len(), &first.fields["background"]), ("edits", 1, &json!("opaque")));
    let prompt = |asked: &ImageRequest| asked.fields["prompt"].as_str().unwrap().to_owned();
    assert!(prompt(first).contains("straight above") && !prompt(first).contains("the legs are seen"));
    assert!(prompt(second).contains("could not be used: the legs are seen."));
    // Another provider, a computed view for one, may answer then.
    let given_up = bench.image_generator.top_view(&bench.call, request).await.unwrap_err();
    assert!(
        given_up.another_may_answer() && given_up.to_string().contains("the legs are seen"),
        "{given_up}"
    );
    assert_eq!(bench.server.asked().len(), asked.len());
}
