//! Turns meshes into triangles on the screen, clipped at the near plane and sorted into bands.
//!
//! Work is cut into fixed pieces that rayon may run in any order; their results are kept in list order,
//! so the triangle order, and with it every tie in depth, does not depend on the number of threads.

use glam::{Vec3, Vec3A};
use rayon::prelude::*;

use super::projection::{Lens, NEAR_M, Projection};
use super::scenery::{Keep, Scenery};

/// A triangle on the screen.
#[derive(Clone, Copy)]
pub struct ScreenTriangle {
    pub x: [f32; 3],
    pub y: [f32; 3],
    pub key: [f32; 3],
    /// Into [`Scenery::triangles`].
    pub source: u32,
}

/// The scene's points as one eye sees them; independent of picture size and sampling.
pub struct Prepared<'a> {
    scenery: &'a Scenery<'a>,
    /// [`Scenery::points_in_world`] in the camera's frame.
    pub camera_points: Vec<Vec3>,
}

/// Screen triangles, and for each band the ones that touch it, nearest list order first.
pub struct Binned {
    pieces: Vec<Piece>,
}

struct Piece {
    triangles: Vec<ScreenTriangle>,
    bands: Vec<Vec<u32>>,
}

impl<'a> Prepared<'a> {
    /// Moves every point into the camera's frame.
    pub fn new(scenery: &'a Scenery<'a>, projection: &Projection) -> Self {
        let camera_from_world = projection.camera_from_world.as_affine3a();
        let seen = |p: &Vec3A| Vec3::from(camera_from_world.transform_point3a(*p));
        Self { scenery, camera_points: scenery.points_in_world.iter().map(seen).collect() }
    }

    /// Projects, clips and bins the triangles for a picture of `projection`'s size in samples.
    pub fn bin(&self, projection: &Projection, band_rows: usize, keep: Keep) -> Binned {
        const PIECE: usize = 8192;
        let band_count = projection.height_px.div_ceil(band_rows);
        let lens = &projection.lens;
        let drawn = self.scenery.drawn(keep);
        let pieces = (0..drawn.len().div_ceil(PIECE))
            .into_par_iter()
            .map(|piece| {
                let mut out = Piece { triangles: Vec::new(), bands: vec![Vec::new(); band_count] };
                for place in piece * PIECE..((piece + 1) * PIECE).min(drawn.len()) {
                    let source = drawn.at(place);
                    let triangle = &self.scenery.triangles[source as usize];
                    let corners = triangle.vertices.map(|v| self.camera_points[v as usize]);
                    clip_and_project(corners, lens, |x, y, key| {
                        if !(triangle.one_sided && is_seen_from_behind(x, y)) {
                            out.push(ScreenTriangle { x, y, key, source }, projection, band_rows);
                        }
                    });
                }
                out
            })
            .collect();
        Binned { pieces }
    }
}

impl Piece {
    fn push(&mut self, t: ScreenTriangle, projection: &Projection, band_rows: usize) {
        let Some((y0, y1)) = covered(t.y, projection.height_px) else { return };
        if covered(t.x, projection.width_px).is_none() {
            return;
        }
        let index = self.triangles.len() as u32;
        self.triangles.push(t);
        for band in y0 / band_rows..=y1 / band_rows {
            self.bands[band].push(index);
        }
    }
}

impl Binned {
    /// Triangles that touch the band, in list order.
    pub fn band(&self, band: usize) -> impl Iterator<Item = &ScreenTriangle> + '_ {
        self.pieces
            .iter()
            .flat_map(move |piece| piece.bands[band].iter().map(|&index| &piece.triangles[index as usize]))
    }

    /// Whether no triangle touches any band.
    pub fn is_empty(&self) -> bool {
        self.pieces.iter().all(|piece| piece.triangles.is_empty())
    }
}

/// First and last pixel whose center lies within the span of the coordinates; `None` if there is none.
#[inline]
pub fn covered(c: [f32; 3], size: usize) -> Option<(usize, usize)> {
    let low = c[0].min(c[1]).min(c[2]);
    let high = c[0].max(c[1]).max(c[2]);
    let (low, high) = ((low - 0.5).max(0.0), (high - 0.5).min(size as f32 - 1.0));
    // Written so that a NaN coordinate drops the triangle; rounding by hand, since without SSE 4.1 the
    // library's is a call.
    if high >= 0.0 && low <= high {
        let first = low as usize + usize::from((low as usize as f32) < low);
        let last = high as usize;
        (first <= last).then_some((first, last))
    } else {
        None
    }
}

/// Whether the corners run clockwise in a picture whose y grows downward.
#[inline]
fn is_seen_from_behind(x: [f32; 3], y: [f32; 3]) -> bool {
    let side = |k: usize| (f64::from(x[k]) - f64::from(x[0]), f64::from(y[k]) - f64::from(y[0]));
    let ((x1, y1), (x2, y2)) = (side(1), side(2));
    x1 * y2 - y1 * x2 > 0.0
}

/// Calls `emit` with the pixel positions and keys of the part of the triangle in front of the near plane.
#[inline]
fn clip_and_project(corners: [Vec3; 3], lens: &Lens, mut emit: impl FnMut([f32; 3], [f32; 3], [f32; 3])) {
    let near = if lens.perspective { NEAR_M } else { 0.0 };
    let behind = corners.map(|p| p.z < near);
    match behind.iter().filter(|&&b| b).count() {
        0 => {
            let [a, b, c] = corners.map(|p| lens.project(p));
            emit([a[0], b[0], c[0]], [a[1], b[1], c[1]], [a[2], b[2], c[2]]);
        }
        3 => {}
        _ => {
            let mut kept: Vec<[f32; 3]> = Vec::with_capacity(4);
            for k in 0..3 {
                let (p, q) = (corners[k], corners[(k + 1) % 3]);
                if p.z >= near {
                    kept.push(lens.project(p));
                }
                if (p.z < near) != (q.z < near) {
                    let t = (near - p.z) / (q.z - p.z);
                    let mut cut = p + t * (q - p);
                    cut.z = near;
                    kept.push(lens.project(cut));
                }
            }
            for k in 2..kept.len() {
                let (a, b, c) = (kept[0], kept[k - 1], kept[k]);
                emit([a[0], b[0], c[0]], [a[1], b[1], c[1]], [a[2], b[2], c[2]]);
            }
        }
    }
}
