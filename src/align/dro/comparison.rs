//! A mesh against a crop: the loss of one yaw, its silhouette and edge terms.

use std::cell::RefCell;

use glam::{DVec2, DVec3};

use super::DroSettings;
use super::crop::Crop;
use super::outline_mesh::OutlineMesh;
use super::placement::{fit, on_viewing_ray, projected};
use super::silhouette::BitPicture;
use crate::geometry::Camera;

/// A mesh to be compared with a crop.
pub struct Comparison<'a> {
    mesh: &'a OutlineMesh,
    camera: &'a Camera,
    crop: Crop,
    origin: DVec3,
    silhouette_weight: f64,
    edge_weight: f64,
}

thread_local! {
    static SCRATCH: RefCell<(Vec<DVec2>, Vec<f32>)> = const { RefCell::new((Vec::new(), Vec::new())) };
}

/// The two terms of the loss, before weighting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terms {
    pub silhouette: f64,
    pub edge: f64,
}

impl<'a> Comparison<'a> {
    pub fn new(mesh: &'a OutlineMesh, camera: &'a Camera, crop: Crop, settings: &DroSettings) -> Self {
        let origin = on_viewing_ray(mesh, camera, &crop);
        Self {
            mesh,
            camera,
            crop,
            origin,
            silhouette_weight: settings.silhouette_weight,
            edge_weight: settings.edge_weight,
        }
    }

    /// Weighted loss at that yaw; a mesh that reaches behind the camera has nothing in common.
    pub fn loss(&self, yaw_rad: f64) -> f64 {
        let terms = SCRATCH.with_borrow_mut(|(pixels, coverage)| {
            self.draw(yaw_rad, pixels, coverage).map(|()| self.terms(coverage))
        });
        let terms = terms.unwrap_or(Terms { silhouette: 1.0, edge: 1.0 });
        self.silhouette_weight * terms.silhouette + self.edge_weight * terms.edge
    }

    /// Draws the mesh at that yaw into `coverage`; `None` if it reaches behind the camera.
    fn draw(&self, yaw_rad: f64, pixels: &mut Vec<DVec2>, coverage: &mut Vec<f32>) -> Option<()> {
        let (_, zoom, offset) = self.placed(yaw_rad, pixels)?;
        let corner = |v: u32| {
            let p = zoom * pixels[v as usize] + offset;
            [p.x as f32, p.y as f32]
        };
        let mut picture = BitPicture::new(self.crop.side_px);
        for t in &self.mesh.triangles {
            picture.fill(t.map(corner));
        }
        coverage.resize(self.crop.side_px * self.crop.side_px, 0.0);
        picture.coverage(coverage);
        Some(())
    }

    /// World position of the object's origin at that yaw, and the map `zoom * pixel + offset` from the
    /// camera's picture, where `pixels` receives the vertices, to the crop.
    fn placed(&self, yaw_rad: f64, pixels: &mut Vec<DVec2>) -> Option<(DVec3, f64, DVec2)> {
        let (mut origin, camera) = (self.origin, self.camera);
        let (mut low, mut high) = projected(self.mesh, camera, origin, yaw_rad, pixels)?;
        // Once more with the rendered box's middle moved to where the mask's is: the silhouette is then
        // seen from the right direction.
        let (zoom, offset) = fit(&self.crop, low, high);
        let half = 0.5 * self.crop.side_px as f64;
        let shift_px = self.crop.center_px - (DVec2::splat(half) - offset) / zoom;
        if shift_px.length() > 0.5 {
            let (_, depth) = camera.project(origin)?;
            let shift = DVec3::new(shift_px.x * depth / camera.fx, shift_px.y * depth / camera.fy, 0.0);
            origin += camera.world_from_camera.transform_vector(shift);
            (low, high) = projected(self.mesh, camera, origin, yaw_rad, pixels)?;
        }
        let (zoom, offset) = fit(&self.crop, low, high);
        Some((origin, zoom, offset))
    }

    /// Where the object's origin stands at that yaw, and the camera whose whole picture is the crop.
    pub fn crop_camera(&self, yaw_rad: f64) -> Option<(DVec3, Camera)> {
        let (origin, zoom, offset) = SCRATCH.with_borrow_mut(|(pixels, _)| self.placed(yaw_rad, pixels))?;
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

    pub fn crop(&self) -> &Crop {
        &self.crop
    }

    fn terms(&self, coverage: &[f32]) -> Terms {
        let side = self.crop.side_px;
        let (mut common, mut drawn) = (0.0_f64, 0.0_f64);
        let (mut far, mut edges) = (0.0_f64, 0.0_f64);
        for y in 0..side {
            let row = |v: usize| &coverage[v * side..(v + 1) * side];
            let (above, here, below) = (row(y.saturating_sub(1)), row(y), row((y + 1).min(side - 1)));
            let known = &self.crop.known[y * side..(y + 1) * side];
            let mask = &self.crop.mask[y * side..(y + 1) * side];
            let distance = &self.crop.distance_px[y * side..(y + 1) * side];
            // f32 lanes within a row, f64 across rows.
            let (mut row_common, mut row_drawn, mut row_far, mut row_edges) =
                (0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
            for x in 0..side {
                row_common += here[x] * mask[x];
                row_drawn += here[x] * known[x];
            }
            for x in 1..side - 1 {
                let dx = (above[x + 1] - above[x - 1])
                    + 2.0 * (here[x + 1] - here[x - 1])
                    + (below[x + 1] - below[x - 1]);
                let dy = (below[x - 1] - above[x - 1])
                    + 2.0 * (below[x] - above[x])
                    + (below[x + 1] - above[x + 1]);
                let edge = (dx * dx + dy * dy).sqrt() * known[x];
                row_far += edge * distance[x];
                row_edges += edge;
            }
            common += f64::from(row_common);
            drawn += f64::from(row_drawn);
            far += f64::from(row_far);
            edges += f64::from(row_edges);
        }
        let union = self.crop.mask_area + drawn - common;
        Terms { silhouette: 1.0 - common / union.max(1e-9), edge: far / edges.max(1e-9) / side as f64 }
    }
}
