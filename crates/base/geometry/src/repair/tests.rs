//! Broken surfaces and what they become.

use super::*;
use crate::shapes::{block, shell_of_revolution, sphere};
use glam::{DVec2, DVec3};

fn shell(solid: crate::Solid) -> Shell {
    let mut mesh = crate::TexturedMesh::default();
    mesh.add(solid, &crate::Material::plain("plain", crate::Rgb::hex(0x80_80_80), 0.5));
    crate::shells::shells(&mesh).remove(0)
}

fn volume_m3(shells: &[Shell]) -> f64 {
    shells.iter().map(Shell::volume_m3).sum()
}

#[test]
fn repaired_leaves_sound_shells_unchanged() {
    let profile = [DVec2::new(0.04, 0.0), DVec2::new(0.04, 0.1)];
    let sound = vec![shell(shell_of_revolution(&profile, 0.004, 0.006, 48)), shell(block(DVec3::splat(0.1)))];
    let (after, repair) = repaired(sound.clone(), 0.001);
    assert!(repair.is_none(), "{repair:?}");
    assert_eq!(after, sound);
}

#[test]
fn repaired_fills_holes_and_welds_torn_vertices() {
    let mut ball = shell(sphere(0.05, 32));
    let whole = ball.volume_m3();
    ball.triangles.swap_remove(200);
    let (after, repair) = repaired(vec![ball.clone()], 0.001);
    assert_eq!((after.len(), repair.holes_filled, repair.shells_remeshed), (1, 1, 0));
    assert!(after[0].is_closed() && (volume_m3(&after) / whole - 1.0).abs() < 1e-9);

    // Every triangle with corners of its own, shaken by less than a hair, some turned over.
    let ball = shell(sphere(0.05, 32));
    let mut torn = Shell::default();
    for (k, corners) in ball.corners().enumerate() {
        let first = torn.points.len() as u32;
        let shake = DVec3::new(1.0, -1.0, 0.5) * 1e-8 * (k % 7) as f64;
        torn.points.extend(corners.map(|p| p + shake));
        torn.triangles.push(if k % 5 == 0 {
            [first, first + 2, first + 1]
        } else {
            [first, first + 1, first + 2]
        });
    }
    let (after, repair) = repaired(vec![torn], 0.001);
    assert!(after.len() == 1 && after[0].is_closed());
    assert!(repair.corners_welded > 1000 && repair.triangles_turned > 100 && repair.shells_remeshed == 0);
    assert!((volume_m3(&after) / whole - 1.0).abs() < 1e-3);
}

#[test]
fn repaired_thickens_a_sheet_and_keeps_its_opening() {
    // A box without its lid, drawn as one sheet.
    let mut tub = shell(block(DVec3::new(0.2, 0.1, 0.05)));
    let top = tub.points.iter().map(|p| p.z).fold(0.0, f64::max);
    let is_lid = |t: &[u32; 3]| t.iter().all(|&v| tub.points[v as usize].z == top);
    tub.triangles = tub.triangles.iter().copied().filter(|t| !is_lid(t)).collect();
    let (after, repair) = repaired(vec![tub], 0.002);
    assert_eq!((repair.sheets_thickened, repair.holes_filled), (1, 0));
    assert!(after.len() == 1 && after[0].is_closed());
    let walls = 0.2 * 0.1 + 2.0 * 0.05 * (0.2 + 0.1);
    assert!((volume_m3(&after) / (walls * 0.002) - 1.0).abs() < 0.3, "{}", volume_m3(&after));
}

#[test]
fn repaired_flips_inverted_shells() {
    let mut cube = shell(block(DVec3::splat(0.1)));
    cube.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let (after, repair) = repaired(vec![cube.clone()], 0.001);
    assert_eq!(repair.triangles_turned, 12);
    assert!((volume_m3(&after) - 0.001).abs() < 1e-12);
    // In another shell it bounds a cavity.
    let around = shell(block(DVec3::splat(0.3)).translated(DVec3::new(0.0, 0.0, -0.1)));
    let (after, repair) = repaired(vec![around, cube], 0.001);
    assert!(repair.is_none() && (volume_m3(&after) - 0.026).abs() < 1e-9);
}

#[test]
fn repaired_rebuilds_self_intersecting_shells() {
    // Two balls joined into one surface where they overlap, which counts the overlap twice.
    let (one, other) =
        (shell(sphere(0.05, 48)), shell(sphere(0.05, 48).translated(DVec3::new(0.06, 0.0, 0.0))));
    let both = bridged(&one, &other);
    assert!(both.is_closed() && crosses_itself(&both));
    let (after, repair) = repaired(vec![both], 0.001);
    assert_eq!(repair.shells_remeshed, 1);
    assert!(after.iter().all(Shell::is_closed), "still open");
    let ball = 4.0 / 3.0 * std::f64::consts::PI * 0.05_f64.powi(3);
    // A lens of two caps of height r - d / 2.
    let h = 0.05 - 0.03;
    let lens = 2.0 * std::f64::consts::PI * h * h * (3.0 * 0.05 - h) / 3.0;
    assert!((volume_m3(&after) / (2.0 * ball - lens) - 1.0).abs() < 0.02, "{}", volume_m3(&after));
}

/// One closed surface of two: a triangle of each is taken out and the holes are joined.
fn bridged(one: &Shell, other: &Shell) -> Shell {
    let first = one.points.len() as u32;
    let mut both = one.clone();
    both.points.extend(&other.points);
    let [a, b, c] = both.triangles.remove(0);
    let mut rest: Vec<[u32; 3]> = other.triangles.iter().map(|t| t.map(|v| first + v)).collect();
    let [x, y, z] = rest.remove(0);
    both.triangles.extend(rest);
    for (p, q, r, s) in [(a, b, x, z), (b, c, z, y), (c, a, y, x)] {
        both.triangles.extend([[p, q, s], [p, s, r]]);
    }
    both
}
