//! Stable poses of the objects: layout, then contact resolution.

use super::objects::{Bodies, SceneObject};
use super::table::SceneTable;
use super::{Settings, error};
use crate::layout;
use crate::layout::{LayoutObject, LayoutProblem, StatedDemands, Yielding};
use geometry::solid_query::MeshSolid;
use geometry::{Outline, Pose};
use physics::{ResolveProblem, resolve};
use ports::ProviderError;
use runtime::CancelFlag;

/// The pose of every object.
pub(super) struct Arrangement {
    /// `world_from_object`, settled, in the order of the objects.
    pub poses: Vec<Pose>,
}

/// A scene before its layout.
pub(super) struct UnarrangedScene<'a> {
    pub table: &'a SceneTable,
    pub objects: &'a [SceneObject<'a>],
    pub bodies: &'a Bodies,
    pub stated: &'a StatedDemands,
}

/// Lays the objects out and settles them; demands yield up to `max_yielding`. The error names the objects without
/// space or without support.
pub(super) fn arrange(
    scene: &UnarrangedScene,
    max_yielding: Yielding,
    seed: u64,
    settings: &Settings,
    cancel: &CancelFlag,
) -> Result<Arrangement, ProviderError> {
    let UnarrangedScene { table, objects, bodies, stated } = *scene;
    let requests = layout_objects(objects);
    let problem = LayoutProblem { objects: &requests, stated, outline: &table.outline, max_yielding };
    let poses = layout::lay_out(problem, seed, &settings.layout, cancel).map_err(error::layout)?.poses;
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

/// Whether the layout succeeds on a top that is larger by a factor, without the habits of the theme.
pub(super) fn has_room(
    scene: &UnarrangedScene,
    growth: f64,
    seed: u64,
    settings: &Settings,
    cancel: &CancelFlag,
) -> Result<bool, ProviderError> {
    let requests = layout_objects(scene.objects);
    let corners = scene.table.outline.corners().iter().map(|corner| growth * *corner);
    let Ok(outline) = Outline::new(corners.collect()) else { return Ok(false) };
    let stated = scene.stated;
    let problem =
        LayoutProblem { objects: &requests, stated, outline: &outline, max_yielding: Yielding::Habits };
    match layout::lay_out(problem, seed, &settings.layout, cancel) {
        Ok(_) => Ok(true),
        Err(layout::LayoutError::NoRoom { .. }) => Ok(false),
        Err(error) => Err(error::layout(error)),
    }
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
