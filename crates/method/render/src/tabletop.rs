//! The horizontal surface that carries a scene, with its mean color.

use glam::{DVec2, DVec3, Vec3};

use crate::RenderObject;
use geometry::Material;
use imaging::srgb::LINEAR_OF_SRGB;

/// A horizontal rectangle in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tabletop {
    /// Meters.
    pub z_m: f64,
    pub low_m: DVec2,
    pub high_m: DVec2,
    /// Mean reflectance, linear.
    pub color: Vec3,
}

impl Tabletop {
    /// Height below the highest point of a table within which a surface counts as its top, meters.
    pub const TOP_DEPTH_M: f64 = 0.05;

    /// The upward surface at the top of an object: height and color are means over its area.
    pub fn of(object: &RenderObject) -> Self {
        let mesh = object.mesh;
        let points: Vec<DVec3> =
            mesh.positions.iter().map(|p| object.world_from_object.transform_point(*p)).collect();
        let (low, high) = points
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let mut top =
            Self { z_m: high.z, low_m: low.truncate(), high_m: high.truncate(), color: Vec3::splat(0.3) };
        let (mut area, mut height, mut color) = (0.0, 0.0, Vec3::ZERO);
        for group in &mesh.groups {
            let mut of_group = 0.0;
            for triangle in &group.triangles {
                let [a, b, c] = triangle.map(|v| points[v as usize]);
                let across = (b - a).cross(c - a);
                let z = (a.z + b.z + c.z) / 3.0;
                if across.z > 0.9 * across.length() && z > high.z - Self::TOP_DEPTH_M {
                    of_group += 0.5 * across.z;
                    height += 0.5 * across.z * z;
                }
            }
            area += of_group;
            color += of_group as f32 * mean_color(&mesh.materials[group.material]);
        }
        if area > 0.0 {
            (top.z_m, top.color) = (height / area, color / area as f32);
        }
        top
    }
}

/// Base color times the mean of the texture, linear.
fn mean_color(material: &Material) -> Vec3 {
    let base = Vec3::from(material.base_color.to_linear());
    let Some(texture) = &material.base_color_texture else { return base };
    let [r, g, b, _] = texture.halved().last().unwrap_or(texture).pixel(0, 0);
    base * Vec3::from([r, g, b].map(|byte| LINEAR_OF_SRGB[usize::from(byte)]))
}
