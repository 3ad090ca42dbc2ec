//! `POST /v1/segment`, the protocol of `docs/segmentation-sidecar.yaml`: where the labels that were asked for show.

use std::sync::Arc;

use axum::extract::multipart::MultipartError;
use axum::extract::{Multipart, State};
use axum::http::StatusCode;
use axum::response::Response;
use bytes::Bytes;
use serde_json::{Value, json};

use super::DevProviders;
use super::refusal::{Refusal, answer};
use super::sight::Sight;
use imaging::codec::decode_png;
use imaging::mask::compressed;
use imaging::{Image, Mask};
use scene::InstanceMask;

/// What a table is asked for by.
const TABLE: &str = "table";

/// How sure this server is of everything.
const SCORE: f64 = 0.9;

pub(super) async fn segment(State(providers): State<Arc<DevProviders>>, form: Multipart) -> Response {
    providers.pause().await;
    match segmented(&providers, form).await {
        Ok(found) => answer(StatusCode::OK, &found),
        Err(refusal) => refusal.detail(),
    }
}

async fn segmented(providers: &DevProviders, mut form: Multipart) -> Result<Value, Refusal> {
    let wrong = |error: MultipartError| Refusal::Wrong(error.to_string());
    let (mut file, mut asked) = (Bytes::new(), Bytes::new());
    while let Some(field) = form.next_field().await.map_err(wrong)? {
        match field.name() {
            Some("image") => file = field.bytes().await.map_err(wrong)?,
            Some("request") => asked = field.bytes().await.map_err(wrong)?,
            _ => return Err(Refusal::Wrong("only image and request are known".into())),
        }
    }
    let picture =
        decode_png(&file).map_err(|error| Refusal::Wrong(format!("image cannot be decoded: {error}")))?;
    let request: Value = serde_json::from_slice(&asked).unwrap_or_default();
    let labels = request["labels"].as_array().filter(|labels| !labels.is_empty());
    let labels = labels.ok_or_else(|| Refusal::Wrong("labels are required".into()))?;
    let labels: Vec<String> = labels.iter().filter_map(|label| Some(plain(label.as_str()?))).collect();
    let (width_px, height_px) = (picture.width_px(), picture.height_px());
    let shown = shown(providers, picture).await?;
    providers.bill.add("segment", "segment", &[file, asked].concat());
    let annotations: Vec<Value> = shown
        .iter()
        .filter(|(label, _)| labels.contains(label))
        .map(|(label, mask)| (label, Sight::scaled(mask, width_px, height_px)))
        .filter_map(|(label, mask)| {
            Some(json!({
                "class_name": label, "score": SCORE, "bbox": mask.bbox_px()?,
                "segmentation": { "size": [height_px, width_px], "counts": compressed(&mask) },
            }))
        })
        .collect();
    Ok(json!({ "img_width": width_px, "img_height": height_px, "annotations": annotations }))
}

/// Labels and masks of what a picture shows, from wherever it was seen; the table under its own.
async fn shown(providers: &DevProviders, picture: Image) -> Result<Vec<(String, Mask)>, Refusal> {
    let named = |sight: &Sight, masks: &[InstanceMask], table: Option<&Mask>| {
        let objects = sight.recognition.objects.iter().zip(masks);
        let objects = objects.map(|(object, mask)| (plain(&object.label), mask.visible.clone()));
        objects.chain(table.map(|mask| (TABLE.to_owned(), mask.clone()))).collect()
    };
    if let Some(top) = providers.studio.seen_from_above(&picture).await {
        return Ok(named(&top.of.sight, &top.known.objects, Some(&top.known.table)));
    }
    let known = providers.studio.sight(picture).await?;
    Ok(named(&known.sight, &known.sight.masks, known.sight.table.as_ref()))
}

/// Lower case, letters and digits, single spaces.
fn plain(label: &str) -> String {
    let letters = label.to_lowercase().replace(|c: char| !c.is_alphanumeric(), " ");
    letters.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_plain_words() {
        assert_eq!(plain(" Coffee-Mug, (red) "), "coffee mug red");
    }
}
