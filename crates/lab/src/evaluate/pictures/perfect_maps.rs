//! Maps that say what was painted, as the network is taught to say it (`training/targets.py`): what is lost with them is
//! lost by the reading of maps and not by the network.

use glam::{DVec2, DVec3};

use super::score::middle as middle_of;
use crate::synthetic::{Labels, ObjectTruth, Painting};
use geometry::Outline;
use imaging::Image;
use runtime::Interrupt;
use vision::network::frame::Look;
use vision::network::maps::channel::{
    BASE, BORDER, CENTER, FOCAL, GROUND_ROW, KINDS, LATITUDE, OFFSET, OUTLINE, TOP_ROW,
};
use vision::network::maps::{Maps, OFFSET_UNIT};
use vision::network::{Answer, Looks, MAP_CHANNELS, NetworkError};

/// Frame pixels a map pixel.
const STRIDE: usize = 2;
/// Standard deviation of the bump at a thing's middle, map pixels.
const CENTER_SIGMA: f64 = 2.5;
/// Places of a map pixel that are looked at, along each side: edges are as soft as a map pixel.
const FINE: usize = 4;
/// Logit of what is certain.
const SURE: f64 = 6.0;
/// Least share that anything has, so that logarithms stay finite.
const LEAST_SHARE: f64 = 1e-3;

/// Looks at a painting with the truth in its hands.
pub struct PerfectMaps<'a> {
    pub painting: &'a Painting,
    /// How far above the camera's elevation they say it to be.
    pub elevation_off_rad: f64,
}

impl<'a> PerfectMaps<'a> {
    pub fn new(painting: &'a Painting) -> Self {
        Self { painting, elevation_off_rad: 0.0 }
    }
}

impl Looks for PerfectMaps<'_> {
    fn maps(&self, _: &Image, look: Look, interrupt: &Interrupt) -> Result<Maps, NetworkError> {
        interrupt.check()?;
        let [width, height] = look.frame_px.map(|side| side / STRIDE);
        let maps = vec![0.0; MAP_CHANNELS * width * height];
        let elevation_rad = self.painting.truth.elevation_rad + self.elevation_off_rad;
        let mut drawn = Drawn { painting: self.painting, elevation_rad, look, width, height, maps };
        drawn.draw();
        Ok(Maps::new(Answer { maps: drawn.maps, width, height }, look))
    }
}

/// What is known of a thing, map positions.
#[derive(Clone, Copy)]
struct Fact {
    middle: DVec2,
    base: DVec2,
    top_row: f64,
    ground_row: f64,
}

struct Drawn<'a> {
    painting: &'a Painting,
    elevation_rad: f64,
    look: Look,
    width: usize,
    height: usize,
    maps: Vec<f32>,
}

impl Drawn<'_> {
    fn draw(&mut self) {
        let labels: Vec<u8> =
            (0..self.width * self.height).map(|index| self.label(self.middle(index))).collect();
        let facts: Vec<Option<Fact>> =
            (0..self.painting.truth.objects.len()).map(|k| self.fact(k, &labels)).collect();
        let outline = Outline::new(self.painting.truth.table.outline_m.clone()).ok();
        let camera = &self.painting.truth.camera;
        let longer_px = f64::from(camera.width_px.max(camera.height_px));
        let focal = camera.fx / longer_px;
        for (index, &label) in labels.iter().enumerate() {
            let middle = self.middle(index);
            let mut kinds = [0.0; KINDS];
            let mut inside = 0.0;
            let part = 1.0 / (FINE * FINE) as f64;
            for k in 0..FINE * FINE {
                let off = DVec2::new((k % FINE) as f64 + 0.5, (k / FINE) as f64 + 0.5) / FINE as f64 - 0.5;
                kinds[usize::from(self.label(middle + off).min(Labels::FIRST_OBJECT))] += part;
                let met = camera.meet_plane(self.in_picture(middle + off), 0.0);
                let is_inside = outline.as_ref().zip(met).is_some_and(|(o, p)| o.contains(p.truncate()));
                inside += if is_inside { part } else { 0.0 };
            }
            for (kind, share) in kinds.into_iter().enumerate() {
                self.set(kind, index, share.max(LEAST_SHARE).ln());
            }
            let inside = inside.clamp(LEAST_SHARE, 1.0 - LEAST_SHARE);
            self.set(OUTLINE, index, (inside / (1.0 - inside)).ln());
            let nearest = facts.iter().flatten().map(|fact| (fact.middle - middle).length_squared());
            let center = nearest.map(|d| (-0.5 * d / CENTER_SIGMA.powi(2)).exp()).fold(0.0, f64::max);
            self.set(CENTER, index, center);
            let slant = (STRIDE as f64 * (middle.y - 0.5 * self.height as f64))
                .atan2(focal * self.look.scale * longer_px);
            self.set(LATITUDE, index, self.elevation_rad + slant);
            self.set(FOCAL, index, focal.ln());
            self.set(BORDER, index, if self.is_beside_another(index, &labels) { SURE } else { -SURE });
            let own = label.checked_sub(Labels::FIRST_OBJECT).and_then(|k| facts[usize::from(k)]);
            let Some(fact) = own else { continue };
            for (channel, to) in [(OFFSET, fact.middle), (BASE, fact.base)] {
                self.set(channel, index, (to.x - middle.x) / OFFSET_UNIT);
                self.set(channel + 1, index, (to.y - middle.y) / OFFSET_UNIT);
            }
            self.set(TOP_ROW, index, (fact.top_row - middle.y) / OFFSET_UNIT);
            self.set(GROUND_ROW, index, (fact.ground_row - middle.y) / OFFSET_UNIT);
        }
    }

    /// Of a thing that shows.
    fn fact(&self, k: usize, labels: &[u8]) -> Option<Fact> {
        let label = Labels::FIRST_OBJECT + k as u8;
        let own =
            labels.iter().enumerate().filter(|(_, l)| **l == label).map(|(index, _)| self.middle(index));
        let (sum, count) = own.fold((DVec2::ZERO, 0.0), |(sum, count), p| (sum + p, count + 1.0));
        let object: &ObjectTruth = &self.painting.truth.objects[k];
        let foot_m = middle_of(&object.footprint_m)?;
        let at = |z: f64| self.in_map(foot_m.extend(z));
        let (base, top) = (at(object.contact_z_m)?, at(object.contact_z_m + object.size_m.z)?);
        (count > 0.0).then_some(Fact { middle: sum / count, base, top_row: top.y, ground_row: at(0.0)?.y })
    }

    /// Whether a thing ends there and another one begins.
    fn is_beside_another(&self, index: usize, labels: &[u8]) -> bool {
        let (x, y) = (index % self.width, index / self.width);
        let is_object = |label: u8| label >= Labels::FIRST_OBJECT;
        let mut around = (y.saturating_sub(1)..(y + 2).min(self.height))
            .flat_map(|v| (x.saturating_sub(1)..(x + 2).min(self.width)).map(move |u| (u, v)))
            .map(|(u, v)| labels[v * self.width + u]);
        is_object(labels[index]) && around.any(|label| is_object(label) && label != labels[index])
    }

    fn middle(&self, index: usize) -> DVec2 {
        DVec2::new((index % self.width) as f64 + 0.5, (index / self.width) as f64 + 0.5)
    }

    fn in_picture(&self, p: DVec2) -> DVec2 {
        self.look.in_picture(STRIDE as f64 * p)
    }

    /// Map position at which a point of the world is seen; `None` behind the camera.
    fn in_map(&self, point: DVec3) -> Option<DVec2> {
        let (pixel, _) = self.painting.truth.camera.project(point)?;
        Some(self.look.in_frame(pixel) / STRIDE as f64)
    }

    /// What is in front at a map position; the frame's filling shows backdrop.
    fn label(&self, p: DVec2) -> u8 {
        let (labels, p) = (&self.painting.labels, self.in_picture(p));
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
