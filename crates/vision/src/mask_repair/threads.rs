//! Threads: parts so thin that none of their pixels need show their color pure, nor that of the thing beside them.

use std::collections::{BTreeMap, VecDeque};

use glam::Vec3;

use super::{GROUND_LEVELS, Growth, LONGEST_PX, NOBODY, Reached};
use imaging::distance_transform::distance_transform;

/// Least share of a pixel that a thread covers.
const THREAD_COVERS: f32 = 0.25;

/// A thread's pixel lies so near to a mixture of the ground with a color of the thing, as a share of its distance from
/// the ground, or within so many sRGB levels.
const THREAD_OFF: (f32, f32) = (0.5, 8.0);

/// Colors that cover at least this share of a mask are the thing's.
const COLOR_SHARE: f32 = 0.01;

/// Half the thickness of a thread at most, pixels.
const THREAD_PX: f32 = 2.0;

/// A thread ends at least so far from what it grew from, pixels; less is the blurred edge of the thing.
const THREAD_END_PX: f32 = 3.5;

impl Growth {
    /// Grows on where colors are mostly the ground's, and keeps of that what is thin and leads away.
    pub(super) fn grow_threads(&mut self) {
        let before: Vec<bool> = self.reached.iter().map(|r| r.owner != NOBODY).collect();
        let palettes = self.palettes();
        let mut front: VecDeque<usize> = (0..before.len()).filter(|&at| before[at]).collect();
        while let Some(from) = front.pop_front() {
            let Reached { owner, steps, color } = self.reached[from];
            if steps >= LONGEST_PX {
                continue;
            }
            let open: Vec<usize> = self.around(from).filter(|&n| self.reached[n].owner == NOBODY).collect();
            for at in open {
                if self.is_thread(at, &palettes[usize::from(owner)]) {
                    self.reached[at] = Reached { owner, steps: steps + 1, color };
                    front.push_back(at);
                }
            }
        }
        let from_before_px = distance_transform(&before, self.width, self.height);
        let outside: Vec<bool> = self.reached.iter().map(|r| r.owner == NOBODY).collect();
        let inward_px = distance_transform(&outside, self.width, self.height);
        let is_new = |at: usize| !before[at] && !outside[at];
        for part in self.parts(is_new) {
            let thin = part.iter().all(|&at| inward_px[at] <= THREAD_PX);
            let leads_away = part.iter().any(|&at| from_before_px[at] >= THREAD_END_PX);
            if !(thin && leads_away) {
                part.iter().for_each(|&at| self.reached[at] = Reached::NOT);
            }
        }
    }

    /// Whether the pixel mixes the ground with one of these colors.
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
                covered >= THREAD_COVERS && beside <= THREAD_OFF.1.max(THREAD_OFF.0 * from_ground)
            })
    }

    /// The colors of each mask, means of cubes of the color space.
    fn palettes(&self) -> Vec<Vec<Vec3>> {
        let count = self.reached.iter().filter(|r| r.owner != NOBODY).map(|r| usize::from(r.owner) + 1).max();
        let mut cubes: Vec<BTreeMap<[u8; 3], (Vec3, f32)>> = vec![BTreeMap::new(); count.unwrap_or(0)];
        for (reached, &color) in self.reached.iter().zip(&self.colors).filter(|(r, _)| r.owner != NOBODY) {
            let cube = color.to_array().map(|level| level as u8 / 32);
            let (sum, pixels) = cubes[usize::from(reached.owner)].entry(cube).or_default();
            *sum += color;
            *pixels += 1.0;
        }
        let of_mask = |cubes: BTreeMap<[u8; 3], (Vec3, f32)>| {
            let all: f32 = cubes.values().map(|(_, pixels)| pixels).sum();
            let large = cubes.into_values().filter(|(_, pixels)| *pixels >= COLOR_SHARE * all);
            large.map(|(sum, pixels)| sum / pixels).collect()
        };
        cubes.into_iter().map(of_mask).collect()
    }
}
