//! Port 3, the segmenter: one mask per instance on the reference picture, one box per instance on the top
//! view. The paper asks GroundedSAM-v2.

use std::sync::Arc;

use super::{Adapter, Answer, Call, KnownTop, Port, ProviderError, Reference, TopPicture};
use imaging::Mask;
use scene::{InstanceMask, MaskEdges, Recognition, TopBox};

/// Finds the pixels of things.
pub trait Segmenter: Send + Sync {
    fn adapter(&self) -> Adapter;

    /// Where each recognized object shows.
    fn segment<'a>(
        &'a self,
        call: &'a Call,
        reference: Reference,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, Segmentation>;

    /// Where the table shows, whole with its legs; `None` where nobody looked for it.
    fn table<'a>(&'a self, call: &'a Call, reference: Reference) -> Answer<'a, Option<Mask>>;

    /// One box per object, and the table's, on the top view.
    fn top_boxes<'a>(
        &'a self,
        call: &'a Call,
        top: TopPicture,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, TopBoxes>;
}

/// Masks of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Segmentation {
    /// In the order of `recognition.objects`.
    pub masks: Vec<InstanceMask>,
    pub edges: MaskEdges,
}

/// Boxes on a top view, pixels, y down: x0, y0, x1, y1.
#[derive(Clone, Debug, PartialEq)]
pub struct TopBoxes {
    /// Box of the table top.
    pub table_px: [f64; 4],
    /// In the order of `recognition.objects`.
    pub objects: Vec<TopBox>,
}

impl KnownTop {
    /// The boxes of what is known; something that does not show there is an error.
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
