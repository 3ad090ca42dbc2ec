//! Which places belong together: those that vote for the same middle, unless a border runs between them, and those of two
//! middles where none does.
//!
//! Votes fail where a thing lies in the middle of another one, as pliers on a mat, and where a small thing's middle is not
//! seen beside that of a large one; but the border between the two may be. So each group of voters falls into the basins
//! of the border map, and basins go together again, those with the weakest border between them first, until what is
//! left are borders.

use std::collections::{BTreeMap, VecDeque};

/// Levels of the border map at which basins may begin.
const LEVELS: usize = 20;
/// Mean probability of a border at which two parts of a group are two things; on pictures of the validation split less finds
/// more things and invents more still.
const LEAST_BORDER: f64 = 0.7;
/// How much more of a border there is between places that vote for different middles.
const OTHER_MIDDLE: f64 = 0.5;

/// Places of a map and what is known of each.
pub(super) struct Places<'a> {
    pub width: usize,
    /// Which middle a place votes for; `None` where no thing is.
    pub group: &'a [Option<usize>],
    /// Probability of a border between two things, 0..1.
    pub border: &'a [f64],
}

/// Places that are one thing's.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Region {
    /// In ascending order.
    pub places: Vec<usize>,
    /// The middle that most of its parts vote for.
    pub group: usize,
    /// Mean probability of the border to others that vote for the same middle, 0 where there are none.
    pub cut_off: f64,
}

impl Places<'_> {
    /// The regions; what is smaller than `least` places and beside another one belongs to that.
    pub(super) fn regions(&self, least: f64) -> Vec<Region> {
        let (basins, count) = self.basins();
        let mut graph = Graph::new(self, &basins, count);
        graph.join_across_weak_borders();
        graph.join_small(least);
        graph.join_hidden_parts();
        let mut regions: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (place, basin) in basins.iter().enumerate() {
            if let Some(basin) = basin {
                regions.entry(graph.root(*basin)).or_default().push(place);
            }
        }
        let region = |(root, places): (usize, Vec<usize>)| Region {
            places,
            group: graph.group[root],
            cut_off: graph.cut_off(root),
        };
        regions.into_iter().map(region).collect()
    }

    fn neighbors(&self, place: usize) -> impl Iterator<Item = usize> + use<> {
        let (width, count) = (self.width, self.group.len());
        let x = place % width;
        let left = (x > 0).then(|| place - 1);
        let right = (x + 1 < width).then(|| place + 1);
        let above = place.checked_sub(width);
        let below = Some(place + width).filter(|p| *p < count);
        [left, right, above, below].into_iter().flatten()
    }

    /// Watershed of the smoothed border map within each group: the basin of each place, and how many there are.
    fn basins(&self) -> (Vec<Option<usize>>, usize) {
        let mut of_level = vec![Vec::new(); LEVELS];
        let level: Vec<usize> = (0..self.group.len()).map(|place| self.level(place)).collect();
        for place in (0..self.group.len()).filter(|&place| self.group[place].is_some()) {
            of_level[level[place]].push(place);
        }
        let mut basin: Vec<Option<usize>> = vec![None; self.group.len()];
        let mut count = 0;
        let same = |a: usize, b: usize| self.group[a] == self.group[b];
        let flood = |basin: &mut Vec<Option<usize>>, mut front: VecDeque<usize>| {
            while let Some(from) = front.pop_front() {
                for to in self.neighbors(from) {
                    if basin[to].is_none() && level[to] == level[from] && same(from, to) {
                        basin[to] = basin[from];
                        front.push_back(to);
                    }
                }
            }
        };
        for places in &of_level {
            // What lies beside a lower basin is that basin's shore.
            let shore: Vec<(usize, usize)> = places
                .iter()
                .filter_map(|&place| {
                    let lower = self.neighbors(place).filter(|&other| same(place, other));
                    lower.filter_map(|other| basin[other]).next().map(|owner| (place, owner))
                })
                .collect();
            shore.iter().for_each(|(place, owner)| basin[*place] = Some(*owner));
            flood(&mut basin, shore.into_iter().map(|(place, _)| place).collect());
            for &place in places {
                if basin[place].is_none() {
                    basin[place] = Some(count);
                    count += 1;
                    flood(&mut basin, VecDeque::from([place]));
                }
            }
        }
        (basin, count)
    }

    /// Of the mean border probability of a place and those around it.
    fn level(&self, place: usize) -> usize {
        let (width, height) = (self.width, self.group.len() / self.width);
        let (x, y) = (place % width, place / width);
        let around = (y.saturating_sub(1)..(y + 2).min(height))
            .flat_map(|v| (x.saturating_sub(1)..(x + 2).min(width)).map(move |u| v * width + u));
        let (sum, count) = around.fold((0.0, 0.0), |(sum, n), k| (sum + self.border[k], n + 1.0));
        ((LEVELS as f64 * sum / count) as usize).min(LEVELS - 1)
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
}

/// Basins that go together.
struct Graph {
    /// The region a basin went into, itself while it went into none.
    into: Vec<usize>,
    size: Vec<f64>,
    group: Vec<usize>,
    /// Of neighbors, the smaller number first.
    shared: BTreeMap<(usize, usize), Shared>,
}

impl Graph {
    fn new(places: &Places, basins: &[Option<usize>], count: usize) -> Self {
        let (mut size, mut group) = (vec![0.0; count], vec![0; count]);
        let mut shared: BTreeMap<(usize, usize), Shared> = BTreeMap::new();
        for (place, basin) in basins.iter().enumerate() {
            let Some((own, voted)) = basin.zip(places.group[place]) else { continue };
            size[own] += 1.0;
            group[own] = voted;
            for other in places.neighbors(place).filter(|other| *other > place) {
                let Some(its) = basins[other].filter(|its| *its != own) else { continue };
                let other_middle = if places.group[other] == Some(voted) { 0.0 } else { OTHER_MIDDLE };
                let pair = shared.entry((own.min(its), own.max(its))).or_default();
                pair.border += places.border[place].max(places.border[other]) + other_middle;
                pair.pairs += 1.0;
            }
        }
        Self { into: (0..count).collect(), size, group, shared }
    }

    fn root(&self, mut basin: usize) -> usize {
        while self.into[basin] != basin {
            basin = self.into[basin];
        }
        basin
    }

    fn join(&mut self, kept: usize, gone: usize) {
        if self.size[gone] > self.size[kept] {
            self.group[kept] = self.group[gone];
        }
        self.size[kept] += self.size[gone];
        self.into[gone] = kept;
        self.shared.remove(&(kept.min(gone), kept.max(gone)));
        for (other, its) in self.beside(gone) {
            self.shared.remove(&(gone.min(other), gone.max(other)));
            let pair = self.shared.entry((kept.min(other), kept.max(other))).or_default();
            pair.border += its.border;
            pair.pairs += its.pairs;
        }
    }

    /// Neighbors of a region.
    fn beside(&self, region: usize) -> Vec<(usize, Shared)> {
        let other = |(a, b): (usize, usize)| (a == region).then_some(b).or((b == region).then_some(a));
        self.shared.iter().filter_map(|(pair, shared)| Some((other(*pair)?, *shared))).collect()
    }

    fn join_across_weak_borders(&mut self) {
        let by_mean = |a: &(&(usize, usize), &Shared), b: &(&(usize, usize), &Shared)| {
            a.1.mean().total_cmp(&b.1.mean()).then(a.0.cmp(b.0))
        };
        while let Some((&(a, b), _)) =
            self.shared.iter().min_by(by_mean).filter(|(_, shared)| shared.mean() < LEAST_BORDER)
        {
            self.join(a, b);
        }
    }

    fn join_small(&mut self, least: f64) {
        for region in 0..self.into.len() {
            while self.into[region] == region && self.size[region] < least {
                let beside = self.beside(region);
                let weakest = beside.iter().min_by(|a, b| a.1.mean().total_cmp(&b.1.mean()));
                let Some(&(other, _)) = weakest else { break };
                self.join(other, region);
            }
        }
    }

    /// What hides a thing may cut it in two: parts of a group that do not touch are one thing.
    fn join_hidden_parts(&mut self) {
        for region in 0..self.into.len() {
            if self.into[region] != region {
                continue;
            }
            let group = self.group[region];
            let touches = self.beside(region).iter().any(|(other, _)| self.group[*other] == group);
            let others =
                (0..self.into.len()).filter(|&k| k != region && self.into[k] == k && self.group[k] == group);
            let largest = others.max_by(|&a, &b| self.size[a].total_cmp(&self.size[b]));
            if let Some(largest) = largest.filter(|&k| !touches && self.size[k] >= self.size[region]) {
                self.join(largest, region);
            }
        }
    }

    fn cut_off(&self, region: usize) -> f64 {
        let own = self.group[region];
        let same = self.beside(region).into_iter().filter(|(other, _)| self.group[*other] == own);
        let sum = same.fold(Shared::default(), |sum, (_, its)| Shared {
            border: sum.border + its.border,
            pairs: sum.pairs + its.pairs,
        });
        if sum.pairs > 0.0 { sum.mean().min(1.0) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 30;

    /// Regions of a map of 30 x 20 places, as what is at each place.
    fn read(
        group: impl Fn(usize, usize) -> Option<usize>,
        border: impl Fn(usize, usize) -> f64,
    ) -> Vec<Region> {
        let at = |place: usize| (place % WIDTH, place / WIDTH);
        let group: Vec<Option<usize>> = (0..600).map(|k| group(at(k).0, at(k).1)).collect();
        let border: Vec<f64> = (0..600).map(|k| border(at(k).0, at(k).1)).collect();
        Places { width: WIDTH, group: &group, border: &border }.regions(8.0)
    }

    fn within(x: usize, y: usize, [left, upper, right, lower]: [usize; 4]) -> bool {
        (left..right).contains(&x) && (upper..lower).contains(&y)
    }

    /// On the rim of a box or just outside of it.
    fn on_rim(x: usize, y: usize, [left, upper, right, lower]: [usize; 4]) -> bool {
        within(x, y, [left - 1, upper - 1, right + 1, lower + 1])
            && !within(x, y, [left + 1, upper + 1, right - 1, lower - 1])
    }

    const MAT: [usize; 4] = [3, 2, 27, 18];
    const PLIERS: [usize; 4] = [11, 7, 19, 13];

    #[test]
    fn a_thing_in_the_middle_of_another_is_told_by_its_border() {
        let mat = |x, y| within(x, y, MAT).then_some(0);
        let told = read(mat, |x, y| if on_rim(x, y, PLIERS) { 0.9 } else { 0.1 });
        assert_eq!(told.len(), 2, "{told:?}");
        let pliers = told.iter().min_by_key(|region| region.places.len()).expect("two");
        assert!(
            pliers.places.contains(&(10 * WIDTH + 15)) && pliers.places.len() <= 8 * 6 + 28,
            "{pliers:?}"
        );
        assert!(pliers.cut_off > LEAST_BORDER);
        let faint = read(mat, |x, y| if on_rim(x, y, PLIERS) { 0.4 } else { 0.1 });
        assert_eq!((faint.len(), faint[0].cut_off), (1, 0.0));
    }

    #[test]
    fn votes_tell_things_apart_but_where_nothing_runs_between_them() {
        let two = |x: usize, y: usize| within(x, y, MAT).then_some(usize::from(x >= 15));
        let border =
            |strength: f64| move |x: usize, _: usize| if (14..16).contains(&x) { strength } else { 0.02 };
        let apart = read(two, border(0.5));
        assert_eq!(apart.iter().map(|r| r.group).collect::<Vec<_>>(), [0, 1]);
        assert_eq!(read(two, border(0.05)).len(), 1);
    }

    #[test]
    fn what_is_hidden_in_the_middle_is_one_thing_and_specks_are_none() {
        // A bar across a mat, whose halves vote for one middle.
        let across = |x: usize, y: usize| within(x, y, MAT).then_some(usize::from((9..12).contains(&y)));
        let edges =
            |x: usize, y: usize| if within(x, y, MAT) && [8, 9, 11, 12].contains(&y) { 0.8 } else { 0.1 };
        let told = read(across, edges);
        assert_eq!(told.iter().map(|r| r.places.len()).collect::<Vec<_>>(), [24 * 13, 24 * 3], "{told:?}");
        let speckled = read(
            |x, y| within(x, y, MAT).then_some(usize::from(within(x, y, [9, 9, 11, 11]))),
            |x, y| if on_rim(x, y, [9, 9, 11, 11]) { 0.9 } else { 0.1 },
        );
        assert_eq!(speckled.len(), 1, "{speckled:?}");
    }
}
