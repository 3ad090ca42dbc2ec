//! Stage `refine_camera`: corrects the camera's angles from all silhouettes, where a model judged the camera.
//!
//! Every later stage gets the recognition with the camera of this stage. The stage does not run where the camera is
//! known.

use std::sync::Arc;

use serde::Serialize;

use super::rotate::{hiders, instances_at};
use crate::pipeline::checkpoint::{ArtifactRef, Stage};
use crate::pipeline::error::StageError;
use crate::pipeline::{Context, Settings, artifact_io, canonicalize, reconstruct, segment};
use geometry::{Camera, TexturedMesh};
use imaging::Mask;
use pose_estimation::camera::{CameraProblem, ObservedMesh, RefinedCamera, refine_camera};
use pose_estimation::yaw::{YawSettings, support_height_m};
use scene::{CameraKnowledge, Recognition, SupportTree};

/// The stage needs all instances at once; `rotate` works on one instance at a time.
pub const STAGE: Stage = Stage { name: "refine_camera", version: 1 };

#[derive(Serialize)]
pub struct Inputs {
    camera: Camera,
    table: Option<Table>,
    objects: Vec<Object>,
    dro: YawSettings,
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
        supports: &SupportTree,
        masks: &segment::Output,
        raw_meshes: &[reconstruct::Output],
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
            .enumerate()
            .map(|(index, (mask, canonical))| Object {
                mesh: canonical.mesh.clone(),
                visible: mask.visible.clone(),
                hiders: hiders(&masks.masks, &instances_at, index, supports),
                below: supports.ancestors(index).map(|below| canonical_meshes[below].mesh.clone()).collect(),
            })
            .collect();
        let table = masks.table.as_ref().zip(reconstruct::of_table(recognition, raw_meshes)).map(
            |(visible, table)| {
                let mut hiders = Mask::empty(visible.width_px(), visible.height_px());
                masks.masks.iter().for_each(|mask| hiders.unite(&mask.visible));
                Table { mesh: table.mesh.clone(), visible: visible.clone(), hiders }
            },
        );
        Some(Self { camera: recognition.camera, table, objects, dro: settings.dro.clone() })
    }
}

/// The recognition with the refined camera.
pub fn with_refined_camera(recognition: &Recognition, refined: &RefinedCamera) -> Recognition {
    Recognition { camera: refined.camera, ..recognition.clone() }
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<RefinedCamera, StageError> {
    let table = match &inputs.table {
        Some(table) => Some(artifact_io::mesh(&context, &table.mesh).await?),
        None => None,
    };
    let mut meshes: Vec<(Arc<TexturedMesh>, f64)> = Vec::with_capacity(inputs.objects.len());
    for object in &inputs.objects {
        let mut below = Vec::with_capacity(object.below.len());
        for supporter in &object.below {
            below.push(artifact_io::mesh(&context, supporter).await?);
        }
        let support_height_m = support_height_m(below.iter().map(AsRef::as_ref));
        meshes.push((artifact_io::mesh(&context, &object.mesh).await?, support_height_m));
    }
    let (given, cancel) = (inputs.clone(), context.cancel().clone());
    let refined = context
        .cpu(move || {
            let table = given.table.as_ref().zip(table.as_deref()).map(|(table, mesh)| ObservedMesh {
                mesh,
                mask: &table.visible,
                unknown: &table.hiders,
                support_height_m: mesh.bounds().0.z,
            });
            let objects = given.objects.iter().zip(&meshes);
            let objects = objects.map(|(object, (mesh, support_height_m))| ObservedMesh {
                mesh,
                mask: &object.visible,
                unknown: &object.hiders,
                support_height_m: *support_height_m,
            });
            let problem = CameraProblem { camera: &given.camera, table, objects: objects.collect() };
            refine_camera(&problem, &given.dro, &cancel)
        })
        .await??;
    context.put_json("camera.json", &refined).await?;
    Ok(refined)
}
