//! Instance masks of the recognized objects, and what else the table carries.

use super::ImageReader;
use ports::{Port, ProviderError, ReferenceImage, Segmentation};
use runtime::CancelFlag;
use scene::{InstanceMask, MaskEdges, Recognition};

/// Masks of the recognized objects, in their order. The recognition must be that of this reference with the
/// same settings.
pub fn segment(
    reference: &ReferenceImage,
    recognition: &Recognition,
    reader: &ImageReader,
    cancel: &CancelFlag,
) -> Result<Segmentation, ProviderError> {
    let reading = reader.read(reference, Port::Segmenter, cancel)?;
    if reading.objects.len() != recognition.objects.len() {
        return Err(ProviderError::Unsupported {
            port: Port::Segmenter,
            adapter: "embedded/photograph".into(),
            reason: format!(
                "{} objects were recognized and {} are found; it only follows its own recognition, use a remote \
                 segmenter with another analyst",
                recognition.objects.len(),
                reading.objects.len()
            ),
        });
    }
    let masks = reading.objects.iter().map(|object| object.mask.clone());
    let objects = recognition.objects.iter().zip(masks);
    let masks = objects.map(|(object, visible)| InstanceMask { id: object.id.clone(), visible }).collect();
    let (unread, bare_top) = (Some(reading.unread.clone()), Some(reading.bare_top.clone()));
    Ok(Segmentation { masks, edges: MaskEdges::Sharp, unread, bare_top })
}
