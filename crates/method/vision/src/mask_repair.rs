//! Regrows eroded masks to the edges in the image.
//!
//! Masks of a network end some pixels inside the object. They have holes and lose what is thinner than that: a
//! thread, a leaf, a ring. Masks grow simultaneously, pixel by pixel, into unclaimed pixels whose color is nearer
//! to the adjacent mask than to the surrounding ground. The ground may be darker than elsewhere, so shadows stay
//! unclaimed. Parts that grow farther than the erosion depth remain only if they are thin. Then threads grow
//! ([`threads`]).
//!
//! Cost: a few passes over the image and some hundred operations for each pixel along the edges.

mod ground;
mod threads;

use std::collections::VecDeque;

use glam::Vec3;

use self::ground::Ground;
use imaging::distance_transform::distance_transform;
use imaging::{Image, Mask};

/// Repaired erosion depth, pixels; parts beyond must be thin.
const EROSION_PX: f32 = 4.0;

/// Maximum half thickness of a thin part, pixels.
const THIN_PX: f32 = 4.0;

/// Maximum growth of a thin part, pixels.
const LONGEST_PX: u16 = 96;

/// Distance from the ground's color, over all its shades, up to which a pixel is ground, sRGB levels.
const GROUND_LEVELS: f32 = 12.0;

/// Window of the mean color of a mask next to a pixel, pixels.
const BESIDE_PX: usize = 2;

/// Share of a grown pixel's own color in its reference color.
const FOLLOWED: f32 = 0.15;

/// Maximum ratio of the distance to the mask's color and that to the ground's: edges mix with the ground.
const GROUND_RATIO: f32 = 1.25;

/// Pixels of no mask.
const UNASSIGNED: u16 = u16::MAX;

/// The masks in their order, at the size of the image, with edges and thin parts regrown. No mask grows where
/// masks overlap. No pixel is lost.
pub fn repair(image: &Image, masks: &[Mask]) -> Vec<Mask> {
    let (width, height) = (image.width_px() as usize, image.height_px() as usize);
    let fits = |mask: &Mask| (mask.width_px() as usize, mask.height_px() as usize) == (width, height);
    if masks.len() >= usize::from(UNASSIGNED) || !masks.iter().all(fits) {
        return masks.to_vec();
    }
    let mut growth = Growth::new(image, masks);
    growth.grow();
    growth.grow_threads();
    growth.without_thick_spurs(masks)
}

/// A pixel of a grown mask.
#[derive(Clone, Copy)]
struct GrownPixel {
    owner: u16,
    /// Steps from the mask it grew from.
    steps: u16,
    /// Reference color for its neighbors.
    color: Vec3,
}

impl GrownPixel {
    /// A pixel of no mask.
    const UNREACHED: Self = Self { owner: UNASSIGNED, steps: 0, color: Vec3::ZERO };
}

struct Growth {
    width: usize,
    height: usize,
    colors: Vec<Vec3>,
    reached: Vec<GrownPixel>,
    ground: Ground,
}

impl Growth {
    fn new(image: &Image, masks: &[Mask]) -> Self {
        let (width, height) = (image.width_px() as usize, image.height_px() as usize);
        let color = |p: &[u8]| Vec3::new(f32::from(p[0]), f32::from(p[1]), f32::from(p[2]));
        let colors: Vec<Vec3> = image.as_rgba().chunks_exact(4).map(color).collect();
        let mut owners = vec![UNASSIGNED; width * height];
        for (owner, mask) in masks.iter().enumerate() {
            let claimed = owners.iter_mut().zip(mask.bits()).filter(|(_, bit)| **bit);
            claimed.for_each(|(own, _)| *own = owner as u16);
        }
        let claimed: Vec<bool> = owners.iter().map(|&owner| owner != UNASSIGNED).collect();
        let ground = Ground::new(&colors, &claimed, width, height);
        let reached = owners.iter().map(|&owner| GrownPixel { owner, ..GrownPixel::UNREACHED }).collect();
        Self { width, height, colors, reached, ground }
    }

    /// Breadth first, so that contested pixels go to the nearer mask.
    fn grow(&mut self) {
        let mut front: VecDeque<usize> = VecDeque::new();
        for at in 0..self.reached.len() {
            if self.reached[at].owner != UNASSIGNED
                && self.neighbors(at).any(|n| self.reached[n].owner == UNASSIGNED)
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
                self.neighbors(from).filter(|&n| self.reached[n].owner == UNASSIGNED).collect();
            for at in open {
                let own = self.colors[at];
                let Some(ground) = self.ground.nearest(at % self.width, at / self.width, own) else {
                    continue;
                };
                let from_ground = own.distance(ground);
                if from_ground > GROUND_LEVELS && own.distance(parent.color) < GROUND_RATIO * from_ground {
                    let color = parent.color.lerp(own, FOLLOWED);
                    self.reached[at] = GrownPixel { owner: parent.owner, steps: parent.steps + 1, color };
                    front.push_back(at);
                }
            }
        }
    }

    /// The up to eight neighbors of a pixel.
    fn around(&self, at: usize) -> impl Iterator<Item = usize> + use<> {
        let (x, y, width, height) = (at % self.width, at / self.width, self.width, self.height);
        let (left, right) = (x.saturating_sub(1), (x + 2).min(width));
        let (top, bottom) = (y.saturating_sub(1), (y + 2).min(height));
        (top..bottom).flat_map(move |v| (left..right).map(move |u| v * width + u)).filter(move |&n| n != at)
    }

    /// Connected components of one owner among the `wanted` pixels.
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

    /// The grown masks without thick components beyond the erosion depth.
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

    /// An image of 96 x 96 pixels.
    fn rendered(color: impl Fn(u32, u32) -> [u8; 3]) -> Image {
        let mut image = Image::filled(SIDE_PX, SIDE_PX, [0, 0, 0, 255]);
        for y in 0..SIDE_PX {
            for x in 0..SIDE_PX {
                let [r, g, b] = color(x, y);
                image.set_pixel(x, y, [r, g, b, 255]);
            }
        }
        image
    }

    fn mask(inside: impl Fn(u32, u32) -> bool) -> Mask {
        Mask::from_fn(SIDE_PX, SIDE_PX, inside)
    }

    fn within(at: u32, low: u32, high: u32) -> bool {
        (low..high).contains(&at)
    }

    #[test]
    fn repair_restores_edge_and_thread_of_eroded_spool() {
        // A thread of two pixels missing in the mask once led to a pose in which the spool hides its thread.
        let spool = |x: u32, y: u32| within(x, 30, 60) && within(y, 30, 70);
        let thread = |x: u32, y: u32| within(x, 60, 84) && within(y, 50, 52);
        let image = rendered(|x, y| if spool(x, y) || thread(x, y) { [40, 70, 190] } else { WOOD });
        let hole = |x: u32, y: u32| within(x, 40, 44) && within(y, 40, 44);
        let eroded = mask(|x, y| within(x, 32, 58) && within(y, 33, 68) && !hole(x, y));
        let repaired = repair(&image, &[eroded]);
        assert_eq!(repaired[0], mask(|x, y| spool(x, y) || thread(x, y)));
    }

    #[test]
    fn repair_finds_subpixel_thread_at_rim_of_other_color() {
        // The end of a winding leaves the spool behind its white rim, with half the color of the wood.
        let (rim, winding) = (
            |x: u32, y: u32| within(x, 30, 60) && within(y, 30, 40),
            |x: u32, y: u32| within(x, 34, 56) && within(y, 40, 70),
        );
        let thread = |x: u32, y: u32| within(x, 60, 84) && y == 35 + (x - 60) / 2;
        let half: [u8; 3] = std::array::from_fn(|k| ((u32::from(WOOD[k]) + [40, 70, 190][k]) / 2) as u8);
        let image = rendered(|x, y| match () {
            () if rim(x, y) => [240, 238, 230],
            () if winding(x, y) => [40, 70, 190],
            () if thread(x, y) => half,
            () => WOOD,
        });
        let repaired = repair(&image, &[mask(|x, y| rim(x, y) || winding(x, y))]);
        assert_eq!(repaired[0], mask(|x, y| rim(x, y) || winding(x, y) || thread(x, y)));
    }

    #[test]
    fn repair_does_not_take_dark_ring_for_shadow() {
        // Brass candle holders on light wood lost their rings, and were posed with the ring behind the candle.
        let dish = |x: u32, y: u32| within(x, 30, 60) && within(y, 30, 70);
        let ring = |x: u32, y: u32| within(x, 60, 84) && within(y, 50, 52);
        let image = rendered(|x, y| if dish(x, y) || ring(x, y) { [60, 46, 26] } else { WOOD });
        let repaired = repair(&image, &[mask(|x, y| within(x, 32, 58) && within(y, 33, 68))]);
        assert_eq!(repaired[0], mask(|x, y| dish(x, y) || ring(x, y)));
    }

    #[test]
    fn repair_leaves_shadows_and_neighbors_alone() {
        let object = |x: u32, y: u32| within(x, 30, 50) && within(y, 30, 60);
        let neighbor = |x: u32, y: u32| within(x, 50, 70) && within(y, 30, 60);
        let shadow = |x: u32, y: u32| within(x, 26, 76) && within(y, 60, 68);
        let image = rendered(|x, y| match () {
            () if object(x, y) || neighbor(x, y) => [60, 40, 35],
            () if shadow(x, y) => WOOD.map(|level| level / 2),
            () => WOOD,
        });
        let masks = [mask(object), mask(neighbor)];
        assert_eq!(repair(&image, &masks), masks);
    }

    #[test]
    fn repair_does_not_claim_large_object_of_same_color() {
        let object = |x: u32, y: u32| within(x, 20, 40) && within(y, 30, 60);
        // Touches the object and has no mask.
        let other = |x: u32, y: u32| within(x, 40, 80) && within(y, 30, 60);
        let image = rendered(|x, y| if object(x, y) || other(x, y) { [200, 60, 50] } else { WOOD });
        let repaired = repair(&image, &[mask(object)]);
        assert!(repaired[0].area_px() <= mask(object).area_px() + 30 * (EROSION_PX as usize + 1));
    }

    #[test]
    fn object_of_ground_color_keeps_its_mask() {
        let image = rendered(|_, _| WOOD);
        let masks = [mask(|x, y| within(x, 30, 50) && within(y, 30, 60))];
        assert_eq!(repair(&image, &masks), masks);
    }
}
