//! Port 3, the segmenter: one mask per instance on the reference picture, one box per instance on the top
//! view. The paper asks GroundedSAM-v2.

use std::sync::Arc;

use super::{Adapter, Answer, Call, Reference, TopPicture};
use crate::geometry::Mask;
use crate::scene::{InstanceMask, MaskEdges, Recognition, TopBox};

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
