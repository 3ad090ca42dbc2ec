//! Solids that a hull may be, from the directions of its largest facets.

use glam::{DMat3, DQuat, DVec2, DVec3};

use super::{SimpleSolid, SimpleSolidKind};
use crate::polygon::convex_hull_2d;
use crate::{ConvexHull, Pose};

/// Smallest cosine between normals of one facet.
const SAME_NORMAL: f64 = 1.0 - 1e-8;
/// Facets whose normals are tried; those of a body of revolution come in groups of equals.
const LARGEST: usize = 4;
/// Largest cosine between normals that are at right angles.
const ACROSS: f64 = 1e-3;

/// Triangles of one plane.
pub(super) struct Facet {
    pub normal: DVec3,
    pub offset_m: f64,
    pub area_m2: f64,
}

/// The facets, the largest first.
pub(super) fn facets(hull: &ConvexHull) -> Vec<Facet> {
    let mut facets: Vec<Facet> = Vec::new();
    for triangle in &hull.triangles {
        let [a, b, c] = triangle.map(|v| hull.points[v as usize]);
        let area = 0.5 * (b - a).cross(c - a);
        let Some(normal) = area.try_normalize() else { continue };
        match facets.iter_mut().find(|facet| facet.normal.dot(normal) > SAME_NORMAL) {
            Some(facet) => facet.area_m2 += area.length(),
            None => {
                let offset_m = hull.points.iter().map(|p| normal.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
                facets.push(Facet { normal, offset_m, area_m2: area.length() });
            }
        }
    }
    facets.sort_by(|a, b| b.area_m2.total_cmp(&a.area_m2));
    facets
}

/// Boxes, cylinders and spheres that the hull may be, not yet tested.
pub(super) fn candidates(hull: &ConvexHull, facets: &[Facet]) -> Vec<SimpleSolid> {
    let largest: Vec<DVec3> = facets.iter().take(LARGEST).map(|facet| facet.normal).collect();
    let largest: &[DVec3] = &largest;
    let Some(&first) = largest.first() else { return Vec::new() };
    let mut found: Vec<SimpleSolid> = facets
        .iter()
        .find(|facet| facet.normal.dot(first).abs() < ACROSS)
        .map(|second| enclosing_box(hull, first, second.normal))
        .into_iter()
        .collect();
    // The axis of a disk is the normal of its faces, that of a rod is across the normals of its sides.
    let crossed = |k: usize| largest[..k].iter().map(move |one| one.cross(largest[k]));
    let across =
        (1..largest.len()).flat_map(crossed).filter(|axis| axis.length() > 0.01).map(DVec3::normalize);
    let mut axes: Vec<DVec3> = Vec::new();
    for axis in largest.iter().copied().chain(across) {
        if axes.iter().all(|known| known.dot(axis).abs() < 1.0 - 1e-6) {
            axes.push(axis);
        }
    }
    found.extend(axes.iter().filter_map(|axis| enclosing_cylinder(hull, *axis)));
    found.extend(sphere(hull));
    found.extend(axes.iter().filter_map(|axis| capsule(hull, *axis)));
    found
}

/// The box along two directions at right angles, up to rounding.
fn enclosing_box(hull: &ConvexHull, first: DVec3, second: DVec3) -> SimpleSolid {
    let z = first;
    let x = (second - second.dot(z) * z).normalize();
    let rotation = DQuat::from_mat3(&nearest_to_identity([x, z.cross(x), z])).normalize();
    let inverse = rotation.inverse();
    let (low, high) = hull
        .points
        .iter()
        .map(|p| inverse * *p)
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let half_m = 0.5 * (high - low);
    let object_from_solid = tidy(rotation * (0.5 * (low + high)), rotation);
    SimpleSolid { kind: SimpleSolidKind::Box { half_m }, object_from_solid }
}

/// The three directions at right angles, or their opposites, in the order that turns the axes least.
fn nearest_to_identity(directions: [DVec3; 3]) -> DMat3 {
    let along = |axis: usize, left: &[DVec3]| -> DVec3 {
        let steepest = left.iter().max_by(|a, b| a[axis].abs().total_cmp(&b[axis].abs()));
        steepest.map_or(DVec3::AXES[axis], |direction| *direction * direction[axis].signum())
    };
    let x = along(0, &directions);
    let left: Vec<DVec3> = directions.into_iter().filter(|other| other.dot(x).abs() < 0.5).collect();
    let y = along(1, &left);
    DMat3::from_cols(x, y, x.cross(y))
}

/// A pose without the noise of rounding.
fn tidy(translation_m: DVec3, rotation: DQuat) -> Pose {
    let tidy = |value: f64| (value * 1e12).round() / 1e12 + 0.0;
    Pose {
        translation_m: DVec3::from_array(translation_m.to_array().map(tidy)),
        rotation: DQuat::from_array(rotation.to_array().map(tidy)),
    }
}

/// The cylinder about the axis through the center of the hull's outline. Its x axis points to a corner of the outline.
fn enclosing_cylinder(hull: &ConvexHull, axis: DVec3) -> Option<SimpleSolid> {
    let Outline { frame, center, radius_m, low_m, high_m } = Outline::about(hull, axis)?;
    let translation_m = frame * center.extend(0.5 * (low_m + high_m));
    let kind = SimpleSolidKind::Cylinder { radius_m, half_length_m: 0.5 * (high_m - low_m) };
    Some(SimpleSolid { kind, object_from_solid: tidy(translation_m, frame) })
}

fn capsule(hull: &ConvexHull, axis: DVec3) -> Option<SimpleSolid> {
    let Outline { frame, center, radius_m, low_m, high_m } = Outline::about(hull, axis)?;
    let half_length_m = 0.5 * (high_m - low_m) - radius_m;
    let translation_m = frame * center.extend(0.5 * (low_m + high_m));
    let kind = SimpleSolidKind::Capsule { radius_m, half_length_m };
    (half_length_m > 0.0).then_some(SimpleSolid { kind, object_from_solid: tidy(translation_m, frame) })
}

fn sphere(hull: &ConvexHull) -> Option<SimpleSolid> {
    let center = circumcenter(&hull.points)?;
    let radius_m = hull.points.iter().map(|p| p.distance(center)).fold(0.0, f64::max);
    let object_from_solid = tidy(center, DQuat::IDENTITY);
    Some(SimpleSolid { kind: SimpleSolidKind::Sphere { radius_m }, object_from_solid })
}

/// The outline of a hull as seen along an axis: its circle, and the extent along the axis.
struct Outline {
    /// Rotation whose z axis is the axis, and whose x axis points from the center to a corner of the outline.
    frame: DQuat,
    /// In that frame.
    center: DVec2,
    radius_m: f64,
    low_m: f64,
    high_m: f64,
}

impl Outline {
    fn about(hull: &ConvexHull, axis: DVec3) -> Option<Self> {
        let largest = axis[axis.abs().max_position()];
        let turn = DQuat::from_rotation_arc(DVec3::Z, axis * largest.signum());
        let own: Vec<DVec3> = hull.points.iter().map(|p| turn.inverse() * *p).collect();
        let flat: Vec<DVec2> = own.iter().map(|p| p.truncate()).collect();
        let outline = convex_hull_2d(&flat);
        let on_plane: Vec<DVec3> = outline.iter().map(|p| p.extend(0.0)).collect();
        let center = circumcenter(&on_plane)?.truncate();
        let radius_m = outline.iter().map(|p| p.distance(center)).fold(0.0, f64::max);
        let first = DQuat::from_rotation_z((*outline.first()? - center).to_angle());
        let (low_m, high_m) = own
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.z), high.max(p.z)));
        let center = (first.inverse() * center.extend(0.0)).truncate();
        Some(Self { frame: turn * first, center, radius_m, low_m, high_m })
    }
}

/// The point of least squares that is as far from all points (Kasa's fit of a sphere, or of a circle in the plane z =
/// 0).
fn circumcenter(points: &[DVec3]) -> Option<DVec3> {
    let count = points.len() as f64;
    let mean = points.iter().sum::<DVec3>() / count;
    let (mut spread, mut moment) = (DMat3::ZERO, DVec3::ZERO);
    let mean_square = points.iter().map(|p| p.distance_squared(mean)).sum::<f64>() / count;
    for point in points {
        let d = *point - mean;
        spread += DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        moment += d * (d.length_squared() - mean_square);
    }
    if spread.z_axis.length() == 0.0 {
        spread.z_axis.z = 1.0;
    }
    // A flat or straight cloud has no center.
    let scale = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
    (spread.determinant().abs() > 1e-12 * scale.powi(3)).then(|| mean + 0.5 * (spread.inverse() * moment))
}
