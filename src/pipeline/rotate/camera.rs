//! Before the yaws, where a model judged the camera: its angles, from all silhouettes together.
//!
//! Every later stage gets the recognition with the camera found here; where nothing is refined nothing runs.

use std::sync::Arc;

use serde::Serialize;

use super::{below, hiders, instances_at};
use crate::pipeline::checkpoint::{ArtifactRef, Stage};
use crate::pipeline::error::StageError;
use crate::pipeline::{Context, Settings, canonicalize, carry, reconstruct, segment};
use geometry::{Camera, TexturedMesh};
use imaging::Mask;
use pose_estimation::camera::{CameraProblem, Outlined, RefinedCamera, refine_camera};
use pose_estimation::dro::{DroSettings, seat_height_m};
use scene::{CameraKnowledge, Recognition};

/// A part of `rotate` with a key of its own: it needs all instances, the yaws one each.
pub const STAGE: Stage = Stage { name: "rotate", version: 1 };

#[derive(Serialize)]
pub struct Inputs {
    camera: Camera,
    table: Option<Table>,
    objects: Vec<Object>,
    dro: DroSettings,
}

#[derive(Serialize)]
struct Table {
    mesh: ArtifactRef,
    visible: Mask,
    /// Pixels of all instances.
    hiders: Mask,
}

#[derive(Serialize)]
struct Object {
    mesh: ArtifactRef,
    visible: Mask,
    hiders: Mask,
    /// Meshes of everything below it, nearest first.
    below: Vec<ArtifactRef>,
}

impl Inputs {
    /// `None` where the camera stays as it was recognized.
    pub fn new(
        recognition: &Recognition,
        masks: &segment::Output,
        raw: &[reconstruct::Output],
        canonical_meshes: &[canonicalize::Output],
        settings: &Settings,
    ) -> Option<Self> {
        if recognition.camera_is != CameraKnowledge::Judged || !settings.dro.refine_camera {
            return None;
        }
        let instances_at = instances_at(&masks.masks);
        let objects = masks
            .masks
            .iter()
            .zip(canonical_meshes)
            .map(|(mask, canonical)| {
                let below = below(recognition, &mask.id);
                Object {
                    mesh: canonical.mesh.clone(),
                    visible: mask.visible.clone(),
                    hiders: hiders(&masks.masks, &instances_at, &mask.id, &below),
                    below: below.iter().map(|(index, _)| canonical_meshes[*index].mesh.clone()).collect(),
                }
            })
            .collect();
        let table = masks.table.as_ref().zip(raw.last()).map(|(visible, table)| {
            let mut hiders = Mask::empty(visible.width_px(), visible.height_px());
            masks.masks.iter().for_each(|mask| hiders.unite(&mask.visible));
            Table { mesh: table.mesh.clone(), visible: visible.clone(), hiders }
        });
        Some(Self { camera: recognition.camera, table, objects, dro: settings.dro.clone() })
    }
}

/// The recognition with this camera.
pub fn seen_by(recognition: &Recognition, refined: &RefinedCamera) -> Recognition {
    Recognition { camera: refined.camera, ..recognition.clone() }
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<RefinedCamera, StageError> {
    let table = match &inputs.table {
        Some(table) => Some(carry::mesh(&context, &table.mesh).await?),
        None => None,
    };
    let mut meshes: Vec<(Arc<TexturedMesh>, f64)> = Vec::with_capacity(inputs.objects.len());
    for object in &inputs.objects {
        let mut below = Vec::with_capacity(object.below.len());
        for supporter in &object.below {
            below.push(carry::mesh(&context, supporter).await?);
        }
        let seat_height_m = seat_height_m(below.iter().map(AsRef::as_ref));
        meshes.push((carry::mesh(&context, &object.mesh).await?, seat_height_m));
    }
    let (given, interrupt) = (inputs.clone(), context.interrupt().clone());
    let refined = context
        .cpu(move || {
            let table = given.table.as_ref().zip(table.as_deref()).map(|(table, mesh)| Outlined {
                mesh,
                mask: &table.visible,
                unknown: &table.hiders,
                seat_height_m: mesh.bounds().0.z,
            });
            let objects = given.objects.iter().zip(&meshes);
            let objects = objects.map(|(object, (mesh, seat_height_m))| Outlined {
                mesh,
                mask: &object.visible,
                unknown: &object.hiders,
                seat_height_m: *seat_height_m,
            });
            let problem = CameraProblem { camera: &given.camera, table, objects: objects.collect() };
            refine_camera(&problem, &given.dro, &interrupt)
        })
        .await??;
    context.put_json("camera.json", &refined).await?;
    Ok(refined)
}
