//! Basins: the smallest parts that things are put together from.
//!
//! Places that vote for the same middle are a group. Votes fail where a thing lies in the middle of another one, as pliers
//! on a mat, and where a small thing's middle is not seen beside that of a large one; but the border between the two may
//! be. So each group falls into the basins of the border map (watershed by levels).

use std::collections::VecDeque;

use glam::DVec2;

/// Levels of the border map at which basins may begin.
const LEVELS: usize = 20;

/// Places of a map and what is known of each.
#[derive(Clone, Copy)]
pub(super) struct Places<'a> {
    pub width: usize,
    /// Which middle a place votes for; `None` where no thing is.
    pub group: &'a [Option<usize>],
    /// Probability of a border between two things, 0..1.
    pub border: &'a [f64],
    /// Probability of a thing, 0..1.
    pub object: &'a [f64],
    /// Map position of the middle it votes for.
    pub vote: &'a [DVec2],
    /// How much it is the middle of a thing, about 0..1.
    pub center: &'a [f64],
}

/// The basin of each place, and how many there are.
pub(super) struct Basins {
    pub of_place: Vec<Option<usize>>,
    pub count: usize,
}

impl Places<'_> {
    pub fn count(&self) -> usize {
        self.group.len()
    }

    pub fn height(&self) -> usize {
        self.count() / self.width
    }

    /// Left, right, above and below, inside the map.
    pub fn neighbors(&self, place: usize) -> impl Iterator<Item = usize> + use<> {
        let (width, count) = (self.width, self.count());
        let x = place % width;
        let left = (x > 0).then(|| place - 1);
        let right = (x + 1 < width).then(|| place + 1);
        let above = place.checked_sub(width);
        let below = Some(place + width).filter(|p| *p < count);
        [left, right, above, below].into_iter().flatten()
    }

    /// The place and those around it, corners too.
    fn around(&self, place: usize) -> impl Iterator<Item = usize> + use<> {
        let (width, height) = (self.width, self.height());
        let (x, y) = (place % width, place / width);
        (y.saturating_sub(1)..(y + 2).min(height))
            .flat_map(move |v| (x.saturating_sub(1)..(x + 2).min(width)).map(move |u| v * width + u))
    }

    /// Probabilities of borders within groups: what lies beside another group is explained by that.
    pub fn inner_borders(&self) -> Vec<f64> {
        let is_explained = |place: usize| {
            let own = self.group[place];
            self.around(place).any(|other| self.group[other].is_some() && self.group[other] != own)
        };
        (0..self.count()).map(|place| if is_explained(place) { 0.0 } else { self.border[place] }).collect()
    }

    /// Watershed of smoothed inner borders within each group.
    pub fn basins(&self, inner_borders: &[f64]) -> Basins {
        let mut of_level = vec![Vec::new(); LEVELS];
        let level: Vec<usize> = (0..self.count()).map(|place| self.level(place, inner_borders)).collect();
        for place in (0..self.count()).filter(|&place| self.group[place].is_some()) {
            of_level[level[place]].push(place);
        }
        let mut basin: Vec<Option<usize>> = vec![None; self.count()];
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
        Basins { of_place: basin, count }
    }

    /// Of the mean of a place and those around it.
    fn level(&self, place: usize, values: &[f64]) -> usize {
        let (sum, count) = self.around(place).fold((0.0, 0.0), |(sum, n), k| (sum + values[k], n + 1.0));
        ((LEVELS as f64 * sum / count) as usize).min(LEVELS - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn basins_end_where_borders_run_and_where_other_groups_begin() {
        // 12 x 4 places: a border down the middle of the first group, another group at the right.
        let group: Vec<Option<usize>> = (0..48).map(|k| Some(usize::from(k % 12 >= 9))).collect();
        let border: Vec<f64> = (0..48).map(|k| if k % 12 == 4 { 0.9 } else { 0.0 }).collect();
        let (none, votes) = (vec![0.0; 48], vec![DVec2::ZERO; 48]);
        let places =
            Places { width: 12, group: &group, border: &border, object: &none, vote: &votes, center: &none };
        let basins = places.basins(&places.inner_borders());
        assert_eq!(basins.count, 3);
        let of = |x: usize| basins.of_place[x];
        assert!(of(0) != of(8) && of(8) != of(11) && of(0).is_some(), "{:?}", basins.of_place);
    }

    #[test]
    fn what_lies_beside_another_group_is_no_border_within_its_own() {
        let group: Vec<Option<usize>> = (0..48).map(|k| Some(usize::from(k % 12 >= 6))).collect();
        let border = vec![0.8; 48];
        let (none, votes) = (vec![0.0; 48], vec![DVec2::ZERO; 48]);
        let places =
            Places { width: 12, group: &group, border: &border, object: &none, vote: &votes, center: &none };
        let inner = places.inner_borders();
        assert_eq!(inner[..12], [0.8, 0.8, 0.8, 0.8, 0.8, 0.0, 0.0, 0.8, 0.8, 0.8, 0.8, 0.8]);
    }
}
