//! The segmenter over a sidecar: a small server beside this one that loads Grounding DINO and SAM 2, or whatever else
//! finds things by their names. Its protocol is `docs/segmentation-sidecar.yaml`.
//!
//! One question names everything that was recognized; [`matching`] says which answer is which thing. Where a pixel is
//! claimed by several, the smallest has it: what stands on something is before it. On a drawn view from above the same
//! labels are looked for, and [`top`] says which is which.

pub mod wire;
pub mod matching;
pub mod top;

use std::sync::Arc;

use serde_json::json;

use super::endpoint::Question;
use super::settings::SidecarSettings;
use super::{Endpoint, picture};
use imaging::{Image, Mask};
use ports::ledger::MicroUsd;
use ports::{
    Adapter, Answer, Call, Port, ProviderError, Reference, Segmentation, Segmenter, TopBoxes, TopPicture,
};
use scene::{InstanceMask, MaskEdges, Recognition};

/// Name of the adapter.
pub const NAME: &str = "sidecar/segmenter";

/// What the table is looked for by.
const TABLE: &str = "table";

/// Largest side of a picture that is sent, pixels: those of the stages are smaller, and masks must fit them.
const SENT_PX: u32 = 4096;

/// Asks a sidecar.
pub struct SidecarSegmenter {
    pub settings: SidecarSettings,
    pub endpoint: Arc<Endpoint>,
}

impl SidecarSegmenter {
    /// What is found of these labels.
    async fn found(
        &self,
        call: &Call,
        image: Arc<Image>,
        labels: Vec<String>,
    ) -> Result<Vec<wire::Found>, ProviderError> {
        let size_px = [image.height_px(), image.width_px()];
        let png = call
            .compute(Port::Segmenter, move |_| {
                picture::sent(&image, SENT_PX).map_err(|error| {
                    rejected("image_unreadable", format!("the picture cannot be sent: {error}"))
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
        reference: Reference,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, Segmentation> {
        Box::pin(async move {
            let found = self.found(call, reference.picture, labels(&recognition)).await?;
            call.compute(Port::Segmenter, move |_| {
                let masks = matching::matched(&recognition.objects, &found).map_err(|id| {
                    rejected(
                        "object_not_found",
                        format!(
                            "the segmenter finds nothing that could be {id}; lower \
                             providers.segmenter_sidecar.box_threshold, or recognize the picture again"
                        ),
                    )
                })?;
                let masks = recognition.objects.iter().zip(parted(masks));
                let masks = masks.map(|(object, visible)| InstanceMask { id: object.id.clone(), visible });
                Ok(Segmentation { masks: masks.collect(), edges: MaskEdges::Sharp })
            })
            .await
        })
    }

    fn table<'a>(&'a self, call: &'a Call, reference: Reference) -> Answer<'a, Option<Mask>> {
        Box::pin(async move {
            let found = self.found(call, reference.picture, vec![TABLE.to_owned()]).await?;
            let best = found.into_iter().max_by(|a, b| a.score.total_cmp(&b.score));
            Ok(best.map(|found| found.mask))
        })
    }

    fn top_boxes<'a>(
        &'a self,
        call: &'a Call,
        top: TopPicture,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, TopBoxes> {
        Box::pin(async move {
            if let Some(known) = top.known {
                return known.boxes();
            }
            let mut labels = labels(&recognition);
            labels.push(TABLE.to_owned());
            let found = self.found(call, Arc::new(top.picture), labels).await?;
            let on_top = |what: &str| {
                let reason = format!(
                    "the segmenter finds no {what} on the view from above; lower \
                     providers.segmenter_sidecar.box_threshold, or put embedded first in providers.painter"
                );
                rejected("object_not_found", reason)
            };
            let tables = found.iter().filter(|found| found.label.as_deref() == Some(TABLE));
            let table = tables.max_by(|a, b| a.score.total_cmp(&b.score));
            let table_px = table.and_then(|table| table.mask.bbox_px()).ok_or_else(|| on_top(TABLE))?;
            top::matched(&recognition, &found, table_px.map(f64::from)).map_err(|id| on_top(id.as_str()))
        })
    }
}

/// What the things are called, each word once.
fn labels(recognition: &Recognition) -> Vec<String> {
    let mut labels: Vec<String> =
        recognition.objects.iter().map(|object| wire::normalized(&object.label)).collect();
    labels.sort();
    labels.dedup();
    labels
}

/// No pixel belongs to two: the smallest of those that claim it has it.
fn parted(mut masks: Vec<Mask>) -> Vec<Mask> {
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
    fn a_pixel_belongs_to_the_smallest_that_claims_it() {
        let plate = Mask::from_fn(10, 10, |_, _| true);
        let apple = Mask::from_fn(10, 10, |x, y| x < 4 && y < 4);
        let stem = Mask::from_fn(10, 10, |x, y| x == 1 && y < 6);
        let parted = parted(vec![plate, apple, stem]);
        let areas: Vec<usize> = parted.iter().map(Mask::area_px).collect();
        assert_eq!(areas, [100 - 16 - 2, 16 - 4, 6]);
        assert!(super::parted(Vec::new()).is_empty());
    }
}
