//! Steps the dining generators share: smooth profiles, vessels with walls, bent and flattened solids,
//! ribbons, loop handles, and fitting the finished mesh to the ordered size. Meters, +z up.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::Order;
use crate::texture::{is_finish, material_finish, wrapped_around};
use geometry::shapes::{circle, ellipse, lathe, loft, loft_closed, rounded_rectangle, sweep};
use geometry::{Material, Solid, TexturedMesh, Vec2};

/// Points from pairs.
pub(super) fn points(pairs: &[(f64, f64)]) -> Vec<DVec2> {
    pairs.iter().map(|&(x, y)| DVec2::new(x, y)).collect()
}

/// The same outline, counter-clockwise.
pub(super) fn counter_clockwise(mut outline: Vec<DVec2>) -> Vec<DVec2> {
    let n = outline.len();
    let area: f64 = (0..n).map(|k| outline[k].perp_dot(outline[(k + 1) % n])).sum();
    if area < 0.0 {
        outline.reverse();
    }
    outline
}

/// An open Catmull-Rom curve through `pairs`, `steps` segments between neighbors.
pub(super) fn spline(pairs: &[(f64, f64)], steps: usize) -> Vec<DVec2> {
    let p = points(pairs);
    let last = p.len() - 1;
    let mut curve: Vec<DVec2> = (0..last)
        .flat_map(|k| {
            let [p0, p1, p2, p3] = [p[k.saturating_sub(1)], p[k], p[k + 1], p[(k + 2).min(last)]];
            (0..steps).map(move |s| {
                let t = s as f64 / steps as f64;
                let (t2, t3) = (t * t, t * t * t);
                0.5 * ((2.0 * p1)
                    + (p2 - p0) * t
                    + (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) * t2
                    + (3.0 * p1 - p0 - 3.0 * p2 + p3) * t3)
            })
        })
        .collect();
    curve.push(p[last]);
    curve
}

/// An open vessel of revolution about +z. `outside` runs (radius, z) from the foot to the rim; the inside
/// lies `wall_m` within it, measured across the wall, and has its floor at z = `floor_m`.
pub(crate) fn vessel(outside: &[DVec2], wall_m: f64, floor_m: f64, segments: usize) -> Solid {
    let n = outside.len();
    let inward = |k: usize| {
        let along = (outside[(k + 1).min(n - 1)] - outside[k.saturating_sub(1)]).normalize_or_zero();
        along.perp()
    };
    let mut profile = vec![DVec2::new(0.0, outside[0].y)];
    profile.extend_from_slice(outside);
    let rim = outside[n - 1];
    profile.push(rim + 0.5 * wall_m * inward(n - 1) + 0.35 * wall_m * DVec2::Y);
    for k in (0..n).rev() {
        let inner = outside[k] + wall_m * inward(k);
        let inner = DVec2::new(inner.x, inner.y.max(floor_m));
        if inner.x > 1e-4 {
            profile.push(inner);
        }
        if inner.y <= floor_m {
            break;
        }
    }
    profile.push(DVec2::new(0.0, floor_m));
    lathe(&profile, segments)
}

/// The solid with every point moved by `f`, normals recomputed.
pub(super) fn deformed(solid: Solid, f: impl Fn(DVec3) -> DVec3) -> Solid {
    let positions: Vec<DVec3> = solid.positions.iter().map(|&p| f(p)).collect();
    Solid::from_corners(&positions, &solid.uvs, &solid.triangles)
}

/// The solid with everything below `low_z_m` pressed onto that plane: a facet to rest on.
pub(super) fn flattened(solid: Solid, low_z_m: f64) -> Solid {
    deformed(solid, |p| DVec3::new(p.x, p.y, p.z.max(low_z_m)))
}

/// The finished mesh stretched to exactly `size_m` (a few percent per axis) and seated.
pub(super) fn fitted(mesh: TexturedMesh, size_m: DVec3) -> TexturedMesh {
    let scale = size_m / mesh.size_m();
    mesh.scaled(scale).seated()
}

/// As [`fitted`], with one common factor for x and y, for bodies of revolution.
pub(super) fn fitted_round(mesh: TexturedMesh, size_m: DVec3) -> TexturedMesh {
    let built = mesh.size_m();
    let across = (size_m.x + size_m.y) / (built.x + built.y);
    mesh.scaled(DVec3::new(across, across, size_m.z / built.z)).seated()
}

/// Adds one closed solid with different materials, chosen by each triangle's center
/// and outward normal.
pub(super) fn add_by(
    mesh: &mut TexturedMesh,
    solid: Solid,
    materials: &[&Material],
    choose: impl Fn(DVec3, DVec3) -> usize,
) {
    let mut parts: Vec<Vec<[u32; 3]>> = vec![Vec::new(); materials.len()];
    for t in &solid.triangles {
        let [a, b, c] = t.map(|v| solid.positions[v as usize]);
        parts[choose((a + b + c) / 3.0, (b - a).cross(c - a).normalize_or_zero())].push(*t);
    }
    for (triangles, material) in parts.into_iter().zip(materials) {
        if triangles.is_empty() {
            continue;
        }
        let mut number = vec![u32::MAX; solid.positions.len()];
        let mut part = Solid::default();
        for t in triangles {
            part.triangles.push(t.map(|v| {
                let v = v as usize;
                if number[v] == u32::MAX {
                    number[v] = part.positions.len() as u32;
                    part.positions.push(solid.positions[v]);
                    part.normals.push(solid.normals[v]);
                    part.uvs.push(solid.uvs[v]);
                }
                number[v]
            }));
        }
        mesh.add(part, material);
    }
}

/// A paper band around a body of revolution of `radius_m`, from z = `low_m` to `high_m`, its image's center in
/// front; 0.6 mm proud of the body, 1.3 mm thick.
pub(super) fn label_band(radius_m: f64, low_m: f64, high_m: f64, segments: usize) -> Solid {
    let (inner, outer) = (radius_m - 0.0007, radius_m + 0.0006);
    let rings: Vec<Vec<DVec3>> = [(inner, low_m), (outer, low_m), (outer, high_m), (inner, high_m)]
        .iter()
        .map(|&(r, z)| circle(r, segments).into_iter().map(|p| p.extend(z)).collect())
        .collect();
    wrapped_around(loft_closed(&rings))
}

/// The solid with its image repeated `u` x `v` times.
pub(super) fn repeated(mut solid: Solid, u: f32, v: f32) -> Solid {
    solid.uvs.iter_mut().for_each(|uv| *uv *= Vec2::new(u, v));
    solid
}

/// Distance of the center of a wall of revolution from the axis at a height; `outside` as in [`vessel`].
pub(super) fn wall_radius_m(outside: &[DVec2], wall_m: f64, z_m: f64) -> f64 {
    let above = outside.iter().position(|p| p.y > z_m).unwrap_or(outside.len() - 1).max(1);
    let (low, high) = (outside[above - 1], outside[above]);
    let share = ((z_m - low.y) / (high.y - low.y).max(1e-9)).clamp(0.0, 1.0);
    low.lerp(high, share).x - 0.5 * wall_m
}

/// A loop handle in the x-z plane toward +x: half an ellipse, sheared so that it ends at the distances
/// `roots_m` from the axis, z + height/2 and z - height/2, and reaches `reach_m` farther outward (to the bar's
/// center); flat-oval bar of `thick_m` x `wide_m`.
pub(super) fn loop_handle(
    roots_m: [f64; 2],
    reach_m: f64,
    z_m: f64,
    height_m: f64,
    thick_m: f64,
    wide_m: f64,
) -> Solid {
    let path: Vec<DVec3> = (0..=16)
        .map(|k| {
            let angle = PI * (0.5 - f64::from(k) / 16.0);
            let bulge = angle.cos().powf(0.75);
            let root_m = roots_m[1] + 0.5 * (roots_m[0] - roots_m[1]) * (1.0 + angle.sin());
            DVec3::new(root_m + reach_m * bulge, 0.0, z_m + 0.5 * height_m * angle.sin())
        })
        .collect();
    sweep(&path, &ellipse(thick_m, wide_m, 14), DVec3::Y, |_| 1.0)
}

/// A bar along y through `stations` (y, z of the underside, width, thickness), smoothly interpolated;
/// its cross-sections are rounded rectangles square to y.
pub(super) fn ribbon(stations: &[[f64; 4]], steps: usize) -> Solid {
    let track = |column: usize| {
        let pairs: Vec<(f64, f64)> = stations.iter().map(|s| (s[0], s[column])).collect();
        spline(&pairs, steps)
    };
    let (z, width, thick) = (track(1), track(2), track(3));
    let rings: Vec<Vec<DVec3>> = (0..z.len())
        .map(|k| {
            let (w, t) = (width[k].y.max(1e-3), thick[k].y.max(1e-3));
            rounded_rectangle(w, t, 0.35 * t.min(w), 2)
                .into_iter()
                .map(|p| DVec3::new(-p.x, z[k].x, z[k].y + 0.5 * t + p.y))
                .collect()
        })
        .collect();
    loft(&rings)
}

/// The requested material, else the usual one.
pub(super) fn finish(order: &mut Order, usual: Material) -> Material {
    match order.material {
        Some(name) if is_finish(name) => material_finish(name, order.color, &mut order.rng),
        _ => usual,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wall_center_matches_the_revolved_profile() {
        let cone = points(&[(0.02, 0.0), (0.04, 0.1)]);
        for (z_m, radius_m) in [(0.0, 0.018), (0.05, 0.028), (0.1, 0.038), (0.3, 0.038)] {
            assert!((wall_radius_m(&cone, 0.004, z_m) - radius_m).abs() < 1e-12, "{z_m}");
        }
    }

    #[test]
    fn shared_solids_are_closed() {
        let bowl = vessel(&spline(&[(0.04, 0.0), (0.07, 0.03), (0.08, 0.06)], 5), 0.003, 0.004, 32);
        assert!(bowl.is_watertight() && bowl.volume_m3() > 0.0);
        let grip = loop_handle([0.04, 0.038], 0.03, 0.05, 0.06, 0.007, 0.01);
        assert!(grip.is_watertight() && grip.volume_m3() > 0.0);
        let bar = ribbon(&[[-0.1, 0.0, 0.02, 0.003], [0.0, 0.01, 0.01, 0.003], [0.1, 0.0, 0.02, 0.003]], 6);
        assert!(bar.is_watertight() && bar.volume_m3() > 0.0, "{}", bar.volume_m3());
    }
}
