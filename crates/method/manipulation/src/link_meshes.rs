//! Visible parts of a robot as meshes: one for each link, in its frame.

use geometry::shapes::{block, cylinder, sphere};
use geometry::{DVec3, Material, Pose, Rgb, Solid, TexturedMesh};
use robot::model::{Primitive, Robot};

use crate::frames::{to_pose, to_vector};

/// Sides of round shapes.
const SEGMENTS: usize = 32;
const ROUGHNESS: f32 = 0.45;
/// Side of the column that a base stands on, meters.
pub(crate) const STAND_M: f64 = 0.16;

/// Meshes of the visible shapes of each link, in the order of `Robot::links`; a link without any has an empty mesh.
pub fn link_meshes(robot: &Robot) -> Vec<TexturedMesh> {
    robot
        .links()
        .iter()
        .map(|link| {
            let mut mesh = TexturedMesh::default();
            for shape in link.shapes.iter().filter(|shape| shape.is_visible()) {
                let stated = &robot.materials()[shape.material];
                let [red, green, blue] = stated.srgb.map(|channel| (255.0 * channel).round() as u32);
                let color = Rgb::hex(red << 16 | green << 8 | blue);
                let material = Material::plain(&stated.name, color, ROUGHNESS);
                let link_from_shape = to_pose(&shape.link_from_shape);
                for solid in solids(&shape.primitive) {
                    mesh.add(posed(solid, &link_from_shape), &material);
                }
            }
            mesh
        })
        .collect()
}

/// Height of the floor, where the legs of the table end.
pub fn floor_m(table: &TexturedMesh) -> f64 {
    table.positions.iter().map(|point| point.z).fold(0.0, f64::min)
}

/// Stand of a base: a column from the floor up, or from the top of the table. It is not simulated.
pub fn stand_mesh(table: &TexturedMesh, world_from_base: &Pose) -> TexturedMesh {
    let mut mesh = TexturedMesh::default();
    let (low, high) = table.bounds();
    let at = world_from_base.translation_m.truncate();
    let is_on_table = at.cmpge(low.truncate()).all() && at.cmple(high.truncate()).all();
    let below_m = if is_on_table { high.z } else { floor_m(table) };
    let height_m = world_from_base.translation_m.z - below_m;
    if height_m > 0.0 {
        let mut column = block(DVec3::new(STAND_M, STAND_M, height_m));
        let placed = Pose { translation_m: at.extend(below_m), rotation: world_from_base.rotation };
        column.positions.iter_mut().for_each(|point| *point = placed.transform_point(*point));
        mesh.add(column, &Material::plain("stand", Rgb::hex(0x8a_8f_96), 0.6));
    }
    mesh
}

/// Closed solids that together are the primitive, about its center.
fn solids(primitive: &Primitive) -> Vec<Solid> {
    let tube = |radius_m: f64, half_length_m: f64| {
        let bottom = DVec3::new(0.0, 0.0, -half_length_m);
        cylinder(radius_m, 2.0 * half_length_m, 0.0, SEGMENTS).translated(bottom)
    };
    match *primitive {
        Primitive::Box { half_size_m } => {
            let half_m = to_vector(&half_size_m);
            vec![block(2.0 * half_m).translated(DVec3::new(0.0, 0.0, -half_m.z))]
        }
        Primitive::Cylinder { radius_m, half_length_m } => vec![tube(radius_m, half_length_m)],
        Primitive::Sphere { radius_m } => vec![ball(radius_m, 0.0)],
        Primitive::Capsule { radius_m, half_length_m } => {
            vec![ball(radius_m, -half_length_m), tube(radius_m, half_length_m), ball(radius_m, half_length_m)]
        }
    }
}

/// A ball with its center at that height.
fn ball(radius_m: f64, center_z_m: f64) -> Solid {
    sphere(radius_m, SEGMENTS).translated(DVec3::new(0.0, 0.0, center_z_m - radius_m))
}

fn posed(mut solid: Solid, pose: &Pose) -> Solid {
    for position in &mut solid.positions {
        *position = pose.transform_point(*position);
    }
    solid
}

#[cfg(test)]
mod tests {
    use geometry::DQuat;

    use super::*;

    #[test]
    fn a_base_stands_on_the_table_or_beside_it_on_the_floor() {
        let mut table = TexturedMesh::default();
        let top = block(DVec3::new(1.2, 0.8, 0.7)).translated(DVec3::new(0.0, 0.0, -0.7));
        table.add(top, &Material::plain("wood", Rgb::hex(0x80_60_40), 0.5));
        for (x_m, z_m, expected) in
            [(0.2, 0.12, Some((0.0, 0.12))), (-0.9, 0.02, Some((-0.7, 0.02))), (0.2, 0.0, None)]
        {
            let base = Pose { translation_m: DVec3::new(x_m, 0.1, z_m), rotation: DQuat::IDENTITY };
            let stand = stand_mesh(&table, &base);
            let found = (!stand.positions.is_empty()).then(|| stand.bounds());
            let micrometers = |(low, high): (f64, f64)| [low, high].map(|z_m| (1e6 * z_m).round());
            let found = found.map(|(low, high)| micrometers((low.z, high.z)));
            assert_eq!(found, expected.map(micrometers), "base at {x_m} m, {z_m} m high");
        }
    }

    #[test]
    fn meshes_are_the_shapes_that_are_seen() {
        for name in ["panda", "piper"] {
            let robot = Robot::built_in(name, None).expect("built in");
            let meshes = link_meshes(&robot);
            assert_eq!(meshes.len(), robot.links().len());
            for (link, mesh) in robot.links().iter().zip(&meshes) {
                let visible: Vec<_> = link.shapes.iter().filter(|shape| shape.is_visible()).collect();
                assert_eq!(mesh.positions.is_empty(), visible.is_empty(), "{}", link.name);
                for point in &mesh.positions {
                    let outside = visible.iter().map(|shape| {
                        let local = to_pose(&shape.link_from_shape).inverse().transform_point(*point);
                        shape.primitive.signed_distance_m(&nalgebra::Point3::new(local.x, local.y, local.z))
                    });
                    let outside_m = outside.fold(f64::INFINITY, f64::min);
                    assert!(
                        outside_m < 1e-6,
                        "{} of {name}: {outside_m} m outside of every shape",
                        link.name
                    );
                }
                // The ends of every shape are there.
                for shape in visible {
                    let reach_m = |direction: DVec3| {
                        mesh.positions.iter().map(|p| p.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
                    };
                    let pose = to_pose(&shape.link_from_shape);
                    let half_m = match shape.primitive {
                        Primitive::Box { half_size_m } => half_size_m.z,
                        Primitive::Cylinder { half_length_m, .. } => half_length_m,
                        Primitive::Capsule { radius_m, half_length_m } => half_length_m + radius_m,
                        Primitive::Sphere { radius_m } => radius_m,
                    };
                    for side in [-1.0, 1.0] {
                        let end = pose.transform_point(DVec3::new(0.0, 0.0, side * half_m));
                        let along = pose.transform_vector(DVec3::new(0.0, 0.0, side));
                        assert!(reach_m(along) >= end.dot(along) - 1e-9, "{} of {name}", link.name);
                    }
                }
            }
        }
    }
}
