//! A part of a closed shell inside a convex cell, cut exactly.
//!
//! A piece keeps the polygons that remain of the shell's triangles and the corners of its cell that
//! lie inside the solid. Together their corners span the convex hull of (solid in the cell): where
//! the solid meets a face or an edge of the cell, it does so along clipped polygons. No caps are built, so
//! results do not depend on their triangulation.

use std::collections::HashMap;

use glam::DVec3;

use super::plane::Plane;
use crate::shells::Shell;

/// Distance up to which corners count as on a cutting plane, meters: above the rounding of single-precision
/// positions, far below visible sizes.
const ON_PLANE_M: f64 = 1e-6;

/// Polygons of a shell inside a convex cell. Object frame, meters.
#[derive(Clone, Default)]
pub(super) struct Piece {
    pub points: Vec<DVec3>,
    /// Corners of all polygons, one after another, indices into `points`.
    corners: Vec<u32>,
    polygons: Vec<Polygon>,
    /// Faces of the cell; the piece lies below each.
    cell: Vec<Plane>,
    /// Corners of the cell inside the solid.
    inner: Vec<DVec3>,
    /// Signed triangles that close the piece along the faces of its cell. Their signed sum covers the cut exactly;
    /// single triangles may extend outside it. For integrals only.
    caps: Vec<[DVec3; 3]>,
}

#[derive(Clone, Copy)]
struct Polygon {
    first: u32,
    count: u32,
    normal: DVec3,
}

/// One polygon, for other modules.
pub(super) struct Face<'a> {
    pub corners: &'a [u32],
    /// Unit, away from the solid.
    pub normal: DVec3,
}

impl Piece {
    pub(super) fn new(shell: &Shell) -> Self {
        let mut piece = Self { points: shell.points.clone(), ..Self::default() };
        for (t, [a, b, c]) in shell.triangles.iter().zip(shell.corners()) {
            if let Some(normal) = (b - a).cross(c - a).try_normalize() {
                piece.polygons.push(Polygon { first: piece.corners.len() as u32, count: 3, normal });
                piece.corners.extend(t);
            }
        }
        piece
    }

    pub(super) fn faces(&self) -> impl Iterator<Item = Face<'_>> + '_ {
        self.polygons.iter().map(|p| Face {
            corners: &self.corners[p.first as usize..(p.first + p.count) as usize],
            normal: p.normal,
        })
    }

    /// Faces of the cell.
    pub(super) fn cell(&self) -> &[Plane] {
        &self.cell
    }

    /// Corners of the cell inside the solid.
    pub(super) fn inner(&self) -> &[DVec3] {
        &self.inner
    }

    /// Volume of the solid in the cell, m^3.
    pub(super) fn volume_m3(&self) -> f64 {
        let origin = self.points.first().copied().unwrap_or(DVec3::ZERO);
        let cone = |[a, b, c]: [DVec3; 3]| (a - origin).dot((b - origin).cross(c - origin)) / 6.0;
        let surface = self.faces().flat_map(|face| {
            let at = |k: usize| self.points[face.corners[k] as usize];
            (2..face.corners.len()).map(move |k| cone([at(0), at(k - 1), at(k)]))
        });
        surface.sum::<f64>() + self.caps.iter().map(|&cap| cone(cap)).sum::<f64>()
    }

    /// Points whose convex hull is that of the solid in the cell.
    pub(super) fn spanning_points(&self) -> Vec<DVec3> {
        self.points.iter().chain(&self.inner).copied().collect()
    }

    /// Height of every point above the plane, zero on it.
    pub(super) fn heights_m(&self, plane: &Plane) -> Vec<f64> {
        self.points
            .iter()
            .map(|&p| plane.height_m(p))
            .map(|h| if h.abs() < ON_PLANE_M { 0.0 } else { h })
            .collect()
    }

    /// The parts below and above the plane; `None` unless there is surface on both sides.
    pub(super) fn split(&self, plane: &Plane, is_inside: impl Fn(DVec3) -> bool) -> Option<(Piece, Piece)> {
        let (mut below, mut above) = self.split_open(plane, is_inside)?;
        self.close(plane, &mut below, &mut above);
        Some((below, above))
    }

    /// As [`split`](Self::split), but the parts have no volume until they are [closed](Self::close).
    pub(super) fn split_open(
        &self,
        plane: &Plane,
        is_inside: impl Fn(DVec3) -> bool,
    ) -> Option<(Piece, Piece)> {
        let heights = self.heights_m(plane);
        let mut below = Builder::new(self.points.len());
        let mut above = Builder::new(self.points.len());
        for face in self.faces() {
            match side(&face, &heights, plane) {
                Side::Below => below.add(self, &face, &heights, -1.0),
                Side::Above => above.add(self, &face, &heights, 1.0),
                Side::Both => {
                    below.add(self, &face, &heights, -1.0);
                    above.add(self, &face, &heights, 1.0);
                }
            }
        }
        let (mut below, mut above) = (below.piece, above.piece);
        if below.polygons.is_empty() || above.polygons.is_empty() {
            return None;
        }
        for &corner in &self.inner {
            let height = plane.height_m(corner);
            if height <= ON_PLANE_M {
                below.inner.push(corner);
            }
            if height >= -ON_PLANE_M {
                above.inner.push(corner);
            }
        }
        for corner in self.new_cell_corners(plane) {
            if is_inside(corner) {
                below.inner.push(corner);
                above.inner.push(corner);
            }
        }
        below.cell = self.cell.iter().copied().chain([*plane]).collect();
        above.cell = self.cell.iter().copied().chain([plane.flipped()]).collect();
        Some((below, above))
    }

    /// Closes the parts that the plane made of this piece.
    pub(super) fn close(&self, plane: &Plane, below: &mut Piece, above: &mut Piece) {
        below.take_caps(self, plane, -1.0);
        above.take_caps(self, plane, 1.0);
    }

    /// Takes over the part of another piece's caps on one side of the plane, and closes the cut along it.
    fn take_caps(&mut self, from: &Piece, plane: &Plane, sign: f64) {
        let mut rim: Vec<(DVec3, DVec3)> = Vec::new();
        let height = |p: DVec3| {
            let height = plane.height_m(p);
            if height.abs() < ON_PLANE_M { 0.0 } else { height }
        };
        for cap in &from.caps {
            let heights = cap.map(height);
            // A cap in the plane belongs to the part that it closes.
            if heights == [0.0; 3] {
                let toward = (cap[1] - cap[0]).cross(cap[2] - cap[0]).dot(plane.normal);
                if toward * sign < 0.0 {
                    self.caps.push(*cap);
                }
                continue;
            }
            let mut corners: Vec<DVec3> = Vec::with_capacity(4);
            let face = Face { corners: &[0, 1, 2], normal: DVec3::ZERO };
            clipped(&face, &heights, sign, |a, b| corners.push(crossing(cap, &heights, a, b)));
            if corners.len() < 3 {
                continue;
            }
            self.caps.extend((2..corners.len()).map(|k| [corners[0], corners[k - 1], corners[k]]));
            rim.extend(edges_on(plane, corners.iter().copied()));
        }
        for polygon in &self.polygons {
            let own = &self.corners[polygon.first as usize..(polygon.first + polygon.count) as usize];
            rim.extend(edges_on(plane, own.iter().map(|&c| self.points[c as usize])));
        }
        let Some(&(apex, _)) = rim.first() else { return };
        self.caps
            .extend(rim.into_iter().filter(|(a, b)| *a != apex && *b != apex).map(|(a, b)| [apex, b, a]));
    }

    /// Intersections of the plane with the edges of the cell.
    fn new_cell_corners(&self, plane: &Plane) -> Vec<DVec3> {
        let mut corners = Vec::new();
        for (k, a) in self.cell.iter().enumerate() {
            for b in &self.cell[..k] {
                let meet = plane.meet(a, b);
                corners.extend(meet.filter(|&p| self.cell.iter().all(|face| face.height_m(p) <= ON_PLANE_M)));
            }
        }
        corners
    }
}

/// Edges of a polygon that lie on the plane, unless the whole polygon does.
fn edges_on(plane: &Plane, corners: impl ExactSizeIterator<Item = DVec3>) -> Vec<(DVec3, DVec3)> {
    let corners: Vec<(DVec3, bool)> = corners.map(|p| (p, plane.height_m(p).abs() < ON_PLANE_M)).collect();
    let n = corners.len();
    (0..n)
        .map(|k| (corners[k], corners[(k + 1) % n]))
        .filter(|((_, a), (_, b))| *a && *b)
        .map(|((a, _), (b, _))| (a, b))
        .collect()
}

/// Position of a polygon relative to a plane.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Below,
    Above,
    Both,
}

/// Side of the plane on which a polygon lies. A polygon in the plane belongs to the side of its solid.
pub(super) fn side(face: &Face, heights_m: &[f64], plane: &Plane) -> Side {
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    for &c in face.corners {
        low = low.min(heights_m[c as usize]);
        high = high.max(heights_m[c as usize]);
    }
    match (low < 0.0, high > 0.0) {
        (true, true) => Side::Both,
        (true, false) => Side::Below,
        (false, true) => Side::Above,
        (false, false) if face.normal.dot(plane.normal) > 0.0 => Side::Below,
        (false, false) => Side::Above,
    }
}

/// Visits the corners of a polygon that remain on one side (`sign` -1 below, 1 above): corners of its own
/// as `(a, a)`, crossings of an edge as `(a, b)` with a < b.
pub(super) fn clipped(face: &Face, heights_m: &[f64], sign: f64, mut corner: impl FnMut(u32, u32)) {
    let n = face.corners.len();
    for k in 0..n {
        let (a, b) = (face.corners[k], face.corners[(k + 1) % n]);
        let (at_a, at_b) = (sign * heights_m[a as usize], sign * heights_m[b as usize]);
        if at_a >= 0.0 {
            corner(a, a);
        }
        if at_a * at_b < 0.0 {
            corner(a.min(b), a.max(b));
        }
    }
}

/// The point where edge (a, b) crosses the plane, the same for both polygons that share it.
pub(super) fn crossing(points: &[DVec3], heights_m: &[f64], a: u32, b: u32) -> DVec3 {
    let (a, b) = (a as usize, b as usize);
    if a == b {
        return points[a];
    }
    points[a] + heights_m[a] / (heights_m[a] - heights_m[b]) * (points[b] - points[a])
}

struct Builder {
    piece: Piece,
    own: Vec<u32>,
    crossings: HashMap<(u32, u32), u32>,
}

impl Builder {
    fn new(points: usize) -> Self {
        Self { piece: Piece::default(), own: vec![u32::MAX; points], crossings: HashMap::new() }
    }

    fn add(&mut self, from: &Piece, face: &Face, heights_m: &[f64], sign: f64) {
        let first = self.piece.corners.len();
        clipped(face, heights_m, sign, |a, b| {
            let points = &mut self.piece.points;
            let next = points.len() as u32;
            let index = if a == b {
                &mut self.own[a as usize]
            } else {
                self.crossings.entry((a, b)).or_insert(u32::MAX)
            };
            if *index == u32::MAX {
                *index = next;
                points.push(crossing(&from.points, heights_m, a, b));
            }
            self.piece.corners.push(*index);
        });
        let count = self.piece.corners.len() - first;
        if count < 3 {
            self.piece.corners.truncate(first);
            return;
        }
        self.piece.polygons.push(Polygon { first: first as u32, count: count as u32, normal: face.normal });
    }
}
