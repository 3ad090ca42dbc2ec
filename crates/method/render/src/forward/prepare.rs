//! Projection of meshes to screen triangles, clipped at the near plane and binned into bands.
//!
//! Work is cut into fixed chunks that rayon may run in any order. Their results are kept in list order, so the
//! triangle order, and with it every tie in depth, does not depend on the number of threads.

use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

use super::projection::{Lens, NEAR_M, Projection};
use super::scene_buffers::{SceneBuffers, TriangleFilter};

/// A triangle on the screen.
#[derive(Clone, Copy)]
pub struct ScreenTriangle {
    pub x: [f32; 3],
    pub y: [f32; 3],
    pub key: [f32; 3],
    /// Into [`SceneBuffers::triangles`].
    pub source: u32,
}

/// The scene's points in the frame of one eye, independent of image size and sampling.
pub struct ViewGeometry<'a> {
    scene_buffers: &'a SceneBuffers<'a>,
    /// [`SceneBuffers::points_in_world`] in the camera's frame.
    pub camera_points: Vec<Vec3>,
}

/// The same points projected to the screen.
pub struct ScreenGeometry<'a> {
    prepared: &'a ViewGeometry<'a>,
    projection: &'a Projection,
    /// Position and key of each point of `objects`; undefined for points behind the eye.
    screen_points: Vec<[f32; 3]>,
    objects: Range<usize>,
    first_point: usize,
    /// Nearest depth that is drawn, meters.
    near_m: f32,
    /// Whether no point of `objects` is nearer than that.
    is_all_in_front: bool,
}

/// Screen triangles, and for each band the triangles that touch it, in list order.
pub struct TriangleBins {
    pieces: Vec<Piece>,
}

struct Piece {
    triangles: Vec<ScreenTriangle>,
    bands: Vec<Vec<u32>>,
}

impl<'a> ViewGeometry<'a> {
    /// Moves every point into the camera's frame.
    pub fn new(scene_buffers: &'a SceneBuffers<'a>, projection: &Projection) -> Self {
        Self::refreshed(scene_buffers, projection, Vec::new(), &scene_buffers.all())
    }

    /// Moves the points of consecutive objects into the camera's frame; the others keep their places in
    /// `camera_points`.
    pub fn refreshed(
        scene_buffers: &'a SceneBuffers<'a>,
        projection: &Projection,
        mut camera_points: Vec<Vec3>,
        objects: &Range<usize>,
    ) -> Self {
        let camera_from_world = projection.camera_from_world.as_affine3a();
        camera_points.resize(scene_buffers.points_in_world.len(), Vec3::ZERO);
        let vertices = scene_buffers.vertices_of(objects);
        for (seen, p) in
            camera_points[vertices.clone()].iter_mut().zip(&scene_buffers.points_in_world[vertices])
        {
            *seen = Vec3::from(camera_from_world.transform_point3a(*p));
        }
        Self { scene_buffers, camera_points }
    }

    /// Projects every point for an image of `projection`'s size in samples.
    pub fn projected(&'a self, projection: &'a Projection) -> ScreenGeometry<'a> {
        self.projected_part(projection, &self.scene_buffers.all())
    }

    /// Projects the points of consecutive objects.
    pub fn projected_part(
        &'a self,
        projection: &'a Projection,
        objects: &Range<usize>,
    ) -> ScreenGeometry<'a> {
        let vertices = self.scene_buffers.vertices_of(objects);
        let first_point = vertices.start;
        let points = &self.camera_points[vertices];
        let near_m = if projection.lens.perspective { NEAR_M } else { 0.0 };
        ScreenGeometry {
            prepared: self,
            projection,
            screen_points: points.iter().map(|p| projection.lens.project(*p)).collect(),
            objects: objects.clone(),
            first_point,
            near_m,
            is_all_in_front: points.iter().all(|p| p.z >= near_m),
        }
    }
}

impl ScreenGeometry<'_> {
    /// Clips and bins the triangles.
    pub fn bin(&self, band_rows: usize, keep: TriangleFilter) -> TriangleBins {
        const PIECE: usize = 8192;
        let band_count = self.projection.height_px.div_ceil(band_rows);
        let drawn = self.prepared.scene_buffers.drawn(keep, &self.objects);
        let pieces = (0..drawn.len().div_ceil(PIECE))
            .into_par_iter()
            .map(|piece| {
                let places = piece * PIECE..((piece + 1) * PIECE).min(drawn.len());
                let triangles = Vec::with_capacity(places.len());
                let mut out = Piece { triangles, bands: vec![Vec::new(); band_count] };
                places.for_each(|place| self.enter(drawn.at(place), &mut out, band_rows));
                out
            })
            .collect();
        TriangleBins { pieces }
    }

    /// Adds what is visible of a triangle. Corners are listed one by one, because `array::map` is not inlined here.
    #[inline]
    fn enter(&self, source: u32, out: &mut Piece, band_rows: usize) {
        let Self { prepared, projection, screen_points, first_point, near_m, .. } = self;
        let triangle = &prepared.scene_buffers.triangles[source as usize];
        let [i, j, k] = triangle.vertices;
        let mut enter = |[a, b, c]: [[f32; 3]; 3]| {
            let (x, y, key) = ([a[0], b[0], c[0]], [a[1], b[1], c[1]], [a[2], b[2], c[2]]);
            if !(triangle.one_sided && is_seen_from_behind(x, y)) {
                out.push(ScreenTriangle { x, y, key, source }, projection, band_rows);
            }
        };
        if !self.is_all_in_front {
            let point = |v: u32| prepared.camera_points[v as usize];
            let corners = [point(i), point(j), point(k)];
            match corners.iter().filter(|p| p.z < *near_m).count() {
                0 => {}
                3 => return,
                _ => return clipped(corners, *near_m, &projection.lens, enter),
            }
        }
        let on_screen = |v: u32| screen_points[v as usize - first_point];
        enter([on_screen(i), on_screen(j), on_screen(k)]);
    }
}

impl Piece {
    #[inline]
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

impl TriangleBins {
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
    // A NaN coordinate fails this test and drops the triangle. Rounding is explicit, since without SSE 4.1 the
    // library's is a call.
    if high >= 0.0 && low <= high {
        let first = low as usize + usize::from((low as usize as f32) < low);
        let last = high as usize;
        (first <= last).then_some((first, last))
    } else {
        None
    }
}

/// Whether the corners run clockwise in an image whose y grows downward.
#[inline]
fn is_seen_from_behind(x: [f32; 3], y: [f32; 3]) -> bool {
    let side = |k: usize| (f64::from(x[k]) - f64::from(x[0]), f64::from(y[k]) - f64::from(y[0]));
    let ((x1, y1), (x2, y2)) = (side(1), side(2));
    x1 * y2 - y1 * x2 > 0.0
}

/// Calls `emit` with the corners on the screen of the triangles that make up the part in front of the near plane.
fn clipped(corners: [Vec3; 3], near_m: f32, lens: &Lens, mut emit: impl FnMut([[f32; 3]; 3])) {
    let mut kept: Vec<[f32; 3]> = Vec::with_capacity(4);
    for k in 0..3 {
        let (p, q) = (corners[k], corners[(k + 1) % 3]);
        if p.z >= near_m {
            kept.push(lens.project(p));
        }
        if (p.z < near_m) != (q.z < near_m) {
            let t = (near_m - p.z) / (q.z - p.z);
            let mut cut = p + t * (q - p);
            cut.z = near_m;
            kept.push(lens.project(cut));
        }
    }
    for k in 2..kept.len() {
        emit([kept[0], kept[k - 1], kept[k]]);
    }
}
