//! Reference implementation of the soft image, in double precision: every pixel against every face. The fast one must
//! agree with it, and its derivatives with its central differences.
//!
//! It intersects each pixel's ray with each face in space instead of interpolating on the screen, and reads textures'
//! bytes. It shares definitions with the fast one, but no computation: the studio's constants.

use glam::{DMat3, DVec2, DVec3};

use crate::color::{DARK, GROUND, KEY, SKY};
use geometry::TexturedMesh;
use imaging::srgb::LINEAR_OF_SRGB;

/// An image's pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Among all triangles of the mesh.
    pub face: usize,
    /// Square roots of linear light.
    pub color: DVec3,
    /// Level of the texture that was read, before it is limited to those there are.
    pub level: f64,
    /// The normal's cosine to the key light.
    pub facing: f64,
}

/// A camera at its frame's origin, looking along +z, y down, that sees the mesh.
pub struct SlowView<'a> {
    pub mesh: &'a TexturedMesh,
    /// The mesh's positions in the camera's frame.
    pub in_camera: &'a [DVec3],
    pub focal_px: f64,
    pub center_px: DVec2,
    /// Unit vectors in the mesh's frame.
    pub toward_key: DVec3,
    pub up: DVec3,
}

impl SlowView<'_> {
    /// The surface point at a pixel position; `None` for background.
    pub fn at(&self, at_px: DVec2) -> Option<SurfacePoint> {
        let ray = ((at_px - self.center_px) / self.focal_px).extend(1.0);
        let all = self.mesh.groups.iter().flat_map(|g| g.triangles.iter().map(|t| (g.material, *t)));
        let mut nearest: Option<(f64, usize, usize, [u32; 3], DVec3)> = None;
        for (face, (material, t)) in all.enumerate() {
            let corners = DMat3::from_cols_array_2d(&t.map(|v| self.in_camera[v as usize].to_array()));
            if corners.determinant().abs() < 1e-14 {
                continue;
            }
            // corners * shares = ray * depth, shares of sum 1.
            let shares = corners.inverse() * ray;
            if shares.min_element() < 0.0 {
                continue;
            }
            let depth = 1.0 / shares.element_sum();
            if nearest.is_none_or(|n| depth < n.0) {
                nearest = Some((depth, face, material, t, shares * depth));
            }
        }
        let (_, face, material, t, shares) = nearest?;
        let blend =
            |of: &dyn Fn(u32) -> DVec3| shares.x * of(t[0]) + shares.y * of(t[1]) + shares.z * of(t[2]);
        let uv_of = |v: u32| self.mesh.uvs[v as usize].as_dvec2();
        let normal = blend(&|v| self.mesh.normals[v as usize].as_dvec3()).normalize();
        let uv = blend(&|v| uv_of(v).extend(0.0)).truncate();
        let material = &self.mesh.materials[material];
        let mut albedo = DVec3::from_array(material.base_color.to_linear().map(f64::from));
        let mut level = 0.0;
        if let Some(texture) = &material.base_color_texture {
            let levels: Vec<_> = std::iter::once(&**texture).chain(texture.halved()).collect();
            let size = DVec2::new(f64::from(levels[0].width_px()), f64::from(levels[0].height_px()));
            let on_screen = t.map(|v| {
                let p = self.in_camera[v as usize];
                self.focal_px * p.truncate() / p.z
            });
            let area = |p: [DVec2; 3]| (p[1] - p[0]).perp_dot(p[2] - p[0]).abs();
            level = 0.5 * (area(t.map(|v| uv_of(v) * size)) / area(on_screen)).log2();
            let limited = level.clamp(0.0, levels.len() as f64 - 1.0);
            let fine = (limited as usize).min(levels.len() - 1);
            let coarse = (fine + 1).min(levels.len() - 1);
            let share = limited - fine as f64;
            albedo *= bilinear(levels[fine], uv).lerp(bilinear(levels[coarse], uv), share);
        }
        let facing = normal.dot(self.toward_key);
        let [ground, sky, key, dark] = [GROUND, SKY, KEY, DARK].map(f64::from);
        let light = ground + (sky - ground) * (0.5 + 0.5 * normal.dot(self.up)) + key * facing.max(0.0);
        let linear = albedo * light + dark;
        let color = DVec3::new(linear.x.sqrt(), linear.y.sqrt(), linear.z.sqrt());
        Some(SurfacePoint { face, color, level, facing })
    }
}

/// The mean of the four texels around, by nearness; repeating.
fn bilinear(image: &imaging::Image, uv: DVec2) -> DVec3 {
    let (width, height) = (i64::from(image.width_px()), i64::from(image.height_px()));
    let (x, y) = (uv.x * width as f64 - 0.5, (1.0 - uv.y) * height as f64 - 0.5);
    let mut sum = DVec3::ZERO;
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let (u, v) = (x.floor() as i64 + dx, y.floor() as i64 + dy);
        let near = (1.0 - (x - u as f64).abs()) * (1.0 - (y - v as f64).abs());
        let texel = image.pixel(u.rem_euclid(width) as u32, v.rem_euclid(height) as u32);
        let [r, g, b, _] = texel.map(|byte| f64::from(LINEAR_OF_SRGB[byte as usize]));
        sum += near * DVec3::new(r, g, b);
    }
    sum
}
