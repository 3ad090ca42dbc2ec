//! Reference renderer: every pixel's ray against every triangle, in double precision. The fast renderer must agree
//! with it on ids and depth except at a few edge pixels.

use glam::{DVec2, DVec3};

use crate::{GeometryFrame, RenderObject, View};

/// Depth and ids, as [`render_geometry`](crate::render_geometry) gives them. Pixels times triangles.
pub fn render_geometry(objects: &[RenderObject], view: &View) -> GeometryFrame {
    let (width_px, height_px) = (view.width_px(), view.height_px());
    let triangles: Vec<([DVec3; 3], u32)> = objects
        .iter()
        .flat_map(|object| {
            object.mesh.triangles().map(|t| {
                let corners =
                    t.map(|v| object.world_from_object.transform_point(object.mesh.positions[v as usize]));
                (corners, object.id)
            })
        })
        .collect();
    let mut depth_m = Vec::with_capacity((width_px * height_px) as usize);
    let mut ids = Vec::with_capacity((width_px * height_px) as usize);
    for y in 0..height_px {
        for x in 0..width_px {
            let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let (origin, direction, near) = ray(view, pixel);
            let (mut nearest, mut id) = (f64::INFINITY, 0);
            for (corners, object) in &triangles {
                if let Some(t) = meet(origin, direction, corners)
                    && t >= near
                    && t < nearest
                {
                    (nearest, id) = (t, *object);
                }
            }
            depth_m.push(nearest as f32);
            ids.push(id);
        }
    }
    GeometryFrame { width_px, height_px, depth_m, ids }
}

/// Origin, direction with unit depth, and nearest depth of the ray through a pixel.
fn ray(view: &View, pixel: DVec2) -> (DVec3, DVec3, f64) {
    match view {
        View::Perspective(camera) => {
            let forward = camera.world_from_camera.transform_vector(DVec3::Z);
            let direction = camera.ray_direction_in_world(pixel);
            let near = f64::from(super::projection::NEAR_M);
            (camera.world_from_camera.translation_m, direction / direction.dot(forward), near)
        }
        View::Orthographic(top) => (top.world_from_pixel(pixel).extend(top.eye_z_m), -DVec3::Z, 0.0),
    }
}

/// Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997), both faces.
fn meet(origin: DVec3, direction: DVec3, [a, b, c]: &[DVec3; 3]) -> Option<f64> {
    let (e1, e2) = (*b - *a, *c - *a);
    let across = direction.cross(e2);
    let determinant = e1.dot(across);
    if determinant.abs() < 1e-18 {
        return None;
    }
    let from_a = origin - *a;
    let u = from_a.dot(across) / determinant;
    let q = from_a.cross(e1);
    let v = direction.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| e2.dot(q) / determinant)
}
