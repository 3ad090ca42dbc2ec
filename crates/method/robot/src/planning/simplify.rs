//! Shorter and smoother paths: shortcuts, cut corners, left-out and moved configurations.

use rand::{Rng, RngExt};

use super::metric::{distance, toward};
use super::sampler::Sampler;
use super::settings::PlanOptions;
use crate::collision::Checker;
use crate::collision::lane_arm::Configuration;

/// A path in work. Each configuration has a number, so that an edge that was found blocked is not checked again.
struct Draft<'a> {
    checker: &'a Checker,
    settings: &'a PlanOptions,
    points: Vec<Point>,
    next_number: u32,
    blocked: Vec<(u32, u32)>,
}

#[derive(Clone, Copy)]
struct Point {
    configuration: Configuration,
    number: u32,
}

/// Makes a free path shorter, keeping its ends. `sampler` is where moved configurations come from.
pub fn simplify(
    checker: &Checker,
    path: &[Configuration],
    settings: &PlanOptions,
    sampler: &mut Sampler,
    rng: &mut impl Rng,
) -> Vec<Configuration> {
    let (Some(&first), Some(&last)) = (path.first(), path.last()) else { return Vec::new() };
    if path.len() < 3 {
        return path.to_vec();
    }
    if checker.edge_is_free(&first, &last, settings.checks_per_unit) {
        return vec![first, last];
    }
    let points = (0..).zip(path).map(|(number, &configuration)| Point { configuration, number }).collect();
    let mut draft = Draft { checker, settings, points, next_number: path.len() as u32, blocked: Vec::new() };
    let simplify = &settings.simplify;
    let mut rounds = vec![draft.points.clone()];
    for _ in 0..simplify.max_rounds {
        let shortened = draft.take_shortcuts();
        let reduced = draft.leave_out(simplify.reduce_attempts, rng);
        let moved = draft.move_points(simplify.perturb_attempts, sampler, rng);
        let rounded = draft.cut_corners();
        if !(shortened || reduced || moved || rounded) {
            break;
        }
        rounds.push(draft.points.clone());
    }
    // Half of a free edge is checked at other points than the edge was, and may graze what they missed. The last round
    // counts whose edges are all free as they are; the first entry is the path as it was found.
    let sound = rounds.iter().skip(1).rev().find(|points| draft.is_path_free(points));
    sound.unwrap_or(&rounds[0]).iter().map(|point| point.configuration).collect()
}

impl Draft<'_> {
    fn numbered(&mut self, configuration: Configuration) -> Point {
        self.next_number += 1;
        Point { configuration, number: self.next_number - 1 }
    }

    fn is_free(&self, from: &Configuration, to: &Configuration) -> bool {
        self.checker.edge_is_free(from, to, self.settings.checks_per_unit)
    }

    fn is_path_free(&self, points: &[Point]) -> bool {
        points.windows(2).all(|ends| self.is_free(&ends[0].configuration, &ends[1].configuration))
    }

    /// Whether the edge between two points of the path is free; remembers if it is not.
    fn joins(&mut self, from: usize, to: usize) -> bool {
        let (from, to) = (self.points[from], self.points[to]);
        let key = (from.number, to.number);
        if self.blocked.contains(&key) {
            return false;
        }
        let free = self.is_free(&from.configuration, &to.configuration);
        if !free {
            self.blocked.push(key);
        }
        free
    }

    /// From each point, goes straight to the farthest one that it can.
    fn take_shortcuts(&mut self) -> bool {
        let before = self.points.len();
        let mut from = 0;
        while from + 2 < self.points.len() {
            if let Some(to) = (from + 2..self.points.len()).rev().find(|&to| self.joins(from, to)) {
                self.points.drain(from + 1..to);
            }
            from += 1;
        }
        self.points.len() < before
    }

    /// Halves each edge and moves each corner toward the midpoint of its neighbors: one step of a quadratic B-spline.
    fn cut_corners(&mut self) -> bool {
        if self.points.len() < 3 {
            return false;
        }
        let mut halved = Vec::with_capacity(2 * self.points.len());
        for index in 0..self.points.len() - 1 {
            let (from, to) = (self.points[index], self.points[index + 1]);
            let midpoint = self.numbered(toward(&from.configuration, &to.configuration, 0.5));
            halved.extend([from, midpoint]);
        }
        halved.extend(self.points.last());
        self.points = halved;
        let mut changed = false;
        for index in (2..self.points.len() - 1).step_by(2) {
            let [before, corner, after] = [index - 1, index, index + 1].map(|i| self.points[i].configuration);
            let cut = toward(&toward(&corner, &before, 0.5), &toward(&corner, &after, 0.5), 0.5);
            if distance(&corner, &cut) > self.settings.simplify.min_corner
                && self.is_free(&before, &cut)
                && self.is_free(&cut, &after)
            {
                self.points[index] = self.numbered(cut);
                changed = true;
            }
        }
        changed
    }

    /// Tries to leave out what is between two random points.
    fn leave_out(&mut self, attempts: usize, rng: &mut impl Rng) -> bool {
        let before = self.points.len();
        for _ in 0..attempts {
            if self.points.len() < 3 {
                break;
            }
            let from = rng.random_range(0..self.points.len() - 2);
            let to = rng.random_range(from + 2..self.points.len());
            if self.joins(from, to) {
                self.points.drain(from + 1..to);
            }
        }
        self.points.len() < before
    }

    /// Tries to move random points a little, where that makes the path shorter.
    fn move_points(&mut self, attempts: usize, sampler: &mut Sampler, rng: &mut impl Rng) -> bool {
        if self.points.len() < 3 {
            return false;
        }
        let mut changed = false;
        for _ in 0..attempts {
            let index = rng.random_range(1..self.points.len() - 1);
            let [before, point, after] = [index - 1, index, index + 1].map(|i| self.points[i].configuration);
            let moved = toward(&point, &sampler.sample(), self.settings.simplify.perturb_share);
            let length = |midpoint: &Configuration| distance(&before, midpoint) + distance(midpoint, &after);
            if length(&moved) < length(&point)
                && self.is_free(&before, &moved)
                && self.is_free(&moved, &after)
            {
                self.points[index] = self.numbered(moved);
                changed = true;
            }
        }
        changed
    }
}
