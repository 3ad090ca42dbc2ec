//! `POST /v1/segment`, the protocol of `docs/segmentation-sidecar.yaml`: masks of the requested labels.

use std::sync::Arc;

use axum::extract::multipart::MultipartError;
use axum::extract::{Multipart, State};
use axum::http::StatusCode;
use axum::response::Response;
use bytes::Bytes;
use serde_json::{Value, json};

use super::MockVendors;
use super::error_response::{VendorError, json_response};
use super::recognized_image::RecognizedImage;
use imaging::codec::decode_png;
use imaging::mask::compressed;
use imaging::{Image, Mask};
use scene::InstanceMask;

/// Label of the table.
const TABLE: &str = "table";

/// Score of every mask.
const SCORE: f64 = 0.9;

pub(super) async fn segment(State(providers): State<Arc<MockVendors>>, form: Multipart) -> Response {
    providers.pause().await;
    match segmented(&providers, form).await {
        Ok(found) => json_response(StatusCode::OK, &found),
        Err(error) => error.detail(),
    }
}

async fn segmented(providers: &MockVendors, mut form: Multipart) -> Result<Value, VendorError> {
    let invalid = |error: MultipartError| VendorError::Invalid(error.to_string());
    let (mut file, mut request_json) = (Bytes::new(), Bytes::new());
    while let Some(field) = form.next_field().await.map_err(invalid)? {
        match field.name() {
            Some("image") => file = field.bytes().await.map_err(invalid)?,
            Some("request") => request_json = field.bytes().await.map_err(invalid)?,
            _ => return Err(VendorError::Invalid("only image and request are known".into())),
        }
    }
    let image = decode_png(&file)
        .map_err(|error| VendorError::Invalid(format!("image cannot be decoded: {error}")))?;
    let request: Value = serde_json::from_slice(&request_json).unwrap_or_default();
    let labels = request["labels"].as_array().filter(|labels| !labels.is_empty());
    let labels = labels.ok_or_else(|| VendorError::Invalid("labels are required".into()))?;
    let labels: Vec<String> = labels.iter().filter_map(|label| Some(plain(label.as_str()?))).collect();
    let (width_px, height_px) = (image.width_px(), image.height_px());
    let shown = shown(providers, image).await?;
    providers.bill.add("segment", "segment", &[file, request_json].concat());
    let annotations: Vec<Value> = shown
        .iter()
        .filter(|(label, _)| labels.contains(label))
        .map(|(label, mask)| (label, RecognizedImage::scaled(mask, width_px, height_px)))
        .filter_map(|(label, mask)| {
            Some(json!({
                "class_name": label, "score": SCORE, "bbox": mask.bbox_px()?,
                "segmentation": { "size": [height_px, width_px], "counts": compressed(&mask) },
            }))
        })
        .collect();
    Ok(json!({ "img_width": width_px, "img_height": height_px, "annotations": annotations }))
}

/// Labels and masks of an image, from generation or analysis; the table has its own label.
async fn shown(providers: &MockVendors, image: Image) -> Result<Vec<(String, Mask)>, VendorError> {
    let named = |recognized: &RecognizedImage, masks: &[InstanceMask], table: Option<&Mask>| {
        let objects = recognized.recognition.objects.iter().zip(masks);
        let objects = objects.map(|(object, mask)| (plain(&object.label), mask.visible.clone()));
        objects.chain(table.map(|mask| (TABLE.to_owned(), mask.clone()))).collect()
    };
    if let Some(top) = providers.sessions.known_top_view(&image).await {
        return Ok(named(&top.of.recognized, &top.known.objects, Some(&top.known.table)));
    }
    let known = providers.sessions.recognize(image).await?;
    Ok(named(&known.recognized, &known.recognized.masks, known.recognized.table.as_ref()))
}

/// Lower case letters and digits with single spaces.
fn plain(label: &str) -> String {
    let letters = label.to_lowercase().replace(|c: char| !c.is_alphanumeric(), " ");
    letters.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_strips_case_and_punctuation() {
        assert_eq!(plain(" Coffee-Mug, (red) "), "coffee mug red");
    }
}
