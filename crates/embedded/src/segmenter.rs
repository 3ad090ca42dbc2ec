//! The embedded segmenter: masks of pictures our own painter painted, which knows them, and of photographs by
//! looking; boxes on top views made here.

use std::sync::Arc;

use super::photograph::{self, PictureReader};
use imaging::Mask;
use ports::{
    Adapter, Answer, Call, Port, ProviderError, Reference, Segmentation, Segmenter, TopBoxes, TopPicture,
};
use scene::{MaskEdges, Recognition};

/// Answers from what the painter knows, or by looking.
pub struct EmbeddedSegmenter {
    pub photograph: PictureReader,
}

const NAME: &str = "embedded/segmenter";

impl Segmenter for EmbeddedSegmenter {
    fn adapter(&self) -> Adapter {
        Adapter::new(NAME, "2", &self.photograph.identity())
    }

    fn segment<'a>(
        &'a self,
        call: &'a Call,
        reference: Reference,
        recognition: Arc<Recognition>,
    ) -> Answer<'a, Segmentation> {
        let reader = self.photograph.clone();
        Box::pin(call.compute(Port::Segmenter, move |interrupt| {
            match &reference.known {
                Some(known) => Ok(Segmentation { masks: known.masks.clone(), edges: known.mask_edges }),
                None => photograph::segment(&reference.picture, &recognition, &reader, interrupt)
                    .map(|masks| Segmentation { masks, edges: MaskEdges::Sharp }),
            }
        }))
    }

    fn table<'a>(&'a self, _call: &'a Call, reference: Reference) -> Answer<'a, Option<Mask>> {
        Box::pin(async move { Ok(reference.known.as_ref().map(|known| known.table_mask.clone())) })
    }

    fn top_boxes<'a>(
        &'a self,
        _call: &'a Call,
        top: TopPicture,
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
