//! The reference image of an edited scene: the scene itself, from the camera of the parent's reference image.

use imaging::{Image, Mask};
use rayon::prelude::*;

use crate::pipeline::composition::Composition;
use crate::pipeline::preview::{PreviewBody, PreviewSettings, Studio};
use crate::pipeline::resolve::Loaded;
use render::RenderSettings;
use scene::InstanceMask;

/// The image, and the pixels of each object in it at the size of the camera.
pub(super) fn rendered(
    composition: &Composition,
    loaded: &[Loaded],
    render: &RenderSettings,
    preview: &PreviewSettings,
) -> Result<(Image, Vec<InstanceMask>), gpu::GpuError> {
    let bodies: Vec<PreviewBody> = loaded
        .iter()
        .zip(&composition.bodies)
        .map(|(geometry, body)| PreviewBody {
            mesh: &geometry.mesh,
            world_from_object: body.resolved.settled,
        })
        .collect();
    let studio = Studio::new(&bodies, render).lit_by(composition.light);
    let camera = &composition.recognition.camera;
    // Without a device this is the CPU's work, which does not fail.
    let image = studio.reference_view(camera, preview)?;
    let seen = studio.reference_geometry(camera);
    let objects = &composition.recognition.objects;
    let masks: Vec<Mask> = (2..objects.len() as u32 + 2).into_par_iter().map(|id| seen.mask(id)).collect();
    let named =
        objects.iter().zip(masks).map(|(object, visible)| InstanceMask { id: object.id.clone(), visible });
    Ok((image, named.collect()))
}
