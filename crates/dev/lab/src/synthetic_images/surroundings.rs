//! Objects around a table that do not belong to it, and flat coverings of its top.
//!
//! Photographs show other tables, chairs, cabinets and boxes beside the table, and arms of robots or people above it.
//! All of these have the label of the backdrop. Mats and cloths that lie flat have the label of the top.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rand::RngExt;

use super::Split;
use super::arrangement::{ArrangementStyle, arrange};
use super::finish::{Finish, Top};
use super::object::{Object, Palette};
use super::sampling::{any_color, chance, pale, pick, uniform, weighted, wood_color};
use super::table::{self, Table, mapped};
use geometry::shapes::{block, cylinder, rectangle, rounded_block, slab, tube};
use geometry::{Material, Outline, Pose, Rgb, TexturedMesh};
use runtime::seed::Rng;

/// A mesh in its world pose.
pub(super) struct Surrounding {
    pub mesh: Arc<TexturedMesh>,
    pub world_from_object: Pose,
    pub role: Role,
}

/// Label of what surrounds the objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Not of this table.
    Backdrop,
    /// Flat on the top, as a part of it.
    Covering,
}

/// Furniture beside a table.
#[derive(Clone, Copy)]
enum Furniture {
    /// A cabinet with drawers, or a carton.
    Cabinet,
    /// Another table with objects on it.
    Table,
    Chair,
    /// An enlarged object on the floor.
    Object,
}

/// Probabilities that an image has furniture beside the table, an arm above it, a covering on it.
const FURNISHED: f64 = 0.6;
const REACHED_INTO: f64 = 0.12;
const COVERED: f64 = 0.15;
/// Thickness of a covering, meters: below the tolerance of what counts as the top.
const COVERING_M: f64 = 4e-4;

/// Samples the surroundings of a table that a camera sees from this azimuth.
pub(super) fn draw(split: Split, table: &Table, azimuth_rad: f64, rng: &mut Rng) -> Vec<Surrounding> {
    let mut all = Vec::new();
    if chance(rng, FURNISHED) {
        for _ in 0..rng.random_range(1..=4) {
            all.extend(furniture(split, table, azimuth_rad, rng));
        }
    }
    if chance(rng, REACHED_INTO) {
        all.push(arm(table, azimuth_rad, rng));
    }
    if chance(rng, COVERED) {
        all.extend(covering(split, table, rng));
    }
    all
}

/// A piece of furniture with the objects on it, beside or behind the table.
fn furniture(split: Split, table: &Table, azimuth_rad: f64, rng: &mut Rng) -> Vec<Surrounding> {
    let floor_m = -table.height_m;
    let kind = weighted(
        rng,
        &[
            (Furniture::Cabinet, 3.0),
            (Furniture::Table, 3.0),
            (Furniture::Chair, 3.0),
            (Furniture::Object, 1.0),
        ],
    );
    // Seen from above, 0 is away from the camera.
    let (reach, turn) = match kind {
        Furniture::Chair => (PI, uniform(rng, -0.3, 0.3)),
        _ => (1.9, if chance(rng, 0.7) { 0.0 } else { uniform(rng, -PI, PI) }),
    };
    let bearing_rad = azimuth_rad + 0.5 * PI + uniform(rng, -reach, reach);
    let outward = DVec2::from_angle(bearing_rad);
    let mut parts = match kind {
        Furniture::Cabinet => vec![(cabinet(rng), Pose::IDENTITY)],
        Furniture::Chair => vec![(chair(rng), Pose::IDENTITY)],
        Furniture::Table => loaded_table(split, rng),
        Furniture::Object => {
            let categories = split.categories();
            let scale = uniform(rng, 1.5, 4.0);
            let object = Object::draw(split, Palette::Usual, scale, &categories, rng);
            vec![(object.mesh, Pose::IDENTITY)]
        }
    };
    let facing_rad = bearing_rad + 0.5 * PI + turn;
    let own_reach_m = {
        let (low, high) = parts[0].0.bounds();
        0.5 * (high - low).truncate().max_element()
    };
    let gap_m = match kind {
        // Chairs stand with their seats under the table.
        Furniture::Chair => uniform(rng, -0.25, 0.25),
        _ if chance(rng, 0.3) => 0.02,
        _ => uniform(rng, 0.02, 1.2),
    };
    let edge_m = table.outline.corners().iter().map(|p| p.dot(outward)).fold(0.0, f64::max);
    let at = ((edge_m + own_reach_m + gap_m) * outward).extend(floor_m);
    let place = Pose::upright(at, facing_rad);
    for (_, pose) in &mut parts {
        *pose = place * *pose;
    }
    let backdrop = |(mesh, world_from_object)| Surrounding { mesh, world_from_object, role: Role::Backdrop };
    parts.into_iter().map(backdrop).collect()
}

/// A color of furniture.
fn coating(name: &str, rng: &mut Rng) -> Material {
    let color = pick(rng, &[wood_color, pale, any_color])(rng);
    Material::plain(name, color, uniform(rng, 0.3, 0.8) as f32)
}

/// A block with fronts and handles, on the floor.
fn cabinet(rng: &mut Rng) -> Arc<TexturedMesh> {
    let size = DVec3::new(uniform(rng, 0.25, 1.4), uniform(rng, 0.25, 0.6), uniform(rng, 0.3, 1.9));
    let mut mesh = TexturedMesh::default();
    let body = coating("body", rng);
    mesh.add(block(size), &body);
    if chance(rng, 0.7) {
        let (front, handle) =
            (if chance(rng, 0.5) { body } else { coating("front", rng) }, coating("handle", rng));
        let (columns, rows) = (rng.random_range(1..4), rng.random_range(1..6));
        let cell = DVec2::new(size.x / f64::from(columns), size.z / f64::from(rows));
        for (column, row) in (0..columns).flat_map(|c| (0..rows).map(move |r| (c, r))) {
            let (x, z) = ((f64::from(column) + 0.5) * cell.x - 0.5 * size.x, f64::from(row) * cell.y);
            let board = block(DVec3::new(0.94 * cell.x, 0.02, 0.9 * cell.y));
            mesh.add(board.translated(DVec3::new(x, -0.5 * size.y, z + 0.05 * cell.y)), &front);
            let grip = block(DVec3::new(0.3 * cell.x.min(0.3), 0.03, 0.015));
            mesh.add(grip.translated(DVec3::new(x, -0.5 * size.y - 0.02, z + 0.7 * cell.y)), &handle);
        }
    }
    Arc::new(mesh)
}

/// A chair whose front is -y.
fn chair(rng: &mut Rng) -> Arc<TexturedMesh> {
    let (wide, seat_m, back_m) = (uniform(rng, 0.38, 0.52), uniform(rng, 0.4, 0.5), uniform(rng, 0.35, 0.6));
    let (frame, cushion) = (coating("frame", rng), coating("seat", rng));
    let mut mesh = TexturedMesh::default();
    let seat = rounded_block(DVec3::new(wide, wide, 0.05), 0.04, 0.01);
    mesh.add(seat.translated(DVec3::new(0.0, 0.0, seat_m)), &cushion);
    let back = rounded_block(DVec3::new(wide, 0.04, back_m * uniform(rng, 0.5, 0.9)), 0.015, 0.01);
    mesh.add(back.translated(DVec3::new(0.0, 0.47 * wide, seat_m + 0.2)), &cushion);
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let height = if y > 0.0 { seat_m + 0.3 } else { seat_m };
        let foot = DVec3::new(0.45 * wide * x, 0.45 * wide * y, 0.0);
        mesh.add(cylinder(0.018, height, 0.002, 10).translated(foot), &frame);
    }
    Arc::new(mesh)
}

/// Another table of the split, its feet at z = 0, with objects.
fn loaded_table(split: Split, rng: &mut Rng) -> Vec<(Arc<TexturedMesh>, Pose)> {
    let table = table::draw(split, rng);
    let lifted = Pose::upright(DVec3::new(0.0, 0.0, table.height_m), 0.0);
    let categories = split.categories();
    let count = rng.random_range(0..7);
    let scale = uniform(rng, 0.8, 1.5);
    let objects = (0..count).map(|_| Object::draw(split, Palette::Usual, scale, &categories, rng)).collect();
    let placed = arrange(objects, &table.outline, ArrangementStyle::draw(rng), rng);
    let loads = placed.into_iter().map(|one| (one.object.mesh, lifted * one.world_from_object));
    std::iter::once((Arc::new(table.mesh), lifted)).chain(loads).collect()
}

/// An arm of a robot or a person that reaches from outside over the top.
fn arm(table: &Table, azimuth_rad: f64, rng: &mut Rng) -> Surrounding {
    let (low, high) = table.outline.bounds();
    let target = DVec2::new(uniform(rng, low.x, high.x), uniform(rng, low.y, high.y)) * 0.8;
    let from = DVec2::from_angle(azimuth_rad + uniform(rng, -PI, PI));
    let edge_m = table.outline.corners().iter().map(|p| p.dot(from)).fold(0.0, f64::max);
    let shoulder = ((edge_m + uniform(rng, -0.15, 0.4)) * from).extend(uniform(rng, 0.0, 0.3));
    let wrist = target.extend(uniform(rng, 0.12, 0.35));
    let elbow = shoulder.lerp(wrist, uniform(rng, 0.35, 0.65)) + DVec3::Z * uniform(rng, 0.1, 0.5);
    let skin = chance(rng, 0.3);
    let hull = if skin {
        let tone = uniform(rng, 0.3, 0.95) as f32;
        Material::plain("arm", Rgb([tone, 0.76 * tone, 0.6 * tone]), 0.6)
    } else {
        Material::plain("arm", pick(rng, &[pale, any_color, dark])(rng), uniform(rng, 0.2, 0.6) as f32)
    };
    let joint = if skin {
        hull.clone()
    } else {
        Material::plain("joint", pick(rng, &[pale, any_color, dark])(rng), 0.4)
    };
    let radius_m = uniform(rng, 0.025, 0.065);
    let mut mesh = TexturedMesh::default();
    for (from, to, share) in [(shoulder, elbow, 1.0), (elbow, wrist, 0.85)] {
        mesh.add(tube(&[from, to], share * radius_m, 16), &hull);
    }
    for (center, share) in [(shoulder, 1.3), (elbow, 1.2), (wrist, 1.05)] {
        let ball = geometry::shapes::sphere(share * radius_m, 16);
        mesh.add(ball.translated(center - DVec3::Z * (share * radius_m)), &joint);
    }
    if !skin {
        let foot = shoulder.truncate().extend(-table.height_m);
        mesh.add(tube(&[foot, shoulder], 1.1 * radius_m, 16), &hull);
    }
    // Two fingers, or five.
    let tip_m = wrist.z - uniform(rng, 0.08, 0.16).min(wrist.z - 0.01);
    let count = if skin { 5 } else { 2 };
    let (spread_m, turn) = (uniform(rng, 0.02, 0.05), uniform(rng, 0.0, PI));
    for k in 0..count {
        let off = spread_m * DVec2::from_angle(turn + 2.0 * PI * f64::from(k) / f64::from(count));
        let knuckle = wrist + (1.2 * off).extend(-0.6 * radius_m);
        let path = [wrist, knuckle, (wrist.truncate() + off).extend(tip_m)];
        mesh.add(tube(&path, if skin { 0.009 } else { 0.011 }, 10), &joint);
    }
    Surrounding { mesh: Arc::new(mesh), world_from_object: Pose::IDENTITY, role: Role::Backdrop }
}

fn dark(rng: &mut Rng) -> Rgb {
    Rgb([uniform(rng, 0.03, 0.25) as f32; 3])
}

/// A mat, a cloth or a printed sheet within the outline of the top; none where it finds no place.
fn covering(split: Split, table: &Table, rng: &mut Rng) -> Option<Surrounding> {
    let (low, high) = table.outline.bounds();
    let room = high - low;
    let top = Top::new(Finish::draw(split, rng), rng);
    for shrunk in [0.9, 0.6, 0.4] {
        let size = DVec2::new(uniform(rng, 0.5, 1.0), uniform(rng, 0.4, 1.0)) * shrunk * room;
        let center = low + room * DVec2::new(uniform(rng, 0.3, 0.7), uniform(rng, 0.3, 0.7));
        let turn_rad = if chance(rng, 0.7) { 0.0 } else { uniform(rng, -0.5, 0.5) };
        let place = Pose::upright(center.extend(0.0), turn_rad);
        let corners = rectangle(size.x, size.y);
        let inside =
            |p: &DVec2| table.outline.depth_inside_m(place.transform_point(p.extend(0.0)).truncate()) > 0.0;
        let Ok(outline) = Outline::new(corners.clone()) else { continue };
        if corners.iter().all(inside) {
            let mut mesh = TexturedMesh::default();
            mesh.add(mapped(slab(&corners, COVERING_M, 0.0), top.mapping, &outline, rng), &top.material);
            return Some(Surrounding {
                mesh: Arc::new(mesh),
                world_from_object: place,
                role: Role::Covering,
            });
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::seed::child_rng;

    #[test]
    fn furniture_stands_on_floor_outside_table_and_coverings_are_flat() {
        let mut seen = [0; 2];
        for seed in 0..60 {
            let mut rng = child_rng(seed, "surroundings");
            let table = table::draw(Split::Training, &mut rng);
            for piece in draw(Split::Training, &table, 0.3, &mut rng) {
                let (low, high) = piece.mesh.bounds();
                assert!(low.is_finite() && high.is_finite(), "{seed}");
                match piece.role {
                    Role::Backdrop => {
                        let feet_m = piece.world_from_object.translation_m.z + low.z;
                        assert!(feet_m > -table.height_m - 0.03, "{seed}: {feet_m}");
                        seen[0] += 1;
                    }
                    Role::Covering => {
                        assert!(high.z <= COVERING_M + 1e-9 && low.z >= 0.0, "{seed}");
                        seen[1] += 1;
                    }
                }
            }
        }
        assert!(seen[0] > 20 && seen[1] > 2, "{seen:?}");
    }
}
