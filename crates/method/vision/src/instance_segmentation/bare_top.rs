//! Objects that stand on the table, found by the visible part of its top.
//!
//! The predicted outline of the whole top is a guess where objects hide it: chairs behind a table whose edges the
//! image cuts are taken for objects on it, and the outline then reaches behind them. The class of bare top does not
//! err there, but for floor and walls, which colors tell apart ([`surfaces`]). The hull of its cells bridges what
//! stands in between. An object on the table is for a good part before
//! that hull, or its foot lies inside it by more than the width of an edge. What stands behind the far edge ends at
//! the hull's border, as the table hides its foot; what stands beside or before the table has its foot outside.
//!
//! An object whose foot others cover stands where they stand. Positions are those of the map. Cost: linear in the
//! cells, times the corners of the hull.
//!
//! In an image of a room, floor, walls and seats pass for bare top. They lie in pieces between the furniture, and the
//! network is unsure of the outline around them. A patterned top lies in pieces too, with a sure outline; a plain top
//! with an unsure outline is one piece.

use std::collections::{BTreeMap, BTreeSet};

use geometry::polygon::depth_in_convex_m;
use glam::DVec2;

use super::instances::DetectedObject;
use super::surfaces;
use crate::VisionError;
use crate::morphology::connected_components;
use crate::pixels::Pixels;
use crate::polygon::convex_hull;
use crate::table_network::maps::{Maps, PixelClass};

/// Parts of the bare top below this share of its largest part are floor or furniture.
const MIN_PART_SHARE: f64 = 0.1;
/// An object with this share of its cells inside the hull stands on the table.
const MIN_INSIDE: f64 = 0.25;
/// Share of an object's height in which its foot is searched.
const FOOT_SHARE: f64 = 0.25;
/// Minimum share of an object's columns that show the foot.
const MIN_SEEN: f64 = 0.15;
/// Depth of the foot inside the hull: cells, and a share of the square root of the object's area.
const FOOT_DEPTH: f64 = 1.5;
const FOOT_DEPTH_SHARE: f64 = 0.08;
/// Cells below an object in which another one covers its foot.
const COVERED_WITHIN: usize = 2;
/// Cells outside the hull from which on objects say nothing of the top.
const BEYOND: f64 = 1.0;
/// The bare top of one table is one piece of at least this share, or has an outline of at least this probability. Of 27
/// images one takes a carpet for the top, with 0.33 and 0.82; of the others none has less than 0.6.
const MIN_LARGEST_SHARE: f64 = 0.45;
const MIN_OUTLINE_PROBABILITY: f64 = 0.93;

/// The bare top.
pub(super) struct BareTop {
    /// Convex hull of the cells, in map positions.
    hull: Vec<DVec2>,
    /// For each cell, whether it passes for bare top and is another surface.
    is_other: Vec<bool>,
    /// Share of the largest connected part of all that passes for bare top.
    largest_share: f64,
}

/// The lower edge of an object.
#[derive(Default)]
struct Foot {
    /// Depths inside the hull of its cells that nothing covers.
    depths: Vec<f64>,
    /// Share of the object's columns that show it.
    seen: f64,
    covered_by: BTreeSet<usize>,
}

impl BareTop {
    /// `None` where no bare top shows.
    pub fn of(maps: &Maps, pixels: &Pixels) -> Option<Self> {
        let is_bare = |index: usize| {
            maps.shows_image(index) && maps.class(index) == PixelClass::Top && maps.outline(index) > 0.0
        };
        let mut bits: Vec<bool> = (0..maps.count()).map(is_bare).collect();
        let all = connected_components(&bits, maps.width(), maps.height());
        let largest_share =
            all.iter().map(Vec::len).max()? as f64 / all.iter().map(Vec::len).sum::<usize>() as f64;
        let is_other = surfaces::others(&bits, maps, pixels);
        bits.iter_mut().zip(&is_other).for_each(|(bit, other)| *bit &= !other);
        let parts = connected_components(&bits, maps.width(), maps.height());
        let largest = parts.iter().map(Vec::len).max()? as f64;
        let large = parts.iter().filter(|part| part.len() as f64 >= MIN_PART_SHARE * largest);
        let corners = large.flatten().flat_map(|&index| {
            let center = maps.pixel_center(index);
            [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)].map(|(x, y)| center + DVec2::new(x, y))
        });
        let hull = convex_hull(&corners.collect::<Vec<_>>());
        (hull.len() > 2).then_some(Self { hull, is_other, largest_share })
    }

    /// Checks that it is the top of one table.
    ///
    /// # Errors
    ///
    /// [`VisionError::NoSingleTop`] for surfaces that lie about a room.
    pub fn check_single(&self, maps: &Maps) -> Result<(), VisionError> {
        let largest_share = self.largest_share;
        let probability = outline_probability(maps);
        if largest_share < MIN_LARGEST_SHARE && probability < MIN_OUTLINE_PROBABILITY {
            return Err(VisionError::NoSingleTop { largest_percent: 100.0 * largest_share });
        }
        Ok(())
    }

    /// Distance of a position of the map from the hull, cells; positive inside.
    pub fn depth(&self, p: DVec2) -> f64 {
        depth_in_convex_m(&self.hull, p)
    }

    /// For each cell, whether it shows the bare top.
    pub fn cells(&self, maps: &Maps) -> Vec<bool> {
        let is_bare = |index: usize| {
            maps.shows_image(index) && maps.class(index) == PixelClass::Top && !self.is_other[index]
        };
        (0..maps.count()).map(is_bare).collect()
    }

    /// For each cell, whether it shows an object or another surface beyond the hull.
    pub fn beyond(&self, maps: &Maps) -> Vec<bool> {
        let is_beyond = |index: usize| {
            (maps.class(index) == PixelClass::Object || self.is_other[index])
                && self.depth(maps.pixel_center(index)) < -BEYOND
        };
        (0..maps.count()).map(is_beyond).collect()
    }

    /// For each object, whether it stands on the table or on an object that does.
    pub fn carries(&self, objects: &[DetectedObject], maps: &Maps) -> Vec<bool> {
        let mut owners = vec![None; maps.count()];
        for (owner, object) in objects.iter().enumerate() {
            object.cells.iter().for_each(|&index| owners[index] = Some(owner));
        }
        let feet: Vec<Foot> = (0..objects.len()).map(|k| self.foot(k, &objects[k], &owners, maps)).collect();
        let mut carried: Vec<Option<bool>> =
            objects.iter().zip(&feet).map(|(object, foot)| self.is_carried(object, foot, maps)).collect();
        // Chains of covered feet are as long as the number of objects at most.
        for _ in 0..objects.len() {
            for (object, foot) in feet.iter().enumerate() {
                if carried[object].is_none() {
                    carried[object] = foot.covered_by.iter().filter_map(|other| carried[*other]).max();
                }
            }
        }
        carried.into_iter().map(|carried| carried.unwrap_or(false)).collect()
    }

    /// `None` where that depends on what covers the object's foot.
    fn is_carried(&self, object: &DetectedObject, foot: &Foot, maps: &Maps) -> Option<bool> {
        let cells = object.cells.len() as f64;
        let inside = object.cells.iter().filter(|&&index| self.depth(maps.pixel_center(index)) > 0.0).count();
        if inside as f64 >= MIN_INSIDE * cells {
            return Some(true);
        }
        if foot.seen < MIN_SEEN {
            return if foot.covered_by.is_empty() { Some(false) } else { None };
        }
        let mut depths = foot.depths.clone();
        depths.sort_by(f64::total_cmp);
        let enough = FOOT_DEPTH.max(FOOT_DEPTH_SHARE * cells.sqrt());
        depths.get(depths.len() / 2).map(|depth| *depth >= enough)
    }

    fn foot(&self, own: usize, object: &DetectedObject, owners: &[Option<usize>], maps: &Maps) -> Foot {
        let (width, height) = (maps.width(), maps.height());
        let rows = || object.cells.iter().map(|index| index / width);
        let (Some(upper), Some(lower)) = (rows().min(), rows().max()) else { return Foot::default() };
        let from = lower as f64 - FOOT_SHARE * (lower - upper + 1) as f64;
        let mut lowest = BTreeMap::<usize, usize>::new();
        for &index in &object.cells {
            let row = lowest.entry(index % width).or_default();
            *row = (*row).max(index / width);
        }
        let mut foot = Foot::default();
        for (&x, &y) in lowest.iter().filter(|(_, y)| **y as f64 >= from) {
            if y + 1 >= height || !maps.shows_image((y + 1) * width + x) {
                continue;
            }
            let below = (y + 1..=y + COVERED_WITHIN).filter(|y| *y < height);
            if let Some(other) = below.filter_map(|y| owners[y * width + x]).find(|other| *other != own) {
                foot.covered_by.insert(other);
            } else {
                foot.depths.push(self.depth(maps.pixel_center(y * width + x)));
            }
        }
        foot.seen = foot.depths.len() as f64 / lowest.len().max(1) as f64;
        foot
    }
}

/// Mean probability of the outline in the cells inside of it; 1 where there is none.
fn outline_probability(maps: &Maps) -> f64 {
    let inside = (0..maps.count()).filter(|&index| maps.shows_image(index) && maps.outline(index) > 0.0);
    let (sum, count) = inside.fold((0.0, 0_usize), |(sum, count), index| {
        (sum + 1.0 / (1.0 + (-maps.outline(index)).exp()), count + 1)
    });
    if count == 0 { 1.0 } else { sum / count as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table_network::frame::ImageCrop;
    use crate::table_network::maps::channel::{OBJECT, OUTLINE, TOP};
    use crate::table_network::{MAP_CHANNELS, RawMaps};
    use imaging::Image;

    const SIZE: [usize; 2] = [160, 128];

    type Box = [usize; 4];

    /// Maps of a whole image: the outline is claimed for `claimed`, the bare top shows in `bare` less the objects.
    fn maps(claimed: Box, bare: Box, objects: &[Box]) -> Maps {
        maps_of(claimed, 4.0, bare, objects)
    }

    /// The outline is claimed with this logit.
    fn maps_of(claimed: Box, outline: f32, bare: Box, objects: &[Box]) -> Maps {
        let [width, height] = SIZE;
        let mut planes = vec![-4.0_f32; MAP_CHANNELS * width * height];
        let mut fill = |channel: usize, [x0, y0, x1, y1]: Box, value: f32| {
            for y in y0..y1 {
                planes[(channel * height + y) * width..][x0..x1].fill(value);
            }
        };
        fill(0, [0, 0, width, height], 0.0);
        fill(OUTLINE, claimed, outline);
        fill(TOP, bare, 4.0);
        objects.iter().for_each(|object| fill(OBJECT, *object, 8.0));
        Maps::new(RawMaps { maps: planes, width, height }, ImageCrop::whole([320, 256]))
    }

    fn detected([x0, y0, x1, y1]: Box) -> DetectedObject {
        let cells = (y0..y1).flat_map(|y| (x0..x1).map(move |x| y * SIZE[0] + x)).collect();
        DetectedObject { cells, base: DVec2::ZERO, top_row: 0.0, ground_row: 0.0 }
    }

    /// The network claims the whole image for the top; its far edge is at row 40, the right one at column 130.
    fn carried(objects: &[Box]) -> Vec<bool> {
        let maps = maps([0, 0, 160, 128], [0, 40, 130, 128], objects);
        let all: Vec<DetectedObject> = objects.iter().map(|object| detected(*object)).collect();
        of(&maps).expect("a bare top").carries(&all, &maps)
    }

    /// In an image of one color.
    fn of(maps: &Maps) -> Option<BareTop> {
        BareTop::of(maps, &Pixels::new(&Image::filled(320, 256, [180, 150, 120, 255]), 512))
    }

    #[test]
    fn chairs_behind_the_table_do_not_stand_on_it_though_the_outline_has_them() {
        // Two chairs behind the far edge, a vase at it and a mug before it.
        assert_eq!(
            carried(&[[2, 2, 60, 40], [90, 4, 128, 41], [65, 5, 80, 44], [30, 60, 45, 75]]),
            [false, false, true, true]
        );
    }

    #[test]
    fn carpet_beside_the_table_and_what_stands_before_it_is_left_out() {
        assert_eq!(carried(&[[130, 60, 160, 128], [126, 50, 158, 90]]), [false, false]);
    }

    #[test]
    fn covered_foot_stands_where_the_covering_object_stands() {
        // A lamp behind a box on the table, and a coat on a chair behind it.
        assert_eq!(
            carried(&[[60, 2, 70, 38], [50, 38, 90, 60], [100, 1, 120, 20], [98, 20, 125, 40]]),
            [true, true, false, false]
        );
    }

    #[test]
    fn objects_beyond_the_bare_top_say_nothing_of_its_outline() {
        let maps = maps([0, 0, 160, 128], [0, 40, 130, 128], &[[2, 2, 60, 40], [30, 60, 45, 75]]);
        let beyond = of(&maps).expect("a bare top").beyond(&maps);
        let at = |x: usize, y: usize| beyond[y * SIZE[0] + x];
        assert_eq!([at(30, 20), at(30, 70), at(100, 20), at(30, 50)], [true, false, false, false]);
    }

    /// A brown table on a grey floor that passes for bare top: a chair stands on the floor, a mug on the table and
    /// another one on a white cloth.
    #[test]
    fn floor_that_passes_for_bare_top_carries_nothing_and_is_beyond_the_outline() {
        let objects = [[6, 10, 20, 40], [70, 60, 80, 75], [108, 82, 116, 92]];
        let whole = [0, 0, 160, 128];
        let maps = maps(whole, whole, &objects);
        let mut image = Image::filled(320, 256, [120, 122, 125, 255]);
        for y in 40..256 {
            (54..320).for_each(|x| image.set_pixel(x, y, [180, 130, 80, 255]));
        }
        for y in 160..200 {
            (200..250).for_each(|x| image.set_pixel(x, y, [245, 245, 245, 255]));
        }
        let top = BareTop::of(&maps, &Pixels::new(&image, 512)).expect("a bare top");
        let all: Vec<DetectedObject> = objects.iter().map(|object| detected(*object)).collect();
        assert_eq!(top.carries(&all, &maps), [false, true, true]);
        let beyond = top.beyond(&maps);
        let at = |x: usize, y: usize| beyond[y * SIZE[0] + x];
        assert_eq!(
            [at(15, 100), at(15, 20), at(100, 100), at(104, 90), at(75, 65)],
            [true, true, false, false, false]
        );
    }

    #[test]
    fn floor_between_furniture_is_no_table_top() {
        let whole = [0, 0, 160, 128];
        // A sofa and a low table part the floor of a room in three.
        let furniture = [[50, 0, 60, 128], [100, 0, 110, 128]];
        let is_single = |outline: f32, objects: &[Box]| {
            let maps = maps_of(whole, outline, whole, objects);
            match of(&maps).expect("a bare top").check_single(&maps) {
                Ok(()) => true,
                Err(VisionError::NoSingleTop { largest_percent }) => {
                    assert!((largest_percent - 100.0 * 50.0 / 140.0).abs() < 1e-9, "{largest_percent}");
                    false
                }
                Err(other) => panic!("{other}"),
            }
        };
        assert!(!is_single(2.0, &furniture));
        assert!(is_single(4.0, &furniture), "a runner parts a table, whose outline is sure");
        assert!(is_single(2.0, &[[50, 30, 60, 128]]), "a plain top is one piece");
    }

    #[test]
    fn where_no_bare_top_shows_there_is_no_hull() {
        assert!(of(&maps([0, 0, 160, 128], [0, 0, 0, 0], &[[0, 0, 160, 128]])).is_none());
    }
}
