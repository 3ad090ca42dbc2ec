//! Convex decomposition: the collision geometry of a visual mesh.
//!
//! Each closed shell is looked at alone (a mug's handle, its body). A shell that is convex already is its
//! own hull and costs nothing; a concave one goes through V-HACD (Mamou and Ghorbel 2009, parry's
//! port: voxelize, cut along planes until every part is nearly convex) and each part's hull is taken of
//! the *surface inside it*, not of its voxels, which fits far closer. Cavities and handles stay open.
//! Neighboring hulls whose common hull adds next to no volume are merged; hulls inside another vanish.
//!
//! Input: meters, object frame; output in the same frame. Guarantees: at most `max_vertices` corners a
//! hull, at least `min_thickness_m` thick, same bytes with any number of threads. Cost: V-HACD's, about
//! resolution^3; shells run in parallel. Not for open surfaces: a shell that does not close is given its
//! convex hull.

use glam::DVec3;
use parry3d_f64::transformation::vhacd::{VHACD, VHACDParameters};
use parry3d_f64::transformation::voxelization::FillMode;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::convex_hull::{convex_hull, distance_above, planes};
use super::mesh_solid::{MeshSolid, SolidError};
use super::shells::{Shell, shells};
use super::{ConvexHull, Interrupt, Interrupted, TexturedMesh};

/// Section `[decompose]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct DecomposeSettings {
    /// A shell whose surface lies nowhere deeper than this below its convex hull counts as convex,
    /// meters, 0.0001..0.01. More: fewer hulls, coarser contact.
    pub convex_tolerance_m: f64,
    /// Voxels along the longest edge of a concave shell, 16..256. More: closer hulls, time grows
    /// with about its square.
    pub resolution: u32,
    /// Concavity below which a part is not cut further, as a share of the shell's hull, 0.0001..0.1.
    /// Less: more hulls, opener cavities.
    pub concavity: f64,
    /// Most hulls V-HACD may make of one shell, 1..256.
    pub max_hulls_per_shell: u32,
    /// Most corners of a hull, 8..255. 64 is what GPU engines accept.
    pub max_vertices: u32,
    /// Least thickness of a hull, meters, 0..0.01. Thin sheets tunnel through things.
    pub min_thickness_m: f64,
    /// Two hulls merge when their common hull adds at most this share of its own volume, 0..0.2.
    pub merge_tolerance: f64,
    /// Spacing of the samples that measure how far hulls stick out, meters, 0.001..0.02.
    pub excess_spacing_m: f64,
}

/// The hulls of a mesh and how well they fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decomposition {
    pub hulls: Vec<ConvexHull>,
    /// Largest distance by which a hull sticks out of the visual mesh, meters.
    pub max_excess_m: f64,
    /// Sum of the hulls' volumes (overlaps count twice) and of the shells', m^3.
    pub hull_volume_m3: f64,
    pub mesh_volume_m3: f64,
    /// Whether every shell of the mesh is closed.
    pub watertight: bool,
}

/// Why a mesh has no hulls.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecomposeError {
    #[error("decomposing: no part of the mesh has a convex hull with volume; repair or replace the mesh")]
    NoHull,
    #[error("decomposing: {0}")]
    Solid(#[from] SolidError),
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Convex hulls that cover the mesh and leave its cavities open.
pub fn decompose(
    mesh: &TexturedMesh,
    settings: &DecomposeSettings,
    interrupt: &Interrupt,
) -> Result<Decomposition, DecomposeError> {
    let shells = shells(mesh);
    let per_shell: Vec<Vec<ConvexHull>> = shells
        .par_iter()
        .filter(|shell| shell.volume_m3() >= 0.0)
        .map(|shell| hulls_of_shell(shell, settings, interrupt))
        .collect::<Result<_, Interrupted>>()?;
    let hulls = without_enclosed(per_shell.into_iter().flatten().collect());
    if hulls.is_empty() {
        return Err(DecomposeError::NoHull);
    }
    let solid = MeshSolid::from_shells(&shells)?;
    let excess: Vec<f64> = hulls
        .par_iter()
        .map(|hull| excess_m(hull, &solid, settings.excess_spacing_m, interrupt))
        .collect::<Result<_, Interrupted>>()?;
    Ok(Decomposition {
        max_excess_m: excess.into_iter().fold(0.0, f64::max),
        hull_volume_m3: hulls.iter().map(ConvexHull::volume_m3).sum(),
        mesh_volume_m3: shells.iter().map(Shell::volume_m3).sum(),
        watertight: solid.is_watertight(),
        hulls,
    })
}

fn hulls_of_shell(
    shell: &Shell,
    settings: &DecomposeSettings,
    interrupt: &Interrupt,
) -> Result<Vec<ConvexHull>, Interrupted> {
    interrupt.check()?;
    let hull =
        |points: &[DVec3]| convex_hull(points, settings.max_vertices as usize, settings.min_thickness_m);
    let whole = hull(&shell.points);
    // Judged by the hull with all its corners: dropping corners is no concavity.
    let convex = convex_hull(&shell.points, usize::MAX, settings.min_thickness_m)
        .is_none_or(|full| depth_below_hull_m(shell, &full) <= settings.convex_tolerance_m);
    if convex || !shell.is_closed() {
        return Ok(whole.into_iter().collect());
    }
    let parameters = VHACDParameters {
        resolution: settings.resolution,
        concavity: settings.concavity,
        max_convex_hulls: settings.max_hulls_per_shell,
        fill_mode: FillMode::FloodFill { detect_cavities: false },
        ..VHACDParameters::default()
    };
    let parts = VHACD::decompose(&parameters, &shell.points, &shell.triangles, true);
    interrupt.check()?;
    let clouds: Vec<Vec<DVec3>> = parts
        .compute_exact_convex_hulls(&shell.points, &shell.triangles)
        .into_iter()
        .map(|(points, _)| points)
        .collect();
    let merged = merged(clouds, settings.merge_tolerance, interrupt)?;
    let hulls: Vec<ConvexHull> = merged.iter().filter_map(|points| hull(points)).collect();
    Ok(if hulls.is_empty() { whole.into_iter().collect() } else { hulls })
}

/// How deep the shell's surface dips below the hull: at its corners, edge middles and face middles.
fn depth_below_hull_m(shell: &Shell, hull: &ConvexHull) -> f64 {
    let faces = planes(hull);
    shell
        .corners()
        .flat_map(|[a, b, c]| [a, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (a + b + c) / 3.0])
        .map(|p| -distance_above(&faces, p))
        .fold(0.0, f64::max)
}

/// Merges the pair that adds the least volume until none adds less than its share.
fn merged(
    mut clouds: Vec<Vec<DVec3>>,
    tolerance: f64,
    interrupt: &Interrupt,
) -> Result<Vec<Vec<DVec3>>, Interrupted> {
    const EXACT: usize = usize::MAX;
    let volume = |points: &[DVec3]| convex_hull(points, EXACT, 0.0).map_or(0.0, |h| h.volume_m3());
    let boxed = |points: &[DVec3]| {
        points
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)))
    };
    // Only hull corners matter from here on, and there are far fewer of them.
    for cloud in &mut clouds {
        if let Some(hull) = convex_hull(cloud, EXACT, 0.0) {
            *cloud = hull.points;
        }
    }
    let mut volumes: Vec<f64> = clouds.iter().map(|c| volume(c)).collect();
    let mut boxes: Vec<(DVec3, DVec3)> = clouds.iter().map(|c| boxed(c)).collect();
    let cost = |clouds: &[Vec<DVec3>], volumes: &[f64], boxes: &[(DVec3, DVec3)], a: usize, b: usize| {
        let apart = (boxes[a].0 - boxes[b].1).max(boxes[b].0 - boxes[a].1).max_element();
        if apart > 1e-4 {
            return f64::INFINITY;
        }
        let both: Vec<DVec3> = clouds[a].iter().chain(&clouds[b]).copied().collect();
        let common = volume(&both);
        if common > 0.0 { (common - volumes[a] - volumes[b]) / common } else { f64::INFINITY }
    };
    let mut costs: Vec<Vec<f64>> = Vec::new();
    for a in 0..clouds.len() {
        interrupt.check()?;
        costs.push((0..a).map(|b| cost(&clouds, &volumes, &boxes, a, b)).collect());
    }
    loop {
        interrupt.check()?;
        let best = (0..clouds.len())
            .flat_map(|a| (0..a).map(move |b| (a, b)))
            .min_by(|&(a, b), &(c, d)| costs[a][b].total_cmp(&costs[c][d]));
        let Some((a, b)) = best.filter(|&(a, b)| costs[a][b] <= tolerance) else { return Ok(clouds) };
        let taken = clouds.remove(a);
        clouds[b].extend(taken);
        if let Some(hull) = convex_hull(&clouds[b], EXACT, 0.0) {
            clouds[b] = hull.points;
        }
        volumes.remove(a);
        boxes.remove(a);
        volumes[b] = volume(&clouds[b]);
        boxes[b] = boxed(&clouds[b]);
        costs.remove(a);
        costs.iter_mut().filter(|row| row.len() > a).for_each(|row| {
            row.remove(a);
        });
        costs[b] = (0..b).map(|other| cost(&clouds, &volumes, &boxes, b, other)).collect();
        for (other, row) in costs.iter_mut().enumerate().skip(b + 1) {
            row[b] = cost(&clouds, &volumes, &boxes, other, b);
        }
    }
}

/// Drops hulls all of whose corners lie in another one.
fn without_enclosed(hulls: Vec<ConvexHull>) -> Vec<ConvexHull> {
    let faces: Vec<_> = hulls.iter().map(planes).collect();
    let mut dropped = vec![false; hulls.len()];
    for a in 0..hulls.len() {
        dropped[a] = (0..hulls.len()).any(|b| {
            b != a && !dropped[b] && hulls[a].points.iter().all(|&p| distance_above(&faces[b], p) <= 1e-9)
        });
    }
    hulls.into_iter().zip(dropped).filter(|(_, dropped)| !dropped).map(|(hull, _)| hull).collect()
}

/// How far the hull's surface leaves the solid, sampled.
fn excess_m(
    hull: &ConvexHull,
    solid: &MeshSolid,
    spacing_m: f64,
    interrupt: &Interrupt,
) -> Result<f64, Interrupted> {
    interrupt.check()?;
    let mut worst: f64 = 0.0;
    for t in &hull.triangles {
        let [a, b, c] = t.map(|v| hull.points[v as usize]);
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        let steps = ((longest / spacing_m).ceil() as usize).clamp(1, 64);
        for i in 0..=steps {
            for j in 0..=steps - i {
                let (u, v) = (i as f64 / steps as f64, j as f64 / steps as f64);
                worst = worst.max(-solid.depth_m(a + u * (b - a) + v * (c - a)));
            }
        }
    }
    Ok(worst)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::{block, ring, shell_of_revolution, sphere, tube};
    use crate::geometry::{Material, Rgb, Solid};
    use glam::DVec2;

    fn settings() -> DecomposeSettings {
        DecomposeSettings {
            convex_tolerance_m: 0.0005,
            resolution: 48,
            concavity: 0.002,
            max_hulls_per_shell: 32,
            max_vertices: 64,
            min_thickness_m: 0.001,
            merge_tolerance: 0.01,
            excess_spacing_m: 0.004,
        }
    }

    fn mesh(solids: impl IntoIterator<Item = Solid>) -> TexturedMesh {
        let mut mesh = TexturedMesh::default();
        for solid in solids {
            mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
        }
        mesh
    }

    fn mug() -> TexturedMesh {
        let profile = [DVec2::new(0.035, 0.0), DVec2::new(0.04, 0.05), DVec2::new(0.04, 0.1)];
        let path: Vec<DVec3> = (0..=12)
            .map(|k| {
                let angle = std::f64::consts::PI * (f64::from(k) / 12.0 - 0.5);
                DVec3::new(0.038 + 0.028 * angle.cos(), 0.0, 0.055 + 0.032 * angle.sin())
            })
            .collect();
        mesh([shell_of_revolution(&profile, 0.004, 0.006, 64), tube(&path, 0.005, 12)])
    }

    fn is_in_a_hull(d: &Decomposition, p: DVec3) -> bool {
        d.hulls.iter().any(|h| distance_above(&planes(h), p) < 1e-6)
    }

    #[test]
    fn convex_parts_are_their_own_hulls() {
        let blocks = [block(DVec3::splat(0.1)), sphere(0.03, 32).translated(DVec3::new(0.0, 0.0, 0.1))];
        let d = decompose(&mesh(blocks), &settings(), &Interrupt::default()).expect("two convex parts");
        assert_eq!(d.hulls.len(), 2);
        assert!(d.watertight && d.max_excess_m < 0.0011, "{}", d.max_excess_m);
        assert!((d.hull_volume_m3 / d.mesh_volume_m3 - 1.0).abs() < 0.02);
    }

    #[test]
    fn a_mug_stays_open_and_its_handle_too() {
        let d = decompose(&mug(), &settings(), &Interrupt::default()).expect("a mug");
        assert!(d.hulls.len() > 8 && d.hulls.iter().all(|h| h.points.len() <= 64));
        for z in [0.012, 0.05, 0.099] {
            assert!(!is_in_a_hull(&d, DVec3::new(0.0, 0.0, z)), "the cavity is filled at {z}");
            assert!(!is_in_a_hull(&d, DVec3::new(0.02, 0.01, z)), "the cavity is filled at {z}");
        }
        assert!(!is_in_a_hull(&d, DVec3::new(0.05, 0.0, 0.055)), "the handle is filled");
        assert!(is_in_a_hull(&d, DVec3::new(0.066, 0.0, 0.055)), "the handle is missing");
        assert!(is_in_a_hull(&d, DVec3::new(-0.038, 0.0, 0.08)), "the wall is missing");
        assert!(is_in_a_hull(&d, DVec3::new(0.0, 0.0, 0.003)), "the floor is missing");
        assert!(d.max_excess_m < 0.004, "hulls stick out by {}", d.max_excess_m);
        let lowest = d.hulls.iter().flat_map(|h| &h.points).map(|p| p.z).fold(1.0, f64::min);
        assert!(lowest.abs() < 1e-9);
    }

    #[test]
    fn hulls_cover_the_surface() {
        for shape in [mug(), mesh([ring(0.05, 0.01, 48, 16)])] {
            let d = decompose(&shape, &settings(), &Interrupt::default()).expect("a shape");
            let faces: Vec<_> = d.hulls.iter().map(planes).collect();
            for t in shape.triangles() {
                let middle = t.map(|v| shape.positions[v as usize]).iter().sum::<DVec3>() / 3.0;
                let outside = faces.iter().map(|f| distance_above(f, middle)).fold(f64::INFINITY, f64::min);
                assert!(outside < 0.0008, "{middle} sticks out by {outside}");
            }
        }
    }

    #[test]
    fn the_same_bytes_with_one_thread_and_with_two() {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| decompose(&mug(), &settings(), &Interrupt::default())).expect("a mug")
        };
        assert_eq!(with(1), with(2));
    }

    #[test]
    fn it_stops_when_asked_and_refuses_nothing() {
        let interrupt = Interrupt::default();
        interrupt.raise();
        assert_eq!(decompose(&mug(), &settings(), &interrupt), Err(DecomposeError::Interrupted(Interrupted)));
        let nothing = decompose(&TexturedMesh::default(), &settings(), &Interrupt::default());
        assert_eq!(nothing, Err(DecomposeError::NoHull));
    }
}
