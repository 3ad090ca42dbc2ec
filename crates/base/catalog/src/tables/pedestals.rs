//! Tables with non-rectangular tops: round, oval, triangular, hexagonal, kidney-shaped.
//!
//! Each function adds its parts to the draft and returns the outer edge of the top, centered on its
//! axis-aligned box.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3};

use super::Draft;
use super::shapes::{bar, board, column, leg, round_leg};
use geometry::shapes::{cylinder, ellipse, prism, regular_polygon, smooth};

/// Overlap between parts.
const JOINT_M: f64 = 0.001;

/// A turned column on four arched feet.
pub fn round_table(draft: &mut Draft) -> Vec<DVec2> {
    let size = draft.size_m;
    let edge = ellipse(size.x, size.y, 64);
    draft.add_top(&edge);
    let top = draft.underside_m() + JOINT_M;
    // The turned part is shortened below low tops: a profile that turned back would leave the column.
    let (foot, shaft) = (0.09, 0.43);
    let shortening = ((top - 0.145 - foot) / shaft).min(1.0);
    let turned = |z: f64| foot + shortening * (z - foot);
    let profile = [
        (0.06, 0.075),
        (0.065, foot),
        (0.065, turned(0.2)),
        (0.045, turned(0.22)),
        (0.04, turned(0.26)),
        (0.052, turned(0.36)),
        (0.056, turned(0.42)),
        (0.045, turned(foot + shaft)),
        (0.035, top - 0.13),
        (0.05, top - 0.11),
        (0.05, top - 0.085),
        (0.036, top - 0.075),
        (0.05, top - 0.03),
        (0.13, top - 0.012),
        (0.13, top),
    ];
    draft.add_frame(column(&profile), DVec3::Z);
    let reach = 0.34 * size.x.min(size.y);
    // Feet below small tops keep their shape.
    let scale = (reach / 0.27).min(1.0);
    for k in 0..4 {
        let foot: [DVec2; 9] = [
            DVec2::new(0.03, 0.08),
            DVec2::new(scale * 0.1, 0.07),
            DVec2::new(reach - scale * 0.11, 0.012),
            DVec2::new(reach - scale * 0.08, 0.0),
            DVec2::new(reach, 0.0),
            DVec2::new(reach, 0.025),
            DVec2::new(reach - scale * 0.06, 0.045),
            DVec2::new(scale * 0.14, 0.13),
            DVec2::new(0.03, 0.18),
        ];
        // The outline stands upright: prism along z, then its y becomes the world's z.
        let solid = prism(&foot, 0.05)
            .translated(DVec3::new(0.0, 0.0, -0.025))
            .rotated(DQuat::from_rotation_x(TAU / 4.0))
            .rotated(DQuat::from_rotation_z(TAU / 8.0 + TAU * f64::from(k) / 4.0));
        draft.add_frame(solid, DVec3::X);
    }
    edge
}

/// Two flat trestles joined by a beam.
pub fn oval_table(draft: &mut Draft) -> Vec<DVec2> {
    let size = draft.size_m;
    let edge = ellipse(size.x, size.y, 64);
    draft.add_top(&edge);
    let top = draft.underside_m() + JOINT_M;
    let x = 0.24 * size.x;
    let half_depth = 0.33 * size.y;
    for side in [-1.0, 1.0] {
        let cx = side * x;
        draft.add_frame(
            board(DVec3::new(cx - 0.045, -half_depth, 0.0), DVec3::new(cx + 0.045, half_depth, 0.055)),
            DVec3::Y,
        );
        draft.add_frame(
            board(
                DVec3::new(cx - 0.035, -half_depth + 0.03, top - 0.05),
                DVec3::new(cx + 0.035, half_depth - 0.03, top),
            ),
            DVec3::Y,
        );
        let waist = 0.22 * half_depth + 0.04;
        let panel: Vec<DVec2> = smooth(
            &[
                DVec2::new(0.6 * half_depth, 0.03),
                DVec2::new(waist, 0.5 * top),
                DVec2::new(0.6 * half_depth, top - 0.02),
                DVec2::new(-0.6 * half_depth, top - 0.02),
                DVec2::new(-waist, 0.5 * top),
                DVec2::new(-0.6 * half_depth, 0.03),
            ],
            8,
        );
        let panel: Vec<DVec2> = panel.iter().map(|p| DVec2::new(p.x, p.y.clamp(0.02, top - 0.02))).collect();
        let panel = drop_repeats(&panel);
        let turn = DQuat::from_mat3(&glam::DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X));
        draft.add_frame(
            prism(&panel, 0.05)
                .translated(DVec3::new(0.0, 0.0, -0.025))
                .rotated(turn)
                .translated(DVec3::X * cx),
            DVec3::Z,
        );
    }
    draft.add_frame(
        bar(DVec3::new(-x, 0.0, 0.33 * top), DVec3::new(x, 0.0, 0.33 * top), 0.035, 0.09),
        DVec3::X,
    );
    edge
}

/// Removes points that repeat or continue in a straight line after clamping.
fn drop_repeats(points: &[DVec2]) -> Vec<DVec2> {
    let n = points.len();
    (0..n)
        .filter(|&k| {
            let (before, here, after) = (points[(k + n - 1) % n], points[k], points[(k + 1) % n]);
            (here - before).length() > 1e-6 && (here - before).perp_dot(after - here).abs() > 1e-9
        })
        .map(|k| points[k])
        .collect()
}

/// Three splayed legs under a triangle with generously rounded corners, its base toward the viewer.
pub fn triangular_table(draft: &mut Draft) -> Vec<DVec2> {
    let size = draft.size_m;
    let corners =
        [DVec2::new(-0.5, -0.5), DVec2::new(0.5, -0.5), DVec2::new(0.0, 0.5)].map(|c| c * size.truncate());
    let edge = fitted(&rounded_corners(&corners, 0.16 * size.x.min(size.y), 8), size.truncate());
    draft.add_top(&edge);
    let top = draft.underside_m() + JOINT_M;
    let center = DVec2::new(0.0, -size.y / 6.0);
    let feet = corners.map(|c| center + 0.62 * (c - center));
    let heads = corners.map(|c| center + 0.52 * (c - center));
    for (foot, head) in feet.iter().zip(&heads) {
        draft.add_frame(round_leg(foot.extend(0.0), head.extend(top), 0.016, 0.027), DVec3::Z);
    }
    let z = top - 0.03;
    for k in 0..3 {
        draft.add_frame(bar(heads[k].extend(z), heads[(k + 1) % 3].extend(z), 0.022, 0.06), DVec3::X);
    }
    edge
}

/// Six legs joined by aprons.
pub fn hexagonal_table(draft: &mut Draft) -> Vec<DVec2> {
    let size = draft.size_m;
    let edge = fitted(&rounded_corners(&regular_polygon(0.5, 6), 0.03, 4), size.truncate());
    draft.add_top(&edge);
    let top = draft.underside_m() + JOINT_M;
    let posts: Vec<DVec2> = fitted(&regular_polygon(0.5, 6), size.truncate() - 0.14);
    for post in &posts {
        draft.add_frame(leg(post.extend(0.0), post.extend(top), 0.04, 0.05), DVec3::Z);
    }
    let (z, low) = (top - 0.035, 0.14);
    for k in 0..6 {
        draft.add_frame(bar(posts[k].extend(z), posts[(k + 1) % 6].extend(z), 0.022, 0.07), DVec3::X);
    }
    for k in 0..3 {
        let lift = DVec3::Z * (low + 0.0007 * k as f64);
        draft.add_frame(
            bar(posts[k].extend(0.0) + lift, posts[k + 3].extend(0.0) + lift, 0.03, 0.04),
            DVec3::X,
        );
    }
    edge
}

/// A bean-shaped top, hollow toward the viewer, on three metal hairpin-like legs and a drum.
pub fn kidney_table(draft: &mut Draft) -> Vec<DVec2> {
    let size = draft.size_m;
    let bean = [
        (-0.5, 0.02),
        (-0.44, -0.34),
        (-0.25, -0.47),
        (0.0, -0.2),
        (0.25, -0.47),
        (0.44, -0.34),
        (0.5, 0.02),
        (0.38, 0.36),
        (0.0, 0.5),
        (-0.38, 0.36),
    ]
    .map(|(x, y)| DVec2::new(x, y) * size.truncate());
    let edge = fitted(&smooth(&bean, 8), size.truncate());
    draft.add_top(&edge);
    let top = draft.underside_m() + JOINT_M;
    let support = fitted(&smooth(&bean, 4), 0.72 * size.truncate());
    draft.add_frame(prism(&support, 0.04).translated(DVec3::Z * (top - 0.04)), DVec3::X);
    let metal = draft.finish.metal.clone();
    for (x, y) in [(-0.3, -0.27), (0.3, -0.27), (0.26, 0.24), (-0.26, 0.24)] {
        let head = DVec2::new(x, y) * size.truncate();
        let foot = 1.18 * head;
        let leg = round_leg(foot.extend(0.008), head.extend(top - 0.02), 0.013, 0.022);
        draft.add_frame(leg, DVec3::Z);
        draft.mesh.add(cylinder(0.019, 0.012, 0.001, 20).translated(foot.extend(0.0)), &metal);
    }
    edge
}

/// Each corner of a convex polygon replaced by an arc that starts `reach_m` before it.
fn rounded_corners(corners: &[DVec2], reach_m: f64, steps: usize) -> Vec<DVec2> {
    let n = corners.len();
    (0..n)
        .flat_map(|k| {
            let (before, here, after) = (corners[(k + n - 1) % n], corners[k], corners[(k + 1) % n]);
            let from = here + (before - here).normalize_or_zero() * reach_m;
            let to = here + (after - here).normalize_or_zero() * reach_m;
            (0..=steps).map(move |s| {
                let t = s as f64 / steps as f64;
                (1.0 - t) * (1.0 - t) * from + 2.0 * t * (1.0 - t) * here + t * t * to
            })
        })
        .collect()
}

/// The outline stretched and moved so that its box is `size_m` around the origin.
fn fitted(outline: &[DVec2], size_m: DVec2) -> Vec<DVec2> {
    let (low, high) =
        outline.iter().fold((outline[0], outline[0]), |(low, high), &p| (low.min(p), high.max(p)));
    outline.iter().map(|&p| (p - 0.5 * (low + high)) / (high - low) * size_m).collect()
}
