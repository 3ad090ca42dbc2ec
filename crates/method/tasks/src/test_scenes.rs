//! Objects of boxes for tests.

use std::sync::Arc;

use geometry::convex_hull::convex_hull;
use geometry::{ConvexHull, Outline, Pose};
use glam::{DVec2, DVec3};
use scene::InstanceId;

use crate::posed_object::{ObjectShape, PosedObject};

/// A box of these extents whose bottom has its center at `bottom_m`.
pub fn hull_of_box(size_m: DVec3, bottom_m: DVec3) -> ConvexHull {
    let corner = |k: usize| {
        let side = |bit: usize| if k & bit == 0 { -0.5 } else { 0.5 };
        bottom_m + size_m * DVec3::new(side(1), side(2), side(4) + 0.5)
    };
    let corners: Vec<DVec3> = (0..8).map(corner).collect();
    convex_hull(&corners, 64, 0.0).expect("a box has a volume")
}

/// A floor and four walls.
pub fn open_box(size_m: DVec3, wall_m: f64, floor_m: f64) -> Vec<ConvexHull> {
    let half = 0.5 * size_m;
    let side = DVec3::new(wall_m, size_m.y, size_m.z);
    let end = DVec3::new(size_m.x, wall_m, size_m.z);
    let (x, y) = (DVec3::X * (half.x - 0.5 * wall_m), DVec3::Y * (half.y - 0.5 * wall_m));
    vec![
        hull_of_box(DVec3::new(size_m.x, size_m.y, floor_m), DVec3::ZERO),
        hull_of_box(side, x),
        hull_of_box(side, -x),
        hull_of_box(end, y),
        hull_of_box(end, -y),
    ]
}

pub fn id(name: &str) -> InstanceId {
    InstanceId::new(name).expect("a name")
}

fn object(name: &str, hulls: Vec<ConvexHull>, center_of_mass_m: DVec3, at_m: DVec3) -> PosedObject {
    let shape = ObjectShape::new(hulls, center_of_mass_m, 0.2, true).expect("convex hulls");
    PosedObject::new(id(name), Arc::new(shape), Pose::upright(at_m, 0.0))
}

/// A solid box with the center of its bottom at a point.
pub fn solid_box(name: &str, size_m: [f64; 3], at_m: [f64; 3]) -> PosedObject {
    let size_m = DVec3::from(size_m);
    object(name, vec![hull_of_box(size_m, DVec3::ZERO)], 0.5 * size_m * DVec3::Z, at_m.into())
}

/// A box open at the top, with walls and a floor of 4 mm.
pub fn container(name: &str, size_m: [f64; 3], at_m: [f64; 3]) -> PosedObject {
    let size_m = DVec3::from(size_m);
    object(name, open_box(size_m, 0.004, 0.004), 0.4 * size_m * DVec3::Z, at_m.into())
}

/// A table of 1.2 m by 0.8 m.
pub fn table() -> Outline {
    let corners = [(-0.6, -0.4), (0.6, -0.4), (0.6, 0.4), (-0.6, 0.4)].map(DVec2::from);
    Outline::new(corners.to_vec()).expect("a rectangle")
}
