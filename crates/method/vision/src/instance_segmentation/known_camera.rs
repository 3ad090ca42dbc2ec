//! Knowledge of the camera beside an image: its intrinsics, and the depths of its pixels.

use glam::DVec2;

use super::camera_fit::{ExpectedCamera, Lens};
use crate::intrinsics::Intrinsics;
use crate::measured_depth::{DepthCopy, DepthDoubt, DepthUse, HeightRange, TopPlane};
use crate::pixels::Pixels;
use crate::table_network::maps::Maps;
use geometry::Camera;
use imaging::{DepthImage, Mask};

/// Knowledge beside an image; by default none.
#[derive(Clone, Copy, Debug, Default)]
pub struct KnownCamera<'a> {
    pub intrinsics: Option<Intrinsics>,
    /// Of the aspect of the image, pixel by pixel. Without intrinsics it is not used.
    pub depth: Option<&'a DepthImage>,
}

impl KnownCamera<'_> {
    /// The stated principal point.
    pub(super) fn center_px(&self) -> Option<DVec2> {
        self.intrinsics.and_then(|intrinsics| intrinsics.center_px)
    }

    /// The camera before the outline of the top is fitted: measured by the depth, or predicted by the network.
    pub(super) fn expected(
        &self,
        whole: &Maps,
        plane: Option<&TopPlane>,
        [width_px, height_px]: [u32; 2],
        pixels: &Pixels,
    ) -> ExpectedCamera {
        let longer_px = f64::from(width_px.max(height_px));
        let known_focal = self.intrinsics.map(|intrinsics| intrinsics.focal_px.x / longer_px);
        let (predicted_rad, focal) = whole.camera(known_focal);
        let lens = self.intrinsics.and_then(|intrinsics| {
            let center_px = pixels.scale * intrinsics.center_px?;
            Some(Lens { center_px, focal_ratio: intrinsics.focal_px.y / intrinsics.focal_px.x })
        });
        // The network assumes a centered principal point.
        let off_center_rad = lens.map_or(0.0, |lens| {
            let focal_px = focal * pixels.width.max(pixels.height) as f64 * lens.focal_ratio;
            ((lens.center_px.y - 0.5 * pixels.height as f64) / focal_px).atan()
        });
        ExpectedCamera {
            elevation_rad: plane.map_or(predicted_rad + off_center_rad, TopPlane::elevation_rad),
            focal,
            is_focal_known: known_focal.is_some(),
            measured_roll_rad: plane.map(TopPlane::roll_rad),
            lens,
        }
    }
}

/// Measurements of a depth image.
pub(super) struct Measured {
    /// The plane of the top, or the reason why the depth is not used; `None` without a depth image.
    plane: Option<Result<TopPlane, DepthDoubt>>,
    /// Heights of each object.
    pub heights: Vec<Option<HeightRange>>,
    /// For each pixel of the copy whether it shows the plane of the top; `None` where that is not known.
    pub shows_plane: Vec<Option<bool>>,
}

impl Measured {
    /// `on_top` are the pixels of the copy that show the bare top, `masks` those of the objects.
    pub fn new(known: &KnownCamera, on_top: &[bool], masks: &[Mask], pixels: &Pixels) -> Self {
        let Some((depth, intrinsics)) = known.depth.zip(known.intrinsics) else {
            let (heights, shows_plane) = (vec![None; masks.len()], vec![None; pixels.len()]);
            return Self { plane: None, heights, shows_plane };
        };
        let depth = DepthCopy::new(depth, &intrinsics, pixels);
        let mut bare = on_top.to_vec();
        for mask in masks {
            bare.iter_mut().zip(mask.bits()).for_each(|(bare, covered)| *bare &= !covered);
        }
        let plane = TopPlane::fit(&depth, &bare);
        let height_range =
            |mask: &Mask| plane.as_ref().ok().and_then(|plane| HeightRange::of(&depth, plane, mask.bits()));
        let heights = masks.iter().map(height_range).collect();
        let shown = |index: usize| plane.as_ref().ok().and_then(|plane| plane.is_shown_at(&depth, index));
        let shows_plane = (0..pixels.len()).map(shown).collect();
        Self { plane: Some(plane), heights, shows_plane }
    }

    /// The plane of the top, if it was found.
    pub fn plane(&self) -> Option<&TopPlane> {
        self.plane.as_ref()?.as_ref().ok()
    }

    /// Contribution of the depth to a reading with that camera.
    pub fn depth_use(&self, camera: &Camera) -> Option<DepthUse> {
        Some(match self.plane.as_ref()? {
            Ok(plane) => DepthUse::Used {
                meters_per_unit: plane.camera_height_m() / camera.world_from_camera.translation_m.z,
                plane_rms_m: plane.rms_m,
            },
            Err(doubt) => DepthUse::Unused(doubt.clone()),
        })
    }
}
