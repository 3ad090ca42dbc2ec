//! Complete silhouette of one object, ignoring occluders.

use glam::DVec2;

use super::{RenderObject, View, render_geometry};
use imaging::Mask;

/// The object's pixels in the image of that view; drawn in the window around it only.
pub fn silhouette(object: RenderObject, view: &View) -> Mask {
    let mut corners =
        object.mesh.positions.iter().map(|p| view.project(object.world_from_object.transform_point(*p)));
    let window = corners.try_fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), corner| {
        corner.map(|pixel| (low.min(pixel), high.max(pixel)))
    });
    // An object reaching behind the camera may cover any part of the image.
    let (low, high) = window.unwrap_or((DVec2::ZERO, DVec2::INFINITY));
    let frame = DVec2::new(f64::from(view.width_px()), f64::from(view.height_px()));
    let low = low.floor().clamp(DVec2::ZERO, frame);
    let size = high.ceil().clamp(low, frame) - low;
    let ([left, top], [width_px, height_px]) = [low, size].map(|p| p.to_array().map(|c| c as u32)).into();
    let seen = render_geometry(&[object], &view.window([left, top], [width_px, height_px]));
    let mut bits = vec![false; view.width_px() as usize * view.height_px() as usize];
    let rows = bits.chunks_exact_mut(view.width_px().max(1) as usize).skip(top as usize);
    for (row, ids) in rows.zip(seen.ids.chunks_exact(width_px.max(1) as usize)) {
        row[left as usize..].iter_mut().zip(ids).for_each(|(bit, id)| *bit = *id == object.id);
    }
    Mask::from_bits(view.width_px(), view.height_px(), bits)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::TopView;
    use geometry::{Camera, Material, Pose, Rgb, TexturedMesh, shapes};

    #[test]
    fn window_equals_crop_of_whole_image() {
        let mut mesh = TexturedMesh::default();
        mesh.add(shapes::cone(0.05, 0.02, 0.12, 32), &Material::plain("gray", Rgb([0.5; 3]), 0.5));
        let camera = Camera::orbit(160, 120, 0.6, DVec3::ZERO, 0.3, 0.5, 0.8);
        let (width_px, height_px, eye_z_m) = (160, 90, 1.0);
        let top = TopView { width_px, height_px, meters_per_px: 0.004, center_m: DVec2::ZERO, eye_z_m };
        for view in [View::Perspective(camera), View::Orthographic(top)] {
            for (x, y) in [(0.0, 0.0), (0.05, -0.03), (-0.3, 0.12), (0.8, 0.0)] {
                let world_from_object = Pose::upright(DVec3::new(x, y, 0.0), 0.4);
                let object = RenderObject { mesh: &mesh, world_from_object, id: 3 };
                let whole = render_geometry(&[object], &view).mask(3);
                assert_eq!(silhouette(object, &view), whole, "{view:?} {x} {y}");
            }
        }
    }
}
