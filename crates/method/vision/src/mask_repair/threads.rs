//! Growth of threads: parts so thin that no pixel shows their pure color.

use std::collections::{BTreeMap, VecDeque};

use glam::Vec3;

use super::{GROUND_LEVELS, GrownPixel, Growth, LONGEST_PX, UNASSIGNED};
use imaging::distance_transform::distance_transform;

/// Minimum share of a pixel that a thread covers.
const MIN_COVERAGE: f32 = 0.25;

/// Maximum distance of a thread's pixel from a mixture of ground and object color: as a share of its distance from
/// the ground, and in sRGB levels.
const MAX_MIX_ERROR: (f32, f32) = (0.5, 8.0);

/// Minimum share of a mask that a color of its palette covers.
const MIN_COLOR_SHARE: f32 = 0.01;

/// Maximum half thickness of a thread, pixels.
const MAX_HALF_WIDTH_PX: f32 = 2.0;

/// Minimum distance of a thread's end from its origin, pixels; less is a blurred edge.
const MIN_REACH_PX: f32 = 3.5;

impl Growth {
    /// Grows into mixtures with the ground, and keeps thin parts that lead away.
    pub(super) fn grow_threads(&mut self) {
        let before: Vec<bool> = self.reached.iter().map(|r| r.owner != UNASSIGNED).collect();
        let palettes = self.palettes();
        let mut front: VecDeque<usize> = (0..before.len()).filter(|&at| before[at]).collect();
        while let Some(from) = front.pop_front() {
            let GrownPixel { owner, steps, color } = self.reached[from];
            if steps >= LONGEST_PX {
                continue;
            }
            let open: Vec<usize> =
                self.around(from).filter(|&n| self.reached[n].owner == UNASSIGNED).collect();
            for at in open {
                if self.is_thread(at, &palettes[usize::from(owner)]) {
                    self.reached[at] = GrownPixel { owner, steps: steps + 1, color };
                    front.push_back(at);
                }
            }
        }
        let from_before_px = distance_transform(&before, self.width, self.height);
        let outside: Vec<bool> = self.reached.iter().map(|r| r.owner == UNASSIGNED).collect();
        let inward_px = distance_transform(&outside, self.width, self.height);
        let is_new = |at: usize| !before[at] && !outside[at];
        for part in self.parts(is_new) {
            let thin = part.iter().all(|&at| inward_px[at] <= MAX_HALF_WIDTH_PX);
            let leads_away = part.iter().any(|&at| from_before_px[at] >= MIN_REACH_PX);
            if !(thin && leads_away) {
                part.iter().for_each(|&at| self.reached[at] = GrownPixel::UNREACHED);
            }
        }
    }

    /// Whether the pixel mixes the ground with a color of the palette.
    fn is_thread(&self, at: usize, palette: &[Vec3]) -> bool {
        let own = self.colors[at];
        let Some(ground) = self.ground.nearest(at % self.width, at / self.width, own) else { return false };
        let off = own - ground;
        let from_ground = off.length();
        from_ground > GROUND_LEVELS
            && palette.iter().any(|&color| {
                let whole = color - ground;
                let covered = off.dot(whole) / whole.length_squared().max(1.0);
                let beside = off.distance(covered.min(1.0) * whole);
                covered >= MIN_COVERAGE && beside <= MAX_MIX_ERROR.1.max(MAX_MIX_ERROR.0 * from_ground)
            })
    }

    /// The palette of each mask: means over cubes of the color space.
    fn palettes(&self) -> Vec<Vec<Vec3>> {
        let count =
            self.reached.iter().filter(|r| r.owner != UNASSIGNED).map(|r| usize::from(r.owner) + 1).max();
        let mut cubes: Vec<BTreeMap<[u8; 3], (Vec3, f32)>> = vec![BTreeMap::new(); count.unwrap_or(0)];
        for (reached, &color) in self.reached.iter().zip(&self.colors).filter(|(r, _)| r.owner != UNASSIGNED)
        {
            let cube = color.to_array().map(|level| level as u8 / 32);
            let (sum, pixels) = cubes[usize::from(reached.owner)].entry(cube).or_default();
            *sum += color;
            *pixels += 1.0;
        }
        let of_mask = |cubes: BTreeMap<[u8; 3], (Vec3, f32)>| {
            let all: f32 = cubes.values().map(|(_, pixels)| pixels).sum();
            let large = cubes.into_values().filter(|(_, pixels)| *pixels >= MIN_COLOR_SHARE * all);
            large.map(|(sum, pixels)| sum / pixels).collect()
        };
        cubes.into_iter().map(of_mask).collect()
    }
}
