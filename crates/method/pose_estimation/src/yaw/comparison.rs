//! Comparison of a mesh with a crop: the loss of one yaw, its silhouette and edge terms.

use std::cell::RefCell;

use glam::{DVec2, DVec3};
use wide::f32x8;

use super::YawSettings;
use super::crop::Crop;
use super::image_edges::ImageEdges;
use super::outline_mesh::OutlineMesh;
use super::placement::{RayPlacement, fit, projected};
use super::silhouette::{BLOCK_PX, BitImage, Coverage, each};
use geometry::Camera;

/// Distance of the rendered box's center from the mask's up to which the object is not re-centered, pixels.
pub(super) const NEAR_CENTER_PX: f64 = 0.5;

/// A mesh to be compared with a crop.
#[derive(Clone, Copy)]
pub struct Comparison<'a> {
    pub(super) mesh: &'a OutlineMesh,
    pub(super) camera: &'a Camera,
    pub(super) crop: &'a Crop,
    /// Initial placement of the object.
    pub(super) standing: RayPlacement,
    pub(super) silhouette_weight: f64,
    pub(super) edge_weight: f64,
    /// Placement of the object; `None` to fit its box to the mask's.
    place: Option<Place>,
}

/// Working memory for comparisons.
#[derive(Default)]
struct Scratch {
    /// Of the mesh's vertices in the camera's image.
    pixels: Vec<DVec2>,
    /// Of the mesh's triangles: whether they run clockwise in the image.
    clockwise: Vec<bool>,
    image: BitImage,
    coverage: Coverage,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// Position and size of an object in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Of the center of its box, pixels of the camera's image.
    pub center_px: DVec2,
    /// Logarithm of the factor on its size in the image.
    pub log_zoom: f64,
}

impl Place {
    /// Offset from the other place to this one.
    pub fn beside(self, other: Self) -> Self {
        Self { center_px: self.center_px - other.center_px, log_zoom: self.log_zoom - other.log_zoom }
    }

    /// The place moved by an offset.
    pub fn moved(self, by: Self) -> Self {
        Self { center_px: self.center_px + by.center_px, log_zoom: self.log_zoom + by.log_zoom }
    }
}

/// The two terms of the loss, before weighting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terms {
    pub silhouette: f64,
    pub edge: f64,
}

impl<'a> Comparison<'a> {
    /// `support_height_m` is that of what the object stands on, world z.
    pub fn new(
        mesh: &'a OutlineMesh,
        camera: &'a Camera,
        support_height_m: f64,
        crop: &'a Crop,
        settings: &YawSettings,
    ) -> Self {
        let standing = RayPlacement::on_viewing_ray(mesh, camera, support_height_m, crop);
        Self {
            mesh,
            camera,
            crop,
            standing,
            silhouette_weight: settings.silhouette_weight,
            edge_weight: settings.edge_weight,
            place: None,
        }
    }

    /// Position and size in the image at which the box of the mesh at that yaw fits the mask's; `None` if it reaches
    /// behind the camera.
    pub fn fitted(&self, yaw_rad: f64) -> Option<Place> {
        let (origin, zoom, offset) =
            SCRATCH.with_borrow_mut(|scratch| self.placed(yaw_rad, &mut scratch.pixels))?;
        let (center_px, _) = self.camera.project(origin + self.standing.center_from_origin)?;
        let half = 0.5 * self.crop.side_px as f64;
        let seen_px = self.crop.center_px + (zoom * center_px + offset - half) / self.crop.scale;
        Some(Place { center_px: seen_px, log_zoom: (zoom / self.crop.scale).ln() })
    }

    /// World position of the object's origin from the mask's position and size; `None` if the camera does not
    /// determine it.
    pub fn seen_m(&self, yaw_rad: f64) -> Option<DVec2> {
        let place = self.place.or_else(|| self.fitted(yaw_rad))?;
        self.standing.seen_m(self.camera, place.center_px, place.log_zoom.exp())
    }

    /// The comparison with the object at that placement.
    pub fn standing_at(&self, place: Option<Place>) -> Self {
        Self { place, ..*self }
    }

    /// Weighted loss at that yaw; the loss of no overlap if the mesh reaches behind the camera.
    pub fn loss(&self, yaw_rad: f64) -> f64 {
        let terms =
            SCRATCH.with_borrow_mut(|scratch| self.draw(yaw_rad, scratch).map(|()| self.terms(scratch)));
        self.weighted(terms)
    }

    fn weighted(&self, terms: Option<Terms>) -> f64 {
        let terms = terms.unwrap_or(Terms { silhouette: 1.0, edge: 1.0 });
        self.silhouette_weight * terms.silhouette + self.edge_weight * terms.edge
    }

    /// Draws the mesh at that yaw; `None` if it reaches behind the camera.
    fn draw(&self, yaw_rad: f64, scratch: &mut Scratch) -> Option<()> {
        let (_, zoom, offset) = self.placed(yaw_rad, &mut scratch.pixels)?;
        self.rasterize(zoom, offset, scratch);
        Some(())
    }

    /// Draws the vertices' pixels of the camera's image, mapped to the crop by `zoom * pixel + offset`.
    fn rasterize(&self, zoom: f64, offset: DVec2, scratch: &mut Scratch) {
        let Scratch { pixels, clockwise, image, coverage } = scratch;
        let corner = |v: u32| (zoom * pixels[v as usize] + offset).as_vec2().to_array();
        image.clear(self.crop.side_px);
        let Some(edges) = &self.mesh.edges else {
            self.mesh.triangles.iter().for_each(|t| image.fill(t.map(corner)));
            image.cover(coverage);
            return;
        };
        clockwise.clear();
        clockwise.extend(self.mesh.triangles.iter().map(|[a, b, c]| {
            let [a, b, c] = [pixels[*a as usize], pixels[*b as usize], pixels[*c as usize]];
            (b - a).perp_dot(c - a) > 0.0
        }));
        image.fill_contour(edges.iter().filter_map(|edge| {
            let layers =
                i32::from(clockwise[edge.along as usize]) - i32::from(clockwise[edge.against as usize]);
            (layers != 0).then(|| (corner(edge.ends[0]), corner(edge.ends[1]), layers))
        }));
        image.cover(coverage);
    }

    /// World position of the object's origin at that yaw, and the map `zoom * pixel + offset` from the
    /// camera's image, where `pixels` receives the vertices, to the crop.
    fn placed(&self, yaw_rad: f64, pixels: &mut Vec<DVec2>) -> Option<(DVec3, f64, DVec2)> {
        let (mut origin, camera) = (self.standing.origin, self.camera);
        if let Some(place) = self.place {
            origin = self.standing.under(camera, place.center_px)?;
            projected(self.mesh, camera, origin, yaw_rad, pixels)?;
            let (scale, zoom) = (self.crop.scale, place.log_zoom.exp());
            let half = 0.5 * self.crop.side_px as f64;
            let (center_px, _) = camera.project(origin + self.standing.center_from_origin)?;
            let offset = scale * (place.center_px - self.crop.center_px - zoom * center_px) + half;
            return Some((origin, scale * zoom, offset));
        }
        let (mut low, mut high) = projected(self.mesh, camera, origin, yaw_rad, pixels)?;
        // Repeated with the rendered box's center moved to the mask's, so that the silhouette has the correct viewing
        // direction.
        let shift_px = self.off_center_px(low, high);
        if shift_px.length() > NEAR_CENTER_PX {
            origin = self.standing.moved(camera, shift_px)?;
            (low, high) = projected(self.mesh, camera, origin, yaw_rad, pixels)?;
        }
        let (zoom, offset) = fit(self.crop, low, high);
        Some((origin, zoom, offset))
    }

    /// From the center of a rendered box to where the mask's is, pixels of the camera's image.
    pub(super) fn off_center_px(&self, low: DVec2, high: DVec2) -> DVec2 {
        let (zoom, offset) = fit(self.crop, low, high);
        let half = 0.5 * self.crop.side_px as f64;
        self.crop.center_px - (DVec2::splat(half) - offset) / zoom
    }

    /// World position of the object's origin at that yaw, and the camera whose whole image is the crop.
    pub fn crop_camera(&self, yaw_rad: f64) -> Option<(DVec3, Camera)> {
        let (origin, zoom, offset) =
            SCRATCH.with_borrow_mut(|scratch| self.placed(yaw_rad, &mut scratch.pixels))?;
        let camera = self.camera;
        let side_px = self.crop.side_px as u32;
        let cropped = Camera {
            width_px: side_px,
            height_px: side_px,
            fx: zoom * camera.fx,
            fy: zoom * camera.fy,
            cx: zoom * camera.cx + offset.x,
            cy: zoom * camera.cy + offset.y,
            world_from_camera: camera.world_from_camera,
        };
        Some((origin, cropped))
    }

    /// Share of the mesh's outline at that yaw, over known pixels, that lies on no edge of the image, 0..1. `edges`
    /// are those at the crop's pixels.
    pub fn off_edges(&self, yaw_rad: f64, edges: &ImageEdges) -> f64 {
        SCRATCH.with_borrow_mut(|scratch| {
            self.draw(yaw_rad, scratch).map_or(1.0, |()| {
                let (mut on, mut all) = (0.0_f64, 0.0_f64);
                let rows = scratch.coverage.rows();
                for y in rows.start.saturating_sub(1)..(rows.end + 1).min(self.crop.side_px) {
                    each(scratch.coverage.outline(y) & self.crop.known_blocks[y], |block| {
                        for x in block * BLOCK_PX..(block + 1) * BLOCK_PX {
                            let pixel = y * self.crop.side_px + x;
                            let across = self.slope(&scratch.coverage, x, y);
                            let length = across[0].hypot(across[1]) * self.crop.inner[pixel];
                            if length > 0.0 {
                                on += f64::from(length * edges.clearness(pixel, across));
                                all += f64::from(length);
                            }
                        }
                    });
                }
                1.0 - on / all.max(1e-9)
            })
        })
    }

    /// Sobel's gradient of the coverage at a pixel.
    fn slope(&self, coverage: &Coverage, x: usize, y: usize) -> [f32; 2] {
        let row = |y: usize| -> [f32; 3] {
            let from = coverage.from(y, x);
            [from[0], from[1], from[2]]
        };
        let [a, b, c] = row(y.saturating_sub(1));
        let [d, _, f] = row(y);
        let [g, h, i] = row((y + 1).min(self.crop.side_px - 1));
        [(c - a) + 2.0 * (f - d) + (i - g), (g - a) + 2.0 * (h - b) + (i - c)]
    }

    /// Compares the silhouette with the crop, a block of eight pixels at a time; only blocks at the outline have
    /// edges.
    fn terms(&self, scratch: &Scratch) -> Terms {
        let (coverage, crop) = (&scratch.coverage, self.crop);
        let side = crop.side_px;
        let (mut common, mut drawn) = (0.0_f64, 0.0_f64);
        let (mut far, mut edges) = (0.0_f64, 0.0_f64);
        let rows = coverage.rows();
        for y in rows.start.saturating_sub(1)..(rows.end + 1).min(side) {
            // f32 lanes within a row, f64 across rows.
            let (mut row_common, mut row_drawn) = (f32x8::ZERO, f32x8::ZERO);
            each(coverage.covered(y) & crop.known_blocks[y], |block| {
                let x = block * BLOCK_PX;
                let (at, cover) = (y * side + x, eight(coverage.from(y, x + 1)));
                row_common += cover * eight(&crop.mask[at..]);
                row_drawn += cover * eight(&crop.known[at..]);
            });
            common += f64::from(row_common.reduce_add());
            drawn += f64::from(row_drawn.reduce_add());
            let outline = coverage.outline(y) & crop.known_blocks[y];
            if outline == 0 {
                continue;
            }
            let (above, below) = (y.saturating_sub(1), (y + 1).min(side - 1));
            let (mut row_far, mut row_edges) = (f32x8::ZERO, f32x8::ZERO);
            each(outline, |block| {
                let x = block * BLOCK_PX;
                let at = y * side + x;
                let from = |row: usize, offset: usize| eight(coverage.from(row, x + offset));
                let (a, b, c) = (from(above, 0), from(above, 1), from(above, 2));
                let (d, f) = (from(y, 0), from(y, 2));
                let (g, h, i) = (from(below, 0), from(below, 1), from(below, 2));
                let dx = (c - a) + (f - d) + (f - d) + (i - g);
                let dy = (g - a) + (h - b) + (h - b) + (i - c);
                let edge = (dx * dx + dy * dy).sqrt() * eight(&crop.inner[at..]);
                row_far += edge * eight(&crop.distance_px[at..]);
                row_edges += edge;
            });
            far += f64::from(row_far.reduce_add());
            edges += f64::from(row_edges.reduce_add());
        }
        let union = crop.mask_area + drawn - common;
        Terms { silhouette: 1.0 - common / union.max(1e-9), edge: far / edges.max(1e-9) / side as f64 }
    }
}

/// The first eight numbers.
#[inline]
fn eight(numbers: &[f32]) -> f32x8 {
    // An array and no slice: copies of slices of eight are calls.
    f32x8::from(*numbers.first_chunk::<BLOCK_PX>().expect("rows of crops are whole blocks"))
}
