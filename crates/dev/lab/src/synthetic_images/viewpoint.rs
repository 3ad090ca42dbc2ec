//! Camera sampling: usually the whole table, sometimes only its top, or a close-up of a few objects.

use glam::{DQuat, DVec2, DVec3};
use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::arrangement::Placed;
use super::sampling::{chance, triangular, uniform, weighted};
use super::table::Table;
use geometry::{Camera, Pose};
use runtime::seed::Rng;

/// Content of the image's frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Framing {
    /// The whole table with its legs.
    Whole,
    /// The top and the objects on it; legs may be cut off.
    Top,
    /// Some of the objects; the table fills most of the frame.
    Detail,
}

/// Camera and framing.
pub(super) struct Viewpoint {
    pub camera: Camera,
    pub framing: Framing,
}

/// Samples a camera for an image whose longer side has `size_px` pixels.
pub(super) fn draw(table: &Table, placed: &[Placed], size_px: u32, rng: &mut Rng) -> Viewpoint {
    let framing = if placed.is_empty() {
        Framing::Whole
    } else {
        weighted(rng, &[(Framing::Whole, 5.0), (Framing::Top, 2.0), (Framing::Detail, 3.0)])
    };
    let lens = Lens::draw(size_px, rng);
    let points = match framing {
        Framing::Whole => [sparse(&table.mesh.positions), corners(placed.iter())].concat(),
        Framing::Top => {
            let rim: Vec<DVec3> = table.outline.corners().iter().map(|p| p.extend(0.0)).collect();
            [rim, corners(placed.iter())].concat()
        }
        Framing::Detail => {
            let center = placed[rng.random_range(0..placed.len())].world_from_object.translation_m;
            let reach_m = uniform(rng, 0.05, 0.6);
            corners(
                placed.iter().filter(|one| (one.world_from_object.translation_m - center).length() < reach_m),
            )
        }
    };
    let margin = match framing {
        Framing::Detail => uniform(rng, 0.04, 0.22),
        _ => uniform(rng, 0.015, 0.14),
    };
    let mut camera = framed(&points, lens, margin, NEAREST_M);
    if chance(rng, 0.12) {
        let roll_rad = uniform(rng, -0.12, 0.12);
        let pose = &mut camera.world_from_camera;
        *pose = Pose { rotation: pose.rotation * DQuat::from_rotation_z(roll_rad), ..*pose };
    }
    // A cropped image has an off-center principal point.
    if chance(rng, 0.1) {
        camera.cx += uniform(rng, -0.08, 0.08) * f64::from(camera.width_px);
        camera.cy += uniform(rng, -0.08, 0.08) * f64::from(camera.height_px);
    }
    Viewpoint { camera, framing }
}

/// Samples a camera that shows one object large.
pub(super) fn close_up(shown: &Placed, size_px: u32, rng: &mut Rng) -> Viewpoint {
    let lens = Lens::draw(size_px, rng);
    let margin = uniform(rng, 0.05, 0.33);
    let points = corners(std::iter::once(shown));
    Viewpoint { camera: framed(&points, lens, margin, NEAREST_CLOSE_UP_M), framing: Framing::Detail }
}

/// Smallest distances of a camera from what it shows, meters.
const NEAREST_M: f64 = 0.25;
const NEAREST_CLOSE_UP_M: f64 = 0.08;

/// Size of the image, field of view, and direction of the camera.
#[derive(Clone, Copy)]
struct Lens {
    size_px: [u32; 2],
    fov_x_rad: f64,
    azimuth_rad: f64,
    elevation_rad: f64,
}

impl Lens {
    fn draw(size_px: u32, rng: &mut Rng) -> Self {
        let aspect =
            weighted(rng, &[(4.0 / 3.0, 4.0), (1.0, 2.5), (1.5, 1.5), (16.0 / 9.0, 1.0), (0.75, 0.7)]);
        let [width, height] = if aspect >= 1.0 { [1.0, 1.0 / aspect] } else { [aspect, 1.0] }
            .map(|share: f64| (share * f64::from(size_px)).round() as u32);
        let fov_x_rad =
            if chance(rng, 0.75) { triangular(rng, 24.0, 48.0) } else { uniform(rng, 18.0, 66.0) }
                .to_radians();
        let elevation_rad =
            if chance(rng, 0.7) { triangular(rng, 14.0, 60.0) } else { uniform(rng, 10.0, 88.0) }
                .to_radians();
        let azimuth_rad = match rng.random_range(0..10) {
            0..3 => uniform(rng, -0.03, 0.03),
            3..7 => uniform(rng, -0.35, 0.35),
            _ => uniform(rng, -0.79, 0.79),
        };
        Self { size_px: [width, height], fov_x_rad, azimuth_rad, elevation_rad }
    }
}

/// A subset of the points that includes the extreme ones.
fn sparse(points: &[DVec3]) -> Vec<DVec3> {
    let directions = (0..26).map(|k| {
        let axis = |n: usize| (k + usize::from(k >= 13)) / n % 3;
        DVec3::new(axis(1) as f64 - 1.0, axis(3) as f64 - 1.0, axis(9) as f64 - 1.0)
    });
    let far = |direction: DVec3| {
        points.iter().copied().max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)))
    };
    directions.filter_map(far).chain(points.iter().copied().step_by(1 + points.len() / 300)).collect()
}

/// Corners of the objects' bounding boxes.
fn corners<'a>(placed: impl Iterator<Item = &'a Placed>) -> Vec<DVec3> {
    placed
        .flat_map(|one| {
            let (low, high) = one.object.mesh.bounds();
            (0..8).map(move |k| {
                let pick = |bit: usize, l: f64, h: f64| if k & bit == 0 { l } else { h };
                let corner =
                    DVec3::new(pick(1, low.x, high.x), pick(2, low.y, high.y), pick(4, low.z, high.z));
                one.world_from_object.transform_point(corner)
            })
        })
        .collect()
}

/// The camera of that lens whose frame the points fill up to the margin (a share of each side), at least `nearest_m`
/// away from them.
fn framed(points: &[DVec3], lens: Lens, margin: f64, nearest_m: f64) -> Camera {
    let Lens { size_px, fov_x_rad, azimuth_rad, elevation_rad } = lens;
    let (low, high) =
        points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
    let (mut target_m, mut distance_m) = (0.5 * (low + high), 2.5 * (high - low).length());
    let camera = |target_m: DVec3, distance_m: f64| {
        Camera::orbit(size_px[0], size_px[1], fov_x_rad, target_m, azimuth_rad, elevation_rad, distance_m)
    };
    for _ in 0..10 {
        let trial = camera(target_m, distance_m);
        let (mut lowest, mut highest) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut behind = false;
        for point in points {
            match trial.project(*point) {
                Some((pixel, depth_m)) if depth_m > 0.02 => {
                    (lowest, highest) = (lowest.min(pixel), highest.max(pixel))
                }
                _ => behind = true,
            }
        }
        if behind {
            distance_m *= 1.5;
            continue;
        }
        let off = 0.5 * (lowest + highest) - DVec2::new(trial.cx, trial.cy);
        target_m += trial.world_from_camera.transform_vector((off * distance_m / trial.fx).extend(0.0));
        let used = (highest - lowest) / DVec2::new(f64::from(size_px[0]), f64::from(size_px[1]));
        distance_m = (distance_m * used.max_element() / (1.0 - 2.0 * margin)).max(nearest_m);
    }
    camera(target_m, distance_m)
}
