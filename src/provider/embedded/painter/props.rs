//! The things on the table: their meshes, and their bodies for the simulation.

use rayon::prelude::*;

use super::error;
use super::table::PaintedTable;
use crate::catalog::{self, Category, PhysicalProperties, Recipe, category, physical_properties};
use crate::geometry::decompose::{DecomposeError, DecomposeSettings, decompose};
use crate::geometry::mesh_solid::MeshSolid;
use crate::geometry::{Interrupt, Pose, TexturedMesh};
use crate::physics::Body;
use crate::provider::ProviderError;
use crate::scene::ObjectSpec;

/// One object of the description with its mesh.
pub(super) struct Prop<'a> {
    pub spec: &'a ObjectSpec,
    pub category: &'static Category,
    /// Canonical frame.
    pub mesh: TexturedMesh,
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
            Ok(Prop { spec, category, mesh: catalog::build(&recipe).ok_or_else(unknown)? })
        })
        .collect()
}

/// Hulls, mass and solid of the table and of every prop, in parallel.
pub(super) fn bodies(
    table: &PaintedTable,
    props: &[Prop],
    settings: &DecomposeSettings,
    interrupt: &Interrupt,
) -> Result<Bodies, ProviderError> {
    let table_material = table.recognized.material.as_deref();
    let mut made: Vec<(Body, MeshSolid)> = (0..=props.len())
        .into_par_iter()
        .map(|index| match index.checked_sub(1).map(|k| &props[k]) {
            None => body("table", &table.mesh, "table", table_material, settings, interrupt),
            Some(prop) => {
                let spec = prop.spec;
                let material = spec.material.as_deref();
                body(spec.id.as_str(), &prop.mesh, &spec.category, material, settings, interrupt)
            }
        })
        .collect::<Result<_, ProviderError>>()?;
    if let Some((table, _)) = made.first_mut() {
        table.fixed = true;
    }
    let (bodies, solids) = made.into_iter().unzip();
    Ok(Bodies { bodies, solids })
}

fn body(
    name: &str,
    mesh: &TexturedMesh,
    category: &str,
    material: Option<&str>,
    settings: &DecomposeSettings,
    interrupt: &Interrupt,
) -> Result<(Body, MeshSolid), ProviderError> {
    let hulls = match decompose(mesh, settings, interrupt) {
        Ok(decomposition) => decomposition.hulls,
        Err(DecomposeError::Interrupted(interrupted)) => return Err(interrupted.into()),
        Err(error) => return Err(error::broken(name, &error)),
    };
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
