//! Hierarchical region merging.
//!
//! Watershed superpixels are merged greedily, the pair with the weakest mean border first, until no two touch. The
//! instances are the disjoint set of tree nodes with the highest objectness (Arbelaez et al., "Contour detection
//! and hierarchical image segmentation", 2011).
//!
//! Cost: O(n log n) in the superpixels, in practice some milliseconds.

use std::cmp::{Ordering, Reverse};
use std::collections::{BTreeMap, BinaryHeap};

use glam::DVec2;

use super::region_score::{NEVER_MERGED, RegionFeatures};
use super::watershed::{CellGrid, Superpixels};
use runtime::{CancelFlag, Cancelled};

/// Added to the border strength between cells of different center groups.
const OTHER_GROUP_PENALTY: f64 = 0.5;
/// Border strength from which on separate parts of one group merge before touching ones: an occluder may cut an
/// object in two.
const OCCLUSION_BORDER: f64 = 0.7;
/// Maximum share of a region that regions of higher score may have taken.
const MAX_TAKEN: f64 = 0.3;

/// Regions, parts before wholes; the superpixels come first.
pub(crate) struct MergeTree {
    regions: Vec<Region>,
    /// The superpixel of each cell.
    superpixel: Vec<Option<usize>>,
}

struct Region {
    features: RegionFeatures,
    area: f64,
    parts: Option<[usize; 2]>,
    whole: Option<usize>,
}

/// A region selected as an object.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ScoredRegion {
    /// In ascending order.
    pub cells: Vec<usize>,
    /// Objectness, 0..1.
    pub score: f64,
}

impl MergeTree {
    pub fn new(grid: &CellGrid, cancel: &CancelFlag) -> Result<Self, Cancelled> {
        let inner_borders = grid.inner_borders();
        let superpixels = grid.superpixels(&inner_borders);
        let mut forest = Forest::new(grid, &inner_borders, &superpixels);
        forest.merge_all(cancel)?;
        let in_group = grid.group.iter().flatten().fold(BTreeMap::new(), |mut counts, &group| {
            *counts.entry(group).or_insert(0.0) += 1.0;
            counts
        });
        let regions = forest.sums.iter().map(|sums| sums.region(grid, &in_group)).collect();
        Ok(Self { regions, superpixel: superpixels.of_cell })
    }

    /// Features and cells (ascending) of each region with at least `lowest` cells.
    pub fn candidates(&self, lowest: f64) -> impl Iterator<Item = (RegionFeatures, Vec<usize>)> {
        let large = (0..self.regions.len()).filter(move |&k| self.regions[k].area >= lowest);
        large.map(|k| {
            let mut cells = Vec::new();
            let members = self.superpixels_of(k);
            for (cell, superpixel) in self.superpixel.iter().enumerate() {
                if superpixel.is_some_and(|superpixel| members.binary_search(&superpixel).is_ok()) {
                    cells.push(cell);
                }
            }
            (self.regions[k].features, cells)
        })
    }

    /// Disjoint regions in descending order of their scores. A region keeps the cells that no region of higher
    /// score has taken, if these are most of it.
    pub fn select_disjoint(&self, min_score: f64, lowest: f64) -> Vec<ScoredRegion> {
        let mut order: Vec<(f64, usize)> = (0..self.regions.len())
            .filter(|&k| self.regions[k].area >= lowest)
            .map(|k| (self.regions[k].features.score(), k))
            .filter(|(score, _)| *score >= min_score)
            .collect();
        order.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut is_taken = vec![false; self.regions.len()];
        let mut taken_area = vec![0.0; self.regions.len()];
        let mut owner: Vec<Option<usize>> = vec![None; self.superpixels()];
        let mut chosen = Vec::new();
        for (score, k) in order {
            let region = &self.regions[k];
            if is_taken[k] || taken_area[k] > MAX_TAKEN * region.area {
                continue;
            }
            let left = region.area - taken_area[k];
            self.visit_subtree(k, |part| {
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
            chosen.push(ScoredRegion { cells: Vec::new(), score });
        }
        for (cell, superpixel) in self.superpixel.iter().enumerate() {
            if let Some(owner) = superpixel.and_then(|superpixel| owner[superpixel]) {
                chosen[owner].cells.push(cell);
            }
        }
        chosen
    }

    fn superpixels(&self) -> usize {
        self.regions.iter().filter(|region| region.parts.is_none()).count()
    }

    fn superpixels_of(&self, region: usize) -> Vec<usize> {
        let mut own = Vec::new();
        self.visit_subtree(region, |part| {
            if self.regions[part].parts.is_none() {
                own.push(part);
            }
        });
        own.sort_unstable();
        own
    }

    /// Visits the region and all its descendants.
    fn visit_subtree(&self, region: usize, mut visit: impl FnMut(usize)) {
        let mut open = vec![region];
        while let Some(next) = open.pop() {
            visit(next);
            open.extend(self.regions[next].parts.into_iter().flatten());
        }
    }
}

/// The border of two regions: summed strength, and number of cell pairs.
#[derive(Clone, Copy, Debug, Default)]
struct SharedBorder {
    border: f64,
    pairs: f64,
}

impl SharedBorder {
    fn mean(&self) -> f64 {
        self.border / self.pairs
    }

    fn and(self, other: Self) -> Self {
        Self { border: self.border + other.border, pairs: self.pairs + other.pairs }
    }
}

/// Regions under construction, with their adjacency.
struct Forest {
    sums: Vec<RegionSums>,
    /// Neighbors of each root; empty for merged regions.
    beside: Vec<BTreeMap<usize, SharedBorder>>,
    /// Past and present borders, the weakest first.
    borders: BinaryHeap<Reverse<Border>>,
}

/// A region and the sums over its cells.
#[derive(Clone)]
struct RegionSums {
    area: f64,
    object: f64,
    vote: DVec2,
    centroid: DVec2,
    low: [usize; 2],
    high: [usize; 2],
    /// Number of steps from its cells to background cells, and to cells of other regions.
    free: f64,
    shared: f64,
    of_group: BTreeMap<usize, f64>,
    joined_at: f64,
    joins_at: f64,
    parts: Option<[usize; 2]>,
    whole: Option<usize>,
}

/// A border between two regions, ordered by its strength.
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
    fn new(grid: &CellGrid, inner_borders: &[f64], superpixels: &Superpixels) -> Self {
        let mut sums = vec![RegionSums::empty(); superpixels.count];
        let mut beside: Vec<BTreeMap<usize, SharedBorder>> = vec![BTreeMap::new(); superpixels.count];
        for (cell, superpixel) in superpixels.of_cell.iter().enumerate() {
            let Some((own, group)) = superpixel.zip(grid.group[cell]) else { continue };
            sums[own].add(cell, group, grid);
            for other in grid.neighbors(cell) {
                let Some(its) = superpixels.of_cell[other] else {
                    sums[own].free += 1.0;
                    continue;
                };
                if its == own {
                    continue;
                }
                sums[own].shared += 1.0;
                let border = if grid.group[other] == Some(group) {
                    inner_borders[cell].max(inner_borders[other])
                } else {
                    grid.border[cell].max(grid.border[other]) + OTHER_GROUP_PENALTY
                };
                let pair = beside[own].entry(its).or_default();
                *pair = pair.and(SharedBorder { border, pairs: 1.0 });
            }
        }
        let mut forest = Self { sums, beside, borders: BinaryHeap::new() };
        (0..superpixels.count).for_each(|superpixel| forest.push_borders(superpixel));
        forest
    }

    /// Pushes the borders to earlier regions.
    fn push_borders(&mut self, region: usize) {
        let earlier = self.beside[region].range(..region);
        let borders =
            earlier.map(|(&other, shared)| Border { mean: shared.mean(), between: [other, region] });
        self.borders.extend(borders.map(Reverse));
    }

    fn is_whole(&self, region: usize) -> bool {
        self.sums[region].whole.is_none()
    }

    fn merge_all(&mut self, cancel: &CancelFlag) -> Result<(), Cancelled> {
        self.merge_below(OCCLUSION_BORDER, cancel)?;
        self.merge_occluded_parts();
        self.merge_below(f64::INFINITY, cancel)
    }

    fn merge_below(&mut self, highest: f64, cancel: &CancelFlag) -> Result<(), Cancelled> {
        while let Some(Reverse(border)) = self.borders.peek().copied().filter(|b| b.0.mean < highest) {
            self.borders.pop();
            let [a, b] = border.between;
            if self.is_whole(a) && self.is_whole(b) {
                cancel.check()?;
                self.merge(a, b, border.mean);
            }
        }
        Ok(())
    }

    /// Merges the parts of a group that touch no other part of it with its largest part.
    fn merge_occluded_parts(&mut self) {
        let mut of_group: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for region in (0..self.sums.len()).filter(|&region| self.is_whole(region)) {
            of_group.entry(self.sums[region].group()).or_default().push(region);
        }
        for (group, mut regions) in of_group {
            regions.sort_by(|&a, &b| self.sums[b].area.total_cmp(&self.sums[a].area));
            let Some((&first, others)) = regions.split_first() else { continue };
            let mut largest = first;
            for &other in others {
                if !self.beside[other].keys().any(|&its| self.sums[its].group() == group) {
                    largest = self.merge(largest, other, OCCLUSION_BORDER);
                }
            }
        }
    }

    /// Merges two regions; returns the new one.
    fn merge(&mut self, a: usize, b: usize, mean: f64) -> usize {
        let new = self.sums.len();
        let (of_a, of_b) = (std::mem::take(&mut self.beside[a]), std::mem::take(&mut self.beside[b]));
        let between = of_a.get(&b).map_or(0.0, |shared| shared.pairs);
        let mut beside: BTreeMap<usize, SharedBorder> = BTreeMap::new();
        for (other, shared) in of_a.into_iter().chain(of_b).filter(|(other, _)| *other != a && *other != b) {
            let pair = beside.entry(other).or_default();
            *pair = pair.and(shared);
        }
        for (&other, &shared) in &beside {
            self.beside[other].remove(&a);
            self.beside[other].remove(&b);
            self.beside[other].insert(new, shared);
        }
        let mut sums = self.sums[a].merged_with(&self.sums[b]);
        sums.shared -= 2.0 * between;
        sums.joined_at = mean;
        sums.parts = Some([a, b]);
        for part in [a, b] {
            self.sums[part].whole = Some(new);
            self.sums[part].joins_at = mean;
        }
        self.sums.push(sums);
        self.beside.push(beside);
        self.push_borders(new);
        new
    }
}

impl RegionSums {
    fn empty() -> Self {
        Self {
            area: 0.0,
            object: 0.0,
            vote: DVec2::ZERO,
            centroid: DVec2::ZERO,
            low: [usize::MAX; 2],
            high: [0; 2],
            free: 0.0,
            shared: 0.0,
            of_group: BTreeMap::new(),
            joined_at: 0.0,
            joins_at: NEVER_MERGED,
            parts: None,
            whole: None,
        }
    }

    fn add(&mut self, cell: usize, group: usize, grid: &CellGrid) {
        let at = [cell % grid.width, cell / grid.width];
        self.area += 1.0;
        self.object += grid.object[cell];
        self.vote += grid.vote[cell];
        self.centroid += DVec2::new(at[0] as f64 + 0.5, at[1] as f64 + 0.5);
        self.low = [0, 1].map(|k| self.low[k].min(at[k]));
        self.high = [0, 1].map(|k| self.high[k].max(at[k]));
        *self.of_group.entry(group).or_insert(0.0) += 1.0;
    }

    fn merged_with(&self, other: &Self) -> Self {
        let mut of_group = self.of_group.clone();
        for (group, count) in &other.of_group {
            *of_group.entry(*group).or_insert(0.0) += count;
        }
        Self {
            area: self.area + other.area,
            object: self.object + other.object,
            vote: self.vote + other.vote,
            centroid: self.centroid + other.centroid,
            low: [0, 1].map(|k| self.low[k].min(other.low[k])),
            high: [0, 1].map(|k| self.high[k].max(other.high[k])),
            free: self.free + other.free,
            shared: self.shared + other.shared,
            of_group,
            ..Self::empty()
        }
    }

    /// The center group of most of its cells, and their number.
    fn majority_group(&self) -> (usize, f64) {
        let highest = self.of_group.iter().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0)));
        highest.map_or((0, 0.0), |(group, count)| (*group, *count))
    }

    fn group(&self) -> usize {
        self.majority_group().0
    }

    fn region(&self, grid: &CellGrid, in_group: &BTreeMap<usize, f64>) -> Region {
        let root = self.area.sqrt();
        let vote = self.vote / self.area;
        let (group, own) = self.majority_group();
        let last = [grid.width - 1, grid.height() - 1];
        let [x, y] = [vote.x, vote.y].map(|v| v.max(0.0) as usize);
        let voted = y.min(last[1]) * grid.width + x.min(last[0]);
        let sides = [0, 1].map(|k| (self.high[k] - self.low[k] + 1) as f64);
        let rim = self.free + self.shared;
        let features = RegionFeatures {
            log_area: (self.area / grid.count() as f64).ln(),
            object: self.object / self.area,
            vote_off: (vote - self.centroid / self.area).length() / root,
            rim_shared: self.shared / rim.max(1.0),
            joined_at: self.joined_at,
            joins_at: self.joins_at,
            fill: self.area / (sides[0] * sides[1]),
            center_at_vote: grid.center[voted],
            rim_length: rim / root,
            complete: own / in_group.get(&group).copied().unwrap_or(own).max(1.0),
        };
        Region { features, area: self.area, parts: self.parts, whole: self.whole }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 30;
    const COUNT: usize = 600;

    /// The tree of a map of 30 x 20 cells.
    fn tree(
        group: impl Fn(usize, usize) -> Option<usize>,
        border: impl Fn(usize, usize) -> f64,
    ) -> MergeTree {
        let at = |cell: usize| (cell % WIDTH, cell / WIDTH);
        let group: Vec<Option<usize>> = (0..COUNT).map(|k| group(at(k).0, at(k).1)).collect();
        let border: Vec<f64> = (0..COUNT).map(|k| border(at(k).0, at(k).1)).collect();
        let centroid = |of: usize| {
            let own = (0..COUNT).filter(|k| group[*k] == Some(of));
            let (sum, count) = own.fold((DVec2::ZERO, 0.0), |(sum, count), k| {
                (sum + DVec2::new(at(k).0 as f64 + 0.5, at(k).1 as f64 + 0.5), count + 1.0)
            });
            sum / count
        };
        let vote: Vec<DVec2> = group.iter().map(|g| g.map_or(DVec2::ZERO, centroid)).collect();
        let mut center = vec![0.0; COUNT];
        for vote in vote.iter().zip(&group).filter(|(_, group)| group.is_some()).map(|(vote, _)| vote) {
            center[vote.y as usize * WIDTH + vote.x as usize] = 0.9;
        }
        let object: Vec<f64> = group.iter().map(|g| if g.is_some() { 0.97 } else { 0.02 }).collect();
        let grid = CellGrid {
            width: WIDTH,
            group: &group,
            border: &border,
            object: &object,
            vote: &vote,
            center: &center,
        };
        MergeTree::new(&grid, &CancelFlag::default()).expect("is not interrupted")
    }

    fn within(x: usize, y: usize, [left, upper, right, lower]: [usize; 4]) -> bool {
        (left..right).contains(&x) && (upper..lower).contains(&y)
    }

    /// Whether a cell is on the rim of a box or just outside of it.
    fn on_rim(x: usize, y: usize, [left, upper, right, lower]: [usize; 4]) -> bool {
        within(x, y, [left - 1, upper - 1, right + 1, lower + 1])
            && !within(x, y, [left + 1, upper + 1, right - 1, lower - 1])
    }

    fn sizes(tree: &MergeTree) -> Vec<usize> {
        tree.candidates(1.0).map(|(_, cells)| cells.len()).collect()
    }

    const MAT: [usize; 4] = [3, 2, 27, 18];
    const PLIERS: [usize; 4] = [11, 7, 19, 13];

    #[test]
    fn inner_object_and_union_are_candidates() {
        let tree =
            tree(|x, y| within(x, y, MAT).then_some(0), |x, y| if on_rim(x, y, PLIERS) { 0.9 } else { 0.1 });
        let sizes = sizes(&tree);
        assert_eq!(sizes.last(), Some(&(24 * 16)), "{sizes:?}");
        let parted = tree.candidates(1.0).find(|(features, _)| (0.8..1.0).contains(&features.joined_at));
        let (_, whole) = parted.expect("joined across the border");
        assert_eq!(whole.len(), 24 * 16);
        let alone = |cells: &Vec<usize>| cells.contains(&(10 * WIDTH + 15)) && cells.len() <= 8 * 6 + 28;
        assert!(tree.candidates(8.0).any(|(m, cells)| alone(&cells) && m.joins_at > 0.8), "{sizes:?}");
    }

    #[test]
    fn border_to_other_group_does_not_split_group() {
        // A bar in front of a mat: the strip of the mat between its edge and the bar is all border.
        let bar = [3, 4, 27, 8];
        let tree = tree(
            |x, y| within(x, y, MAT).then_some(usize::from(within(x, y, bar))),
            |x, y| if on_rim(x, y, [2, 4, 28, 8]) { 0.95 } else { 0.02 },
        );
        let of_mat: Vec<usize> = tree
            .candidates(1.0)
            .filter(|(features, _)| features.joins_at < OCCLUSION_BORDER)
            .map(|(_, cells)| cells.len())
            .collect();
        assert!(of_mat.is_empty(), "{of_mat:?}");
    }

    #[test]
    fn separated_parts_merge_before_occluder() {
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
    fn selected_regions_are_disjoint_and_sorted_by_score() {
        let two = |x: usize, y: usize| within(x, y, MAT).then_some(usize::from(x >= 15));
        let tree = tree(two, |x: usize, _: usize| if (14..16).contains(&x) { 0.9 } else { 0.02 });
        let scored = tree.select_disjoint(0.0, 8.0);
        assert!(scored.windows(2).all(|pair| pair[0].score >= pair[1].score));
        let mut cells: Vec<usize> = scored.iter().flat_map(|region| region.cells.clone()).collect();
        cells.sort_unstable();
        let count = cells.len();
        cells.dedup();
        assert_eq!(cells.len(), count);
        let mut own: Vec<usize> = scored.iter().map(|region| region.cells.len()).collect();
        own.sort_unstable();
        assert_eq!(own, [12 * 16, 12 * 16], "{scored:?}");
        assert!(tree.select_disjoint(1.0, 8.0).is_empty());
    }

    #[test]
    fn incremental_features_equal_features_of_cells() {
        // Noise: the incremental sums must equal the sums over the cells.
        let noise = |x: usize, y: usize| f64::from(((x * 7919 + y * 104_729) % 97) as u32) / 97.0;
        let tree = tree(|x, y| (noise(x, y) > 0.2).then_some((x / 7 + y / 9) % 3), noise);
        let mut regions = 0;
        for (features, cells) in tree.candidates(1.0) {
            let size = cells.len() as f64;
            assert!((features.log_area - (size / COUNT as f64).ln()).abs() < 1e-9);
            let own: std::collections::BTreeSet<usize> = cells.iter().copied().collect();
            let (mut free, mut shared) = (0.0, 0.0);
            for &cell in &cells {
                let (x, y) = (cell % WIDTH, cell / WIDTH);
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
            assert!((features.rim_length - (free + shared) / size.sqrt()).abs() < 1e-9);
            assert!((features.rim_shared - shared / f64::max(free + shared, 1.0)).abs() < 1e-9);
            regions += 1;
        }
        assert!(regions > 100, "{regions}");
    }

    #[test]
    fn merge_tree_stops_when_cancelled() {
        let group = vec![Some(0); COUNT];
        let border: Vec<f64> = (0..COUNT).map(|k| f64::from((k % 5) as u32) / 5.0).collect();
        let (vote, numbers) = (vec![DVec2::ONE; COUNT], vec![0.5; COUNT]);
        let grid = CellGrid {
            width: WIDTH,
            group: &group,
            border: &border,
            object: &numbers,
            vote: &vote,
            center: &numbers,
        };
        let cancel = CancelFlag::default();
        cancel.cancel();
        assert!(MergeTree::new(&grid, &cancel).is_err());
    }
}
