//! Initial poses of contained objects: distinct positions over the cavity's floor; long objects lean.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec2, DVec3};
use rand::RngExt;

use super::{ObjectGeometry, Placement};
use runtime::seed::Rng;

/// Lean of long objects in a deep container from the vertical, radians.
const LEAN_RAD: f64 = 0.22;

/// Placement in the container's frame, lean and object index, for each of the `contained`.
pub(super) fn place_contained(
    objects: &[ObjectGeometry],
    container: usize,
    contained: &[usize],
    rng: &mut Rng,
) -> Vec<(Placement, DQuat, usize)> {
    let Some(height_map) = objects[container].height_map.as_ref().filter(|_| !contained.is_empty()) else {
        return Vec::new();
    };
    let (opening_m, depth_m) = height_map.opening();
    let is_upright = |object: usize| {
        let own = &objects[object];
        let long_m = own.footprint.size_m().max_element();
        own.slenderness() > 2.2 && long_m > 0.95 * opening_m && depth_m > 0.35 * opening_m
    };
    let upright: Vec<usize> = contained.iter().copied().filter(|&object| is_upright(object)).collect();
    let lying: Vec<usize> = contained.iter().copied().filter(|&object| !is_upright(object)).collect();
    let radius = |object: usize| 0.5 * objects[object].footprint.size_m().min_element();
    let mut placements = Vec::new();
    let radii: Vec<f64> = lying.iter().map(|&object| radius(object)).collect();
    for (&object, (at, _)) in lying.iter().zip(height_map.positions_inside(&radii)) {
        // Long objects lie side by side, not crosswise.
        let yaw_rad = if objects[object].slenderness() > 1.4 {
            let along_x = objects[container].footprint.size_m().x >= objects[container].footprint.size_m().y;
            let base = if objects[object].long_in_y() == along_x { 0.5 * PI } else { 0.0 };
            base + rng.random_range(-0.25..0.25)
        } else {
            rng.random_range(-PI..PI)
        };
        let offset = DVec2::from_angle(yaw_rad).rotate(objects[object].footprint.center());
        placements.push((Placement { xy_m: at - offset, yaw_rad }, DQuat::IDENTITY, object));
    }
    let center = height_map.positions_inside(&[0.0]).first().map_or(DVec2::ZERO, |place| place.0);
    let phase: f64 = rng.random_range(-PI..PI);
    for (slot, &object) in upright.iter().enumerate() {
        let share = TAU * slot as f64 / upright.len() as f64;
        let toward = DVec2::from_angle(phase + share + rng.random_range(-0.2..0.2));
        let lean = leaning(objects[object].long_in_y(), head_is_back(&objects[object].category.name), toward);
        // The foot is opposite to the direction of the lean.
        let foot_m = 0.5 * opening_m - radius(object) - 0.002;
        let foot = center - toward * (0.55 * foot_m).max(0.0);
        let foot_vertex = objects[object]
            .mesh
            .positions
            .iter()
            .map(|p| lean * *p)
            .fold(DVec3::INFINITY, |low, p| if p.z < low.z { p } else { low });
        let xy_m = foot - foot_vertex.truncate();
        placements.push((Placement { xy_m, yaw_rad: 0.0 }, lean, object));
    }
    placements
}

/// Whether the end that usually points up is at the back (+y, or +x) of the object in its canonical pose.
fn head_is_back(category: &str) -> bool {
    !matches!(category, "spoon" | "fork" | "knife" | "ladle" | "whisk" | "spatula" | "scissors")
}

/// The rotation to an upright pose, head up, with a lean toward a direction.
fn leaning(long_in_y: bool, head_is_back: bool, toward: DVec2) -> DQuat {
    let head = if long_in_y { DVec3::Y } else { DVec3::X } * if head_is_back { 1.0 } else { -1.0 };
    let up = DVec3::Z * LEAN_RAD.cos() + toward.extend(0.0) * LEAN_RAD.sin();
    DQuat::from_rotation_arc(head, up)
}
