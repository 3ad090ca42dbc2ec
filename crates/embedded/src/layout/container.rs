//! Where contained things start: at distinct places over the cavity's floor, long ones leaning.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec2, DVec3};
use rand::RngExt;

use super::Placement;
use super::group::Grouping;

/// How far long things in a deep container lean from the upright, radians.
const LEAN_RAD: f64 = 0.22;

/// Placement in the container's frame, lean, and thing, for each of the `contained`.
pub(super) fn stow(
    grouping: &mut Grouping,
    container: usize,
    contained: &[usize],
) -> Vec<(Placement, DQuat, usize)> {
    let things = grouping.things;
    let Some(relief) = things[container].relief.as_ref().filter(|_| !contained.is_empty()) else {
        return Vec::new();
    };
    let (opening_m, depth_m) = relief.opening();
    let stands = |thing: usize| {
        let own = &things[thing];
        let long_m = own.footprint.size_m().max_element();
        own.slenderness() > 2.2 && long_m > 0.95 * opening_m && depth_m > 0.35 * opening_m
    };
    let upright: Vec<usize> = contained.iter().copied().filter(|&thing| stands(thing)).collect();
    let lying: Vec<usize> = contained.iter().copied().filter(|&thing| !stands(thing)).collect();
    let radius = |thing: usize| 0.5 * things[thing].footprint.size_m().min_element();
    let mut stowed = Vec::new();
    let radii: Vec<f64> = lying.iter().map(|&thing| radius(thing)).collect();
    for (&thing, (at, _)) in lying.iter().zip(relief.places_inside(&radii)) {
        // Of long things several lie side by side, not crosswise.
        let yaw_rad = if things[thing].slenderness() > 1.4 {
            let along_x = things[container].footprint.size_m().x >= things[container].footprint.size_m().y;
            let base = if things[thing].long_in_y() == along_x { 0.5 * PI } else { 0.0 };
            base + grouping.rng.random_range(-0.25..0.25)
        } else {
            grouping.rng.random_range(-PI..PI)
        };
        let offset = DVec2::from_angle(yaw_rad).rotate(things[thing].footprint.center());
        stowed.push((Placement { xy_m: at - offset, yaw_rad }, DQuat::IDENTITY, thing));
    }
    let middle = relief.places_inside(&[0.0]).first().map_or(DVec2::ZERO, |place| place.0);
    let phase: f64 = grouping.rng.random_range(-PI..PI);
    for (slot, &thing) in upright.iter().enumerate() {
        let share = TAU * slot as f64 / upright.len() as f64;
        let toward = DVec2::from_angle(phase + share + grouping.rng.random_range(-0.2..0.2));
        let lean = leaning(things[thing].long_in_y(), head_is_back(&things[thing].category.name), toward);
        // Its foot stands opposite to where it leans.
        let foot_m = 0.5 * opening_m - radius(thing) - 0.002;
        let foot = middle - toward * (0.55 * foot_m).max(0.0);
        let lowest = things[thing]
            .mesh
            .positions
            .iter()
            .map(|p| lean * *p)
            .fold(DVec3::INFINITY, |low, p| if p.z < low.z { p } else { low });
        let xy_m = foot - lowest.truncate();
        stowed.push((Placement { xy_m, yaw_rad: 0.0 }, lean, thing));
    }
    stowed
}

/// Whether the end that people leave up lies at the back (+y, or +x) of the thing as it lies.
fn head_is_back(category: &str) -> bool {
    !matches!(category, "spoon" | "fork" | "knife" | "ladle" | "whisk" | "spatula" | "scissors")
}

/// The rotation that stands the thing up, its head up, leaning toward a direction.
fn leaning(long_in_y: bool, head_is_back: bool, toward: DVec2) -> DQuat {
    let head = if long_in_y { DVec3::Y } else { DVec3::X } * if head_is_back { 1.0 } else { -1.0 };
    let up = DVec3::Z * LEAN_RAD.cos() + toward.extend(0.0) * LEAN_RAD.sin();
    DQuat::from_rotation_arc(head, up)
}
