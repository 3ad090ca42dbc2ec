//! Projection from the world to the image: one form for perspective cameras, the top view and light maps.
//!
//! A projected vertex is (x, y, key): pixel position and a *depth key* that is linear on the screen and larger where
//! nearer: 1 / depth in perspective, -depth where parallel.

use glam::{DAffine3, DMat3, DVec3, Vec3};

use crate::View;

/// Nearest depth that is drawn in perspective, meters.
pub const NEAR_M: f32 = 0.005;

/// World to pixels.
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    pub width_px: usize,
    pub height_px: usize,
    pub camera_from_world: DAffine3,
    pub lens: Lens,
}

/// Map from camera coordinates to pixels. `scale` is a focal length in pixels in perspective, and pixels per meter
/// where parallel.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    pub perspective: bool,
    pub scale_x: f32,
    pub scale_y: f32,
    pub center_x: f32,
    pub center_y: f32,
}

impl Projection {
    /// The view with `samples` samples along each side of a pixel.
    pub fn new(view: &View, samples: u32) -> Self {
        let s = f64::from(samples);
        match view {
            View::Perspective(camera) => {
                let camera_from_world = camera.world_from_camera.inverse();
                Self {
                    width_px: (camera.width_px * samples) as usize,
                    height_px: (camera.height_px * samples) as usize,
                    camera_from_world: DAffine3::from_rotation_translation(
                        camera_from_world.rotation,
                        camera_from_world.translation_m,
                    ),
                    lens: Lens {
                        perspective: true,
                        scale_x: (camera.fx * s) as f32,
                        scale_y: (camera.fy * s) as f32,
                        center_x: (camera.cx * s) as f32,
                        center_y: (camera.cy * s) as f32,
                    },
                }
            }
            View::Orthographic(top) => {
                let axes = DMat3::from_cols(DVec3::X, -DVec3::Y, -DVec3::Z);
                let eye = top.center_m.extend(top.eye_z_m);
                let scale = (s / top.meters_per_px) as f32;
                Self {
                    width_px: (top.width_px * samples) as usize,
                    height_px: (top.height_px * samples) as usize,
                    camera_from_world: DAffine3::from_mat3_translation(axes, -(axes * eye)),
                    lens: Lens {
                        perspective: false,
                        scale_x: scale,
                        scale_y: scale,
                        center_x: (0.5 * f64::from(top.width_px) * s) as f32,
                        center_y: (0.5 * f64::from(top.height_px) * s) as f32,
                    },
                }
            }
        }
    }

    /// The eye's rotation as `f32`: world from camera.
    pub fn world_from_camera(&self) -> glam::Affine3A {
        self.camera_from_world.inverse().as_affine3a()
    }
}

impl Lens {
    /// Pixel position and depth key of a point in camera coordinates (in front of the eye).
    pub fn project(&self, p: Vec3) -> [f32; 3] {
        if self.perspective {
            let key = 1.0 / p.z;
            [self.scale_x * p.x * key + self.center_x, self.scale_y * p.y * key + self.center_y, key]
        } else {
            [self.scale_x * p.x + self.center_x, self.scale_y * p.y + self.center_y, -p.z]
        }
    }

    /// Origin and direction (not unit; z = 1) of the ray through a pixel position, camera coordinates.
    pub fn ray(&self, x: f32, y: f32) -> (Vec3, Vec3) {
        let (u, v) = ((x - self.center_x) / self.scale_x, (y - self.center_y) / self.scale_y);
        if self.perspective { (Vec3::ZERO, Vec3::new(u, v, 1.0)) } else { (Vec3::new(u, v, 0.0), Vec3::Z) }
    }

    /// Depth along the optical axis of a key.
    pub fn depth_of(&self, key: f32) -> f32 {
        if self.perspective { 1.0 / key } else { -key }
    }

    /// Width of a pixel at that depth, meters.
    pub fn pixel_size_m(&self, depth: f32) -> f32 {
        if self.perspective { depth / self.scale_x } else { 1.0 / self.scale_x }
    }
}
