//! Plane of the table top: RANSAC and weighted least squares in inverse depth.

use glam::{DMat3, DVec3};

use super::{DepthCopy, DepthDoubt};

/// Points among which RANSAC counts, and its hypotheses. With half of the points in the plane, all 200 triples miss it
/// with a probability of 1e-11.
const MAX_COUNTED: usize = 3000;
const HYPOTHESES: u32 = 200;
/// Distance along the optical axis within which a point may lie in the plane: a constant, meters, and a multiple of
/// the square of the depth, per meter. Twice the noise of the first Kinect (Khoshelham and Elberink 2012).
const TOLERANCE_M: f64 = 0.004;
const TOLERANCE_PER_M: f64 = 0.006;
const REFINEMENTS: usize = 6;
/// Distance along the optical axis within which a pixel shows the plane: a constant, meters, and a multiple of the
/// noise that the plane itself has. Beyond this share of the depth it does not tell the top from its side.
const EDGE_TOLERANCE_M: f64 = 0.002;
const EDGE_SIGMAS: f64 = 3.0;
const MAX_EDGE_TOLERANCE_SHARE: f64 = 0.01;
/// Minimum share of the top's pixels with a depth, and of these in the plane.
const MIN_MEASURED_SHARE: f64 = 0.15;
const MIN_PLANE_SHARE: f64 = 0.5;
/// Minimum number of the top's pixels with a depth.
const MIN_MEASURED: usize = 200;
/// Ranges of a camera that shows a table top.
const ELEVATION_RANGE_RAD: [f64; 2] = [0.05, 1.53];
const MAX_ROLL_RAD: f64 = 0.6;

/// A plane in the camera's frame: the points with `normal_per_m . point = 1`. The normal points away from the camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TopPlane {
    normal_per_m: DVec3,
    /// Root mean square distance of its points, meters.
    pub rms_m: f64,
    /// Root mean square deviation of their inverse depths, per meter.
    inverse_rms_per_m: f64,
}

impl TopPlane {
    /// The plane in which most of the pixels `on_top` lie.
    pub fn fit(depth: &DepthCopy, on_top: &[bool]) -> Result<Self, DepthDoubt> {
        let shown: Vec<usize> = (0..depth.len()).filter(|&index| on_top[index]).collect();
        let points: Vec<DVec3> = shown.iter().filter_map(|&index| depth.point_m(index)).collect();
        let measured_share = points.len() as f64 / shown.len().max(1) as f64;
        if points.len() < MIN_MEASURED || measured_share < MIN_MEASURED_SHARE {
            return Err(DepthDoubt::FewMeasured {
                percent: 100.0 * measured_share,
                min_percent: 100.0 * MIN_MEASURED_SHARE,
            });
        }
        let no_plane =
            |share: f64| DepthDoubt::NoPlane { percent: 100.0 * share, min_percent: 100.0 * MIN_PLANE_SHARE };
        let mut normal_per_m = consensus(&points).ok_or_else(|| no_plane(0.0))?;
        for _ in 0..REFINEMENTS {
            normal_per_m = refined(&points, normal_per_m).ok_or_else(|| no_plane(0.0))?;
        }
        let near: Vec<&DVec3> = points.iter().filter(|point| is_near(**point, normal_per_m)).collect();
        let share = near.len() as f64 / points.len() as f64;
        if share < MIN_PLANE_SHARE {
            return Err(no_plane(share));
        }
        let plane = Self { normal_per_m, rms_m: 0.0, inverse_rms_per_m: 0.0 };
        let rms = |of: &dyn Fn(DVec3) -> f64| {
            (near.iter().map(|point| of(**point).powi(2)).sum::<f64>() / near.len() as f64).sqrt()
        };
        let rms_m = rms(&|point_m| plane.height_m(point_m));
        let inverse_rms_per_m = rms(&|point_m| (normal_per_m.dot(point_m) - 1.0) / point_m.z);
        let plane = Self { rms_m, inverse_rms_per_m, ..plane };
        let [lowest_rad, highest_rad] = ELEVATION_RANGE_RAD;
        let (elevation_rad, roll_rad) = (plane.elevation_rad(), plane.roll_rad());
        if !(lowest_rad..=highest_rad).contains(&elevation_rad) || roll_rad.abs() > MAX_ROLL_RAD {
            let (elevation_deg, roll_deg) = (elevation_rad.to_degrees(), roll_rad.to_degrees());
            return Err(DepthDoubt::NoTableView { elevation_deg, roll_deg });
        }
        Ok(plane)
    }

    /// Whether a pixel shows the plane; `None` where it shows something before it, has no depth, or one too noisy to
    /// distinguish the top from its side.
    pub fn is_shown_at(&self, depth: &DepthCopy, index: usize) -> Option<bool> {
        let point_m = depth.point_m(index)?;
        let inverse_depth = self.normal_per_m.dot(point_m) / point_m.z;
        let noise_m = EDGE_SIGMAS * self.inverse_rms_per_m * point_m.z * point_m.z;
        let tolerance_m = EDGE_TOLERANCE_M + noise_m;
        // Its ray passes the plane, or does not meet it.
        if inverse_depth <= 0.0 || point_m.z > inverse_depth.recip() + tolerance_m {
            return Some(false);
        }
        let is_sharp = tolerance_m < MAX_EDGE_TOLERANCE_SHARE * point_m.z;
        (is_sharp && point_m.z > inverse_depth.recip() - tolerance_m).then_some(true)
    }

    /// Height of the camera above the plane, meters.
    pub fn camera_height_m(&self) -> f64 {
        self.normal_per_m.length().recip()
    }

    /// Height of a point above the plane, meters.
    pub fn height_m(&self, point_m: DVec3) -> f64 {
        (1.0 - self.normal_per_m.dot(point_m)) * self.camera_height_m()
    }

    /// Elevation of the camera above the plane, radians.
    pub fn elevation_rad(&self) -> f64 {
        self.normal_per_m.normalize().z.clamp(-1.0, 1.0).asin()
    }

    /// Rotation of the camera about its optical axis, radians; positive where the plane's downward normal leans to the
    /// right of the image.
    pub fn roll_rad(&self) -> f64 {
        self.normal_per_m.x.atan2(self.normal_per_m.y)
    }
}

/// Whether a point lies in the plane, within the noise of its depth.
fn is_near(point_m: DVec3, normal_per_m: DVec3) -> bool {
    let inverse_depth = normal_per_m.dot(point_m) / point_m.z;
    let tolerance_m = TOLERANCE_M + TOLERANCE_PER_M * point_m.z * point_m.z;
    inverse_depth > 0.0 && (point_m.z - inverse_depth.recip()).abs() < tolerance_m
}

/// The plane through three of the points near which most points lie.
fn consensus(points: &[DVec3]) -> Option<DVec3> {
    let counted: Vec<DVec3> =
        points.iter().step_by(points.len().div_ceil(MAX_COUNTED).max(1)).copied().collect();
    let hypothesis = |number: u32| {
        let at = |k: u32| counted[(scrambled(3 * number + k) % counted.len() as u64) as usize];
        let through = DMat3::from_cols(at(0), at(1), at(2)).transpose();
        (through.determinant().abs() > 1e-9).then(|| through.inverse() * DVec3::ONE)
    };
    let agreed =
        |normal_per_m: &DVec3| counted.iter().filter(|point| is_near(**point, *normal_per_m)).count();
    // Of equal hypotheses the first: the result is a function of the points.
    let all =
        (0..HYPOTHESES).filter_map(hypothesis).map(|normal_per_m| (agreed(&normal_per_m), normal_per_m));
    all.reduce(|best, next| if next.0 > best.0 { next } else { best }).map(|(_, normal_per_m)| normal_per_m)
}

/// A pseudo-random number (the finalizer of SplitMix64).
fn scrambled(number: u32) -> u64 {
    let mut z = (u64::from(number) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// One step of least squares in inverse depth over the points near the plane, the nearer the more.
fn refined(points: &[DVec3], normal_per_m: DVec3) -> Option<DVec3> {
    let (mut squares, mut moments) = (DMat3::ZERO, DVec3::ZERO);
    for point in points.iter().filter(|point| is_near(**point, normal_per_m)) {
        let direction = *point / point.z;
        let tolerance = (TOLERANCE_M + TOLERANCE_PER_M * point.z * point.z) / (point.z * point.z);
        let off = (normal_per_m.dot(direction) - point.z.recip()) / tolerance;
        // Tukey's weights: 0 at the tolerance.
        let weight = (1.0 - off * off).max(0.0).powi(2);
        squares +=
            DMat3::from_cols(direction * direction.x, direction * direction.y, direction * direction.z)
                * weight;
        moments += direction * (weight / point.z);
    }
    let solved = squares.inverse() * moments;
    (squares.determinant().abs() > 1e-12 && solved.is_finite()).then_some(solved)
}
