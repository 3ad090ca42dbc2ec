//! Side-by-side view of an instance in the image and its mesh at the estimated yaw, for visual inspection.
//!
//! The mesh is rendered as the optimizer compares it: on the instance's viewing ray, with the image's camera, fitted
//! into the mask's square crop; the mask's contour is drawn over it. The best other candidate follows, so that the
//! alternatives of an uncertain choice are visible.

use std::f64::consts::TAU;

use super::appearance::{rendered, scene_cache};
use super::yaw::comparison::Comparison;
use super::yaw::crop::Crop;
use super::yaw::outline_mesh::OutlineMesh;
use super::yaw::{YawEstimate, YawProblem, YawSettings};
use geometry::Pose;
use geometry::pose::wrap_angle_rad;
use imaging::{Image, Mask};
use render::annotate::{draw_mask_outline, sheet};

/// Side of a cell, pixels.
const CELL_PX: u32 = 192;

/// Candidates closer than this count as equal, radians.
const SAME_RAD: f64 = TAU / 36.0;

const CONTOUR: [u8; 4] = [225, 40, 40, 255];

/// Cells in a row: the image, the mesh at the yaw, and at the best other candidate if there is one. `None` without an
/// image or a mask, or if the mesh reaches behind the camera.
pub fn beside(problem: &YawProblem, estimate: &YawEstimate, settings: &YawSettings) -> Option<Image> {
    let image = problem.image?;
    let crop = Crop::new(problem.mask, problem.unknown, problem.mask.bbox_px()?, CELL_PX as usize);
    let outline = OutlineMesh::new(problem.mesh, settings.outline_cells);
    let comparison = Comparison::new(&outline, problem.camera, problem.support_height_m, &crop, settings);
    let scene_cache = scene_cache(problem.mesh);
    let mask = Mask::from_fn(CELL_PX, CELL_PX, |x, y| crop.mask[(y * CELL_PX + x) as usize] > 0.5);
    let drawn = |yaw_rad: f64| {
        let (origin, camera) = comparison.crop_camera(yaw_rad)?;
        let mut drawn = rendered(&scene_cache, &Pose::upright(origin, yaw_rad), camera);
        draw_mask_outline(&mut drawn, &mask, CONTOUR, 1);
        Some(drawn)
    };
    let far = |yaw_rad: f64| wrap_angle_rad(yaw_rad - estimate.yaw_rad).abs() > SAME_RAD;
    let other = estimate.top.iter().find(|(yaw_rad, _)| far(*yaw_rad));
    let caption = |yaw_rad: f64, loss: f64| format!("{:.1} deg, loss {loss:.4}", yaw_rad.to_degrees());
    let mut cells = vec![
        (shown(image, &crop), "picture".to_owned()),
        (drawn(estimate.yaw_rad)?, caption(estimate.yaw_rad, estimate.loss)),
    ];
    if let Some(&(yaw_rad, loss)) = other {
        cells.push((drawn(yaw_rad)?, format!("other: {}", caption(yaw_rad, loss))));
    }
    let cells: Vec<(&Image, &str)> = cells.iter().map(|(cell, caption)| (cell, caption.as_str())).collect();
    Some(sheet(&cells, cells.len(), CELL_PX))
}

/// The image under the crop with the instance's surroundings; white beyond it.
fn shown(image: &Image, crop: &Crop) -> Image {
    let mut cell = Image::filled(CELL_PX, CELL_PX, [255; 4]);
    let half = 0.5 * f64::from(CELL_PX);
    for y in 0..CELL_PX {
        for x in 0..CELL_PX {
            let at = |k: u32, center_px: f64| (f64::from(k) + 0.5 - half) / crop.scale + center_px;
            let (u, v) = (at(x, crop.center_px.x), at(y, crop.center_px.y));
            let within = (0.0..f64::from(image.width_px())).contains(&u)
                && (0.0..f64::from(image.height_px())).contains(&v);
            if within {
                cell.set_pixel(x, y, image.pixel(u as u32, v as u32));
            }
        }
    }
    cell
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    #[test]
    fn cell_shows_image_under_crop_and_white_beyond() {
        let mut image = Image::filled(40, 40, [10, 20, 30, 255]);
        image.set_pixel(4, 5, [200, 0, 0, 255]);
        let mask = Mask::from_fn(40, 40, |x, y| (2..8).contains(&x) && (3..9).contains(&y));
        let crop = Crop::new(&mask, &Mask::empty(40, 40), mask.bbox_px().expect("pixels"), CELL_PX as usize);
        let cell = shown(&image, &crop);
        let under = |p: DVec2| {
            let q = (p - crop.center_px) * crop.scale + 0.5 * f64::from(CELL_PX);
            cell.pixel(q.x as u32, q.y as u32)
        };
        assert_eq!(under(DVec2::new(4.5, 5.5)), [200, 0, 0, 255]);
        assert_eq!(under(DVec2::new(6.5, 5.5)), [10, 20, 30, 255]);
        let corner = Mask::from_fn(40, 40, |x, y| x < 6 && y < 6);
        let crop =
            Crop::new(&corner, &Mask::empty(40, 40), corner.bbox_px().expect("pixels"), CELL_PX as usize);
        assert_eq!(shown(&image, &crop).pixel(0, 0), [255; 4]);
    }
}
