//! Round trip: reads every format and compares it with the scene: names, mass, center of mass, inertia, friction,
//! restitution, pose, hulls, visual meshes, labels, marks of stand-ins.
//!
//! The readers share only the file layout with the writers. A wrong axis order, unit or rounding in a writer is an
//! error here, and no bundle is made. Differences within the tolerances go into the report.

mod error;
mod usd;
mod urdf;
mod mjcf;
mod sdf;
mod glb;
mod labels;
mod stand_ins;
mod visuals;
mod xml_node;

pub use error::{Difference, LayerError, ReadError};

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};
use schemars::JsonSchema;
use serde::Serialize;

use geometry::{ConvexHull, Pose, SimpleSolid, SimpleSolidKind};
use scene::StandIn;

use super::{Body, BundleFile, ExportError};

/// Largest differences allowed. Single-precision formats round at 6e-8 of a value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Tolerances {
    #[schemars(range(min = 0.0))]
    pub mass_relative: f64,
    #[schemars(range(min = 0.0))]
    pub center_of_mass_m: f64,
    /// Over the largest moment.
    #[schemars(range(min = 0.0))]
    pub inertia_relative: f64,
    #[schemars(range(min = 0.0))]
    pub dynamic_friction: f64,
    #[schemars(range(min = 0.0))]
    pub static_friction: f64,
    #[schemars(range(min = 0.0))]
    pub restitution: f64,
    #[schemars(range(min = 0.0))]
    pub rolling_friction_m: f64,
    #[schemars(range(min = 0.0))]
    pub torsional_friction_m: f64,
    #[schemars(range(min = 0.0))]
    pub translation_m: f64,
    #[schemars(range(min = 0.0))]
    pub rotation_rad: f64,
    #[schemars(range(min = 0.0))]
    pub hull_corner_m: f64,
    #[schemars(range(min = 0.0))]
    pub hull_volume_relative: f64,
    /// Of the visual meshes.
    #[schemars(range(min = 0.0))]
    pub vertex_m: f64,
}

impl Tolerances {
    pub const BUNDLE: Self = Self {
        mass_relative: 1e-6,
        center_of_mass_m: 1e-6,
        inertia_relative: 1e-5,
        dynamic_friction: 1e-6,
        static_friction: 1e-6,
        restitution: 1e-6,
        rolling_friction_m: 1e-6,
        torsional_friction_m: 1e-6,
        translation_m: 1e-6,
        rotation_rad: 1e-6,
        hull_corner_m: 1e-6,
        hull_volume_relative: 1e-4,
        vertex_m: 1e-6,
    };
}

/// One body as read from a format.
#[derive(Clone, Debug)]
struct ReadBody {
    mass_kg: f64,
    center_of_mass_m: DVec3,
    /// About the center of mass, along the object's axes.
    inertia_tensor_kg_m2: DMat3,
    contact: ReadContact,
    world_from_object: Pose,
    /// `None` where the format leaves this to the loader.
    movable: Option<bool>,
    /// Every hull, object frame.
    hulls: Vec<ReadHull>,
    /// Triangles of the visual meshes by material, object frame; `None` where they are compared separately.
    visual: Option<BTreeMap<String, Vec<[DVec3; 3]>>>,
    /// `None` where they are compared separately.
    labels: Option<ReadLabels>,
}

/// A collision shape: the corners of a hull, or the solid that it stands for.
#[derive(Clone, Debug, PartialEq)]
enum ReadHull {
    Corners(Vec<DVec3>),
    Solid(SimpleSolid),
}

/// Contact parameters of a body; `None` where the format has no place for one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ReadContact {
    dynamic_friction: f64,
    static_friction: Option<f64>,
    restitution: Option<f64>,
    rolling_friction_m: Option<f64>,
    torsional_friction_m: Option<f64>,
}

/// Names of a body for people and for taxonomies.
#[derive(Clone, Debug)]
struct ReadLabels {
    label: String,
    category: String,
    wikidata_item: String,
    stand_in: Option<StandIn>,
}

/// Bodies by name.
type ReadScene = BTreeMap<String, ReadBody>;

/// The error becomes [`ExportError::Unreadable`].
type ReadResult<T> = Result<T, ReadError>;

/// Result of the comparison, per format. If there is a report, names, labels, movable bodies and the numbers of bodies,
/// hulls and corners are equal.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RoundTripReport {
    pub tolerances: Tolerances,
    pub usd: FormatDeviation,
    pub urdf: FormatDeviation,
    pub mjcf: FormatDeviation,
    pub sdf: FormatDeviation,
    pub glb: MeshDeviation,
}

/// Largest differences between a format and the scene over all bodies, rounded up to a power of ten.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct FormatDeviation {
    pub bodies: usize,
    pub hulls: usize,
    #[schemars(range(min = 0.0))]
    pub mass_relative: f64,
    #[schemars(range(min = 0.0))]
    pub center_of_mass_m: f64,
    #[schemars(range(min = 0.0))]
    pub inertia_relative: f64,
    #[schemars(range(min = 0.0))]
    pub dynamic_friction: f64,
    /// Null where a format has no place for it.
    #[schemars(range(min = 0.0))]
    pub static_friction: Option<f64>,
    /// Null where a format has no place for it.
    #[schemars(range(min = 0.0))]
    pub restitution: Option<f64>,
    /// Null where a format has no place for it.
    #[schemars(range(min = 0.0))]
    pub rolling_friction_m: Option<f64>,
    /// Null where a format has no place for it.
    #[schemars(range(min = 0.0))]
    pub torsional_friction_m: Option<f64>,
    #[schemars(range(min = 0.0))]
    pub translation_m: f64,
    #[schemars(range(min = 0.0))]
    pub rotation_rad: f64,
    #[schemars(range(min = 0.0))]
    pub hull_corner_m: f64,
    #[schemars(range(min = 0.0))]
    pub hull_volume_relative: f64,
    /// Of the visual meshes.
    #[schemars(range(min = 0.0))]
    pub vertex_m: f64,
}

/// Largest differences between the GLB files and the scene, rounded up to a power of ten.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct MeshDeviation {
    pub meshes: usize,
    #[schemars(range(min = 0.0))]
    pub translation_m: f64,
    #[schemars(range(min = 0.0))]
    pub rotation_rad: f64,
    /// Vertices of the scene file against the meshes at their poses.
    #[schemars(range(min = 0.0))]
    pub vertex_m: f64,
}

/// Reads all formats among `files` and compares them with the bodies.
///
/// # Errors
///
/// [`ExportError::Unreadable`] for a file that is missing or malformed; [`ExportError::RoundTripMismatch`] for the
/// first difference beyond [`Tolerances::BUNDLE`].
pub fn read_back(bodies: &[Body], files: &[BundleFile]) -> Result<RoundTripReport, ExportError> {
    let by_path: BTreeMap<&str, &[u8]> =
        files.iter().map(|file| (file.path.as_str(), file.bytes.as_slice())).collect();
    let files = Files(by_path);
    let check = |format, read: fn(&Files<'_>) -> ReadResult<ReadScene>| {
        let read = read(&files).map_err(|reason| ExportError::unreadable(format, reason))?;
        compare(bodies, &read).map_err(|difference| ExportError::mismatch(format, difference))
    };
    let ((usd, urdf), (mjcf, (sdf, glb))) = rayon::join(
        || rayon::join(|| check("USD", usd::read), || check("URDF", urdf::read)),
        || {
            rayon::join(
                || check("MJCF", mjcf::read),
                || rayon::join(|| check("SDF", sdf::read), || glb::compare(bodies, &files)),
            )
        },
    );
    let (usd, mut urdf, mut mjcf, mut sdf, glb) = (usd?, urdf?, mjcf?, sdf?, glb?);
    let (labels, visuals) =
        rayon::join(|| labels::compare(bodies, &files), || visuals::compare(bodies, &files));
    labels?;
    stand_ins::compare(bodies, &files)?;
    let visuals = visuals?;
    urdf.vertex_m = visuals.urdf;
    mjcf.vertex_m = visuals.mjcf;
    sdf.vertex_m = visuals.sdf;
    Ok(RoundTripReport { tolerances: Tolerances::BUNDLE, usd, urdf, mjcf, sdf, glb })
}

/// The files by path.
struct Files<'a>(BTreeMap<&'a str, &'a [u8]>);

impl<'a> Files<'a> {
    fn bytes(&self, path: &str) -> ReadResult<&'a [u8]> {
        self.0.get(path).copied().ok_or_else(|| ReadError::missing(path))
    }

    fn text(&self, path: &str) -> ReadResult<&'a str> {
        std::str::from_utf8(self.bytes(path)?).map_err(|_| ReadError::NotUtf8(path.to_owned()))
    }
}

fn compare(bodies: &[Body], read: &ReadScene) -> Result<FormatDeviation, Difference> {
    let mut deviation = FormatDeviation { bodies: read.len(), ..FormatDeviation::default() };
    if read.len() != bodies.len() {
        return Err(Difference::Count { found: read.len(), of: "bodies".to_owned(), wanted: bodies.len() });
    }
    for body in bodies {
        let name = || body.name.clone();
        let found = read.get(&body.name).ok_or_else(|| Difference::Missing(name()))?;
        if found.hulls.len() != body.hulls.len() {
            return Err(Difference::HullCount { body: name(), found: found.hulls.len() });
        }
        if found.movable.is_some_and(|movable| movable != body.movable) {
            return Err(Difference::Movable { body: name(), found: !body.movable });
        }
        deviation.hulls += found.hulls.len();
        compare_labels(body, found)?;
        let inertia = body.inertia_tensor_kg_m2();
        let largest_moment = body.mass.inertia_diagonal_kg_m2.max_element();
        let inertia_difference = (found.inertia_tensor_kg_m2 - inertia).to_cols_array();
        let pose = body.world_from_object;
        let (mut corner_m, mut volume): (f64, f64) = (0.0, 0.0);
        for (k, found) in found.hulls.iter().enumerate() {
            let difference = compare_hull(&body.hulls[k], body.solids[k].as_ref(), found);
            let [apart_m, grown] =
                difference.map_err(|fault| Difference::Hull { body: name(), hull: k, fault })?;
            (corner_m, volume) = (larger(corner_m, apart_m), larger(volume, grown));
        }
        let vertex_m = match &found.visual {
            Some(triangles) => visuals::farthest_corner_m(&body.visual, triangles)
                .map_err(|inner| Difference::Visual { body: name(), difference: Box::new(inner) })?,
            None => 0.0,
        };
        let limits = Tolerances::BUNDLE;
        compare_contact(body, &found.contact, &mut deviation)?;
        let differences = [
            (
                "mass",
                &mut deviation.mass_relative,
                (found.mass_kg - body.mass.mass_kg).abs() / body.mass.mass_kg,
                limits.mass_relative,
            ),
            (
                "center of mass",
                &mut deviation.center_of_mass_m,
                (found.center_of_mass_m - body.mass.center_of_mass_m).length(),
                limits.center_of_mass_m,
            ),
            (
                "inertia",
                &mut deviation.inertia_relative,
                inertia_difference.iter().fold(0.0_f64, |worst, d| larger(worst, d.abs())) / largest_moment,
                limits.inertia_relative,
            ),
            (
                "position",
                &mut deviation.translation_m,
                (found.world_from_object.translation_m - pose.translation_m).length(),
                limits.translation_m,
            ),
            (
                "rotation",
                &mut deviation.rotation_rad,
                angle_between_rad(found.world_from_object.rotation, pose.rotation),
                limits.rotation_rad,
            ),
            ("hull", &mut deviation.hull_corner_m, corner_m, limits.hull_corner_m),
            ("hull volume", &mut deviation.hull_volume_relative, volume, limits.hull_volume_relative),
            ("visual mesh", &mut deviation.vertex_m, vertex_m, limits.vertex_m),
        ];
        for (name, worst, difference, tolerance) in differences {
            *worst = worst.max(within(body, name, difference, tolerance)?);
        }
    }
    Ok(deviation)
}

/// Largest distance of a corner, or of the center of a face of a solid, and relative difference of volumes.
fn compare_hull(
    hull: &ConvexHull,
    solid: Option<&SimpleSolid>,
    found: &ReadHull,
) -> Result<[f64; 2], &'static str> {
    match (solid, found) {
        (Some(solid), ReadHull::Solid(found)) => {
            if std::mem::discriminant(&solid.kind) != std::mem::discriminant(&found.kind) {
                return Err("is another solid");
            }
            let farthest =
                face_centers(solid).into_iter().zip(face_centers(found)).map(|(a, b)| a.distance(b));
            Ok([farthest.fold(0.0, larger), (found.volume_m3() / solid.volume_m3() - 1.0).abs()])
        }
        // URDF has no capsules.
        (
            None | Some(SimpleSolid { kind: SimpleSolidKind::Capsule { .. }, .. }),
            ReadHull::Corners(corners),
        ) => {
            if hull.points.len() != corners.len() {
                return Err("has another number of corners");
            }
            let farthest = hull.points.iter().zip(corners).map(|(a, b)| a.distance(*b)).fold(0.0, larger);
            let found = ConvexHull { points: corners.clone(), triangles: hull.triangles.clone() };
            Ok([farthest, (found.volume_m3() / hull.volume_m3() - 1.0).abs()])
        }
        (Some(_), ReadHull::Corners(_)) => Err("is a mesh and not the solid"),
        (None, ReadHull::Solid(_)) => Err("is a solid and not the mesh"),
    }
}

/// Center of a solid, and the points at which its own axes leave it on the positive side.
fn face_centers(solid: &SimpleSolid) -> [DVec3; 4] {
    let half_m = solid.half_size_m();
    [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]
        .map(|axis| solid.object_from_solid.transform_point(axis * half_m))
}

/// Checks a difference against its tolerance and rounds it up to a power of ten, which hides the rounding of the
/// platform.
fn within(body: &Body, quantity: &'static str, difference: f64, tolerance: f64) -> Result<f64, Difference> {
    if difference.is_nan() || difference > tolerance {
        return Err(Difference::Quantity { body: body.name.clone(), quantity, difference });
    }
    Ok(ceil_to_power_of_ten(difference))
}

fn compare_contact(
    body: &Body,
    found: &ReadContact,
    deviation: &mut FormatDeviation,
) -> Result<(), Difference> {
    let limits = Tolerances::BUNDLE;
    let dynamic = (found.dynamic_friction - body.friction.dynamic_coefficient).abs();
    let dynamic = within(body, "dynamic friction", dynamic, limits.dynamic_friction)?;
    deviation.dynamic_friction = deviation.dynamic_friction.max(dynamic);
    let static_friction = body.friction.static_coefficient;
    let optional = [
        (
            "static friction",
            &mut deviation.static_friction,
            found.static_friction,
            static_friction,
            limits.static_friction,
        ),
        ("restitution", &mut deviation.restitution, found.restitution, body.restitution, limits.restitution),
        (
            "rolling friction",
            &mut deviation.rolling_friction_m,
            found.rolling_friction_m,
            body.rolling_friction_m,
            limits.rolling_friction_m,
        ),
        (
            "torsional friction",
            &mut deviation.torsional_friction_m,
            found.torsional_friction_m,
            body.torsional_friction_m,
            limits.torsional_friction_m,
        ),
    ];
    for (name, worst, found, wanted, tolerance) in optional {
        let Some(found) = found else { continue };
        let difference = within(body, name, (found - wanted).abs(), tolerance)?;
        *worst = Some(worst.unwrap_or(0.0).max(difference));
    }
    Ok(())
}

fn compare_labels(body: &Body, found: &ReadBody) -> Result<(), Difference> {
    let Some(labels) = &found.labels else { return Ok(()) };
    let name = || body.name.clone();
    // USD strings cannot hold a NUL.
    let label = body.label.replace('\0', "\u{fffd}");
    let pairs = [
        ("label", &labels.label, &label),
        ("category", &labels.category, &body.category),
        ("Wikidata item", &labels.wikidata_item, &body.wikidata_item),
    ];
    match pairs.into_iter().find(|(_, found, wanted)| found != wanted) {
        Some((what, found, wanted)) => {
            Err(Difference::Words { body: name(), what, found: found.clone(), wanted: wanted.clone() })
        }
        None if labels.stand_in != stand_ins::held(body, |words| words.replace('\0', "\u{fffd}")) => {
            let boxed = |mark: &Option<StandIn>| mark.clone().map(Box::new);
            let (found, wanted) = (boxed(&labels.stand_in), boxed(&body.stand_in));
            Err(Difference::StandIn { body: name(), found, wanted })
        }
        None => Ok(()),
    }
}

/// Maximum that propagates NaN, unlike `f64::max`.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

/// Angle between two rotations. Exact for small angles, where the arc cosine of the scalar part is not.
fn angle_between_rad(a: glam::DQuat, b: glam::DQuat) -> f64 {
    let q = a.conjugate() * b;
    2.0 * q.xyz().length().atan2(q.w.abs())
}

/// The next power of ten at or above the value; zero stays zero.
fn ceil_to_power_of_ten(value: f64) -> f64 {
    if value <= 1e-15 { 0.0 } else { 10_f64.powi(value.log10().ceil() as i32) }
}

/// Numbers separated by white space, commas or brackets.
fn numbers(text: &str) -> ReadResult<Vec<f64>> {
    text.split(|c: char| c.is_whitespace() || ",()[]".contains(c))
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().map_err(|_| ReadError::not_a("number", part)))
        .collect()
}

/// Three numbers.
fn vector(text: &str) -> ReadResult<DVec3> {
    match numbers(text)?.as_slice() {
        &[x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err(ReadError::not_a("vector", text)),
    }
}

/// Four numbers in the order w, x, y, z.
fn quaternion_wxyz(text: &str) -> ReadResult<glam::DQuat> {
    match numbers(text)?.as_slice() {
        &[w, x, y, z] => Ok(glam::DQuat::from_xyzw(x, y, z, w).normalize()),
        _ => Err(ReadError::not_a("quaternion", text)),
    }
}

/// Triples.
fn points(text: &str) -> ReadResult<Vec<DVec3>> {
    Ok(numbers(text)?.chunks_exact(3).map(DVec3::from_slice).collect())
}

/// Corners of a hull in a Wavefront file. Its faces must enclose a positive volume.
fn obj_hull(text: &str) -> ReadResult<ReadHull> {
    let rows: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("v ")).collect();
    let corners = points(&rows.join(" "))?;
    let mut triangles = Vec::new();
    for face in text.lines().filter_map(|line| line.strip_prefix("f ")) {
        let corner = |word: &str| {
            let index = word.split('/').next().and_then(|first| first.parse::<u32>().ok());
            index.and_then(|index| index.checked_sub(1)).filter(|&k| (k as usize) < corners.len())
        };
        match face.split_whitespace().map(corner).collect::<Option<Vec<u32>>>().as_deref() {
            Some(&[a, b, c]) => triangles.push([a, b, c]),
            _ => return Err(ReadError::NotTriangle { face: face.to_owned(), corners: corners.len() }),
        }
    }
    let hull = ConvexHull { points: corners, triangles };
    if hull.volume_m3() > 0.0 {
        Ok(ReadHull::Corners(hull.points))
    } else {
        Err(ReadError::wrong("a hull", "encloses no volume or is inside out"))
    }
}

/// The inertia tensor along the object's axes from its principal moments.
fn tensor(diagonal: DVec3, object_from_principal: glam::DQuat) -> DMat3 {
    let axes = DMat3::from_quat(object_from_principal);
    axes * DMat3::from_diagonal(diagonal) * axes.transpose()
}
