//! The embedded segmenter: masks from the ground truth of the embedded image generator, or from single-view
//! segmentation for other images; boxes for rendered top views.

use std::sync::Arc;

use super::single_view_reconstruction::{self, ImageReader};
use super::with_catalog;
use imaging::Mask;
use ports::{
    Adapter, Answer, Call, Port, ProviderError, ReferenceImage, Segmentation, Segmenter, TopBoxes,
    TopViewImage,
};
use scene::Recognition;

/// Answers the segmentation port from ground truth or by segmentation.
pub struct EmbeddedSegmenter {
    pub photograph: ImageReader,
}

const NAME: &str = "embedded/segmenter";

impl Segmenter for EmbeddedSegmenter {
    fn adapter(&self) -> Adapter {
        with_catalog(Adapter::new(NAME, "3", &self.photograph.identity()))
    }

    fn segment<'a>(
        &'a self,
        call: &'a Call,
        reference: ReferenceImage,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, Segmentation> {
        let reader = self.photograph.clone();
        Box::pin(call.compute(Port::Segmenter, move |cancel| match &reference.known {
            Some(known) => {
                let (masks, edges) = (known.masks.clone(), known.mask_edges);
                Ok(Segmentation { masks, edges, unread: None, bare_top: None })
            }
            None => single_view_reconstruction::segment(&reference, &recognition, &reader, cancel),
        }))
    }

    fn table<'a>(&'a self, _call: &'a Call, reference: ReferenceImage) -> Answer<'a, Option<Mask>> {
        Box::pin(async move { Ok(reference.known.as_ref().map(|known| known.table_mask.clone())) })
    }

    fn top_boxes<'a>(
        &'a self,
        _call: &'a Call,
        top: TopViewImage,
        _recognition: Arc<Recognition>,
    ) -> Answer<'a, TopBoxes> {
        Box::pin(async move {
            let known = top.known.ok_or_else(|| unknown("it finds boxes only on top views made here"))?;
            known.boxes()
        })
    }
}

fn unknown(reason: &str) -> ProviderError {
    ProviderError::Unsupported { port: Port::Segmenter, adapter: NAME.into(), reason: reason.into() }
}
