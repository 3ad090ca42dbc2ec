//! The segmenter over a sidecar: a local server with Grounding DINO and SAM 2, or another open-vocabulary detector. Its
//! protocol is `docs/segmentation-sidecar.yaml`.
//!
//! One question names the labels of all recognized objects; [`matching`] assigns detections to objects. A pixel of
//! several masks belongs to the smallest: an object on top of another is in front of it. On a generated top view,
//! [`top`] assigns the boxes.

pub mod wire;
pub mod matching;
pub mod top;

use std::sync::Arc;

use serde_json::json;

use super::endpoint::Question;
use super::settings::SidecarSettings;
use super::{Endpoint, image};
use imaging::{Image, Mask};
use ports::ledger::MicroUsd;
use ports::{
    Adapter, Answer, Call, Port, ProviderError, ReferenceImage, Segmentation, Segmenter, TopBoxes,
    TopViewImage,
};
use scene::{InstanceMask, MaskEdges, Recognition};

/// Name of the adapter.
pub const NAME: &str = "sidecar/segmenter";

/// The label of the table.
const TABLE: &str = "table";

/// Maximum side of a sent image, pixels. Images of the stages are smaller, so masks have their size.
const SENT_PX: u32 = 4096;

/// The segmenter of a sidecar server.
pub struct SidecarSegmenter {
    pub settings: SidecarSettings,
    pub endpoint: Arc<Endpoint>,
}

impl SidecarSegmenter {
    /// The detections of these labels.
    async fn detect(
        &self,
        call: &Call,
        image: Arc<Image>,
        labels: Vec<String>,
    ) -> Result<Vec<wire::Detection>, ProviderError> {
        let size_px = [image.height_px(), image.width_px()];
        let png = call
            .compute(Port::Segmenter, move |_| {
                image::sent(&image, SENT_PX).map_err(|error| {
                    rejected("image_unreadable", format!("the image cannot be sent: {error}"))
                })
            })
            .await?;
        let (content_type, body) = wire::request(&self.settings, png, &labels).encoded();
        let question = Question {
            operation: "segment",
            path: "/v1/segment",
            headers: Vec::new(),
            content_type: content_type.into(),
            body,
            reserved: MicroUsd::of_usd(self.settings.usd_per_call),
        };
        self.endpoint.ask(call, &question, |reply| wire::read(&self.settings, reply, size_px, &labels)).await
    }
}

impl Segmenter for SidecarSegmenter {
    fn adapter(&self) -> Adapter {
        let SidecarSettings { endpoint, box_threshold, text_threshold, .. } = &self.settings;
        let settings = json!({ "base_url": endpoint.base_url, "box_threshold": box_threshold, "text_threshold": text_threshold });
        Adapter { name: NAME.to_owned(), model: self.settings.model.clone(), settings }
    }

    fn segment<'a>(
        &'a self,
        call: &'a Call,
        reference: ReferenceImage,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, Segmentation> {
        Box::pin(async move {
            let found = self.detect(call, reference.image, labels(&recognition)).await?;
            call.compute(Port::Segmenter, move |_| {
                let masks = matching::matched(&recognition.objects, &found).map_err(|id| {
                    rejected(
                        "object_not_found",
                        format!(
                            "the segmenter finds nothing that could be {id}; lower \
                             providers.segmenter_sidecar.box_threshold, or recognize the image again"
                        ),
                    )
                })?;
                let masks = recognition.objects.iter().zip(made_disjoint(masks));
                let masks = masks.map(|(object, visible)| InstanceMask { id: object.id.clone(), visible });
                let (masks, edges) = (masks.collect(), MaskEdges::Sharp);
                Ok(Segmentation { masks, edges, unread: None, bare_top: None })
            })
            .await
        })
    }

    fn table<'a>(&'a self, call: &'a Call, reference: ReferenceImage) -> Answer<'a, Option<Mask>> {
        Box::pin(async move {
            let found = self.detect(call, reference.image, vec![TABLE.to_owned()]).await?;
            let best = found.into_iter().max_by(|a, b| a.score.total_cmp(&b.score));
            Ok(best.map(|found| found.mask))
        })
    }

    fn top_boxes<'a>(
        &'a self,
        call: &'a Call,
        top: TopViewImage,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, TopBoxes> {
        Box::pin(async move {
            if let Some(known) = top.known {
                return known.boxes();
            }
            let mut labels = labels(&recognition);
            labels.push(TABLE.to_owned());
            let found = self.detect(call, Arc::new(top.image), labels).await?;
            let on_top = |what: &str| {
                let reason = format!(
                    "the segmenter finds no {what} on the view from above; lower \
                     providers.segmenter_sidecar.box_threshold, or put embedded first in providers.image_generator"
                );
                rejected("object_not_found", reason)
            };
            let tables = found.iter().filter(|found| found.label.as_deref() == Some(TABLE));
            let table = tables.max_by(|a, b| a.score.total_cmp(&b.score));
            let table_px = table.and_then(|table| table.mask.bbox_px()).ok_or_else(|| on_top(TABLE))?;
            let supports = recognition.support_tree().map_err(|error| {
                rejected("recognition_inconsistent", format!("{error}; recognize the image again"))
            })?;
            top::matched(&recognition, &supports, &found, table_px.map(f64::from))
                .map_err(|id| on_top(id.as_str()))
        })
    }
}

/// The distinct labels of the objects, sorted.
fn labels(recognition: &Recognition) -> Vec<String> {
    let mut labels: Vec<String> =
        recognition.objects.iter().map(|object| wire::normalized(&object.label)).collect();
    labels.sort();
    labels.dedup();
    labels
}

/// Makes the masks disjoint: a shared pixel belongs to the smallest mask.
fn made_disjoint(mut masks: Vec<Mask>) -> Vec<Mask> {
    let mut order: Vec<usize> = (0..masks.len()).collect();
    order.sort_by_key(|&index| (masks[index].area_px(), index));
    let Some(mut taken) = masks.first().map(|mask| Mask::empty(mask.width_px(), mask.height_px())) else {
        return masks;
    };
    for index in order {
        let free = masks[index].without(&taken);
        taken.unite(&free);
        masks[index] = free;
    }
    masks
}

fn rejected(code: &'static str, reason: String) -> ProviderError {
    ProviderError::Rejected { port: Port::Segmenter, code, reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shared_pixels_belong_to_the_smallest_mask() {
        let plate = Mask::from_fn(10, 10, |_, _| true);
        let apple = Mask::from_fn(10, 10, |x, y| x < 4 && y < 4);
        let stem = Mask::from_fn(10, 10, |x, y| x == 1 && y < 6);
        let made_disjoint = made_disjoint(vec![plate, apple, stem]);
        let areas: Vec<usize> = made_disjoint.iter().map(Mask::area_px).collect();
        assert_eq!(areas, [100 - 16 - 2, 16 - 4, 6]);
        assert!(super::made_disjoint(Vec::new()).is_empty());
    }
}
