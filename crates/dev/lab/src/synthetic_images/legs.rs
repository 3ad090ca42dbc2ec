//! Table supports: legs of many kinds, panels, columns, aprons.
//!
//! Parts extend from the underside of the top (world z < 0) down to the floor. They may intersect each other.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rand::RngExt;

use super::sampling::{chance, uniform, weighted};
use super::shape::TableShape;
use geometry::shapes::{block, circle, inset, lathe, loft, prism, rectangle, rounded_rectangle, tube};
use geometry::{Material, Outline, TexturedMesh};
use runtime::seed::Rng;

/// The space for the legs: the edge and underside of the top, and the floor.
pub(super) struct LegSpace<'a> {
    pub shape: TableShape,
    pub outline: &'a Outline,
    pub underside_m: f64,
    pub floor_m: f64,
}

#[derive(Clone, Copy)]
enum Kind {
    Square,
    Splayed,
    Hairpin,
    Panels,
    Pedestal,
    Block,
}

/// Adds legs of a random kind.
pub(super) fn add(mesh: &mut TexturedMesh, under: &LegSpace, material: &Material, rng: &mut Rng) {
    let round = matches!(under.shape, TableShape::Round | TableShape::Oval);
    let pedestal = if round { 3.0 } else { 0.4 };
    let kind = weighted(
        rng,
        &[
            (Kind::Square, if round { 1.0 } else { 5.0 }),
            (Kind::Splayed, 3.0),
            (Kind::Hairpin, 0.7),
            (Kind::Panels, 0.8),
            (Kind::Pedestal, pedestal),
            (Kind::Block, 0.3),
        ],
    );
    match kind {
        Kind::Square => {
            let (side, taper) = (uniform(rng, 0.025, 0.09), uniform(rng, 0.5, 1.0));
            let inward = 0.5 * side + uniform(rng, 0.005, 0.07);
            let heads = under.leg_heads(rng, inward);
            for head in &heads {
                let ring =
                    |z: f64, side: f64| lifted(&rounded_rectangle(side, side, 0.1 * side, 2), *head, z);
                let leg = loft(&[ring(under.floor_m, taper * side), ring(under.underside_m + 0.001, side)]);
                mesh.add(leg, material);
            }
            if chance(rng, 0.65) {
                add_apron(mesh, under, &heads, material, rng);
            }
            if chance(rng, 0.2) && heads.len() == 4 {
                add_shelf(mesh, under, &heads, material, rng);
            }
        }
        Kind::Splayed => {
            let radius = uniform(rng, 0.014, 0.04);
            let inward = radius + uniform(rng, 0.04, 0.14);
            let heads = under.leg_heads(rng, inward);
            let spread = uniform(rng, 0.0, 0.12);
            let tip =
                chance(rng, 0.2).then(|| Material::metal("tip", geometry::Rgb([0.75, 0.62, 0.35]), 0.3));
            for head in &heads {
                let foot = *head + spread * head.normalize_or_zero();
                let taper = uniform(rng, 0.45, 0.9);
                let at = |t: f64| head.lerp(foot, t);
                let z = |t: f64| under.underside_m + 0.001 + t * (under.floor_m - under.underside_m - 0.001);
                let ring = |t: f64| {
                    let r = radius * (1.0 + (taper - 1.0) * t);
                    lifted(&circle(r, 16), at(t), z(t))
                };
                let knee = if tip.is_some() { 0.9 } else { 1.0 };
                mesh.add(loft(&[ring(knee), ring(0.0)]), material);
                if let Some(tip) = &tip {
                    mesh.add(loft(&[ring(1.0), ring(knee - 0.002)]), tip);
                }
            }
            if chance(rng, 0.35) {
                add_apron(mesh, under, &heads, material, rng);
            }
        }
        Kind::Hairpin => {
            let inward = uniform(rng, 0.04, 0.12);
            let heads = under.leg_heads(rng, inward);
            let radius = uniform(rng, 0.004, 0.009);
            for head in &heads {
                let outward = head.normalize_or(DVec2::X);
                let side = 0.05 * outward.perp();
                let foot = (*head + 0.03 * outward).extend(under.floor_m + radius);
                let top = under.underside_m + 0.001;
                let path = [
                    (*head - side).extend(top),
                    foot - 0.1 * side.extend(0.0),
                    foot + 0.1 * side.extend(0.0),
                    (*head + side).extend(top),
                ];
                mesh.add(tube(&path, radius, 8), material);
            }
        }
        Kind::Panels => {
            let (low, high) = under.outline.bounds();
            let thick = uniform(rng, 0.02, 0.06);
            let x = (0.5 - uniform(rng, 0.04, 0.22)) * (high.x - low.x);
            for side in [-1.0, 1.0] {
                let reach = under.reach(DVec2::new(side * x, 0.0), DVec2::Y, 0.02).max(0.05);
                let size = DVec3::new(
                    thick,
                    2.0 * uniform(rng, 0.6, 0.95) * reach,
                    under.underside_m - under.floor_m + 0.001,
                );
                mesh.add(block(size).translated(DVec3::new(side * x, 0.0, under.floor_m)), material);
            }
            if chance(rng, 0.5) {
                let size = DVec3::new(2.0 * x, 0.02, uniform(rng, 0.08, 0.4));
                let z = under.underside_m + 0.001 - size.z - uniform(rng, 0.0, 0.1);
                mesh.add(block(size).translated(DVec3::new(0.0, 0.0, z)), material);
            }
        }
        Kind::Pedestal => add_pedestal(mesh, under, material, rng),
        Kind::Block => {
            let inner = inset(under.outline.corners(), uniform(rng, 0.01, 0.1));
            if let Ok(inner) = Outline::new(inner) {
                let foot = prism(inner.corners(), under.underside_m - under.floor_m + 0.001);
                mesh.add(foot.translated(DVec3::new(0.0, 0.0, under.floor_m)), material);
            }
        }
    }
}

impl LegSpace<'_> {
    /// Leg positions, `inward_m` from the edge, counter-clockwise.
    fn leg_heads(&self, rng: &mut Rng, inward_m: f64) -> Vec<DVec2> {
        let (low, high) = self.outline.bounds();
        if self.shape == TableShape::Rectangle {
            let (low, high) = (low + inward_m, high - inward_m);
            return [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)]
                .map(|(x, y)| DVec2::new(x, y))
                .to_vec();
        }
        let count = match self.shape {
            TableShape::Triangle => 3,
            TableShape::Round => rng.random_range(3..5),
            _ => 4,
        };
        let turn = match self.shape {
            TableShape::Triangle => {
                // Toward the corners: the farthest points of the edge.
                let far = |a: &&DVec2, b: &&DVec2| a.length().total_cmp(&b.length());
                self.outline.corners().iter().max_by(far).map_or(0.0, |p| p.to_angle())
            }
            _ if chance(rng, 0.5) => 0.125 * TAU,
            _ => uniform(rng, 0.0, TAU),
        };
        (0..count)
            .map(|k| {
                let direction = DVec2::from_angle(turn + TAU * f64::from(k) / f64::from(count));
                self.reach(DVec2::ZERO, direction, inward_m) * direction
            })
            .collect()
    }

    /// Distance from a point along a unit direction up to which the top extends `inward_m` further, meters.
    fn reach(&self, from: DVec2, direction: DVec2, inward_m: f64) -> f64 {
        let (mut inside, mut outside) = (0.0, 2.0);
        for _ in 0..24 {
            let center = 0.5 * (inside + outside);
            if self.outline.depth_inside_m(from + center * direction) >= inward_m {
                inside = center;
            } else {
                outside = center;
            }
        }
        inside
    }
}

fn lifted(ring: &[DVec2], at: DVec2, z_m: f64) -> Vec<DVec3> {
    ring.iter().map(|p| (*p + at).extend(z_m)).collect()
}

/// Boards under the top from leg to leg.
fn add_apron(mesh: &mut TexturedMesh, under: &LegSpace, heads: &[DVec2], material: &Material, rng: &mut Rng) {
    let (height, thick) = (uniform(rng, 0.03, 0.13), uniform(rng, 0.012, 0.03));
    for k in 0..heads.len() {
        add_bar(
            mesh,
            heads[k],
            heads[(k + 1) % heads.len()],
            under.underside_m + 0.001,
            height,
            thick,
            material,
        );
    }
}

/// A low shelf, or bars between the legs.
fn add_shelf(mesh: &mut TexturedMesh, under: &LegSpace, heads: &[DVec2], material: &Material, rng: &mut Rng) {
    let z = under.floor_m + uniform(rng, 0.08, 0.35) * (under.underside_m - under.floor_m);
    if chance(rng, 0.5) {
        let span = heads[2] - heads[0];
        mesh.add(
            block(span.abs().extend(0.018)).translated((0.5 * (heads[0] + heads[2])).extend(z)),
            material,
        );
    } else {
        for k in 0..4 {
            add_bar(mesh, heads[k], heads[(k + 1) % 4], z, 0.03, 0.02, material);
        }
    }
}

/// An upright board between two points below `top_m`.
fn add_bar(
    mesh: &mut TexturedMesh,
    a: DVec2,
    b: DVec2,
    top_m: f64,
    height_m: f64,
    thick_m: f64,
    material: &Material,
) {
    let along = b - a;
    let bar = prism(&rectangle(along.length(), thick_m), height_m)
        .rotated(glam::DQuat::from_rotation_z(along.to_angle()))
        .translated((0.5 * (a + b)).extend(top_m - height_m));
    mesh.add(bar, material);
}

/// A column, turned or plain, on a disc or on feet.
fn add_pedestal(mesh: &mut TexturedMesh, under: &LegSpace, material: &Material, rng: &mut Rng) {
    let height = under.underside_m - under.floor_m + 0.001;
    let (low, high) = under.outline.bounds();
    let half = 0.5 * (high - low).min_element();
    let radius = uniform(rng, 0.025, 0.09).min(0.4 * half);
    let base = uniform(rng, 0.45, 0.75) * half;
    let foot = uniform(rng, 0.012, 0.035);
    let on_disc = chance(rng, 0.6);
    let mut profile = vec![DVec2::ZERO];
    if on_disc {
        profile.extend([DVec2::new(base, 0.0), DVec2::new(base, foot), DVec2::new(radius, 1.8 * foot)]);
    } else {
        profile.push(DVec2::new(radius, 0.05));
        profile[0].y = 0.05;
    }
    let swell = uniform(rng, 0.6, 1.4);
    for k in 1..6 {
        let t = f64::from(k) / 6.0;
        profile.push(DVec2::new(radius * (1.0 + (swell - 1.0) * (0.5 * TAU * t).sin()), t.max(0.1) * height));
    }
    profile.extend([
        DVec2::new(radius, height - 0.02),
        DVec2::new(2.0 * radius, height),
        DVec2::new(0.0, height),
    ]);
    mesh.add(lathe(&profile, 32).translated(DVec3::new(0.0, 0.0, under.floor_m)), material);
    if !on_disc {
        let (count, turn) = (rng.random_range(3..6), uniform(rng, 0.0, TAU));
        for k in 0..count {
            let direction = DVec2::from_angle(turn + TAU * f64::from(k) / f64::from(count));
            let ring = |reach: f64, z: f64, size: f64| -> Vec<DVec3> {
                let side = direction.perp();
                rectangle(0.05, size)
                    .iter()
                    .map(|p| (reach * direction + p.x * side).extend(under.floor_m + z + p.y))
                    .collect()
            };
            mesh.add(loft(&[ring(0.0, 0.1, 0.1), ring(base, 0.0125, 0.025)]), material);
        }
    }
}
