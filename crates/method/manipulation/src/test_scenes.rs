//! Objects that tests share.

use geometry::convex_hull::convex_hull;
use geometry::mass_properties::solid_mass_properties;
use geometry::{ConvexHull, DVec3, Friction, Material, Pose, Rgb, Solid, TexturedMesh};
use physics::Body;

pub use geometry::shapes::block;

/// The mesh of solids.
pub fn mesh(solids: impl IntoIterator<Item = Solid>) -> TexturedMesh {
    let mut mesh = TexturedMesh::default();
    for solid in solids {
        mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
    }
    mesh
}

pub fn hull(solid: &Solid) -> ConvexHull {
    convex_hull(&solid.positions, 64, 0.0005).expect("a solid")
}

/// A convex body of a mass.
pub fn box_body(name: &str, solid: Solid, mass_kg: f64, world_from_object: Pose) -> Body {
    body(name, vec![solid], mass_kg, world_from_object)
}

/// A body of convex solids.
pub fn body(name: &str, solids: Vec<Solid>, mass_kg: f64, world_from_object: Pose) -> Body {
    let hulls = solids.iter().map(hull).collect();
    let mass = solid_mass_properties(&mesh(solids), 700.0).expect("a solid").with_mass(mass_kg);
    Body {
        name: name.to_owned(),
        hulls,
        world_from_object,
        mass,
        friction: Friction { static_coefficient: 0.5, dynamic_coefficient: 0.4 },
        restitution: 0.1,
        rolling_friction_m: 0.0003,
        fixed: false,
    }
}

/// 2 m square, its top at z = 0.
pub fn table() -> Body {
    let top = block(DVec3::new(2.0, 2.0, 0.03)).translated(DVec3::new(0.0, 0.0, -0.03));
    Body { fixed: true, ..box_body("table", top, 10.0, Pose::IDENTITY) }
}
