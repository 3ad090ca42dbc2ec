//! Parts of a solid's surface that have a surface of their own.

use serde::Deserialize;

use geometry::{DVec3, Solid};

/// The triangles of a part that meet every condition given, and their surface. Conditions are in the form's own frame,
/// before its placement.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Faces {
    facing: Option<Facing>,
    /// Bounds of the height of the triangle's center, meters.
    above: Option<f64>,
    below: Option<f64>,
    /// Bounds of the distance of the triangle's center from the form's vertical axis, meters.
    within: Option<f64>,
    beyond: Option<f64>,
    pub surface: String,
}

/// Direction of a triangle's outward normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Facing {
    Up,
    Down,
    /// Toward -y.
    Front,
    Back,
    /// Toward -x.
    Left,
    Right,
    /// Toward the vertical axis, or up in the lower half of the form: the inside of a vessel.
    Inside,
    /// Neither inside nor up.
    Outside,
}

/// Share of a normal along a direction from which the triangle faces it.
const FACING_COSINE: f64 = 0.7;

/// The same for the direction toward the axis. The two triangles of a quad on a rim differ by less, so that both are
/// inside or neither.
const INWARD_COSINE: f64 = 0.05;

impl Facing {
    fn is_met(self, center: DVec3, normal: DVec3, center_z_m: f64) -> bool {
        let toward_axis = normal.dot(center.with_z(0.0).normalize_or_zero()) < -INWARD_COSINE;
        match self {
            Self::Up => normal.z > FACING_COSINE,
            Self::Down => normal.z < -FACING_COSINE,
            Self::Front => normal.y < -FACING_COSINE,
            Self::Back => normal.y > FACING_COSINE,
            Self::Left => normal.x < -FACING_COSINE,
            Self::Right => normal.x > FACING_COSINE,
            Self::Inside => toward_axis || (normal.z > 0.5 && center.z < center_z_m),
            Self::Outside => !toward_axis && normal.z < FACING_COSINE,
        }
    }
}

impl Faces {
    fn have(&self, center: DVec3, normal: DVec3, center_z_m: f64) -> bool {
        let radius_m = center.truncate().length();
        self.facing.is_none_or(|facing| facing.is_met(center, normal, center_z_m))
            && self.above.is_none_or(|z_m| center.z > z_m)
            && self.below.is_none_or(|z_m| center.z < z_m)
            && self.within.is_none_or(|within_m| radius_m < within_m)
            && self.beyond.is_none_or(|beyond_m| radius_m > beyond_m)
    }
}

/// The solid in pieces that have one surface each: that of the first entry whose conditions a triangle meets, else
/// `usual`. The pieces together are closed as the solid is.
pub(super) fn split<'a>(solid: Solid, usual: &'a str, faces: &'a [Faces]) -> Vec<(&'a str, Solid)> {
    if faces.is_empty() {
        return vec![(usual, solid)];
    }
    let (low_m, high_m) = solid
        .positions
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.z), high.max(p.z)));
    let center_z_m = 0.5 * (low_m + high_m);
    let mut triangles: Vec<Vec<[u32; 3]>> = vec![Vec::new(); faces.len() + 1];
    for triangle in &solid.triangles {
        let [a, b, c] = triangle.map(|v| solid.positions[v as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let piece = faces.iter().position(|faces| faces.have((a + b + c) / 3.0, normal, center_z_m));
        triangles[piece.unwrap_or(faces.len())].push(*triangle);
    }
    let surfaces = faces.iter().map(|faces| faces.surface.as_str()).chain([usual]);
    surfaces
        .zip(&triangles)
        .filter(|(_, triangles)| !triangles.is_empty())
        .map(|(surface, triangles)| (surface, piece_of(&solid, triangles)))
        .collect()
}

/// Some triangles of the solid, with the vertices that they use.
fn piece_of(solid: &Solid, triangles: &[[u32; 3]]) -> Solid {
    let mut numbers = vec![None; solid.positions.len()];
    let mut piece = Solid::default();
    for triangle in triangles {
        let triangle = triangle.map(|v| {
            let v = v as usize;
            *numbers[v].get_or_insert_with(|| {
                piece.positions.push(solid.positions[v]);
                piece.normals.push(solid.normals[v]);
                piece.uvs.push(solid.uvs[v]);
                piece.positions.len() as u32 - 1
            })
        });
        piece.triangles.push(triangle);
    }
    piece
}
