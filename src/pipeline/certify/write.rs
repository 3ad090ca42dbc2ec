//! The scene as one value, its images, and the files of every format.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use bytes::Bytes;
use glam::DVec3;
use rayon::prelude::*;

use super::Inputs;
use super::grasp::known_or_found;
use crate::pipeline::composition::{BodyParts, StoredComposition};
use crate::pipeline::error::StageError;
use crate::pipeline::preview;
use crate::pipeline::preview::{HiddenShares, PreviewBody, Studio};
use crate::pipeline::rehearse::ObjectGrasps;
use crate::pipeline::resolve::Loaded;
use catalog::{made_of, wikidata_item};
use certificate::Certificate;
use export::archive::zip_derived_bundle;
use export::{Assets, BodyAsset, BundleFile, Images, write_formats, zip_bundle};
use geometry::parallel_grasp::ParallelGrasp;
use gpu::{Gpu, GpuError};
use imaging::codec::encode_png;
use imaging::{Image, Mask};
use render::annotate::{fitted, side_by_side};
use scene::finished::Frame;
use scene::instance::ImageRegion;
use scene::{Instance, InstanceId, RecognizedObject, Scene, Support, Table};
use vision::image_similarity::{SceneSimilarity, compare};

/// Images of the scene, and how much they are like the reference image.
pub(super) struct Rendered {
    pub images: Images,
    /// The scene from the camera of the reference image.
    pub scene_view: Arc<Image>,
    pub top_view: Image,
    /// Image of the agreement of `scene_view` with the reference image.
    pub agreement: Image,
    pub likeness: SceneSimilarity,
    /// Of the bodies, where objects were dropped; empty for other scenes.
    pub hidden: Vec<HiddenShares>,
}

/// Images that earlier stages drew, as PNG.
pub(super) struct StoredImages {
    pub reference_png: Bytes,
    /// Of each body, where there is one.
    pub thumbnails: Vec<Option<Bytes>>,
}

/// The certificate with the archive that was written.
pub(super) struct Certified {
    pub certificate: Certificate,
    pub archive: Vec<u8>,
}

/// Renders all previews.
/// What is an error here has broken the device.
pub(super) fn render(
    inputs: &Inputs,
    loaded: &[Loaded],
    reference: &Image,
    drawn: &StoredImages,
    gpu: Option<Arc<Gpu>>,
) -> Result<Rendered, GpuError> {
    let bodies: Vec<PreviewBody> = loaded
        .iter()
        .zip(&inputs.composition.bodies)
        .map(|(geometry, body)| PreviewBody {
            mesh: &geometry.mesh,
            world_from_object: body.resolved.settled,
        })
        .collect();
    let studio = Studio::with_room(&bodies, &inputs.render, inputs.identity.request.seed)
        .lit_by(inputs.composition.light);
    let studio = match gpu {
        Some(gpu) => studio.on(gpu)?,
        None => studio,
    };
    let sides = [("front", 0.0), ("right", FRAC_PI_2), ("back", PI), ("left", -FRAC_PI_2)];
    let side = |(name, azimuth_rad): &(&str, f64)| -> Result<_, GpuError> {
        Ok(((*name).to_owned(), encode_png(&studio.side(*azimuth_rad, &inputs.preview)?)))
    };
    let thumbnail = |((geometry, body), drawn): ((&Loaded, &BodyParts), &Option<Bytes>)| {
        let image = match drawn {
            Some(drawn) => drawn.to_vec(),
            None => encode_png(&preview::thumbnail(&geometry.mesh)),
        };
        (body.resolved.name.clone(), image)
    };
    let camera = &inputs.composition.recognition.camera;
    let view = || -> Result<_, GpuError> {
        let seen = studio.reference_geometry(camera);
        let masks = (2..inputs.composition.masks.len() as u32 + 2).into_par_iter();
        let in_scene: Vec<Mask> = masks.map(|id| seen.mask(id)).collect();
        let in_image: Vec<&Mask> = inputs.composition.masks.iter().map(|mask| &mask.visible).collect();
        let scene_view = studio.reference_view(camera, &inputs.preview)?;
        let small = fitted(reference, scene_view.width_px(), scene_view.height_px());
        let (likeness, agreement) =
            compare(&small, &scene_view, &in_image, &in_scene, inputs.composition.unread.as_ref());
        let beside_png = encode_png(&side_by_side(&[&small, &scene_view, &agreement]));
        Ok((scene_view, agreement, likeness, beside_png))
    };
    let ((seen, hero), (sides_png, (top, thumbnails))) = rayon::join(
        || rayon::join(view, || studio.hero(&inputs.preview).map(|image| encode_png(&image))),
        || {
            rayon::join(
                || sides.par_iter().map(side).collect::<Result<Vec<_>, GpuError>>(),
                || {
                    rayon::join(
                        || studio.top(&inputs.preview).map(|image| (encode_png(&image), image)),
                        || {
                            let bodies =
                                loaded.par_iter().zip(&inputs.composition.bodies).zip(&drawn.thumbnails);
                            bodies.map(thumbnail).collect()
                        },
                    )
                },
            )
        },
    );
    let (scene_view, agreement, likeness, beside_png) = seen?;
    let (top_png, top_view) = top?;
    let images = Images {
        hero_png: hero?,
        top_png,
        sides_png: sides_png?,
        reference_png: drawn.reference_png.to_vec(),
        beside_png,
        thumbnails,
    };
    let hidden = if inputs.composition.clutter.is_some() { studio.hidden_shares() } else { Vec::new() };
    Ok(Rendered { images, scene_view: Arc::new(scene_view), top_view, agreement, likeness, hidden })
}

/// Writes every format, reads it back and packs it; files that an earlier archive has are copied from there.
pub(super) fn files(
    inputs: &Inputs,
    loaded: &[Loaded],
    certificate: Certificate,
    images: &Images,
    packed_before: Option<&[u8]>,
) -> Result<Certified, StageError> {
    let scene = scene(inputs, loaded, &certificate)?;
    let (table, objects) = (&inputs.composition.recognition.table, &inputs.composition.recognition.objects);
    let categories: Vec<&str> =
        [TABLE_CATEGORY].into_iter().chain(objects.iter().map(|o| o.category.as_str())).collect();
    let mut composition = inputs.composition.clone();
    let bodies = composition.bodies.par_iter_mut().zip(loaded).zip(&categories);
    bodies.for_each(|((body, geometry), category)| {
        let found = known_or_found(body.grasp.as_ref(), category, &body.resolved.physical, geometry);
        body.grasp = Some(found);
    });
    let asset = |index: usize, label: &str, category: &str, material: Option<&str>| {
        let BodyParts { resolved, grasp, .. } = &composition.bodies[index];
        let physical = &resolved.physical;
        BodyAsset {
            name: resolved.name.clone(),
            label: label.to_owned(),
            category: category.to_owned(),
            wikidata_item: wikidata_item(category).to_owned(),
            substance: made_of(category, material).to_owned(),
            grasp: robot_grasps(inputs, index).and_then(ObjectGrasps::best).or_else(|| {
                let contacts_m = grasp.as_ref()?.contacts_m?;
                Some(ParallelGrasp { contacts_m })
            }),
            visual: (*loaded[index].mesh).clone(),
            hulls: loaded[index].hulls.clone(),
            rolling_friction_m: physical.rolling_friction_m,
            torsional_friction_m: physical.torsional_friction_m,
        }
    };
    let of_object = |(index, object): (usize, &RecognizedObject)| {
        asset(index + 1, &object.label, &object.category, object.material.as_deref())
    };
    let assets = Assets {
        table: asset(0, &table.label, TABLE_CATEGORY, table.material.as_deref()),
        instances: objects.par_iter().enumerate().map(of_object).collect(),
    };
    let hulls = loaded.iter().map(|geometry| geometry.hulls.clone()).collect();
    let grasps = scene.instances.iter().enumerate().filter_map(|(index, instance)| {
        let grasps = robot_grasps(inputs, index + 1).filter(|grasps| !grasps.file.grasps.is_empty())?;
        let path = format!("grasps/{}.yaml", instance.name);
        Some(BundleFile::text(path, grasps.yaml.clone(), "grasps", "application/yaml"))
    });
    let archive = StoredComposition::file(&composition, hulls)
        .and_then(|file| {
            let more = std::iter::once(file).chain(grasps).collect();
            write_formats(&scene, &certificate, &assets, images, more, &inputs.export)
        })
        .and_then(|files| match packed_before {
            Some(parent) => zip_derived_bundle(&files, parent),
            None => zip_bundle(&files),
        })
        .map_err(|error| StageError::permanent(error.code(), format!("writing the bundle: {error}")))?;
    Ok(Certified { certificate, archive })
}

/// The grasps that a robot has of a body, the table first.
fn robot_grasps(inputs: &Inputs, body: usize) -> Option<&ObjectGrasps> {
    inputs.robot.as_ref()?.objects.get(body.checked_sub(1)?)?.as_ref()
}

/// Name of the table among categories.
const TABLE_CATEGORY: &str = "table";

/// The one value every format is written from.
fn scene(inputs: &Inputs, loaded: &[Loaded], certificate: &Certificate) -> Result<Scene, StageError> {
    let invalid = |error: scene::name::InvalidName| StageError::permanent("invalid_name", error.to_string());
    let hulls = |index: usize| u32::try_from(loaded[index].hulls.len()).unwrap_or(u32::MAX);
    let table_body = &inputs.composition.bodies[0].resolved;
    let recognized = &inputs.composition.recognition.table;
    let table = Table {
        name: table_body.name.clone(),
        label: recognized.label.clone(),
        shape: recognized.shape,
        outline_m: inputs.composition.table.outline_m.clone(),
        height_m: inputs.composition.table.size_m.z,
        model: recognized.model.clone(),
        size_m: loaded[0].mesh.size_m(),
        mass: table_body.physical.mass,
        friction: table_body.physical.friction,
        restitution: table_body.physical.restitution,
        hulls: hulls(0),
        mesh: format!("glb/{}.glb", table_body.name),
    };
    let mut instances = Vec::with_capacity(inputs.composition.recognition.objects.len());
    for (index, object) in inputs.composition.recognition.objects.iter().enumerate() {
        let body = &inputs.composition.bodies[index + 1];
        let supporter = inputs.composition.supports.supporter(index);
        instances.push(Instance {
            name: InstanceId::new(&body.resolved.name).map_err(invalid)?,
            label: object.label.clone(),
            category: object.category.clone(),
            stand_in: object.stand_in.clone(),
            image: ImageRegion {
                bbox_px: inputs.composition.masks[index].visible.bbox_px().unwrap_or_default(),
            },
            world_from_object: body.resolved.settled,
            yaw_rad: body.resolved.settled.yaw_rad(),
            symmetry_order: body.symmetry_order,
            scale: DVec3::splat(body.scale),
            size_m: loaded[index + 1].mesh.size_m(),
            mass: body.resolved.physical.mass,
            friction: body.resolved.physical.friction,
            restitution: body.resolved.physical.restitution,
            support: Support {
                parent: inputs.composition.name_of(supporter).to_owned(),
                relation: supporter.relation,
            },
            hulls: hulls(index + 1),
            mesh: format!("glb/{}.glb", body.resolved.name),
            grasps: robot_grasps(inputs, index + 1).map(|grasps| grasps.file.clone()),
            provenance: body.provenance.clone(),
        });
    }
    Ok(Scene {
        format: Scene::FORMAT.to_owned(),
        id: inputs.identity.id.clone(),
        seed: inputs.identity.request.seed,
        request: inputs.identity.request.clone(),
        frame: Frame::world(),
        camera: inputs.composition.recognition.camera,
        table,
        instances,
        metrics: certificate.metrics,
        text: inputs.composition.account.clone(),
        light: inputs.composition.light,
        edit: inputs.composition.edit.clone(),
        clutter: certificate.clutter.clone(),
    })
}
