//! Masks whose edges are eaten into, regrown to where the picture says the thing ends.
//!
//! A network's mask stops some pixels short of a thing's edge, is holed, and loses what is thinner than that: a thread,
//! a leaf, a ring. The picture still shows it. Masks grow, all at once and pixel by pixel, into pixels that no mask
//! claims and whose color is nearer to that of the mask beside them than to that of the ground around, where the ground
//! may be darker than elsewhere: shadows are nobody's. What has grown farther than erosion reaches stays only where it
//! is thin. Then threads grow ([`threads`]).
//!
//! Cost: a few passes over the picture and some hundred operations for each pixel along the edges.

mod ground;
mod threads;

use std::collections::VecDeque;

use glam::Vec3;

use self::ground::Ground;
use imaging::distance_transform::distance_transform;
use imaging::{Image, Mask};

/// Erosion is mended up to this depth, pixels; whatever grows farther must be thin.
const EROSION_PX: f32 = 4.0;

/// Half the thickness of a thin part at most, pixels.
const THIN_PX: f32 = 4.0;

/// Thin parts grow by at most so many pixels.
const LONGEST_PX: u16 = 96;

/// Distance from the ground's color, over all shades of it, up to which a pixel is ground, sRGB levels.
const GROUND_LEVELS: f32 = 12.0;

/// Reach of the mean color of a mask beside a pixel, pixels.
const BESIDE_PX: usize = 2;

/// Share of a grown pixel's own color in the color that grows on from it.
const FOLLOWED: f32 = 0.15;

/// How much farther from the mask than from the ground a color may be: where edges mix with the ground.
const LENIENCE: f32 = 1.25;

/// No mask.
const NOBODY: u16 = u16::MAX;

/// The masks, as large as the picture and in their order, with their edges and thin parts regrown. Where masks
/// overlap none grows. No pixel is lost.
pub fn repaired(picture: &Image, masks: &[Mask]) -> Vec<Mask> {
    let (width, height) = (picture.width_px() as usize, picture.height_px() as usize);
    let fits = |mask: &Mask| (mask.width_px() as usize, mask.height_px() as usize) == (width, height);
    if masks.len() >= usize::from(NOBODY) || !masks.iter().all(fits) {
        return masks.to_vec();
    }
    let mut growth = Growth::new(picture, masks);
    growth.grow();
    growth.grow_threads();
    growth.without_thick_spurs(masks)
}

/// A pixel that was reached.
#[derive(Clone, Copy)]
struct Reached {
    owner: u16,
    /// Steps from the mask it grew from.
    steps: u16,
    /// Color that its neighbors are compared with.
    color: Vec3,
}

impl Reached {
    /// By nobody.
    const NOT: Self = Self { owner: NOBODY, steps: 0, color: Vec3::ZERO };
}

struct Growth {
    width: usize,
    height: usize,
    colors: Vec<Vec3>,
    reached: Vec<Reached>,
    ground: Ground,
}

impl Growth {
    fn new(picture: &Image, masks: &[Mask]) -> Self {
        let (width, height) = (picture.width_px() as usize, picture.height_px() as usize);
        let color = |p: &[u8]| Vec3::new(f32::from(p[0]), f32::from(p[1]), f32::from(p[2]));
        let colors: Vec<Vec3> = picture.as_rgba().chunks_exact(4).map(color).collect();
        let mut owners = vec![NOBODY; width * height];
        for (owner, mask) in masks.iter().enumerate() {
            let claimed = owners.iter_mut().zip(mask.bits()).filter(|(_, bit)| **bit);
            claimed.for_each(|(own, _)| *own = owner as u16);
        }
        let claimed: Vec<bool> = owners.iter().map(|&owner| owner != NOBODY).collect();
        let ground = Ground::new(&colors, &claimed, width, height);
        let reached = owners.iter().map(|&owner| Reached { owner, ..Reached::NOT }).collect();
        Self { width, height, colors, reached, ground }
    }

    /// Breadth first, so that what two masks could have goes to the nearer.
    fn grow(&mut self) {
        let mut front: VecDeque<usize> = VecDeque::new();
        for at in 0..self.reached.len() {
            if self.reached[at].owner != NOBODY && self.neighbors(at).any(|n| self.reached[n].owner == NOBODY)
            {
                self.reached[at].color = self.beside(at);
                front.push_back(at);
            }
        }
        while let Some(from) = front.pop_front() {
            let parent = self.reached[from];
            if parent.steps >= LONGEST_PX {
                continue;
            }
            let open: Vec<usize> =
                self.neighbors(from).filter(|&n| self.reached[n].owner == NOBODY).collect();
            for at in open {
                let own = self.colors[at];
                let Some(ground) = self.ground.nearest(at % self.width, at / self.width, own) else {
                    continue;
                };
                let from_ground = own.distance(ground);
                if from_ground > GROUND_LEVELS && own.distance(parent.color) < LENIENCE * from_ground {
                    let color = parent.color.lerp(own, FOLLOWED);
                    self.reached[at] = Reached { owner: parent.owner, steps: parent.steps + 1, color };
                    front.push_back(at);
                }
            }
        }
    }

    /// The up to eight pixels around one.
    fn around(&self, at: usize) -> impl Iterator<Item = usize> + use<> {
        let (x, y, width, height) = (at % self.width, at / self.width, self.width, self.height);
        let (left, right) = (x.saturating_sub(1), (x + 2).min(width));
        let (top, bottom) = (y.saturating_sub(1), (y + 2).min(height));
        (top..bottom).flat_map(move |v| (left..right).map(move |u| v * width + u)).filter(move |&n| n != at)
    }

    /// Connected pixels of one owner among those that are `wanted`.
    fn parts(&self, wanted: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
        let mut seen = vec![false; self.reached.len()];
        let mut parts = Vec::new();
        for start in 0..self.reached.len() {
            if seen[start] || !wanted(start) {
                continue;
            }
            let owner = self.reached[start].owner;
            let (mut part, mut next) = (vec![start], 0);
            seen[start] = true;
            while next < part.len() {
                for at in self.around(part[next]) {
                    if !seen[at] && wanted(at) && self.reached[at].owner == owner {
                        seen[at] = true;
                        part.push(at);
                    }
                }
                next += 1;
            }
            parts.push(part);
        }
        parts
    }

    fn neighbors(&self, at: usize) -> impl Iterator<Item = usize> + use<> {
        let (x, y, width, height) = (at % self.width, at / self.width, self.width, self.height);
        let beside = [
            (x > 0).then(|| at - 1),
            (x + 1 < width).then(|| at + 1),
            (y > 0).then(|| at - width),
            (y + 1 < height).then(|| at + width),
        ];
        beside.into_iter().flatten()
    }

    /// Mean color of the pixel's mask around it.
    fn beside(&self, at: usize) -> Vec3 {
        let (x, y, owner) = (at % self.width, at / self.width, self.reached[at].owner);
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        for v in y.saturating_sub(BESIDE_PX)..(y + BESIDE_PX + 1).min(self.height) {
            for u in x.saturating_sub(BESIDE_PX)..(x + BESIDE_PX + 1).min(self.width) {
                let k = v * self.width + u;
                if self.reached[k].owner == owner {
                    sum += self.colors[k];
                    count += 1.0;
                }
            }
        }
        sum / count
    }

    /// The masks with what has grown, but for connected parts beyond the reach of erosion that are not thin.
    fn without_thick_spurs(&self, masks: &[Mask]) -> Vec<Mask> {
        let (width, height) = (self.width, self.height);
        let mut grown: Vec<Vec<bool>> = masks.iter().map(|mask| mask.bits().to_vec()).collect();
        let taken = |grown: &[Vec<bool>]| -> Vec<bool> {
            (0..width * height).map(|at| grown.iter().any(|bits| bits[at])).collect()
        };
        let from_masks_px = distance_transform(&taken(&grown), width, height);
        for (at, reached) in self.reached.iter().enumerate().filter(|(_, r)| r.steps > 0) {
            grown[usize::from(reached.owner)][at] = true;
        }
        let outside: Vec<bool> = taken(&grown).iter().map(|bit| !bit).collect();
        let inward_px = distance_transform(&outside, width, height);
        let far = |at: usize| self.reached[at].steps > 0 && from_masks_px[at] > EROSION_PX;
        for part in self.parts(far) {
            if part.iter().any(|&at| inward_px[at] > THIN_PX) {
                let owner = usize::from(self.reached[part[0]].owner);
                part.iter().for_each(|&at| grown[owner][at] = false);
            }
        }
        grown.into_iter().map(|bits| Mask::from_bits(width as u32, height as u32, bits)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE_PX: u32 = 96;
    const WOOD: [u8; 3] = [176, 134, 92];

    /// A picture of 96 x 96 pixels.
    fn painted(color: impl Fn(u32, u32) -> [u8; 3]) -> Image {
        let mut picture = Image::filled(SIDE_PX, SIDE_PX, [0, 0, 0, 255]);
        for y in 0..SIDE_PX {
            for x in 0..SIDE_PX {
                let [r, g, b] = color(x, y);
                picture.set_pixel(x, y, [r, g, b, 255]);
            }
        }
        picture
    }

    fn mask(inside: impl Fn(u32, u32) -> bool) -> Mask {
        Mask::from_fn(SIDE_PX, SIDE_PX, inside)
    }

    fn within(at: u32, low: u32, high: u32) -> bool {
        (low..high).contains(&at)
    }

    #[test]
    fn an_eroded_spool_gets_back_its_edge_and_its_thread() {
        // A thread of two pixels was gone from the mask, and the spool was turned until its own hid behind it.
        let spool = |x: u32, y: u32| within(x, 30, 60) && within(y, 30, 70);
        let thread = |x: u32, y: u32| within(x, 60, 84) && within(y, 50, 52);
        let picture = painted(|x, y| if spool(x, y) || thread(x, y) { [40, 70, 190] } else { WOOD });
        let hole = |x: u32, y: u32| within(x, 40, 44) && within(y, 40, 44);
        let eroded = mask(|x, y| within(x, 32, 58) && within(y, 33, 68) && !hole(x, y));
        let repaired = repaired(&picture, &[eroded]);
        assert_eq!(repaired[0], mask(|x, y| spool(x, y) || thread(x, y)));
    }

    #[test]
    fn a_thread_that_covers_no_pixel_whole_and_leaves_at_a_rim_of_another_color_is_found() {
        // The end of a spool's winding leaves behind its white rim; on the wood it was half the wood's color.
        let (rim, winding) = (
            |x: u32, y: u32| within(x, 30, 60) && within(y, 30, 40),
            |x: u32, y: u32| within(x, 34, 56) && within(y, 40, 70),
        );
        let thread = |x: u32, y: u32| within(x, 60, 84) && y == 35 + (x - 60) / 2;
        let half: [u8; 3] = std::array::from_fn(|k| ((u32::from(WOOD[k]) + [40, 70, 190][k]) / 2) as u8);
        let picture = painted(|x, y| match () {
            () if rim(x, y) => [240, 238, 230],
            () if winding(x, y) => [40, 70, 190],
            () if thread(x, y) => half,
            () => WOOD,
        });
        let repaired = repaired(&picture, &[mask(|x, y| rim(x, y) || winding(x, y))]);
        assert_eq!(repaired[0], mask(|x, y| rim(x, y) || winding(x, y) || thread(x, y)));
    }

    #[test]
    fn a_ring_of_the_hue_of_the_wood_at_a_third_of_its_light_is_no_shadow() {
        // Candle holders of brass lost their rings on light wood, and were turned until the ring hid behind the candle.
        let dish = |x: u32, y: u32| within(x, 30, 60) && within(y, 30, 70);
        let ring = |x: u32, y: u32| within(x, 60, 84) && within(y, 50, 52);
        let picture = painted(|x, y| if dish(x, y) || ring(x, y) { [60, 46, 26] } else { WOOD });
        let repaired = repaired(&picture, &[mask(|x, y| within(x, 32, 58) && within(y, 33, 68))]);
        assert_eq!(repaired[0], mask(|x, y| dish(x, y) || ring(x, y)));
    }

    #[test]
    fn shadows_and_other_things_are_left_alone() {
        let thing = |x: u32, y: u32| within(x, 30, 50) && within(y, 30, 60);
        let neighbor = |x: u32, y: u32| within(x, 50, 70) && within(y, 30, 60);
        let shadow = |x: u32, y: u32| within(x, 26, 76) && within(y, 60, 68);
        let picture = painted(|x, y| match () {
            () if thing(x, y) || neighbor(x, y) => [60, 40, 35],
            () if shadow(x, y) => WOOD.map(|level| level / 2),
            () => WOOD,
        });
        let masks = [mask(thing), mask(neighbor)];
        assert_eq!(repaired(&picture, &masks), masks);
    }

    #[test]
    fn a_large_thing_of_the_same_color_is_not_swallowed() {
        let thing = |x: u32, y: u32| within(x, 20, 40) && within(y, 30, 60);
        // Touches the thing and has no mask.
        let other = |x: u32, y: u32| within(x, 40, 80) && within(y, 30, 60);
        let picture = painted(|x, y| if thing(x, y) || other(x, y) { [200, 60, 50] } else { WOOD });
        let repaired = repaired(&picture, &[mask(thing)]);
        assert!(repaired[0].area_px() <= mask(thing).area_px() + 30 * (EROSION_PX as usize + 1));
    }

    #[test]
    fn a_thing_like_the_ground_keeps_its_mask() {
        let picture = painted(|_, _| WOOD);
        let masks = [mask(|x, y| within(x, 30, 50) && within(y, 30, 60))];
        assert_eq!(repaired(&picture, &masks), masks);
    }
}
