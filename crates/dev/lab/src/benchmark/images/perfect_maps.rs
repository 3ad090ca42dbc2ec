//! Network maps computed from the ground truth, in the encoding of the training targets (`training/targets.py`).
//! Errors that remain with them are caused by the decoding of the maps, not by the network.

use glam::{DVec2, DVec3};

use super::score::center as center_of;
use crate::synthetic_images::{Labels, ObjectTruth, SyntheticImage};
use geometry::Outline;
use imaging::Image;
use runtime::CancelFlag;
use vision::NetworkError;
use vision::table_network::frame::ImageCrop;
use vision::table_network::maps::channel::{
    BASE, BORDER, CENTER, FOCAL, GROUND_ROW, KINDS, LATITUDE, OFFSET, OUTLINE, TOP_ROW,
};
use vision::table_network::maps::{Maps, OFFSET_UNIT};
use vision::table_network::{DensePredictor, MAP_CHANNELS, RawMaps};

/// Frame pixels per map pixel.
const STRIDE: usize = 2;
/// Standard deviation of the peak at an object center, map pixels.
const CENTER_SIGMA: f64 = 2.5;
/// Samples of a map pixel along each side: edges are as soft as a map pixel.
const FINE: usize = 4;
/// Logit of certain values.
const SURE: f64 = 6.0;
/// Minimum share of a class, so that logarithms stay finite.
const MIN_SHARE: f64 = 1e-3;

/// A predictor that returns ground-truth maps.
pub struct PerfectMaps<'a> {
    pub image: &'a SyntheticImage,
    /// Offset added to the camera elevation, radians.
    pub elevation_off_rad: f64,
}

impl<'a> PerfectMaps<'a> {
    pub fn new(sample: &'a SyntheticImage) -> Self {
        Self { image: sample, elevation_off_rad: 0.0 }
    }
}

impl DensePredictor for PerfectMaps<'_> {
    fn maps(&self, _: &Image, crop: ImageCrop, cancel: &CancelFlag) -> Result<Maps, NetworkError> {
        cancel.check()?;
        let [width, height] = crop.frame_px.map(|side| side / STRIDE);
        let maps = vec![0.0; MAP_CHANNELS * width * height];
        let elevation_rad = self.image.truth.elevation_rad + self.elevation_off_rad;
        let mut builder = MapBuilder { sample: self.image, elevation_rad, crop, width, height, maps };
        builder.build();
        Ok(Maps::new(RawMaps { maps: builder.maps, width, height }, crop))
    }
}

/// Map targets of one object, map positions.
#[derive(Clone, Copy)]
struct ObjectTargets {
    center: DVec2,
    base: DVec2,
    top_row: f64,
    ground_row: f64,
}

struct MapBuilder<'a> {
    sample: &'a SyntheticImage,
    elevation_rad: f64,
    crop: ImageCrop,
    width: usize,
    height: usize,
    maps: Vec<f32>,
}

impl MapBuilder<'_> {
    fn build(&mut self) {
        let labels: Vec<u8> =
            (0..self.width * self.height).map(|index| self.label(self.center(index))).collect();
        let targets: Vec<Option<ObjectTargets>> =
            (0..self.sample.truth.objects.len()).map(|k| self.target(k, &labels)).collect();
        let outline = Outline::new(self.sample.truth.table.outline_m.clone()).ok();
        let camera = &self.sample.truth.camera;
        let longer_px = f64::from(camera.width_px.max(camera.height_px));
        let focal = camera.fx / longer_px;
        for (index, &label) in labels.iter().enumerate() {
            let position = self.center(index);
            let mut kinds = [0.0; KINDS];
            let mut inside = 0.0;
            let part = 1.0 / (FINE * FINE) as f64;
            for k in 0..FINE * FINE {
                let off = DVec2::new((k % FINE) as f64 + 0.5, (k / FINE) as f64 + 0.5) / FINE as f64 - 0.5;
                kinds[usize::from(self.label(position + off).min(Labels::FIRST_OBJECT))] += part;
                let met = camera.meet_plane(self.in_image(position + off), 0.0);
                let is_inside = outline.as_ref().zip(met).is_some_and(|(o, p)| o.contains(p.truncate()));
                inside += if is_inside { part } else { 0.0 };
            }
            for (kind, share) in kinds.into_iter().enumerate() {
                self.set(kind, index, share.max(MIN_SHARE).ln());
            }
            let inside = inside.clamp(MIN_SHARE, 1.0 - MIN_SHARE);
            self.set(OUTLINE, index, (inside / (1.0 - inside)).ln());
            let nearest = targets.iter().flatten().map(|target| (target.center - position).length_squared());
            let heat = nearest.map(|d| (-0.5 * d / CENTER_SIGMA.powi(2)).exp()).fold(0.0, f64::max);
            self.set(CENTER, index, heat);
            let slant = (STRIDE as f64 * (position.y - 0.5 * self.height as f64))
                .atan2(focal * self.crop.scale * longer_px);
            self.set(LATITUDE, index, self.elevation_rad + slant);
            self.set(FOCAL, index, focal.ln());
            self.set(BORDER, index, if self.is_beside_another(index, &labels) { SURE } else { -SURE });
            let own = label.checked_sub(Labels::FIRST_OBJECT).and_then(|k| targets[usize::from(k)]);
            let Some(target) = own else { continue };
            for (channel, to) in [(OFFSET, target.center), (BASE, target.base)] {
                self.set(channel, index, (to.x - position.x) / OFFSET_UNIT);
                self.set(channel + 1, index, (to.y - position.y) / OFFSET_UNIT);
            }
            self.set(TOP_ROW, index, (target.top_row - position.y) / OFFSET_UNIT);
            self.set(GROUND_ROW, index, (target.ground_row - position.y) / OFFSET_UNIT);
        }
    }

    /// Map targets of a visible object; `None` if it is hidden.
    fn target(&self, k: usize, labels: &[u8]) -> Option<ObjectTargets> {
        let label = Labels::FIRST_OBJECT + k as u8;
        let own =
            labels.iter().enumerate().filter(|(_, l)| **l == label).map(|(index, _)| self.center(index));
        let (sum, count) = own.fold((DVec2::ZERO, 0.0), |(sum, count), p| (sum + p, count + 1.0));
        let object: &ObjectTruth = &self.sample.truth.objects[k];
        let foot_m = center_of(&object.footprint_m)?;
        let at = |z: f64| self.in_map(foot_m.extend(z));
        let (base, top) = (at(object.contact_z_m)?, at(object.contact_z_m + object.size_m.z)?);
        (count > 0.0).then_some(ObjectTargets {
            center: sum / count,
            base,
            top_row: top.y,
            ground_row: at(0.0)?.y,
        })
    }

    /// Whether an object borders on another one at this pixel.
    fn is_beside_another(&self, index: usize, labels: &[u8]) -> bool {
        let (x, y) = (index % self.width, index / self.width);
        let is_object = |label: u8| label >= Labels::FIRST_OBJECT;
        let mut around = (y.saturating_sub(1)..(y + 2).min(self.height))
            .flat_map(|v| (x.saturating_sub(1)..(x + 2).min(self.width)).map(move |u| (u, v)))
            .map(|(u, v)| labels[v * self.width + u]);
        is_object(labels[index]) && around.any(|label| is_object(label) && label != labels[index])
    }

    fn center(&self, index: usize) -> DVec2 {
        DVec2::new((index % self.width) as f64 + 0.5, (index / self.width) as f64 + 0.5)
    }

    fn in_image(&self, p: DVec2) -> DVec2 {
        self.crop.in_image(STRIDE as f64 * p)
    }

    /// Map position of a world point; `None` behind the camera.
    fn in_map(&self, point: DVec3) -> Option<DVec2> {
        let (pixel, _) = self.sample.truth.camera.project(point)?;
        Some(self.crop.in_frame(pixel) / STRIDE as f64)
    }

    /// Label of the front-most surface at a map position; padding counts as backdrop.
    fn label(&self, p: DVec2) -> u8 {
        let (labels, p) = (&self.sample.labels, self.in_image(p));
        let shows =
            p.x >= 0.0 && p.y >= 0.0 && p.x < f64::from(labels.width_px) && p.y < f64::from(labels.height_px);
        if shows {
            labels.values[p.y as usize * labels.width_px as usize + p.x as usize]
        } else {
            Labels::BACKDROP
        }
    }

    fn set(&mut self, channel: usize, index: usize, value: f64) {
        self.maps[channel * self.width * self.height + index] = value as f32;
    }
}
