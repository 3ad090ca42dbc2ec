//! The objects of a scene: meshes, and rigid bodies for the simulation.

use std::collections::BTreeSet;
use std::sync::Arc;

use rayon::prelude::*;

use super::error;
use super::table::SceneTable;
use crate::requested_pose::posed;
use catalog::{Category, PhysicalProperties, Recipe, category, physical_properties};
use geometry::convex_hull::convex_hulls;
use geometry::decompose::{DecomposeError, DecomposeSettings, decompose};
use geometry::shells::shells;
use geometry::solid_query::MeshSolid;
use geometry::{ConvexHull, Pose, TexturedMesh};
use physics::Body;
use ports::ProviderError;
use runtime::CancelFlag;
use scene::{InstanceId, ObjectSpec};

/// An object of the description with its mesh.
pub(super) struct SceneObject<'a> {
    pub spec: &'a ObjectSpec,
    pub category: &'static Category,
    /// Canonical frame, in the requested pose.
    pub mesh: Arc<TexturedMesh>,
}

/// Bodies and solids: the table first, then the objects in order.
pub(super) struct Bodies {
    pub bodies: Vec<Body>,
    pub solids: Vec<MeshSolid>,
}

/// Builds every object's mesh.
pub(super) fn build(objects: &[ObjectSpec]) -> Result<Vec<SceneObject<'_>>, ProviderError> {
    objects
        .par_iter()
        .map(|spec| {
            let unknown = || error::unknown("category", &spec.category);
            let category = category(&spec.category).ok_or_else(unknown)?;
            let recipe = Recipe {
                category: spec.category.clone(),
                size_m: spec.size_m,
                color: spec.color,
                material: spec.material.clone(),
                seed: spec.seed,
            };
            let mesh = catalog::build_cached(&recipe).ok_or_else(unknown)?;
            let mesh = if spec.pose.is_upright() {
                mesh
            } else {
                let cannot = || error::cannot_rest(spec.id.as_str(), spec.pose);
                Arc::new(posed(&mesh, spec.pose).ok_or_else(cannot)?)
            };
            Ok(SceneObject { spec, category, mesh })
        })
        .collect()
}

/// Hulls, mass and solid of the table and of every object, in parallel. Only supporting objects get hulls with
/// cavities, because a later stage settles the poses again with full collision geometry.
pub(super) fn bodies(
    table: &SceneTable,
    objects: &[SceneObject],
    settings: &DecomposeSettings,
    cancel: &CancelFlag,
) -> Result<Bodies, ProviderError> {
    let supporters: BTreeSet<&InstanceId> =
        objects.iter().filter_map(|object| object.spec.supporter()).collect();
    let is_supporter = |spec: &ObjectSpec| supporters.contains(&spec.id);
    let table_material = table.recognized.material.as_deref();
    let mut built: Vec<(Body, MeshSolid)> = (0..=objects.len())
        .into_par_iter()
        .map(|index| match index.checked_sub(1).map(|k| &objects[k]) {
            None => {
                let hulls = shell_hulls(&table.mesh, settings);
                body("table", &table.mesh, "table", table_material, hulls)
            }
            Some(object) => {
                let spec = object.spec;
                let hulls = if is_supporter(spec) {
                    decomposed_hulls(object, settings, cancel)?
                } else {
                    shell_hulls(&object.mesh, settings)
                };
                body(spec.id.as_str(), &object.mesh, &spec.category, spec.material.as_deref(), hulls)
            }
        })
        .collect::<Result<_, ProviderError>>()?;
    if let Some((table, _)) = built.first_mut() {
        table.fixed = true;
    }
    let (bodies, solids) = built.into_iter().unzip();
    Ok(Bodies { bodies, solids })
}

/// One hull for each closed shell, or two of round ones: sufficient for objects that support nothing, and about a
/// hundred times cheaper than convex decomposition.
fn shell_hulls(mesh: &TexturedMesh, settings: &DecomposeSettings) -> Vec<ConvexHull> {
    shells(mesh)
        .iter()
        .filter(|shell| shell.volume_m3() > 0.0)
        .flat_map(|shell| {
            convex_hulls(&shell.points, settings.max_vertices as usize, settings.min_thickness_m)
        })
        .collect()
}

/// Convex decomposition that leaves cavities open.
fn decomposed_hulls(
    object: &SceneObject,
    settings: &DecomposeSettings,
    cancel: &CancelFlag,
) -> Result<Vec<ConvexHull>, ProviderError> {
    match decompose(&object.mesh, settings, cancel) {
        Ok(decomposition) => Ok(decomposition.hulls),
        Err(DecomposeError::Cancelled(cancelled)) => Err(cancelled.into()),
        Err(error) => Err(error::broken(object.spec.id.as_str(), &error)),
    }
}

fn body(
    name: &str,
    mesh: &TexturedMesh,
    category: &str,
    material: Option<&str>,
    hulls: Vec<ConvexHull>,
) -> Result<(Body, MeshSolid), ProviderError> {
    let PhysicalProperties { mass, friction, restitution, rolling_friction_m, .. } =
        physical_properties(mesh, category, material).map_err(|error| error::broken(name, &error))?;
    let body = Body {
        name: name.to_owned(),
        hulls,
        world_from_object: Pose::IDENTITY,
        mass,
        friction,
        restitution,
        rolling_friction_m,
        fixed: false,
    };
    Ok((body, MeshSolid::new(mesh).map_err(|error| error::broken(name, &error))?))
}
