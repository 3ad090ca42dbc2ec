//! Tables on four legs: dining table, desk, workbench, coffee table, square table.
//!
//! Each function adds its parts to the draft and returns the outer edge of the top.

use glam::{DVec2, DVec3};
use rand::RngExt;

use super::Draft;
use super::shapes::{board, leg};
use geometry::shapes::{cylinder, rectangle, rounded_rectangle, tube};
use runtime::seed::Rng;

/// Overlap between parts.
const JOINT_M: f64 = 0.001;

/// Four corners (+-x, +-y).
const CORNERS: [DVec2; 4] =
    [DVec2::new(-1.0, -1.0), DVec2::new(1.0, -1.0), DVec2::new(1.0, 1.0), DVec2::new(-1.0, 1.0)];

/// Boards under the top between four legs whose centers are at +-`reach`.
fn add_apron(draft: &mut Draft, reach: DVec2, height_m: f64, thickness_m: f64, front: bool) {
    let high = draft.underside_m() + JOINT_M;
    let low = high - height_m;
    let t = 0.5 * thickness_m;
    for side in [-1.0, 1.0] {
        if front || side > 0.0 {
            let y = side * reach.y;
            draft.add_frame(
                board(DVec3::new(-reach.x, y - t, low), DVec3::new(reach.x, y + t, high)),
                DVec3::X,
            );
        }
        let x = side * reach.x;
        draft.add_frame(board(DVec3::new(x - t, -reach.y, low), DVec3::new(x + t, reach.y, high)), DVec3::Y);
    }
}

/// Farmhouse style: square legs tapering below an apron, sometimes a stretcher.
pub fn dining_table(draft: &mut Draft, rng: &mut Rng) -> Vec<DVec2> {
    let size = draft.size_m;
    let edge = rounded_rectangle(size.x, size.y, 0.02, 4);
    draft.add_top(&edge);
    let head = 0.075;
    let reach = DVec2::new(0.5 * size.x - 0.09, 0.5 * size.y - 0.08);
    let tapered = rng.random_range(0..2) == 0;
    for corner in CORNERS {
        let at = (corner * reach).extend(0.0);
        let foot = if tapered { 0.045 } else { head };
        let shoulder = draft.underside_m() - 0.11;
        let top = draft.underside_m() + JOINT_M;
        draft.add_frame(leg(at, at + DVec3::Z * (shoulder + JOINT_M), foot, head), DVec3::Z);
        draft.add_frame(
            leg(at + DVec3::Z * shoulder, at + DVec3::Z * top, head + 0.002, head + 0.002),
            DVec3::Z,
        );
    }
    add_apron(draft, reach, 0.09, 0.024, true);
    if !tapered {
        for side in [-1.0, 1.0] {
            let x = side * reach.x;
            draft.add_frame(
                board(DVec3::new(x - 0.02, -reach.y, 0.12), DVec3::new(x + 0.02, reach.y, 0.18)),
                DVec3::Y,
            );
        }
        draft.add_frame(board(DVec3::new(-reach.x, -0.02, 0.13), DVec3::new(reach.x, 0.02, 0.175)), DVec3::X);
    }
    edge
}

/// A pedestal of three drawers on the right, legs on the left, a flat drawer in the center and a modesty board behind.
pub fn desk(draft: &mut Draft) -> Vec<DVec2> {
    let size = draft.size_m;
    let edge = rounded_rectangle(size.x, size.y, 0.012, 4);
    draft.add_top(&edge);
    let top = draft.underside_m() + JOINT_M;
    let (x, y) = (0.5 * size.x - 0.03, 0.5 * size.y - 0.03);
    let cabinet_width = (0.3 * size.x).clamp(0.32, 0.45);
    let cabinet_left = x - cabinet_width;
    draft.add_frame(board(DVec3::new(cabinet_left, -y + 0.02, 0.06), DVec3::new(x, y, top)), DVec3::Z);
    draft.add_frame(
        board(DVec3::new(cabinet_left + 0.02, -y + 0.05, 0.0), DVec3::new(x - 0.02, y - 0.02, 0.061)),
        DVec3::X,
    );
    let front = -y + 0.02;
    let clear = top - 0.06;
    let mut low = 0.075;
    for (index, share) in [0.42, 0.29, 0.29].into_iter().enumerate() {
        let height = share * (clear - 0.03);
        let high = low + height - 0.012;
        add_drawer(
            draft,
            DVec3::new(cabinet_left + 0.012, front, low),
            DVec3::new(x - 0.012, front, if index == 2 { high.min(top - 0.015) } else { high }),
        );
        low += height;
    }
    for side in [-1.0, 1.0] {
        let at = DVec3::new(-x + 0.025, side * (y - 0.025), 0.0);
        draft.add_frame(leg(at, at + DVec3::Z * top, 0.05, 0.05), DVec3::Z);
    }
    let left = -x + 0.025;
    draft.add_frame(
        board(
            DVec3::new(left, y - 0.035, (top - 0.32).max(0.02)),
            DVec3::new(cabinet_left + 0.01, y - 0.015, top),
        ),
        DVec3::X,
    );
    draft.add_frame(
        board(DVec3::new(left - 0.01, -y + 0.025, top - 0.09), DVec3::new(left + 0.01, y - 0.025, top)),
        DVec3::Y,
    );
    draft.add_frame(
        board(DVec3::new(left, -y + 0.03, top - 0.1), DVec3::new(cabinet_left + 0.01, y - 0.1, top)),
        DVec3::X,
    );
    add_drawer(
        draft,
        DVec3::new(left + 0.06, -y + 0.03, top - 0.09),
        DVec3::new(cabinet_left - 0.03, -y + 0.03, top - 0.012),
    );
    edge
}

/// A drawer front standing 14 mm out of the plane y = `low.y`, with a bow handle.
fn add_drawer(draft: &mut Draft, low: DVec3, high: DVec3) {
    let face_y = low.y - 0.014;
    draft.add_frame(
        board(DVec3::new(low.x, face_y, low.z), DVec3::new(high.x, low.y + 0.001, high.z)),
        DVec3::X,
    );
    let center = 0.5 * (low + high);
    let half = (0.18 * (high.x - low.x)).min(0.07);
    let path = [
        DVec3::new(center.x - half, face_y + 0.002, center.z),
        DVec3::new(center.x - half, face_y - 0.014, center.z),
        DVec3::new(center.x - half + 0.006, face_y - 0.02, center.z),
        DVec3::new(center.x + half - 0.006, face_y - 0.02, center.z),
        DVec3::new(center.x + half, face_y - 0.014, center.z),
        DVec3::new(center.x + half, face_y + 0.002, center.z),
    ];
    let metal = draft.finish.metal.clone();
    draft.mesh.add(tube(&path, 0.005, 10), &metal);
}

/// Heavy legs, a planked top, a shelf of planks below and a front vise.
pub fn workbench(draft: &mut Draft) -> Vec<DVec2> {
    let size = draft.size_m;
    let edge = rectangle(size.x, size.y);
    draft.add_top(&edge);
    let reach = DVec2::new(0.5 * size.x - 0.1, 0.5 * size.y - 0.08);
    let top = draft.underside_m() + JOINT_M;
    for corner in CORNERS {
        let at = (corner * reach).extend(0.0);
        draft.add_frame(leg(at, at + DVec3::Z * top, 0.09, 0.09), DVec3::Z);
    }
    add_apron(draft, reach, 0.12, 0.035, true);
    for side in [-1.0, 1.0] {
        let y = side * reach.y;
        draft.add_frame(
            board(DVec3::new(-reach.x, y - 0.02, 0.15), DVec3::new(reach.x, y + 0.02, 0.22)),
            DVec3::X,
        );
        let x = side * reach.x;
        draft.add_frame(
            board(DVec3::new(x - 0.02, -reach.y, 0.15), DVec3::new(x + 0.02, reach.y, 0.22)),
            DVec3::Y,
        );
    }
    let planks = 4;
    let pitch = 2.0 * reach.y / f64::from(planks);
    for plank in 0..planks {
        let y = -reach.y + f64::from(plank) * pitch;
        draft.add_frame(
            board(
                DVec3::new(-reach.x - 0.03, y + 0.004, 0.219),
                DVec3::new(reach.x + 0.03, y + pitch - 0.004, 0.241),
            ),
            DVec3::X,
        );
    }
    // The vise stays within the top's outline: its jaw is a block under the front edge.
    let (x, front) = (-0.5 * size.x + 0.3, -0.5 * size.y);
    let jaw_low = top - 0.15;
    draft.add_frame(
        board(DVec3::new(x - 0.12, front + 0.002, jaw_low), DVec3::new(x + 0.12, front + 0.045, top)),
        DVec3::X,
    );
    let metal = draft.finish.metal.clone();
    let turn = glam::DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    let screw =
        cylinder(0.014, 0.1, 0.0, 20).rotated(turn).translated(DVec3::new(x, front + 0.012, jaw_low + 0.07));
    draft.mesh.add(screw, &metal);
    edge
}

/// Low, on splayed round-cornered legs with a slatted shelf.
pub fn coffee_table(draft: &mut Draft) -> Vec<DVec2> {
    let size = draft.size_m;
    let edge = rounded_rectangle(size.x, size.y, 0.035, 6);
    draft.add_top(&edge);
    let top = draft.underside_m() + JOINT_M;
    let reach = DVec2::new(0.5 * size.x - 0.05, 0.5 * size.y - 0.05);
    for corner in CORNERS {
        let foot = (corner * reach).extend(0.0);
        let head = (corner * (reach - 0.035)).extend(top);
        draft.add_frame(leg(foot, head, 0.03, 0.045), DVec3::Z);
    }
    add_apron(draft, reach - 0.035, 0.05, 0.02, true);
    let inner = reach - 0.015;
    for side in [-1.0, 1.0] {
        let x = side * (inner.x - 0.01);
        draft.add_frame(
            board(DVec3::new(x - 0.014, -inner.y, 0.13), DVec3::new(x + 0.014, inner.y, 0.158)),
            DVec3::Y,
        );
    }
    for slat in 0..6 {
        let y = (f64::from(slat) - 2.5) / 2.5 * (inner.y - 0.05);
        draft.add_frame(
            board(
                DVec3::new(-inner.x + 0.005, y - 0.02, 0.157),
                DVec3::new(inner.x - 0.005, y + 0.02, 0.171),
            ),
            DVec3::X,
        );
    }
    edge
}

/// Slim legs at the very corners and a thin apron.
pub fn square_table(draft: &mut Draft, rng: &mut Rng) -> Vec<DVec2> {
    let size = draft.size_m;
    let edge = rounded_rectangle(size.x, size.y, 0.03, 6);
    draft.add_top(&edge);
    let top = draft.underside_m() + JOINT_M;
    let reach = DVec2::new(0.5 * size.x - 0.045, 0.5 * size.y - 0.045);
    let foot_side = if rng.random_range(0..2) == 0 { 0.03 } else { 0.05 };
    for corner in CORNERS {
        let foot = (corner * reach).extend(0.0);
        let head = (corner * reach).extend(top);
        draft.add_frame(leg(foot, head, foot_side, 0.05), DVec3::Z);
    }
    add_apron(draft, reach, 0.07, 0.02, true);
    edge
}
