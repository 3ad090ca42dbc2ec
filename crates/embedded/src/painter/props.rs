//! The things on the table: their meshes, and their bodies for the simulation.

use std::collections::BTreeSet;
use std::sync::Arc;

use rayon::prelude::*;

use super::error;
use super::table::PaintedTable;
use catalog;
use catalog::{Category, PhysicalProperties, Recipe, category, physical_properties};
use geometry::convex_hull::convex_hull;
use geometry::decompose::{DecomposeError, DecomposeSettings, decompose};
use geometry::mesh_solid::MeshSolid;
use geometry::shells::shells;
use geometry::{ConvexHull, Pose, TexturedMesh};
use physics::Body;
use ports::ProviderError;
use runtime::Interrupt;
use scene::{InstanceId, ObjectSpec};

/// One object of the description with its mesh.
pub(super) struct Prop<'a> {
    pub spec: &'a ObjectSpec,
    pub category: &'static Category,
    /// Canonical frame.
    pub mesh: Arc<TexturedMesh>,
}

/// Bodies and solids: the table first, then the props in their order.
pub(super) struct Bodies {
    pub bodies: Vec<Body>,
    pub solids: Vec<MeshSolid>,
}

/// Builds every object's mesh.
pub(super) fn build(objects: &[ObjectSpec]) -> Result<Vec<Prop<'_>>, ProviderError> {
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
            Ok(Prop { spec, category, mesh: catalog::stocked(&recipe).ok_or_else(unknown)? })
        })
        .collect()
}

/// Hulls, mass and solid of the table and of every prop, in parallel. Only what carries something gets
/// hulls with cavities: the poses are settled again by whoever builds the scene.
pub(super) fn bodies(
    table: &PaintedTable,
    props: &[Prop],
    settings: &DecomposeSettings,
    interrupt: &Interrupt,
) -> Result<Bodies, ProviderError> {
    let carried: BTreeSet<&InstanceId> = props.iter().filter_map(|prop| prop.spec.supporter()).collect();
    let carries = |spec: &ObjectSpec| carried.contains(&spec.id);
    let table_material = table.recognized.material.as_deref();
    let mut made: Vec<(Body, MeshSolid)> = (0..=props.len())
        .into_par_iter()
        .map(|index| match index.checked_sub(1).map(|k| &props[k]) {
            None => {
                let hulls = shell_hulls(&table.mesh, settings);
                body("table", &table.mesh, "table", table_material, hulls)
            }
            Some(prop) => {
                let spec = prop.spec;
                let hulls = if carries(spec) {
                    cut_hulls(prop, settings, interrupt)?
                } else {
                    shell_hulls(&prop.mesh, settings)
                };
                body(spec.id.as_str(), &prop.mesh, &spec.category, spec.material.as_deref(), hulls)
            }
        })
        .collect::<Result<_, ProviderError>>()?;
    if let Some((table, _)) = made.first_mut() {
        table.fixed = true;
    }
    let (bodies, solids) = made.into_iter().unzip();
    Ok(Bodies { bodies, solids })
}

/// One hull per closed shell: enough for what carries nothing, and some hundred times cheaper than cutting
/// cavities open.
fn shell_hulls(mesh: &TexturedMesh, settings: &DecomposeSettings) -> Vec<ConvexHull> {
    shells(mesh)
        .iter()
        .filter(|shell| shell.volume_m3() > 0.0)
        .filter_map(|shell| {
            convex_hull(&shell.points, settings.max_vertices as usize, settings.min_thickness_m)
        })
        .collect()
}

/// Hulls that leave cavities and hollows open.
fn cut_hulls(
    prop: &Prop,
    settings: &DecomposeSettings,
    interrupt: &Interrupt,
) -> Result<Vec<ConvexHull>, ProviderError> {
    match decompose(&prop.mesh, settings, interrupt) {
        Ok(decomposition) => Ok(decomposition.hulls),
        Err(DecomposeError::Interrupted(interrupted)) => Err(interrupted.into()),
        Err(error) => Err(error::broken(prop.spec.id.as_str(), &error)),
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
