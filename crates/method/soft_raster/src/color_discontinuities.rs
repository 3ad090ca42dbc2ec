//! Color discontinuities of a soft image inside the object, and their motion: occlusion edges, and edges at which
//! material, texture or normal change.
//!
//! Method: the antialiasing of Laine et al., "Modular primitives for high-performance differentiable rendering"
//! (2020), section 3.6. For two adjacent pixels that show different triangles, the edge of the nearer triangle (or of
//! its neighbors) that passes between their centers gives the extent of the nearer color. The pixel that the color
//! reaches into, or falls short of, is mixed with the other by that share. Nothing jumps as the edge passes a center,
//! and the mixture's derivative is the color difference times the speed of the edge. Edges nearer to upright mix
//! pixels in rows, the others pixels in columns.
//!
//! Guarantees: the same bits always. Cost: a pass over the edges, and one over the pixels at discontinuities. Not
//! covered are triangles much smaller than a pixel, whose neighbors' neighbors may have the edge, and corners: there
//! the color jumps as in the hard image, without a derivative. Surfaces that intersect each other change color where
//! their depths meet; the caller reports where.

use glam::{Vec2, Vec3};

use super::fill::Step;
use super::nearest::{NOTHING, Nearest};
use super::shading::ShadingMaterials;
use super::surface::{OTHERWISE, Side};
use super::{MovingPoint, Surface};

/// Edges at which the color is discontinuous; reuse it to save allocations.
#[derive(Debug, Default)]
pub struct ColorDiscontinuities {
    marks: Marks,
}

/// A set of edges and the triangles at them.
#[derive(Clone, Debug, Default)]
struct Marks {
    /// Of each edge: whether it breaks the color.
    color_discontinuities: Vec<bool>,
    /// Of each triangle: whether such an edge is its own, and whether it is its own or a neighbor's.
    own: Vec<bool>,
    near: Vec<bool>,
}

/// The discontinuities that are the same at any yaw.
#[derive(Debug, Default)]
pub struct Creases {
    marks: Marks,
    /// Edges that are no creases and that the silhouette's steps do not decide.
    others: Vec<u32>,
}

impl Creases {
    /// `creases` of each edge: whether the colors to its two sides are unrelated.
    pub fn new(surface: &Surface, creases: Vec<bool>, shading: &ShadingMaterials) -> Self {
        let triangles = surface.triangles.len();
        let mut found = Self::default();
        found.marks.color_discontinuities.resize(surface.edges.len(), false);
        found.marks.own.resize(triangles, false);
        found.marks.near.resize(triangles, false);
        for ((edge, crease), &pair) in (0..).zip(creases).zip(&surface.pairs) {
            match crease {
                true => found.marks.mark(edge, surface, shading),
                false if pair == OTHERWISE => found.others.push(edge),
                false => {}
            }
        }
        found
    }
}

impl Marks {
    fn copy_from(&mut self, other: &Self) {
        self.color_discontinuities.clone_from(&other.color_discontinuities);
        self.own.clone_from(&other.own);
        self.near.clone_from(&other.near);
    }

    fn mark(&mut self, edge: u32, surface: &Surface, shading: &ShadingMaterials) {
        self.color_discontinuities[edge as usize] = true;
        for side in surface.sides(&surface.edges[edge as usize]) {
            let own = &mut self.own[side.triangle as usize];
            if !std::mem::replace(own, true) {
                self.near[side.triangle as usize] = true;
                shading.beside(side.triangle).iter().for_each(|&other| self.near[other as usize] = true);
            }
        }
    }
}

/// Mixing weight of a pixel with an adjacent one, and its derivatives.
pub struct Mixture<const N: usize> {
    pub pixel: usize,
    pub with: usize,
    pub share: f32,
    pub slopes: [f32; N],
}

impl ColorDiscontinuities {
    /// Finds the edges; `clockwise` of each triangle on the screen, `steps` the silhouette's.
    pub fn find(
        &mut self,
        surface: &Surface,
        shading: &ShadingMaterials,
        clockwise: &[bool],
        steps: &[Step],
    ) {
        self.marks.copy_from(&shading.creases.marks);
        // An ordinary edge where the surface turns is a step.
        let others = shading.creases.others.iter().copied();
        for edge in steps.iter().map(|step| step.edge).chain(others) {
            let turns =
                |pair: &[Side]| clockwise[pair[0].triangle as usize] != clockwise[pair[1].triangle as usize];
            let sides = surface.sides(&surface.edges[edge as usize]);
            if !self.marks.color_discontinuities[edge as usize] && sides.windows(2).any(turns) {
                self.marks.mark(edge, surface, shading);
            }
        }
    }

    /// Calls `mix` for each mixed pixel, with `points` the vertices in the image's pixels. Pairs of equal color
    /// (`differ`) are skipped. Without an edge, `meet` gives the distance of the discontinuity from the first of two
    /// pixels along the axis between them.
    pub fn each_mixture<const N: usize>(
        &self,
        (surface, shading): (&Surface, &ShadingMaterials),
        points: &[MovingPoint<N>],
        nearest: &Nearest,
        differ: impl Fn([usize; 2]) -> bool,
        meet: impl Fn([usize; 2], usize) -> Option<(f32, [f32; N])>,
        mut mix: impl FnMut(Mixture<N>),
    ) {
        let (width, pixels) = (nearest.width_px, nearest.faces.len());
        let rows = pixels.checked_div(width).unwrap_or(0);
        for (y, x) in (0..rows).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let at = y * width + x;
            let here = nearest.faces[at];
            if here == NOTHING {
                continue;
            }
            let center = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            for (axis, beside) in [(0, at + 1), (1, at + width)] {
                if (axis == 0 && x + 1 == width) || beside >= pixels {
                    continue;
                }
                let there = nearest.faces[beside];
                if there == NOTHING || there == here || !differ([at, beside]) {
                    continue;
                }
                // On a slope the farther surface may be nearer a pixel on: then the edge is the other's.
                let here_is_nearer = nearest.keys[at] >= nearest.keys[beside];
                let faces = if here_is_nearer { [here, there] } else { [there, here] };
                let edge = faces
                    .into_iter()
                    .filter(|&face| self.marks.near[face as usize])
                    .find_map(|face| self.crossing(surface, shading, points, face, center, axis));
                let Some((reach, slopes)) = edge.or_else(|| meet([at, beside], axis)) else { continue };
                // By this much of a pixel the color here reaches beyond the border between the two.
                let beyond = reach - 0.5;
                if beyond > 0.0 {
                    mix(Mixture { pixel: beside, with: at, share: beyond, slopes });
                } else {
                    mix(Mixture { pixel: at, with: beside, share: -beyond, slopes: slopes.map(|s| -s) });
                }
            }
        }
    }

    /// Distance along the axis from a pixel center to an edge at which the color is discontinuous, pixels, and its
    /// derivatives: of the triangle's own edges the first that crosses the axis before the next center, then of its
    /// neighbors'.
    fn crossing<const N: usize>(
        &self,
        surface: &Surface,
        shading: &ShadingMaterials,
        points: &[MovingPoint<N>],
        face: u32,
        center: Vec2,
        axis: usize,
    ) -> Option<(f32, [f32; N])> {
        let crossed = |face: u32| {
            let breaking = |edge: &&u32| self.marks.color_discontinuities[**edge as usize];
            shading.edges_of[face as usize]
                .iter()
                .filter(breaking)
                .find_map(|&edge| crossed(surface.edges[edge as usize].ends, points, center, axis))
        };
        let beside = || shading.beside(face).iter().filter(|&&other| self.marks.own[other as usize]);
        crossed(face).or_else(|| beside().find_map(|&other| crossed(other)))
    }
}

#[inline]
fn crossed<const N: usize>(
    ends: [u32; 2],
    points: &[MovingPoint<N>],
    center: Vec2,
    axis: usize,
) -> Option<(f32, [f32; N])> {
    let [a, b] = ends.map(|v| &points[v as usize]);
    let across = 1 - axis;
    let level = center[across];
    // Only those that pass this row or column, which most do not.
    if (a.at_px[across] <= level) == (b.at_px[across] <= level) {
        return None;
    }
    // Steep edges for rows, level ones for columns, those at 45 degrees for rows.
    let (along, rise) = (b.at_px[axis] - a.at_px[axis], b.at_px[across] - a.at_px[across]);
    let steep = if axis == 0 { rise.abs() >= along.abs() } else { rise.abs() > along.abs() };
    if !steep {
        return None;
    }
    let share = (level - a.at_px[across]) / rise;
    let reach = a.at_px[axis] + share * along - center[axis];
    if !(0.0..=1.0).contains(&reach) {
        return None;
    }
    let slopes = std::array::from_fn(|k| {
        let [from, to] = [a.slopes[k], b.slopes[k]];
        let moving = |axis: usize| from[axis] + share * (to[axis] - from[axis]);
        moving(axis) - moving(across) * along / rise
    });
    Some((reach, slopes))
}

/// Of each triangle its edges, and of each edge whether material, texture or normals differ to its two sides.
pub fn creases(
    surface: &Surface,
    same: impl Fn((u32, u32), (u32, u32)) -> bool,
) -> (Vec<[u32; 3]>, Vec<bool>) {
    let mut edges_of = vec![[u32::MAX; 3]; surface.triangles.len()];
    let mut creases = Vec::with_capacity(surface.edges.len());
    for (number, edge) in (0..).zip(&surface.edges) {
        let sides = surface.sides(edge);
        for side in sides {
            let edges = &mut edges_of[side.triangle as usize];
            if let Some(free) = edges.iter_mut().find(|edge| **edge == u32::MAX) {
                *free = number;
            }
        }
        let corner = |triangle: u32, vertex: u32| {
            let corners = surface.triangles[triangle as usize];
            (triangle, corners.iter().position(|&v| v == vertex).unwrap_or(0) as u32)
        };
        let smooth = sides.len() == 2
            && edge.ends.iter().all(|&v| same(corner(sides[0].triangle, v), corner(sides[1].triangle, v)));
        creases.push(!smooth);
    }
    (edges_of, creases)
}

/// Whether two corners have equal material, texture coordinates and normals.
pub fn alike(shading: &[super::shading::Face], a: (u32, u32), b: (u32, u32)) -> bool {
    /// Cosine of the angle between normals above which shading is visually continuous.
    const SMOOTH: f32 = 0.98;
    const SAME_UV: f32 = 1e-4;
    let (s, t) = (&shading[a.0 as usize], &shading[b.0 as usize]);
    let normals: [Vec3; 2] = [s.normals[a.1 as usize], t.normals[b.1 as usize]];
    s.material == t.material
        && normals[0].dot(normals[1]) > SMOOTH
        && s.uvs[a.1 as usize].distance(t.uvs[b.1 as usize]) < SAME_UV
}
