//! The forms of parts, and deformations that apply to all of them.

use std::f64::consts::TAU;

use glam::DVec3;

use super::forms::{Ball, Block, Cylinder, Extrusion, Hoop, Loft, Revolution, Silhouette, Torus, Tube};
use super::table_error::TableError;
use crate::Order;
use geometry::{Solid, Vec3};

/// One of the forms; each standing on z = 0 unless its documentation says otherwise.
#[derive(Clone, Debug)]
pub(super) enum Form {
    Block(Block),
    Cylinder(Cylinder),
    Ball(Ball),
    Revolution(Revolution),
    Hoop(Hoop),
    Torus(Torus),
    Tube(Tube),
    Extrusion(Extrusion),
    Loft(Loft),
    Silhouette(Silhouette),
}

impl Form {
    /// The closed solid with outward faces, meters.
    pub fn solid(&self) -> Solid {
        match self {
            Self::Block(form) => form.solid(),
            Self::Cylinder(form) => form.solid(),
            Self::Ball(form) => form.solid(),
            Self::Revolution(form) => form.solid(),
            Self::Hoop(form) => form.solid(),
            Self::Torus(form) => form.solid(),
            Self::Tube(form) => form.solid(),
            Self::Extrusion(form) => form.solid(),
            Self::Loft(form) => form.solid(),
            Self::Silhouette(form) => form.solid(),
        }
    }

    /// Refuses what has too few points to be a solid.
    pub fn check_points(&self) -> Result<(), TableError> {
        let (points, needed) = match self {
            Self::Revolution(form) => (form.profile.len(), 2),
            Self::Hoop(form) => (form.section.len(), 3),
            Self::Tube(form) => (form.point_count(), 2),
            Self::Extrusion(form) => (form.outline.len(), 3),
            Self::Loft(form) => (form.sections.len(), 2),
            Self::Silhouette(form) => (form.outline.len(), 3),
            Self::Block(_) | Self::Cylinder(_) | Self::Ball(_) | Self::Torus(_) => (0, 0),
        };
        if points < needed {
            return Err(TableError::TooFewPoints { points, needed, form: format!("{self:?}") });
        }
        Ok(())
    }

    /// Whether its surface is closed and encloses a positive volume. Builds it, which takes longer than reading it.
    pub fn is_solid(&self) -> bool {
        let solid = self.solid();
        solid.is_watertight() && solid.volume_m3() > 0.0
    }
}

/// The solid with everything below `floor_m` pressed up to it.
pub(super) fn rested(solid: Solid, floor_m: f64) -> Solid {
    if solid.positions.iter().all(|p| p.z >= floor_m) {
        return solid;
    }
    let positions: Vec<DVec3> =
        solid.positions.iter().map(|p| DVec3::new(p.x, p.y, p.z.max(floor_m))).collect();
    let mut flat = Solid::from_corners(&positions, &solid.uvs, &solid.triangles);
    // Slivers pressed into the plane have no normal of their own.
    flat.normals.iter_mut().filter(|n| n.length_squared() < 0.5).for_each(|n| *n = Vec3::NEG_Z);
    flat
}

/// The solid with bumps: each point moves away from the center of the box or toward it by up to `amplitude` of its
/// distance. The bumps depend on the direction and on the order's random stream.
pub(super) fn bumpy(solid: Solid, amplitude: f64, order: &mut Order) -> Solid {
    let (low, high) = solid
        .positions
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let (center, half) = (0.5 * (low + high), (0.5 * (high - low)).max(DVec3::splat(1e-9)));
    let waves: Vec<(DVec3, f64)> = (0..6)
        .map(|_| {
            let mut frequency = || order.uniform(-5.0, 5.0);
            let direction = DVec3::new(frequency(), frequency(), frequency());
            (direction, order.uniform(0.0, TAU))
        })
        .collect();
    let moved = |p: &DVec3| {
        let direction = ((*p - center) / half).normalize_or_zero();
        let height: f64 = waves.iter().map(|(wave, phase)| (wave.dot(direction) + phase).sin()).sum();
        center + (*p - center) * (1.0 + amplitude * height / 3.0)
    };
    let positions: Vec<DVec3> = solid.positions.iter().map(moved).collect();
    Solid::from_corners(&positions, &solid.uvs, &solid.triangles)
}
