//! Wire format: `POST {base}/v1/segment`, the protocol of `docs/segmentation-sidecar.yaml`. Responses have the shape
//! of the files that the demonstrations of Grounded SAM 2 write.

use bytes::Bytes;
use serde::Deserialize;
use serde_json::json;

use super::super::endpoint::Reading;
use super::super::failure::{Failure, FailureKind, one_line};
use super::super::multipart::Form;
use super::super::settings::SidecarSettings;
use http_client::HttpResponse;
use imaging::{Mask, RunLengths};
use ports::ledger::MicroUsd;

/// Maximum detections of a response.
const MAX_DETECTIONS: usize = 512;

/// A detected object.
#[derive(Clone, Debug, PartialEq)]
pub struct Detection {
    /// One of the requested labels; `None` where the class name means none of them.
    pub label: Option<String>,
    /// 0..1.
    pub score: f64,
    /// Bounding box: x0, y0, x1, y1, pixels.
    pub box_px: [f64; 4],
    /// Of the size of the image, not empty.
    pub mask: Mask,
}

/// Form of a request. `labels` are [`normalized`].
pub fn request(settings: &SidecarSettings, png: Bytes, labels: &[String]) -> Form {
    let asked = json!({
        "labels": labels, "box_threshold": settings.box_threshold, "text_threshold": settings.text_threshold,
    });
    Form::default().file("image", "image.png", "image/png", png).text("request", &asked.to_string())
}

/// A label in the form for detectors: lower case, letters, digits and single spaces.
pub fn normalized(label: &str) -> String {
    let spaced: String =
        label.to_lowercase().chars().map(|c| if c.is_alphanumeric() { c } else { ' ' }).collect();
    spaced.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[derive(Deserialize)]
struct Answer {
    img_width: u32,
    img_height: u32,
    annotations: Vec<Annotation>,
}

#[derive(Deserialize)]
struct Annotation {
    class_name: String,
    score: Score,
    bbox: [f64; 4],
    segmentation: Segmentation,
}

/// The demonstrations write SAM's score as a list of one.
#[derive(Deserialize)]
#[serde(untagged)]
enum Score {
    One(f64),
    List([f64; 1]),
}

#[derive(Deserialize)]
struct Segmentation {
    size: [u32; 2],
    counts: String,
}

/// Reads a successful response. Masks have the size of the image, `size_px` = [height, width].
pub fn read(
    settings: &SidecarSettings,
    reply: &HttpResponse,
    size_px: [u32; 2],
    labels: &[String],
) -> Reading<Vec<Detection>> {
    let result = found(reply, size_px, labels);
    let cost = Some(MicroUsd::of_usd(settings.usd_per_call));
    Reading { cost, input_tokens: None, output_tokens: None, task: None, result }
}

fn found(reply: &HttpResponse, size_px: [u32; 2], labels: &[String]) -> Result<Vec<Detection>, Failure> {
    if !reply.content_type.ends_with("json") {
        return Err(bad(format!("it answered with {:?} in place of JSON", one_line(&reply.content_type))));
    }
    let answer: Answer = serde_json::from_slice(&reply.body)
        .map_err(|error| bad(format!("its answer is no list of annotations: {error}")))?;
    let [height, width] = size_px;
    if [answer.img_height, answer.img_width] != size_px {
        let (other_width, other_height) = (answer.img_width, answer.img_height);
        return Err(bad(format!(
            "it describes an image of {other_width} x {other_height}, sent was {width} x {height}"
        )));
    }
    if answer.annotations.len() > MAX_DETECTIONS {
        let found = answer.annotations.len();
        return Err(bad(format!("it found {found} objects, more than {MAX_DETECTIONS}")));
    }
    let read = answer.annotations.into_iter().enumerate().map(|(index, annotation)| {
        let wrong = |what: &str| bad(format!("annotations[{index}]: {what}"));
        let (Score::One(score) | Score::List([score])) = annotation.score;
        if !(0.0..=1.0).contains(&score) {
            return Err(wrong("its score is not from 0 to 1"));
        }
        let [x0, y0, x1, y1] = annotation.bbox;
        if !(x0 < x1 && y0 < y1 && annotation.bbox.iter().all(|side| side.abs() < 1e6)) {
            return Err(wrong("its box is empty"));
        }
        let Segmentation { size, counts } = annotation.segmentation;
        if size != size_px {
            return Err(wrong("its mask has another size than the image"));
        }
        let mask = RunLengths::from_compressed(size, &counts).and_then(Mask::try_from);
        let mask = mask.map_err(|error| wrong(&error.to_string()))?;
        let label = label_of(&annotation.class_name, labels);
        Ok((mask.area_px() > 0).then_some(Detection { label, score, box_px: annotation.bbox, mask }))
    });
    let found: Result<Vec<Option<Detection>>, Failure> = read.collect();
    Ok(found?.into_iter().flatten().collect())
}

fn bad(reason: String) -> Failure {
    Failure::new(FailureKind::BadAnswer, reason)
}

/// The label that a class name means. Grounding DINO answers with the matched tokens: words of several labels, or
/// pieces of words ("##fying glass" for "magnifying glass"). The label with the most shared letters wins, if they are
/// at least half of it.
fn label_of(class_name: &str, labels: &[String]) -> Option<String> {
    let pieces: String = class_name.replace("##", "");
    let name = normalized(&pieces);
    if labels.contains(&name) {
        return Some(name);
    }
    let words: Vec<&str> = name.split(' ').filter(|word| !word.is_empty()).collect();
    let shared = |label: &str| -> usize {
        let in_label = |word: &&str| label.split(' ').any(|of_label| of_label.ends_with(*word));
        words.iter().filter(|word| in_label(word)).map(|word| word.chars().count()).sum()
    };
    let scored = labels.iter().map(|label| (shared(label), label));
    let letters = |label: &str| label.chars().filter(|c| *c != ' ').count();
    let enough = scored.filter(|(shared, label)| *shared > 0 && 2 * shared >= letters(label));
    // Ties go to the shorter label, then to the first.
    let best = enough.max_by_key(|(shared, label)| (*shared, std::cmp::Reverse((label.len(), *label))));
    best.map(|(_, label)| label.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> SidecarSettings {
        let mut defaults = crate::chat::tests::defaults();
        let section = defaults["providers"]["segmenter_sidecar"].take();
        serde_json::from_value(section).expect("is the section")
    }

    fn read_text(body: &str) -> Result<Vec<Detection>, String> {
        let body = Bytes::copy_from_slice(body.as_bytes());
        let reply =
            HttpResponse { status: 200, content_type: "application/json".into(), retry_after: None, body };
        let labels = ["mug".to_owned(), "magnifying glass".to_owned()];
        read(&settings(), &reply, [4, 4], &labels).result.map_err(|failure| failure.reason)
    }

    const DOCUMENTED: &str = r#"{"img_width": 4, "img_height": 4, "annotations": [{"class_name": "mug", "score": 0.93,
        "bbox": [1.0, 1.0, 3.0, 3.0], "segmentation": {"size": [4, 4], "counts": "52203"}}]}"#;

    #[test]
    fn read_parses_the_documented_response() {
        let [found] = &read_text(DOCUMENTED).expect("is read")[..] else { panic!("one thing") };
        assert_eq!((found.label.as_deref(), found.score), (Some("mug"), 0.93));
        assert_eq!(found.mask.bbox_px(), Some([1, 1, 3, 3]));
        // The demonstrations write scores as lists.
        let list = DOCUMENTED.replace("0.93", "[0.93]");
        assert_eq!(read_text(&list), read_text(DOCUMENTED));
        // Detections without pixels are dropped.
        let empty = DOCUMENTED.replace("52203", "`0");
        assert_eq!(read_text(&empty), Ok(Vec::new()));
    }

    #[test]
    fn request_has_the_documented_form() {
        let labels = ["mug".to_owned()];
        let (_, body) = request(&settings(), Bytes::from_static(b"PNG"), &labels).encoded();
        let text = String::from_utf8(body.to_vec()).expect("is text here");
        assert!(
            text.contains("name=\"image\"; filename=\"image.png\"\r\nContent-Type: image/png\r\n\r\nPNG\r\n")
        );
        assert!(text.contains(
            "name=\"request\"\r\n\r\n{\"labels\":[\"mug\"],\"box_threshold\":0.35,\"text_threshold\":0.25}\r\n"
        ));
    }

    #[test]
    fn read_rejects_detections_that_do_not_fit_the_image() {
        for (from, to) in [
            ("\"img_width\": 4", "\"img_width\": 5"),
            ("[4, 4]", "[4, 5]"),
            ("52203", "52204"),
            ("52203", "oooooooo"),
            ("0.93", "1.5"),
            ("0.93", "\"high\""),
            ("[1.0, 1.0, 3.0, 3.0]", "[3.0, 1.0, 1.0, 3.0]"),
            ("[1.0, 1.0, 3.0, 3.0]", "[1.0, 1.0, 3e300, 3.0]"),
            ("\"annotations\"", "\"results\""),
        ] {
            let spoiled = DOCUMENTED.replace(from, to);
            assert_ne!(spoiled, DOCUMENTED);
            assert!(read_text(&spoiled).is_err(), "{to}");
        }
    }

    #[test]
    fn label_of_resolves_pieces_of_words() {
        let labels: Vec<String> =
            ["mug", "magnifying glass", "wine glass", "red mug", "plate"].map(str::to_owned).into();
        for (answered, meant) in [
            ("mug", Some("mug")),
            ("Mug.", Some("mug")),
            ("##fying glass", Some("magnifying glass")),
            ("##gnifying", Some("magnifying glass")),
            ("wine", None),
            ("wine glass", Some("wine glass")),
            ("red mug", Some("red mug")),
            ("red", Some("red mug")),
            ("late", Some("plate")),
            ("", None),
            ("##", None),
            ("giraffe", None),
        ] {
            assert_eq!(label_of(answered, &labels).as_deref(), meant, "{answered}");
        }
        assert_eq!(normalized(" Coffee-Mug, (red) "), "coffee mug red");
    }
}
