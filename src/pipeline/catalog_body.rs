//! An object of the catalog by itself, as simulations have it.

use catalog::{Recipe, build, physical_properties};
use geometry::decompose::{DecomposeSettings, decompose};
use geometry::{Pose, TexturedMesh};
use physics::Body;
use runtime::CancelFlag;

/// The body and the mesh of a recipe, upright at the origin: the lowest point is at z = 0.
///
/// # Errors
///
/// In words, for a category that the catalog does not have, and a mesh without volume or hulls.
pub fn catalog_body(
    name: &str,
    recipe: &Recipe,
    settings: &DecomposeSettings,
) -> Result<(Body, TexturedMesh), String> {
    let mesh = build(recipe).ok_or("its recipe has no mesh")?;
    let physical = physical_properties(&mesh, &recipe.category, None).map_err(|error| error.to_string())?;
    let hulls = decompose(&mesh, settings, &CancelFlag::default()).map_err(|error| error.to_string())?.hulls;
    let body = Body {
        name: name.to_owned(),
        hulls,
        world_from_object: Pose::IDENTITY,
        mass: physical.mass,
        friction: physical.friction,
        restitution: physical.restitution,
        rolling_friction_m: physical.rolling_friction_m,
        fixed: false,
    };
    Ok((body, mesh))
}
