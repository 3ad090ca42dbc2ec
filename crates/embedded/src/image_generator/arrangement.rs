//! Stable poses of the objects: layout, then contact resolution.

use super::objects::{Bodies, SceneObject};
use super::table::SceneTable;
use super::{Settings, error};
use crate::layout;
use crate::layout::LayoutObject;
use geometry::Pose;
use geometry::solid_query::MeshSolid;
use physics::{ResolveProblem, resolve};
use ports::ProviderError;
use runtime::CancelFlag;

/// The pose of every object.
pub(super) struct Arrangement {
    /// `world_from_object`, settled, in the order of the objects.
    pub poses: Vec<Pose>,
}

/// Lays the objects out and settles them; the error names the objects without space or without support.
pub(super) fn arrange(
    table: &SceneTable,
    objects: &[SceneObject],
    bodies: &Bodies,
    seed: u64,
    settings: &Settings,
    cancel: &CancelFlag,
) -> Result<Arrangement, ProviderError> {
    let requests = layout_objects(objects);
    let poses =
        layout::arrange(&requests, &table.outline, seed, &settings.layout, cancel).map_err(error::layout)?;
    let mut movable = bodies.bodies.clone();
    for (body, pose) in movable.iter_mut().skip(1).zip(&poses) {
        body.world_from_object = *pose;
    }
    let supports = layout::support_tree(&requests);
    let solids: Vec<&MeshSolid> = bodies.solids.iter().collect();
    let problem =
        ResolveProblem { bodies: &movable, solids: &solids, supports: &supports, outline: &table.outline };
    let resolved = resolve(problem, &settings.resolve, &settings.settle, &settings.certify, cancel)
        .map_err(error::resolve)?;
    for line in &resolved.log {
        tracing::debug!(line, "resolving the layout");
    }
    Ok(Arrangement { poses: resolved.poses.into_iter().skip(1).collect() })
}

/// The objects as requests to the layout sampler.
fn layout_objects<'a>(objects: &'a [SceneObject]) -> Vec<LayoutObject<'a>> {
    objects
        .iter()
        .map(|object| LayoutObject {
            name: object.spec.id.to_string(),
            category: object.category,
            mesh: &object.mesh,
            relations: object
                .spec
                .relations
                .iter()
                .filter_map(|relation| match &relation.target {
                    None => Some((relation.kind, None)),
                    Some(id) => objects
                        .iter()
                        .position(|other| other.spec.id == *id)
                        .map(|k| (relation.kind, Some(k))),
                })
                .collect(),
        })
        .collect()
}
