//! What the painter knows of its own picture.

use super::arrangement::Arrangement;
use super::props::Prop;
use super::stage::{FIRST_PROP, TABLE};
use super::table::PaintedTable;
use super::view::Viewpoint;
use ports::{KnownPicture, Truth, TruthInstance};
use render::Frame;
use scene::{
    CameraKnowledge, InstanceMask, MaskEdges, ObjectSpec, Recognition, RecognizedObject, RelationKind,
    StandsOn,
};

/// Visible pixels of each prop, in order.
pub(super) fn masks(frame: &Frame, props: &[Prop]) -> Vec<InstanceMask> {
    props
        .iter()
        .enumerate()
        .map(|(k, prop)| InstanceMask {
            id: prop.spec.id.clone(),
            visible: frame.mask(k as u32 + FIRST_PROP),
        })
        .collect()
}

/// Recognition, masks and camera as they are.
pub(super) fn picture(
    table: &PaintedTable,
    props: &[Prop],
    viewpoint: &Viewpoint,
    frame: &Frame,
    masks: Vec<InstanceMask>,
) -> KnownPicture {
    KnownPicture {
        recognition: Recognition {
            camera: viewpoint.camera,
            camera_is: CameraKnowledge::Known,
            table: table.recognized.clone(),
            objects: props.iter().map(|prop| recognized(prop.spec)).collect(),
        },
        masks,
        mask_edges: MaskEdges::Sharp,
        table_mask: frame.mask(TABLE),
    }
}

fn recognized(spec: &ObjectSpec) -> RecognizedObject {
    RecognizedObject {
        id: spec.id.clone(),
        label: spec.label.clone(),
        category: spec.category.clone(),
        size_m: spec.size_m,
        color: spec.color,
        material: spec.material.clone(),
        seed: spec.seed,
        stands_on: stands_on(spec),
        seen_px: None,
        seen_as: None,
        seen_like: None,
    }
}

fn stands_on(spec: &ObjectSpec) -> StandsOn {
    let support = spec.relations.iter().find(|relation| relation.kind.is_support());
    match support.and_then(|relation| relation.target.clone().map(|id| (relation.kind, id))) {
        Some((RelationKind::In, id)) => StandsOn::In(id),
        Some((_, id)) => StandsOn::On(id),
        None => StandsOn::Table,
    }
}

/// The settled poses.
pub(super) fn truth(props: &[Prop], arrangement: &Arrangement) -> Truth {
    let instances = props
        .iter()
        .zip(&arrangement.poses)
        .map(|(prop, pose)| TruthInstance {
            name: prop.spec.id.clone(),
            translation_m: pose.translation_m,
            rotation_xyzw: pose.rotation,
            yaw_rad: pose.yaw_rad(),
            size_m: prop.mesh.size_m(),
            symmetry_order: prop.category.symmetry_order,
        })
        .collect();
    Truth { instances }
}
