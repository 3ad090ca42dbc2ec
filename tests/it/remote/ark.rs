//! The image generator over Ark's Seedream, against a server that speaks its protocol.

use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use imaging::Image;
use imaging::codec::encode_png;
use ports::ledger::OnUnknown;
use ports::{Call, Completion, GeneratedReference, ImageGenerator, Port, ProviderError, TopViewImage};
use remote::ark;
use remote::ark::ArkImageGenerator;
use serde_json::json;

use crate::harness::server::settings;
use crate::remote::ark_server::{ArkServer, Fault, KEY};
use crate::remote::bench::{self, Book, class};
use crate::remote::images::{half_hidden_ball, plain_description, view_from_above};
use crate::remote::wire_faults::{self, WireFault};

/// Price of an image in these tests, millionths of a dollar.
const PRICE: i64 = 30_000;

const ANSWERED: &str = "answered";
const UNKNOWN: &str = "outcome_unknown";

struct Bench {
    server: ArkServer,
    book: Arc<Book>,
    call: Call,
    image_generator: ArkImageGenerator,
}

impl Bench {
    async fn new() -> Self {
        Self::with(KEY, OnUnknown::Resend).await
    }

    async fn with(key: &str, on_unknown: OnUnknown) -> Self {
        let server = ArkServer::start().await;
        let mut settings = settings(&[]).config.providers.ark;
        settings.endpoint.base_url = server.base_url.clone();
        settings.usd_per_image = PRICE as f64 / 1e6;
        settings.redraws = 2;
        bench::make_quick(&mut settings.endpoint.limits);
        settings.endpoint.limits.max_answer_bytes = 4 << 20;
        let endpoint = bench::endpoint(Port::ImageGenerator, ark::NAME, &settings.endpoint, key, on_unknown);
        let image_generator = ArkImageGenerator { endpoint: Arc::new(endpoint), settings };
        let book = Book::with_budget(1_000_000_000);
        Self { server, call: book.call(), book, image_generator }
    }

    async fn reference(&self) -> Result<GeneratedReference, ProviderError> {
        let asked = self.image_generator.reference(&self.call, Arc::new(plain_description()), 7);
        tokio::time::timeout(Duration::from_secs(60), asked).await.expect("nothing hangs")
    }

    async fn top_view(&self) -> Result<TopViewImage, ProviderError> {
        let asked = self.image_generator.top_view(&self.call, view_from_above());
        tokio::time::timeout(Duration::from_secs(60), asked).await.expect("nothing hangs")
    }

    async fn completion(&self) -> Result<Completion, ProviderError> {
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

#[tokio::test]
async fn ark_renders_description_without_watermark_and_records_price() {
    let bench = Bench::new().await;
    let generated = bench.reference().await.unwrap();
    let (width_px, height_px) = (generated.image.width_px(), generated.image.height_px());
    assert_eq!(generated.image.pixel(width_px - 3, height_px - 3), [120, 100, 80, 255]);
    let (asked, images) = &bench.server.asked()[0];
    assert!(asked["prompt"].as_str().unwrap().contains("A red ball on a table.") && images.is_empty());
    assert_eq!((bench.outcomes(), bench.book.spent()), (vec![ANSWERED], PRICE));
}

#[tokio::test]
async fn top_view_is_drawn_from_the_reference_image() {
    let bench = Bench::new().await;
    assert_eq!(bench.top_view().await.unwrap().known, None, "somebody has to look at it");
    let (asked, images) = &bench.server.asked()[0];
    assert!(asked["prompt"].as_str().unwrap().contains("straight above"));
    assert_eq!(images.len(), 1);
}

#[tokio::test]
async fn object_is_drawn_on_a_key_color_and_cut_out() {
    let bench = Bench::new().await;
    let completion = bench.completion().await.unwrap();
    let [x0, y0, x1, y1] = completion.crop_px;
    assert!((0.5 * (x0 + x1) - 200.0).abs() < 2.5 && (0.5 * (y0 + y1) - 150.0).abs() < 2.5);
    assert!((0.15..0.35).contains(&completion.completed_share), "{}", completion.completed_share);
    let (width_px, height_px) = (completion.image.width_px(), completion.image.height_px());
    assert_eq!(completion.image.pixel(0, 0)[3], 0);
    assert_eq!(completion.image.pixel(width_px / 2, height_px / 2), [200, 20, 20, 255]);
    let (asked, images) = &bench.server.asked()[0];
    let around = images[1].pixel(0, 0);
    let named = format!("#{:02x}{:02x}{:02x}", around[0], around[1], around[2]);
    assert!(asked["prompt"].as_str().unwrap().contains(&named), "the color is named: {}", asked["prompt"]);
    assert_eq!((images.len(), asked["size"].as_str()), (2, Some("1024x1024")));
    assert_eq!((bench.outcomes(), bench.book.spent()), (vec![ANSWERED], PRICE));
}

#[tokio::test]
async fn a_drawing_with_a_scene_behind_it_is_asked_for_again_with_the_reason() {
    let scene = {
        let mut scene = Image::filled(1024, 1024, [240, 240, 240, 255]);
        (0..1024).for_each(|x| (400..1024).for_each(|y| scene.set_pixel(x, y, [90, 60, 40, 255])));
        Bytes::from(encode_png(&scene))
    };
    let bench = Bench::new().await;
    bench.server.faults.script([Fault::File(scene.clone())]);
    bench.completion().await.unwrap();
    let asked = bench.server.asked();
    assert!(asked[1].0["prompt"].as_str().unwrap().contains("not one plain color"));
    assert_eq!(bench.outcomes(), [ANSWERED; 2]);
    let bench = Bench::new().await;
    bench.server.faults.script(vec![Fault::File(scene); 3]);
    assert_eq!(class(&bench.completion().await.map(|_| ()).unwrap_err()), "transient provider_bad_answer");
    assert_eq!(bench.outcomes(), [ANSWERED; 3]);
}

#[tokio::test]
async fn each_fault_ends_in_its_class() {
    let half = {
        let whole = encode_png(&Image::filled(1024, 1024, [1, 2, 3, 255]));
        Bytes::from(whole[..whole.len() / 2].to_vec())
    };
    let small = Bytes::from(encode_png(&Image::filled(64, 64, [1, 2, 3, 255])));
    let filtered = r#"{"error": {"code": "InputTextSensitiveContentDetected", "message": "told"}}"#;
    let overdue = r#"{"error": {"code": "AccountOverdueError", "message": "told"}}"#;
    let status = |status, message| vec![Fault::Wire(WireFault::Status(status, message))];
    let mut cases = wire_faults::cases(Fault::Wire);
    cases.extend([
        (status(403, overdue), "misconfigured provider_denied", vec!["provider_denied"]),
        (status(400, filtered), "refused answer_refused", vec!["answer_refused"]),
        (vec![Fault::Wire(WireFault::Body("{\"data\": []}"))], "ok", vec!["provider_bad_answer", ANSWERED]),
        (
            vec![Fault::NoImage("OutputImageSensitiveContentDetected")],
            "refused answer_refused",
            vec!["answer_refused"],
        ),
        (vec![Fault::NoImage("InternalServiceError")], "ok", vec!["provider_bad_answer", ANSWERED]),
        (
            vec![Fault::Address("http://169.254.169.254/latest"); 3],
            "transient provider_bad_answer",
            vec!["provider_bad_answer"; 3],
        ),
        (vec![Fault::File(half.clone())], "ok", vec![ANSWERED; 2]),
        (vec![Fault::File(half); 3], "transient provider_bad_answer", vec![ANSWERED; 3]),
        (vec![Fault::File(small)], "ok", vec![ANSWERED; 2]),
    ]);
    for (faults, expected, outcomes) in cases {
        let bench = Bench::new().await;
        bench.server.faults.script(faults.iter().cloned());
        let result = bench.reference().await.map_or_else(|error| class(&error), |_| "ok".into());
        assert_eq!((result.as_str(), &bench.outcomes()), (expected, &outcomes), "{faults:?}");
    }
}

#[tokio::test]
async fn a_view_from_above_that_cannot_be_read_is_no_view() {
    let bench = Bench::new().await;
    bench.server.faults.script([Fault::File(Bytes::from_static(b"GIF89a"))]);
    let result = bench.top_view().await.map(|_| ()).map_err(|error| class(&error));
    assert_eq!(result, Err("transient provider_bad_answer".into()));
    assert_eq!(bench.outcomes(), [ANSWERED]);
}

#[tokio::test]
async fn lost_image_waits_for_a_person_where_configured() {
    let bench = Bench::with(KEY, OnUnknown::Fail).await;
    bench.server.faults.script([Fault::Wire(WireFault::ResetMidBody)]);
    assert_eq!(class(&bench.reference().await.map(|_| ()).unwrap_err()), "rejected outcome_unknown");
    assert_eq!(bench.outcomes(), [UNKNOWN]);
    assert_eq!(bench.server.billed(), 1, "nothing is sent twice");
}

#[tokio::test]
async fn a_wrong_key_is_refused_and_a_small_budget_sends_nothing() {
    let bench = Bench::with("ark-wrong", OnUnknown::Resend).await;
    assert_eq!(class(&bench.reference().await.map(|_| ()).unwrap_err()), "misconfigured provider_denied");
    assert_eq!(bench.book.spent(), 0);
    let mut bench = Bench::new().await;
    bench.call = Book::with_budget(PRICE - 1).call();
    assert!(matches!(bench.reference().await, Err(ProviderError::OverBudget { .. })));
    assert!(bench.server.asked().is_empty());
    assert_eq!(bench.image_generator.adapter().settings["size"], json!(bench.image_generator.settings.size));
}
