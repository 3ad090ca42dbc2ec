//! Checks of the mesh of a category: a closed solid of the right size and symmetry that stands.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use crate::{Recipe, build, category};
use geometry::TexturedMesh;
use geometry::shells::shells;

/// A check of a mesh that was built by a recipe; the objection, in words.
pub type Check = fn(&Recipe, &TexturedMesh) -> Option<String>;

/// Checks that every mesh of the catalog passes.
pub const CHECKS: [Check; 8] =
    [closed, closed_when_stored, normals_agree, in_size_and_budget, dressed, stands, repeats, symmetric];

fn welded(p: DVec3) -> [u64; 3] {
    (p + DVec3::ZERO).to_array().map(f64::to_bits)
}

/// Signed volume and center of mass of the (possibly overlapping) shells.
fn mass_center(mesh: &TexturedMesh) -> (f64, DVec3) {
    let (mut volume, mut moment) = (0.0, DVec3::ZERO);
    for t in mesh.triangles() {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        let tetrahedron = a.dot(b.cross(c)) / 6.0;
        volume += tetrahedron;
        moment += tetrahedron * (a + b + c) / 4.0;
    }
    (volume, moment / volume)
}

/// After welding, every edge is used once in each direction, and the faces point outward.
pub fn closed(_: &Recipe, mesh: &TexturedMesh) -> Option<String> {
    let mut balance: BTreeMap<([u64; 3], [u64; 3]), i32> = BTreeMap::new();
    for t in mesh.triangles() {
        for k in 0..3 {
            let a = welded(mesh.positions[t[k] as usize]);
            let b = welded(mesh.positions[t[(k + 1) % 3] as usize]);
            let (edge, sign) = if a < b { ((a, b), 1) } else { ((b, a), -1) };
            *balance.entry(edge).or_default() += sign;
        }
    }
    let open = balance.values().filter(|&&count| count != 0).count();
    let (volume_m3, _) = mass_center(mesh);
    (open > 0 || volume_m3 <= 0.0).then(|| format!("{open} open edges, volume {volume_m3:e} m^3"))
}

/// Every shell is closed after the way through files, too: at a longest side of 1 and back, in single precision.
/// Vertices that are too near to each other become one there.
pub fn closed_when_stored(_: &Recipe, mesh: &TexturedMesh) -> Option<String> {
    let longest_m = mesh.size_m().max_element();
    let unit = mesh.clone().scaled(DVec3::splat(1.0 / longest_m)).snap_to_f32();
    let stored = unit.scaled(DVec3::splat(longest_m)).snap_to_f32();
    let shells = shells(&stored);
    let open = shells.iter().find(|shell| !shell.is_closed())?;
    let (low_m, high_m) = open.bounds();
    Some(format!(
        "the shell from {low_m:.4} to {high_m:.4} is open in single precision: vertices are too near to each other"
    ))
}

/// Normals are unit and point in the direction of their faces.
pub fn normals_agree(_: &Recipe, mesh: &TexturedMesh) -> Option<String> {
    let not_unit = mesh.normals.iter().filter(|n| (n.length() - 1.0).abs() > 1e-3).count();
    let against = mesh
        .triangles()
        .filter(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            let face = (b - a).cross(c - a).normalize_or_zero().as_vec3();
            t.iter().any(|&v| mesh.normals[v as usize].dot(face) < -0.1)
        })
        .count();
    (not_unit > 0 || against > 0)
        .then(|| format!("{not_unit} normals not unit, {against} faces against their normals"))
}

/// The ordered extents, base on z = 0, 300 to 6000 triangles, finite numbers.
pub fn in_size_and_budget(recipe: &Recipe, mesh: &TexturedMesh) -> Option<String> {
    let error = (mesh.size_m() / recipe.size_m - 1.0).abs();
    let base_m = mesh.bounds().0.z.abs();
    let count = mesh.triangle_count();
    let parallel = mesh.uvs.len() == mesh.positions.len() && mesh.normals.len() == mesh.positions.len();
    let finite = mesh.positions.iter().all(|p| p.is_finite()) && mesh.uvs.iter().all(|uv| uv.is_finite());
    (error.max_element() > 0.06
        || base_m > 1e-9
        || !(300..=6000).contains(&count)
        || !parallel
        || !finite)
        .then(|| {
            format!(
                "size error {error:.3}, base {base_m:e}, {count} triangles, parallel {parallel}, finite {finite}"
            )
        })
}

/// Texture sizes are powers of two, and material names differ.
pub fn dressed(_: &Recipe, mesh: &TexturedMesh) -> Option<String> {
    let names: BTreeSet<&str> = mesh.materials.iter().map(|m| m.name.as_str()).collect();
    let odd = mesh.materials.iter().filter_map(|m| m.base_color_texture.as_ref()).find(|t| {
        [t.width_px(), t.height_px()].iter().any(|s| !s.is_power_of_two() || !(64..=512).contains(s))
    });
    (names.len() != mesh.materials.len() || odd.is_some())
        .then(|| format!("materials {names:?}, odd texture {:?}", odd.map(|t| (t.width_px(), t.height_px()))))
}

/// The center of mass is over the feet, away from their edge: the tilt at which it passes over the edge is at least
/// four degrees.
pub fn stands(_: &Recipe, mesh: &TexturedMesh) -> Option<String> {
    let (_, center) = mass_center(mesh);
    let feet: Vec<DVec3> =
        mesh.positions.iter().copied().filter(|p| p.z < 2e-4).map(|p| p - center).collect();
    // Smallest reach of the feet beyond the center of mass over all directions.
    let reach_m = (0..72)
        .map(|k| {
            let angle = f64::from(k) * std::f64::consts::TAU / 72.0;
            let (sin, cos) = angle.sin_cos();
            feet.iter().map(|p| p.x * cos + p.y * sin).fold(f64::NEG_INFINITY, f64::max)
        })
        .fold(f64::INFINITY, f64::min);
    let tilt_deg = reach_m.atan2(center.z).to_degrees();
    (tilt_deg < 4.0)
        .then(|| format!("tips over at {tilt_deg:.1} degrees ({reach_m:.4} m, center {:.4} m up)", center.z))
}

/// A second build gives the same bytes.
pub fn repeats(recipe: &Recipe, mesh: &TexturedMesh) -> Option<String> {
    (build(recipe).as_ref() != Some(mesh)).then(|| "two builds differ".to_owned())
}

/// The shape is unchanged by a rotation of its symmetry: every vertex lands within 4 % of the
/// largest extent of another one.
pub fn symmetric(recipe: &Recipe, mesh: &TexturedMesh) -> Option<String> {
    let order = category(&recipe.category)?.symmetry_order;
    let turn_rad = match order {
        0 => 0.7,
        1 => return None,
        n => std::f64::consts::TAU / f64::from(n),
    };
    let turn = glam::DQuat::from_rotation_z(turn_rad);
    let stride = mesh.positions.len().div_ceil(300);
    let worst_m = mesh
        .positions
        .iter()
        .step_by(stride)
        .map(|p| {
            let turned = turn * *p;
            mesh.positions.iter().map(|q| q.distance_squared(turned)).fold(f64::INFINITY, f64::min)
        })
        .fold(0.0, f64::max)
        .sqrt();
    let share = worst_m / mesh.size_m().max_element();
    (share > 0.04).then(|| format!("symmetry order {order}, but a vertex is off by {share:.3} of the size"))
}

/// Winding number of the surface around a point: 1 inside, 0 outside, other values at self-intersections.
fn winding(triangles: &[[DVec3; 3]], point: DVec3) -> f64 {
    let solid_angle = |corners: &[DVec3; 3]| {
        let [a, b, c] = corners.map(|p| p - point);
        let lengths = a.length() * b.length() * c.length();
        let around = lengths + a.dot(b) * c.length() + b.dot(c) * a.length() + c.dot(a) * b.length();
        2.0 * a.dot(b.cross(c)).atan2(around)
    };
    triangles.iter().map(solid_angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// There is air in front of each face. A wall whose sides cross is inverted there, and objects on it seem to be
/// inside.
pub fn nowhere_inside_out(_: &Recipe, mesh: &TexturedMesh) -> Option<String> {
    const BEFORE_M: f64 = 2e-5;
    let inside_out = shells(mesh).into_iter().map(|shell| {
        let triangles: Vec<[DVec3; 3]> = shell.corners().collect();
        let is_in_the_solid = |[a, b, c]: &[DVec3; 3]| {
            let before = (b - a).cross(c - a).normalize_or_zero() * BEFORE_M;
            winding(&triangles, (a + b + c) / 3.0 + before) > 0.5
        };
        triangles.iter().filter(|triangle| is_in_the_solid(triangle)).count()
    });
    let count: usize = inside_out.sum();
    (count > 0).then(|| format!("{count} faces are directed into the solid"))
}
