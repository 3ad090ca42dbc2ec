//! All that basins may be parts of: they are joined two by two, those with the weakest border between them first, until no
//! two touch. Each step is a region that may be a thing; which ones are is what is most believed.
//!
//! A tree of regions with a score each is the common way to choose a segmentation among many (Arbelaez et al., "Contour
//! detection and hierarchical image segmentation", 2011). Cost: n log n in the basins, in practice some milliseconds.

use std::cmp::{Ordering, Reverse};
use std::collections::{BTreeMap, BinaryHeap};

use glam::DVec2;

use super::belief::{Measures, NEVER_JOINED};
use super::partition::{Basins, Places};
use runtime::{Interrupt, Interrupted};

/// How much more of a border there is between places that vote for different middles.
const OTHER_MIDDLE: f64 = 0.5;
/// Mean probability of a border from which on parts of a group that do not touch are joined before parts that do: what hides
/// a thing may cut it in two.
const HIDDEN_AT: f64 = 0.7;
/// Largest share of a region that may be taken by what is believed more.
const MOST_TAKEN: f64 = 0.3;

/// Regions, parts before wholes, the first as many as there are basins.
pub(crate) struct MergeTree {
    regions: Vec<Region>,
    /// The basin of each place.
    basin: Vec<Option<usize>>,
}

struct Region {
    measures: Measures,
    area: f64,
    parts: Option<[usize; 2]>,
    whole: Option<usize>,
}

/// A region that is believed to be a thing.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Believed {
    /// In ascending order.
    pub places: Vec<usize>,
    /// Probability that it is one, 0..1.
    pub belief: f64,
}

impl MergeTree {
    pub fn new(places: &Places, interrupt: &Interrupt) -> Result<Self, Interrupted> {
        let inner_borders = places.inner_borders();
        let basins = places.basins(&inner_borders);
        let mut forest = Forest::new(places, &inner_borders, &basins);
        forest.join_all(interrupt)?;
        let in_group = places.group.iter().flatten().fold(BTreeMap::new(), |mut counts, &group| {
            *counts.entry(group).or_insert(0.0) += 1.0;
            counts
        });
        let regions = forest.grown.iter().map(|grown| grown.region(places, &in_group)).collect();
        Ok(Self { regions, basin: basins.of_place })
    }

    /// Measures of each region of at least `least` places, and its places in ascending order.
    pub fn candidates(&self, least: f64) -> impl Iterator<Item = (Measures, Vec<usize>)> {
        let large = (0..self.regions.len()).filter(move |&k| self.regions[k].area >= least);
        large.map(|k| {
            let mut places = Vec::new();
            let members = self.basins_of(k);
            for (place, basin) in self.basin.iter().enumerate() {
                if basin.is_some_and(|basin| members.binary_search(&basin).is_ok()) {
                    places.push(place);
                }
            }
            (self.regions[k].measures, places)
        })
    }

    /// Regions of which no two share a place, the most believed first. What has parts that are believed more is what is left
    /// of it, if that is most of it.
    pub fn most_believed(&self, least_belief: f64, least: f64) -> Vec<Believed> {
        let mut order: Vec<(f64, usize)> = (0..self.regions.len())
            .filter(|&k| self.regions[k].area >= least)
            .map(|k| (self.regions[k].measures.belief(), k))
            .filter(|(belief, _)| *belief >= least_belief)
            .collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut is_taken = vec![false; self.regions.len()];
        let mut taken_area = vec![0.0; self.regions.len()];
        let mut owner: Vec<Option<usize>> = vec![None; self.basins()];
        let mut chosen = Vec::new();
        for (belief, k) in order {
            let region = &self.regions[k];
            if is_taken[k] || taken_area[k] > MOST_TAKEN * region.area {
                continue;
            }
            let left = region.area - taken_area[k];
            self.parts_of(k, |part| {
                is_taken[part] = true;
                if part < owner.len() {
                    owner[part].get_or_insert(chosen.len());
                }
            });
            let mut whole = region.whole;
            while let Some(next) = whole {
                taken_area[next] += left;
                whole = self.regions[next].whole;
            }
            chosen.push(Believed { places: Vec::new(), belief });
        }
        for (place, basin) in self.basin.iter().enumerate() {
            if let Some(owner) = basin.and_then(|basin| owner[basin]) {
                chosen[owner].places.push(place);
            }
        }
        chosen
    }

    fn basins(&self) -> usize {
        self.regions.iter().filter(|region| region.parts.is_none()).count()
    }

    fn basins_of(&self, region: usize) -> Vec<usize> {
        let mut own = Vec::new();
        self.parts_of(region, |part| {
            if self.regions[part].parts.is_none() {
                own.push(part);
            }
        });
        own.sort_unstable();
        own
    }

    /// The region, its parts, and theirs.
    fn parts_of(&self, region: usize, mut visit: impl FnMut(usize)) {
        let mut open = vec![region];
        while let Some(next) = open.pop() {
            visit(next);
            open.extend(self.regions[next].parts.into_iter().flatten());
        }
    }
}

/// What two regions share.
#[derive(Clone, Copy, Debug, Default)]
struct Shared {
    border: f64,
    pairs: f64,
}

impl Shared {
    fn mean(&self) -> f64 {
        self.border / self.pairs
    }

    fn and(self, other: Self) -> Self {
        Self { border: self.border + other.border, pairs: self.pairs + other.pairs }
    }
}

/// Regions, and who touches whom.
struct Forest {
    grown: Vec<Grown>,
    /// Of regions that no other one has for a part; empty for the others.
    beside: Vec<BTreeMap<usize, Shared>>,
    /// Borders that were there once, the weakest first.
    borders: BinaryHeap<Reverse<Border>>,
}

/// A region and the sums over it.
#[derive(Clone)]
struct Grown {
    area: f64,
    object: f64,
    vote: DVec2,
    middle: DVec2,
    low: [usize; 2],
    high: [usize; 2],
    /// Steps from its places to places of nobody, and to places of others.
    free: f64,
    shared: f64,
    of_group: BTreeMap<usize, f64>,
    joined_at: f64,
    joins_at: f64,
    parts: Option<[usize; 2]>,
    whole: Option<usize>,
}

/// The border between two regions, ordered by its strength.
#[derive(Clone, Copy, PartialEq)]
struct Border {
    mean: f64,
    between: [usize; 2],
}

impl Eq for Border {}

impl Ord for Border {
    fn cmp(&self, other: &Self) -> Ordering {
        self.mean.total_cmp(&other.mean).then(self.between.cmp(&other.between))
    }
}

impl PartialOrd for Border {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Forest {
    fn new(places: &Places, inner_borders: &[f64], basins: &Basins) -> Self {
        let mut grown = vec![Grown::nothing(); basins.count];
        let mut beside: Vec<BTreeMap<usize, Shared>> = vec![BTreeMap::new(); basins.count];
        for (place, basin) in basins.of_place.iter().enumerate() {
            let Some((own, group)) = basin.zip(places.group[place]) else { continue };
            grown[own].add(place, group, places);
            for other in places.neighbors(place) {
                let Some(its) = basins.of_place[other] else {
                    grown[own].free += 1.0;
                    continue;
                };
                if its == own {
                    continue;
                }
                grown[own].shared += 1.0;
                let border = if places.group[other] == Some(group) {
                    inner_borders[place].max(inner_borders[other])
                } else {
                    places.border[place].max(places.border[other]) + OTHER_MIDDLE
                };
                let pair = beside[own].entry(its).or_default();
                *pair = pair.and(Shared { border, pairs: 1.0 });
            }
        }
        let mut forest = Self { grown, beside, borders: BinaryHeap::new() };
        (0..basins.count).for_each(|basin| forest.note_borders(basin));
        forest
    }

    /// Those to regions that came before.
    fn note_borders(&mut self, region: usize) {
        let earlier = self.beside[region].range(..region);
        let borders =
            earlier.map(|(&other, shared)| Border { mean: shared.mean(), between: [other, region] });
        self.borders.extend(borders.map(Reverse));
    }

    fn is_whole(&self, region: usize) -> bool {
        self.grown[region].whole.is_none()
    }

    fn join_all(&mut self, interrupt: &Interrupt) -> Result<(), Interrupted> {
        self.join_below(HIDDEN_AT, interrupt)?;
        self.join_hidden_parts();
        self.join_below(f64::INFINITY, interrupt)
    }

    fn join_below(&mut self, most: f64, interrupt: &Interrupt) -> Result<(), Interrupted> {
        while let Some(Reverse(border)) = self.borders.peek().copied().filter(|b| b.0.mean < most) {
            self.borders.pop();
            let [a, b] = border.between;
            if self.is_whole(a) && self.is_whole(b) {
                interrupt.check()?;
                self.join(a, b, border.mean);
            }
        }
        Ok(())
    }

    /// Parts of a group that touch no other part of it become the largest one's.
    fn join_hidden_parts(&mut self) {
        let mut of_group: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for region in (0..self.grown.len()).filter(|&region| self.is_whole(region)) {
            of_group.entry(self.grown[region].group()).or_default().push(region);
        }
        for (group, mut regions) in of_group {
            regions.sort_by(|&a, &b| self.grown[b].area.total_cmp(&self.grown[a].area));
            let Some((&first, others)) = regions.split_first() else { continue };
            let mut largest = first;
            for &other in others {
                if !self.beside[other].keys().any(|&its| self.grown[its].group() == group) {
                    largest = self.join(largest, other, HIDDEN_AT);
                }
            }
        }
    }

    /// The new region.
    fn join(&mut self, a: usize, b: usize, mean: f64) -> usize {
        let new = self.grown.len();
        let (of_a, of_b) = (std::mem::take(&mut self.beside[a]), std::mem::take(&mut self.beside[b]));
        let between = of_a.get(&b).map_or(0.0, |shared| shared.pairs);
        let mut beside: BTreeMap<usize, Shared> = BTreeMap::new();
        for (other, shared) in of_a.into_iter().chain(of_b).filter(|(other, _)| *other != a && *other != b) {
            let pair = beside.entry(other).or_default();
            *pair = pair.and(shared);
        }
        for (&other, &shared) in &beside {
            self.beside[other].remove(&a);
            self.beside[other].remove(&b);
            self.beside[other].insert(new, shared);
        }
        let mut grown = self.grown[a].joined_with(&self.grown[b]);
        grown.shared -= 2.0 * between;
        grown.joined_at = mean;
        grown.parts = Some([a, b]);
        for part in [a, b] {
            self.grown[part].whole = Some(new);
            self.grown[part].joins_at = mean;
        }
        self.grown.push(grown);
        self.beside.push(beside);
        self.note_borders(new);
        new
    }
}

impl Grown {
    fn nothing() -> Self {
        Self {
            area: 0.0,
            object: 0.0,
            vote: DVec2::ZERO,
            middle: DVec2::ZERO,
            low: [usize::MAX; 2],
            high: [0; 2],
            free: 0.0,
            shared: 0.0,
            of_group: BTreeMap::new(),
            joined_at: 0.0,
            joins_at: NEVER_JOINED,
            parts: None,
            whole: None,
        }
    }

    fn add(&mut self, place: usize, group: usize, places: &Places) {
        let at = [place % places.width, place / places.width];
        self.area += 1.0;
        self.object += places.object[place];
        self.vote += places.vote[place];
        self.middle += DVec2::new(at[0] as f64 + 0.5, at[1] as f64 + 0.5);
        self.low = [0, 1].map(|k| self.low[k].min(at[k]));
        self.high = [0, 1].map(|k| self.high[k].max(at[k]));
        *self.of_group.entry(group).or_insert(0.0) += 1.0;
    }

    fn joined_with(&self, other: &Self) -> Self {
        let mut of_group = self.of_group.clone();
        for (group, count) in &other.of_group {
            *of_group.entry(*group).or_insert(0.0) += count;
        }
        Self {
            area: self.area + other.area,
            object: self.object + other.object,
            vote: self.vote + other.vote,
            middle: self.middle + other.middle,
            low: [0, 1].map(|k| self.low[k].min(other.low[k])),
            high: [0, 1].map(|k| self.high[k].max(other.high[k])),
            free: self.free + other.free,
            shared: self.shared + other.shared,
            of_group,
            ..Self::nothing()
        }
    }

    /// The middle most of its places vote for, and how many do.
    fn most_voted(&self) -> (usize, f64) {
        let most = self.of_group.iter().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0)));
        most.map_or((0, 0.0), |(group, count)| (*group, *count))
    }

    fn group(&self) -> usize {
        self.most_voted().0
    }

    fn region(&self, places: &Places, in_group: &BTreeMap<usize, f64>) -> Region {
        let root = self.area.sqrt();
        let vote = self.vote / self.area;
        let (group, own) = self.most_voted();
        let last = [places.width - 1, places.height() - 1];
        let [x, y] = [vote.x, vote.y].map(|v| v.max(0.0) as usize);
        let voted = y.min(last[1]) * places.width + x.min(last[0]);
        let sides = [0, 1].map(|k| (self.high[k] - self.low[k] + 1) as f64);
        let rim = self.free + self.shared;
        let measures = Measures {
            log_area: (self.area / places.count() as f64).ln(),
            object: self.object / self.area,
            vote_off: (vote - self.middle / self.area).length() / root,
            rim_shared: self.shared / rim.max(1.0),
            joined_at: self.joined_at,
            joins_at: self.joins_at,
            fill: self.area / (sides[0] * sides[1]),
            center_at_vote: places.center[voted],
            rim_length: rim / root,
            complete: own / in_group.get(&group).copied().unwrap_or(own).max(1.0),
        };
        Region { measures, area: self.area, parts: self.parts, whole: self.whole }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 30;
    const COUNT: usize = 600;

    /// The tree of a map of 30 x 20 places, as what is at each place.
    fn tree(
        group: impl Fn(usize, usize) -> Option<usize>,
        border: impl Fn(usize, usize) -> f64,
    ) -> MergeTree {
        let at = |place: usize| (place % WIDTH, place / WIDTH);
        let group: Vec<Option<usize>> = (0..COUNT).map(|k| group(at(k).0, at(k).1)).collect();
        let border: Vec<f64> = (0..COUNT).map(|k| border(at(k).0, at(k).1)).collect();
        let middle = |of: usize| {
            let own = (0..COUNT).filter(|k| group[*k] == Some(of));
            let (sum, count) = own.fold((DVec2::ZERO, 0.0), |(sum, count), k| {
                (sum + DVec2::new(at(k).0 as f64 + 0.5, at(k).1 as f64 + 0.5), count + 1.0)
            });
            sum / count
        };
        let vote: Vec<DVec2> = group.iter().map(|g| g.map_or(DVec2::ZERO, middle)).collect();
        let mut center = vec![0.0; COUNT];
        for vote in vote.iter().zip(&group).filter(|(_, group)| group.is_some()).map(|(vote, _)| vote) {
            center[vote.y as usize * WIDTH + vote.x as usize] = 0.9;
        }
        let object: Vec<f64> = group.iter().map(|g| if g.is_some() { 0.97 } else { 0.02 }).collect();
        let places = Places {
            width: WIDTH,
            group: &group,
            border: &border,
            object: &object,
            vote: &vote,
            center: &center,
        };
        MergeTree::new(&places, &Interrupt::default()).expect("is not interrupted")
    }

    fn within(x: usize, y: usize, [left, upper, right, lower]: [usize; 4]) -> bool {
        (left..right).contains(&x) && (upper..lower).contains(&y)
    }

    /// On the rim of a box or just outside of it.
    fn on_rim(x: usize, y: usize, [left, upper, right, lower]: [usize; 4]) -> bool {
        within(x, y, [left - 1, upper - 1, right + 1, lower + 1])
            && !within(x, y, [left + 1, upper + 1, right - 1, lower - 1])
    }

    fn sizes(tree: &MergeTree) -> Vec<usize> {
        tree.candidates(1.0).map(|(_, places)| places.len()).collect()
    }

    const MAT: [usize; 4] = [3, 2, 27, 18];
    const PLIERS: [usize; 4] = [11, 7, 19, 13];

    #[test]
    fn a_thing_in_the_middle_of_another_and_both_together_are_candidates() {
        let tree =
            tree(|x, y| within(x, y, MAT).then_some(0), |x, y| if on_rim(x, y, PLIERS) { 0.9 } else { 0.1 });
        let sizes = sizes(&tree);
        assert_eq!(sizes.last(), Some(&(24 * 16)), "{sizes:?}");
        let parted = tree.candidates(1.0).find(|(measures, _)| (0.8..1.0).contains(&measures.joined_at));
        let (_, whole) = parted.expect("joined across the border");
        assert_eq!(whole.len(), 24 * 16);
        let alone = |places: &Vec<usize>| places.contains(&(10 * WIDTH + 15)) && places.len() <= 8 * 6 + 28;
        assert!(tree.candidates(8.0).any(|(m, places)| alone(&places) && m.joins_at > 0.8), "{sizes:?}");
    }

    #[test]
    fn a_border_beside_another_group_parts_nothing_within_its_own() {
        // A bar before a mat: the strip of the mat between its edge and the bar is all border.
        let bar = [3, 4, 27, 8];
        let tree = tree(
            |x, y| within(x, y, MAT).then_some(usize::from(within(x, y, bar))),
            |x, y| if on_rim(x, y, [2, 4, 28, 8]) { 0.95 } else { 0.02 },
        );
        let of_mat: Vec<usize> = tree
            .candidates(1.0)
            .filter(|(measures, _)| measures.joins_at < HIDDEN_AT)
            .map(|(_, places)| places.len())
            .collect();
        assert!(of_mat.is_empty(), "{of_mat:?}");
    }

    #[test]
    fn parts_that_do_not_touch_are_joined_before_what_hides_them() {
        let across = |x: usize, y: usize| within(x, y, MAT).then_some(usize::from((9..12).contains(&y)));
        let edges =
            |x: usize, y: usize| if within(x, y, MAT) && [8, 9, 11, 12].contains(&y) { 0.8 } else { 0.1 };
        let tree = tree(across, edges);
        let sizes = sizes(&tree);
        assert!(sizes.ends_with(&[24 * 13, 24 * 16]), "{sizes:?}");
        let half_and_bar = [24 * 10, 24 * 9];
        assert!(!sizes.iter().any(|size| half_and_bar.contains(size)), "{sizes:?}");
    }

    #[test]
    fn what_is_believed_shares_no_place_and_comes_in_the_order_of_belief() {
        let two = |x: usize, y: usize| within(x, y, MAT).then_some(usize::from(x >= 15));
        let tree = tree(two, |x: usize, _: usize| if (14..16).contains(&x) { 0.9 } else { 0.02 });
        let believed = tree.most_believed(0.0, 8.0);
        assert!(believed.windows(2).all(|pair| pair[0].belief >= pair[1].belief));
        let mut places: Vec<usize> = believed.iter().flat_map(|region| region.places.clone()).collect();
        places.sort_unstable();
        let count = places.len();
        places.dedup();
        assert_eq!(places.len(), count);
        let mut own: Vec<usize> = believed.iter().map(|region| region.places.len()).collect();
        own.sort_unstable();
        assert_eq!(own, [12 * 16, 12 * 16], "{believed:?}");
        assert!(tree.most_believed(1.0, 8.0).is_empty());
    }

    #[test]
    fn sums_are_those_of_the_places() {
        // Noise: what was summed up along the way must be what the places say.
        let noise = |x: usize, y: usize| f64::from(((x * 7919 + y * 104_729) % 97) as u32) / 97.0;
        let tree = tree(|x, y| (noise(x, y) > 0.2).then_some((x / 7 + y / 9) % 3), noise);
        let mut regions = 0;
        for (measures, places) in tree.candidates(1.0) {
            let size = places.len() as f64;
            assert!((measures.log_area - (size / COUNT as f64).ln()).abs() < 1e-9);
            let own: std::collections::BTreeSet<usize> = places.iter().copied().collect();
            let (mut free, mut shared) = (0.0, 0.0);
            for &place in &places {
                let (x, y) = (place % WIDTH, place / WIDTH);
                for (dx, dy) in [(-1_i32, 0_i32), (1, 0), (0, -1), (0, 1)] {
                    let (u, v) = (x as i32 + dx, y as i32 + dy);
                    if !(0..30).contains(&u) || !(0..20).contains(&v) {
                        continue;
                    }
                    let other = v as usize * WIDTH + u as usize;
                    if own.contains(&other) {
                        continue;
                    }
                    if noise(u as usize, v as usize) > 0.2 { shared += 1.0 } else { free += 1.0 }
                }
            }
            assert!((measures.rim_length - (free + shared) / size.sqrt()).abs() < 1e-9);
            assert!((measures.rim_shared - shared / f64::max(free + shared, 1.0)).abs() < 1e-9);
            regions += 1;
        }
        assert!(regions > 100, "{regions}");
    }

    #[test]
    fn it_stops_when_it_is_told_to() {
        let group = vec![Some(0); COUNT];
        let border: Vec<f64> = (0..COUNT).map(|k| f64::from((k % 5) as u32) / 5.0).collect();
        let (vote, numbers) = (vec![DVec2::ONE; COUNT], vec![0.5; COUNT]);
        let places = Places {
            width: WIDTH,
            group: &group,
            border: &border,
            object: &numbers,
            vote: &vote,
            center: &numbers,
        };
        let interrupt = Interrupt::default();
        interrupt.raise();
        assert!(MergeTree::new(&places, &interrupt).is_err());
    }
}
