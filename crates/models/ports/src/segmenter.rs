//! Port 3, the segmenter: one mask per instance in the reference image, and one box per instance in the top view. The
//! paper uses GroundedSAM-v2.

use std::sync::Arc;

use super::{Adapter, Answer, Call, Port, ProviderError, ReferenceImage, TopViewAnnotations, TopViewImage};
use imaging::Mask;
use scene::{InstanceMask, MaskEdges, Recognition, TopBox};

/// Segments objects.
pub trait Segmenter: Send + Sync {
    fn adapter(&self) -> Adapter;

    /// The visible pixels of each recognized object.
    fn segment<'a>(
        &'a self,
        call: &'a Call,
        reference: ReferenceImage,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, Segmentation>;

    /// The visible pixels of the table with its legs; `None` where the adapter does not segment tables.
    fn table<'a>(&'a self, call: &'a Call, reference: ReferenceImage) -> Answer<'a, Option<Mask>>;

    /// The boxes of the objects and of the table in the top view.
    fn top_boxes<'a>(
        &'a self,
        call: &'a Call,
        top: TopViewImage,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, TopBoxes>;
}

/// The masks of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Segmentation {
    /// In the order of `recognition.objects`.
    pub masks: Vec<InstanceMask>,
    pub edges: MaskEdges,
    /// Pixels of what stands on the table and is none of the recognized objects; `None` where the adapter does
    /// not search for it.
    pub unread: Option<Mask>,
    /// Pixels of the bare table top; `None` where the adapter does not search for it.
    pub bare_top: Option<Mask>,
}

/// Boxes on a top view, pixels, y down: x0, y0, x1, y1.
#[derive(Clone, Debug, PartialEq)]
pub struct TopBoxes {
    /// Box of the table top.
    pub table_px: [f64; 4],
    /// In the order of `recognition.objects`.
    pub objects: Vec<TopBox>,
}

impl TopViewAnnotations {
    /// The bounding boxes of the masks.
    ///
    /// # Errors
    ///
    /// `not_on_top_view` for an empty mask.
    pub fn boxes(&self) -> Result<TopBoxes, ProviderError> {
        let bounds_px = |mask: &Mask| mask.bbox_px().map(|corners| corners.map(f64::from));
        let hidden = |name: &str| ProviderError::Rejected {
            port: Port::Segmenter,
            code: "not_on_top_view",
            reason: format!("{name} does not show on the top view"),
        };
        let table_px = bounds_px(&self.table).ok_or_else(|| hidden("the table"))?;
        let objects = self.objects.iter().map(|mask| {
            let box_px = bounds_px(&mask.visible).ok_or_else(|| hidden(mask.id.as_str()))?;
            Ok(TopBox { id: mask.id.clone(), box_px })
        });
        Ok(TopBoxes { table_px, objects: objects.collect::<Result<_, ProviderError>>()? })
    }
}
