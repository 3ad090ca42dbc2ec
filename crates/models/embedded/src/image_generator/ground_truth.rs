//! Ground truth of a rendered image.

use std::sync::Arc;

use super::arrangement::Arrangement;
use super::objects::SceneObject;
use super::render_scene::{FIRST_OBJECT_ID, TABLE_ID};
use super::table::SceneTable;
use super::viewpoint::Viewpoint;
use crate::requested_pose::resting_rotation;
use catalog::{Recipe, build_cached};
use geometry::TexturedMesh;
use ports::{ImageAnnotations, Truth, TruthInstance};
use render::Frame;
use scene::{
    CameraKnowledge, InstanceMask, MaskEdges, ObjectSpec, Recognition, RecognizedObject, RelationKind,
    RequestedPose, StandsOn, TippedPose,
};

/// Visible pixels of each object, in order.
pub(super) fn masks(frame: &Frame, objects: &[SceneObject]) -> Vec<InstanceMask> {
    objects
        .iter()
        .enumerate()
        .map(|(k, object)| InstanceMask {
            id: object.spec.id.clone(),
            visible: frame.mask(k as u32 + FIRST_OBJECT_ID),
        })
        .collect()
}

/// Exact recognition, masks and camera.
pub(super) fn image(
    table: &SceneTable,
    objects: &[SceneObject],
    viewpoint: &Viewpoint,
    frame: &Frame,
    masks: Vec<InstanceMask>,
) -> ImageAnnotations {
    ImageAnnotations {
        recognition: Recognition {
            camera: viewpoint.camera,
            camera_is: CameraKnowledge::Known,
            table: table.recognized.clone(),
            objects: objects.iter().map(recognized).collect(),
            left_out_px: Vec::new(),
            depth: None,
        },
        masks,
        mask_edges: MaskEdges::Sharp,
        table_mask: frame.mask(TABLE_ID),
    }
}

fn recognized(object: &SceneObject) -> RecognizedObject {
    let spec = object.spec;
    let tipped = (!spec.pose.is_upright()).then(|| TippedPose {
        pose: spec.pose,
        upright_size_m: spec.size_m,
        tipped_from_upright: upright_mesh(spec)
            .and_then(|mesh| resting_rotation(&mesh, spec.pose))
            .unwrap_or_default(),
    });
    RecognizedObject {
        id: spec.id.clone(),
        label: spec.label.clone(),
        category: spec.category.clone(),
        size_m: if tipped.is_some() { object.mesh.size_m() } else { spec.size_m },
        tipped,
        color: spec.color,
        material: spec.material.clone(),
        seed: spec.seed,
        stands_on: stands_on(spec),
        seen_px: None,
        seen_as: None,
        seen_like: None,
        mass_kg: spec.mass_kg,
        stand_in: spec.stand_in.clone(),
    }
}

fn upright_mesh(spec: &ObjectSpec) -> Option<Arc<TexturedMesh>> {
    build_cached(&Recipe {
        category: spec.category.clone(),
        size_m: spec.size_m,
        color: spec.color,
        material: spec.material.clone(),
        seed: spec.seed,
    })
}

fn stands_on(spec: &ObjectSpec) -> StandsOn {
    let support = spec.relations.iter().find(|relation| relation.kind.is_support());
    match support.and_then(|relation| relation.target.clone().map(|id| (relation.kind, id))) {
        Some((RelationKind::In, id)) => StandsOn::In(id),
        Some((_, id)) => StandsOn::On(id),
        None => StandsOn::Table,
    }
}

/// Settled poses.
pub(super) fn truth(objects: &[SceneObject], arrangement: &Arrangement) -> Truth {
    let instances = objects
        .iter()
        .zip(&arrangement.poses)
        .map(|(object, pose)| TruthInstance {
            name: object.spec.id.clone(),
            translation_m: pose.translation_m,
            rotation_xyzw: pose.rotation,
            yaw_rad: pose.yaw_rad(),
            size_m: object.mesh.size_m(),
            symmetry_order: if object.spec.pose == RequestedPose::LyingOnSide {
                1
            } else {
                object.category.symmetry_order
            },
        })
        .collect();
    Truth { instances }
}
