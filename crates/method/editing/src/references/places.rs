//! Orders, regions and relations of the objects on the table, from footprints and supporters. World frame, meters.

use glam::DVec2;

use super::modifier::Measure;
use super::qualifier::{Direction, Region};
use crate::EditableObject;
use geometry::Outline;
use scene::RelationKind;
use scene::predicates::{NEXT_TO_M, PosedRelation, holds};

/// Difference of positions up to which their order is open, meters.
const SAME_PLACE_M: f64 = 0.01;

/// Ratio of sizes up to which their order is open.
const SAME_SIZE: f64 = 1.02;

/// Ratio of sizes from which one group is distinctly larger.
const DISTINCT_SIZE: f64 = 1.1;

/// The objects in an order, with whether an object and the next one may also stand the other way around.
pub(super) struct Ranking {
    pub order: Vec<usize>,
    /// One fewer than objects.
    pub open: Vec<bool>,
}

impl Ranking {
    fn new(pool: &[usize], key: impl Fn(usize) -> f64, same: impl Fn(f64, f64) -> bool) -> Self {
        let mut order = pool.to_vec();
        order.sort_by(|&a, &b| key(a).total_cmp(&key(b)));
        let open = order.windows(2).map(|pair| same(key(pair[0]), key(pair[1]))).collect();
        Self { order, open }
    }

    /// From that direction.
    pub fn from(objects: &[EditableObject], pool: &[usize], direction: Direction) -> Self {
        let key = |index: usize| {
            let footprint = &objects[index].footprint;
            let height_m = 0.5 * (footprint.bottom_m + footprint.top_m);
            match direction {
                Direction::Left => footprint.center().x,
                Direction::Right => -footprint.center().x,
                Direction::Front => footprint.center().y,
                Direction::Back => -footprint.center().y,
                Direction::Top => -height_m,
                Direction::Bottom => height_m,
            }
        };
        let same_m =
            if matches!(direction, Direction::Top | Direction::Bottom) { 0.003 } else { SAME_PLACE_M };
        Self::new(pool, key, |a, b| b - a < same_m)
    }

    /// The largest first, or the smallest.
    pub fn by(objects: &[EditableObject], pool: &[usize], measure: Measure, largest: bool) -> Self {
        let key = |index: usize| {
            let logarithm = measure.of(&objects[index]).max(1e-9).ln();
            if largest { -logarithm } else { logarithm }
        };
        Self::new(pool, key, |a, b| b - a < SAME_SIZE.ln())
    }

    /// The nearest to the target first, or the farthest.
    pub fn by_distance(objects: &[EditableObject], pool: &[usize], target: usize, nearest: bool) -> Self {
        let pool: Vec<usize> = pool.iter().copied().filter(|&index| index != target).collect();
        let key = |index: usize| {
            let distance_m = objects[index].footprint.distance_m(&objects[target].footprint);
            if nearest { distance_m } else { -distance_m }
        };
        Self::new(&pool, key, |a, b| b - a < SAME_PLACE_M)
    }

    /// The nearest to the center of the table first.
    pub fn by_center(objects: &[EditableObject], pool: &[usize]) -> Self {
        let key = |index: usize| objects[index].footprint.center().length();
        Self::new(pool, key, |a, b| b - a < SAME_PLACE_M)
    }

    /// Objects from rank `start` on, or those that may have these ranks if the order is open there.
    pub fn ranks(&self, start: usize, count: usize) -> Result<Vec<usize>, Vec<usize>> {
        let (mut low, mut high) = (start, start + count);
        while low > 0 && self.open.get(low - 1) == Some(&true) {
            low -= 1;
        }
        while high < self.order.len() && self.open.get(high - 1) == Some(&true) {
            high += 1;
        }
        let among = self.order[low..high].to_vec();
        if among.len() == count { Ok(among) } else { Err(among) }
    }
}

/// Objects that are distinctly larger, or smaller, than the rest; `None` if sizes form no two groups.
pub(super) fn size_group(
    objects: &[EditableObject],
    pool: &[usize],
    measure: Measure,
    large: bool,
) -> Option<Vec<usize>> {
    let order = Ranking::by(objects, pool, measure, large).order;
    let ratio = |k: usize| {
        let (a, b) = (measure.of(&objects[order[k]]), measure.of(&objects[order[k + 1]]));
        (a.max(b) / a.min(b).max(1e-9), k)
    };
    let (gap, at) = (0..order.len().saturating_sub(1)).map(ratio).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (gap >= DISTINCT_SIZE).then(|| order[..=at].to_vec())
}

/// Whether the object is in a region of the table: on that side of its center, or in the central third of what is
/// occupied.
pub(super) fn is_in_region(objects: &[EditableObject], index: usize, region: Region) -> bool {
    let center = objects[index].footprint.center();
    if region == (Region { x: 0, y: 0 }) {
        let half = bounds(objects).map_or(DVec2::ZERO, |(low, high)| 0.5 * (high - low));
        return center.abs().cmple(half / 3.0).all();
    }
    f64::from(region.x) * center.x >= 0.0 && f64::from(region.y) * center.y >= 0.0
}

fn bounds(objects: &[EditableObject]) -> Option<(DVec2, DVec2)> {
    let all = objects.iter().map(|object| object.footprint.bounds());
    all.reduce(|(low, high), (l, h)| (low.min(l), high.max(h)))
}

/// Whether `index` is above `below`, directly or through others.
pub(super) fn rests_on(objects: &[EditableObject], index: usize, below: usize, directly: bool) -> bool {
    let mut at = index;
    for _ in 0..objects.len() {
        match objects[at].supporter.parent {
            Some(parent) if parent == below => return true,
            Some(parent) if !directly => at = parent,
            _ => return false,
        }
    }
    false
}

/// Whether the relation to the target holds. `wide` relaxes what users say loosely: "on" for "in" and for what is
/// stacked higher, "next to" up to twice the distance.
pub(super) fn is_related(
    objects: &[EditableObject],
    index: usize,
    kind: RelationKind,
    target: usize,
    wide: bool,
) -> bool {
    let (object, other) = (&objects[index], &objects[target]);
    if index == target {
        return false;
    }
    match kind {
        RelationKind::On | RelationKind::In => {
            let inside = object.supporter.is_container() == (kind == RelationKind::In);
            rests_on(objects, index, target, !wide) && (inside || wide)
        }
        RelationKind::NextTo => {
            let free_m = object.footprint.distance_m(&other.footprint);
            let stacked = rests_on(objects, index, target, false) || rests_on(objects, target, index, false);
            !stacked && free_m <= if wide { 2.0 * NEXT_TO_M } else { NEXT_TO_M }
        }
        kind => all_of(objects).is_some_and(|outline| {
            let relation = PosedRelation {
                kind,
                object: &object.footprint,
                target: Some(&other.footprint),
                second_target: None,
                distance_m: None,
            };
            holds(&relation, &outline)
        }),
    }
}

pub(super) fn is_between(objects: &[EditableObject], index: usize, ends: [usize; 2]) -> bool {
    let [first, second] = ends.map(|end| &objects[end].footprint);
    all_of(objects).is_some_and(|outline| {
        let relation = PosedRelation {
            kind: RelationKind::Between,
            object: &objects[index].footprint,
            target: Some(first),
            second_target: Some(second),
            distance_m: None,
        };
        !ends.contains(&index) && holds(&relation, &outline)
    })
}

/// A rectangle around all objects; relations to objects do not depend on the outline of the table.
fn all_of(objects: &[EditableObject]) -> Option<Outline> {
    let (low, high) = bounds(objects)?;
    Outline::new(vec![low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)]).ok()
}
