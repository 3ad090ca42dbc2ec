//! An object of the catalog by itself, as simulations have it.

use catalog::{Recipe, build, physical_properties};
use geometry::decompose::{DecomposeError, DecomposeSettings, decompose};
use geometry::mass_properties::MassError;
use geometry::{ConvexHull, Pose, TexturedMesh};
use physics::Body;
use runtime::CancelFlag;

/// Reason why a recipe has no body.
#[derive(Clone, Debug, thiserror::Error)]
pub enum CatalogBodyError {
    #[error("its recipe has no mesh")]
    NoMesh,
    #[error(transparent)]
    Mass(#[from] MassError),
    #[error(transparent)]
    Decompose(#[from] DecomposeError),
}

/// The body and the mesh of a recipe, upright at the origin: the lowest point is at z = 0.
///
/// # Errors
///
/// [`CatalogBodyError`] for a category that the catalog does not have, and a mesh without volume or hulls.
pub fn catalog_body(
    name: &str,
    recipe: &Recipe,
    settings: &DecomposeSettings,
) -> Result<(Body, TexturedMesh), CatalogBodyError> {
    let mesh = build(recipe).ok_or(CatalogBodyError::NoMesh)?;
    let body = body_of(name, &mesh, &recipe.category, settings)?;
    Ok((body, mesh))
}

/// The body of a mesh of the category, in the frame of the mesh.
///
/// # Errors
///
/// [`CatalogBodyError`] for a mesh without volume or hulls.
pub fn body_of(
    name: &str,
    mesh: &TexturedMesh,
    category: &str,
    settings: &DecomposeSettings,
) -> Result<Body, CatalogBodyError> {
    let hulls = decompose(mesh, settings, &CancelFlag::default())?.hulls;
    Ok(body_with(name, mesh, category, hulls)?)
}

/// As [`body_of`], with hulls that are known.
///
/// # Errors
///
/// [`MassError`] for a mesh without volume.
pub fn body_with(
    name: &str,
    mesh: &TexturedMesh,
    category: &str,
    hulls: Vec<ConvexHull>,
) -> Result<Body, MassError> {
    let physical = physical_properties(mesh, category, None)?;
    Ok(Body {
        name: name.to_owned(),
        hulls,
        world_from_object: Pose::IDENTITY,
        mass: physical.mass,
        friction: physical.friction,
        restitution: physical.restitution,
        rolling_friction_m: physical.rolling_friction_m,
        fixed: false,
    })
}
