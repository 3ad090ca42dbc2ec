//! Reads every format back and compares it with the scene: mass, center of mass, inertia, dynamic
//! friction, pose, hulls, visual meshes.
//!
//! The readers share nothing with the writers but the file layout, so a wrong axis order, unit or
//! rounding in a writer shows here and stops the bundle.

mod usd;
mod urdf;
mod mjcf;
mod glb;
mod xml_tree;

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};
use serde::Serialize;

use crate::geometry::Pose;

use super::{Body, BundleFile, ExportError};

/// Largest differences a format may show. Single-precision formats round at 6e-8 of a value.
struct Tolerances;

impl Tolerances {
    const MASS_RELATIVE: f64 = 1e-6;
    const LENGTH_M: f64 = 2e-6;
    const INERTIA_RELATIVE: f64 = 1e-5;
    const FRICTION: f64 = 1e-6;
    const ROTATION_RAD: f64 = 1e-5;
}

/// What a reader found about one body.
#[derive(Clone, Debug)]
struct ReadBody {
    mass_kg: f64,
    center_of_mass_m: DVec3,
    /// About the center of mass, along the object's axes.
    inertia_tensor_kg_m2: DMat3,
    dynamic_friction: f64,
    world_from_object: Pose,
    /// `None` where the format leaves it to whoever loads the file.
    movable: Option<bool>,
    /// Corners of every hull, object frame.
    hulls: Vec<Vec<DVec3>>,
}

/// Body name to what was read.
type ReadScene = BTreeMap<String, ReadBody>;

/// Why a format could not be read; becomes [`ExportError::Unreadable`].
type ReadResult<T> = Result<T, String>;

/// What the comparison showed, format by format.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParityReport {
    pub usd: FormatParity,
    pub urdf: FormatParity,
    pub mjcf: FormatParity,
    pub glb: MeshParity,
}

/// Largest differences between a format and the scene over all bodies.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FormatParity {
    pub bodies: usize,
    pub hulls: usize,
    pub mass_relative: f64,
    pub center_of_mass_m: f64,
    pub inertia_relative: f64,
    pub dynamic_friction: f64,
    pub translation_m: f64,
    pub rotation_rad: f64,
    pub hull_corner_m: f64,
}

/// The same for the visual meshes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MeshParity {
    pub meshes: usize,
    /// Vertices of the scene file against the meshes at their poses.
    pub vertex_m: f64,
}

/// Reads all formats among `files` and compares them with the bodies.
pub fn read_back(bodies: &[Body], files: &[BundleFile]) -> Result<ParityReport, ExportError> {
    let by_path: BTreeMap<&str, &[u8]> =
        files.iter().map(|file| (file.path.as_str(), file.bytes.as_slice())).collect();
    let files = Files(by_path);
    let check = |format, read: fn(&Files<'_>) -> ReadResult<ReadScene>| {
        let read = read(&files).map_err(|reason| ExportError::Unreadable { format, reason })?;
        compare(bodies, &read).map_err(|difference| ExportError::Parity { format, difference })
    };
    let ((usd, urdf), (mjcf, glb)) = rayon::join(
        || rayon::join(|| check("USD", usd::read), || check("URDF", urdf::read)),
        || rayon::join(|| check("MJCF", mjcf::read), || glb::compare(bodies, &files)),
    );
    Ok(ParityReport { usd: usd?, urdf: urdf?, mjcf: mjcf?, glb: glb? })
}

/// The files by path.
struct Files<'a>(BTreeMap<&'a str, &'a [u8]>);

impl<'a> Files<'a> {
    fn bytes(&self, path: &str) -> ReadResult<&'a [u8]> {
        self.0.get(path).copied().ok_or_else(|| format!("{path} is missing"))
    }

    fn text(&self, path: &str) -> ReadResult<&'a str> {
        std::str::from_utf8(self.bytes(path)?).map_err(|_| format!("{path} is not UTF-8"))
    }
}

fn compare(bodies: &[Body], read: &ReadScene) -> Result<FormatParity, String> {
    let mut parity = FormatParity { bodies: read.len(), ..FormatParity::default() };
    if read.len() != bodies.len() {
        return Err(format!("{} bodies instead of {}", read.len(), bodies.len()));
    }
    for body in bodies {
        let found = read.get(&body.name).ok_or_else(|| format!("{} is missing", body.name))?;
        if found.hulls.len() != body.hulls.len() {
            return Err(format!("{}: {} hulls", body.name, found.hulls.len()));
        }
        if found.movable.is_some_and(|movable| movable != body.movable) {
            return Err(format!("{}: movable {}", body.name, !body.movable));
        }
        parity.hulls += found.hulls.len();
        let inertia = body.inertia_tensor_kg_m2();
        let largest_moment = body.mass.inertia_diagonal_kg_m2.max_element();
        let inertia_difference = (found.inertia_tensor_kg_m2 - inertia).to_cols_array();
        let pose = body.world_from_object;
        let mut corner_m: f64 = 0.0;
        for (hull, found) in body.hulls.iter().zip(&found.hulls) {
            if hull.points.len() != found.len() {
                return Err(format!("{}: a hull has {} corners", body.name, found.len()));
            }
            let farthest = hull.points.iter().zip(found).map(|(a, b)| (*a - *b).length());
            corner_m = farthest.fold(corner_m, f64::max);
        }
        let differences = [
            (
                &mut parity.mass_relative,
                (found.mass_kg - body.mass.mass_kg).abs() / body.mass.mass_kg,
                Tolerances::MASS_RELATIVE,
            ),
            (
                &mut parity.center_of_mass_m,
                (found.center_of_mass_m - body.mass.center_of_mass_m).length(),
                Tolerances::LENGTH_M,
            ),
            (
                &mut parity.inertia_relative,
                inertia_difference.iter().fold(0.0_f64, |worst, d| worst.max(d.abs())) / largest_moment,
                Tolerances::INERTIA_RELATIVE,
            ),
            (
                &mut parity.dynamic_friction,
                (found.dynamic_friction - body.friction.dynamic_coefficient).abs(),
                Tolerances::FRICTION,
            ),
            (
                &mut parity.translation_m,
                (found.world_from_object.translation_m - pose.translation_m).length(),
                Tolerances::LENGTH_M,
            ),
            (
                &mut parity.rotation_rad,
                found.world_from_object.rotation.angle_between(pose.rotation),
                Tolerances::ROTATION_RAD,
            ),
            (&mut parity.hull_corner_m, corner_m, Tolerances::LENGTH_M),
        ];
        for (k, (worst, difference, tolerance)) in differences.into_iter().enumerate() {
            if difference.is_nan() || difference > tolerance {
                let names = ["mass", "center of mass", "inertia", "friction", "position", "rotation", "hull"];
                return Err(format!("{}: {} differs by {difference}", body.name, names[k]));
            }
            // Rounded up to one digit: the report says how good, not how the platform rounds.
            *worst = worst.max(one_digit_up(difference));
        }
    }
    Ok(parity)
}

/// The next power of ten at or above the value; zero stays zero.
fn one_digit_up(value: f64) -> f64 {
    if value <= 1e-15 { 0.0 } else { 10_f64.powi(value.log10().ceil() as i32) }
}

/// Numbers separated by white space, commas or brackets.
fn numbers(text: &str) -> ReadResult<Vec<f64>> {
    text.split(|c: char| c.is_whitespace() || ",()[]".contains(c))
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().map_err(|_| format!("{part:?} is no number")))
        .collect()
}

/// Three numbers.
fn vector(text: &str) -> ReadResult<DVec3> {
    match numbers(text)?.as_slice() {
        &[x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err(format!("{text:?} is no vector")),
    }
}

/// Four numbers in the order w, x, y, z.
fn quaternion_wxyz(text: &str) -> ReadResult<glam::DQuat> {
    match numbers(text)?.as_slice() {
        &[w, x, y, z] => Ok(glam::DQuat::from_xyzw(x, y, z, w).normalize()),
        _ => Err(format!("{text:?} is no quaternion")),
    }
}

/// Triples.
fn points(text: &str) -> ReadResult<Vec<DVec3>> {
    Ok(numbers(text)?.chunks_exact(3).map(DVec3::from_slice).collect())
}

/// The tensor of principal moments turned into the object's axes.
fn tensor(diagonal: DVec3, object_from_principal: glam::DQuat) -> DMat3 {
    let axes = DMat3::from_quat(object_from_principal);
    axes * DMat3::from_diagonal(diagonal) * axes.transpose()
}
