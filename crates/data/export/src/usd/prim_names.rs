//! Names of the prims below a prop's root that more than one layer of the prop refers to.

/// Scope of the materials, named as is customary in USD assets.
pub const MATERIALS: &str = "Looks";

/// The material that holds friction. Its capital letter cannot occur in a visual material's name.
pub const PHYSICS_MATERIAL: &str = "Physics_material";

/// Parent of the visual meshes.
pub const VISUAL: &str = "visual";

/// Parent of the colliders.
pub const COLLIDERS: &str = "colliders";

/// Name of the collider of one hull.
pub fn hull_name(index: usize) -> String {
    format!("hull_{index:02}")
}
