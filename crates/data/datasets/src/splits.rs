//! Splits: scenes that share something form groups, and groups are assigned whole.
//!
//! Groups are the connected components of the graph whose edges are common keys (union-find). The largest group is
//! assigned first, each to the split that lacks the largest number of scenes; groups of one size are in the order of a
//! digest of seed and scenes. The number of scenes of every split differs from its ratio by less than the size of the
//! largest group: the last group of an overfull split was given to it when no split lacked more.
//!
//! Scenes of an earlier version keep their split, so that none moves from training to tests: a group goes to the split
//! that the majority of these scenes had, before all other groups, and the bound holds for the others only roughly.
//! Cost: O(n log n) in the number of keys.

use std::cmp::{Ordering, Reverse};
use std::collections::{BTreeMap, HashMap};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::bundle::sha256;
use crate::error::DatasetError;
use crate::sharing::{LeakageRules, Shareable};

/// Name of the assignment in `dataset.json`; a changed method has another name.
pub const METHOD: &str = "largest-group-first/1";

/// Names and shares of the splits, and the seed of the assignment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SplitPlan {
    pub ratios: Vec<SplitRatio>,
    pub seed: u64,
}

/// One split and its share of the scenes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SplitRatio {
    pub name: String,
    /// 0 to 1; the ratios of a plan have the sum 1.
    pub ratio: f64,
}

/// The reason why a text is no plan of splits; the message states the correction.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SplitPlanError {
    #[error("{0:?} is not of the form NAME=RATIO, such as train=0.8")]
    NoRatio(String),
    #[error("{0:?} must be a name of lower-case letters, digits and _, given once")]
    Name(String),
    #[error("{0:?} is no number")]
    NotNumber(String),
    #[error("the ratio of {0} must be from 0 to 1")]
    Ratio(String),
    #[error("the ratios must have the sum 1, and have {0}")]
    Sum(f64),
}

impl FromStr for SplitPlan {
    type Err = SplitPlanError;

    /// A list such as `train=0.8,validation=0.1,test=0.1`, or `none` for one split `all` of all scenes; the seed is 0.
    fn from_str(text: &str) -> Result<Self, SplitPlanError> {
        let mut ratios: Vec<SplitRatio> = Vec::new();
        let text = if text.trim() == "none" { "all=1" } else { text };
        for part in text.split(',').map(str::trim) {
            let (name, ratio) =
                part.split_once('=').ok_or_else(|| SplitPlanError::NoRatio(part.to_owned()))?;
            let is_name = (1..=32).contains(&name.len())
                && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
            if !is_name || ratios.iter().any(|other| other.name == name) {
                return Err(SplitPlanError::Name(name.to_owned()));
            }
            let ratio: f64 = ratio.parse().map_err(|_| SplitPlanError::NotNumber(ratio.to_owned()))?;
            if !(0.0..=1.0).contains(&ratio) {
                return Err(SplitPlanError::Ratio(name.to_owned()));
            }
            ratios.push(SplitRatio { name: name.to_owned(), ratio });
        }
        let sum: f64 = ratios.iter().map(|split| split.ratio).sum();
        if (sum - 1.0).abs() > 1e-6 {
            return Err(SplitPlanError::Sum(sum));
        }
        Ok(Self { ratios, seed: 0 })
    }
}

impl SplitPlan {
    /// Refuses an assignment that leaves a split empty whose share is above 0.
    ///
    /// # Errors
    ///
    /// [`DatasetError::EmptySplits`] with the reason, and what else could be asked for.
    pub fn check_filled(&self, groups: &[Group], assigned: &[String]) -> Result<(), DatasetError> {
        let is_empty = |split: &&SplitRatio| split.ratio > 0.0 && !assigned.contains(&split.name);
        let empty: Vec<&str> = self.ratios.iter().filter(is_empty).map(|split| &*split.name).collect();
        if empty.is_empty() {
            return Ok(());
        }
        let sizes = groups.iter().map(|group| group.scenes.len());
        let (scenes, largest) = (sizes.clone().sum::<usize>(), sizes.max().unwrap_or(0));
        let words = if empty.len() == 1 { "the split" } else { "the splits" };
        Err(DatasetError::EmptySplits(format!(
            "no scene is left for {words} {}: scenes that share a description, an image, a mesh or a parent are a group, \
             and a group is never divided (scenes: {scenes}, groups: {}, largest group: {largest}); freeze scenes of more \
             descriptions, ask for other shares or for no splits (none, or all=1), or let splits share more (disjoint)",
            empty.join(", "),
            groups.len(),
        )))
    }
}

/// Scenes that stay together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Ids, sorted.
    scenes: Vec<String>,
}

impl Group {
    pub fn of<S: Into<String>>(scenes: impl IntoIterator<Item = S>) -> Self {
        let mut scenes: Vec<String> = scenes.into_iter().map(Into::into).collect();
        scenes.sort();
        Self { scenes }
    }

    pub fn scenes(&self) -> &[String] {
        &self.scenes
    }

    /// The name of the group: a short digest of its scenes.
    pub fn name(&self) -> String {
        sha256(self.scenes.join("\n").as_bytes())[..12].to_owned()
    }
}

/// The groups of scenes that share a key, in the order of their first scene's id.
pub fn groups(scenes: &[Shareable], rules: &LeakageRules) -> Vec<Group> {
    let mut parents: Vec<usize> = (0..scenes.len()).collect();
    let mut first_with: HashMap<String, usize> = HashMap::new();
    for (index, scene) in scenes.iter().enumerate() {
        for key in rules.keys(scene) {
            let other = *first_with.entry(key).or_insert(index);
            let (a, b) = (root(&mut parents, index), root(&mut parents, other));
            parents[a.max(b)] = a.min(b);
        }
    }
    let mut members: Vec<Vec<String>> = vec![Vec::new(); scenes.len()];
    for (index, scene) in scenes.iter().enumerate() {
        members[root(&mut parents, index)].push(scene.id.clone());
    }
    let mut groups: Vec<Group> = members.into_iter().filter(|ids| !ids.is_empty()).map(Group::of).collect();
    groups.sort_by(|a, b| a.scenes.cmp(&b.scenes));
    groups
}

/// The root of a set, with path halving.
fn root(parents: &mut [usize], mut index: usize) -> usize {
    while parents[index] != index {
        parents[index] = parents[parents[index]];
        index = parents[index];
    }
    index
}

/// The split of every group, by its name. `earlier` holds the splits of scenes in the version before. The result
/// depends on the plan, on `earlier` and on the set of groups, not on their order.
pub fn assign(groups: &[Group], plan: &SplitPlan, earlier: &BTreeMap<String, String>) -> Vec<String> {
    let total: usize = groups.iter().map(|group| group.scenes.len()).sum();
    let mut missing: Vec<f64> = plan.ratios.iter().map(|split| split.ratio * total as f64).collect();
    let rank = |group: &Group| sha256(format!("{}\n{}", plan.seed, group.scenes.join("\n")).as_bytes());
    let mut order: Vec<(Reverse<usize>, String, usize)> = Vec::with_capacity(groups.len());
    let mut names = vec![String::new(); groups.len()];
    for (index, group) in groups.iter().enumerate() {
        match kept_split(group, plan, earlier) {
            Some(split) => {
                missing[split] -= group.scenes.len() as f64;
                names[index].clone_from(&plan.ratios[split].name);
            }
            None => order.push((Reverse(group.scenes.len()), rank(group), index)),
        }
    }
    order.sort();
    for (_, _, index) in order {
        let Some(split) = first_max(&missing, f64::total_cmp) else { continue };
        missing[split] -= groups[index].scenes.len() as f64;
        names[index].clone_from(&plan.ratios[split].name);
    }
    names
}

/// Index of the split that the majority of the group's earlier scenes had; the first of equals.
fn kept_split(group: &Group, plan: &SplitPlan, earlier: &BTreeMap<String, String>) -> Option<usize> {
    let splits: Vec<&String> = group.scenes.iter().filter_map(|id| earlier.get(id)).collect();
    let votes = plan.ratios.iter().map(|ratio| splits.iter().filter(|split| ***split == ratio.name).count());
    let votes: Vec<usize> = votes.collect();
    first_max(&votes, usize::cmp).filter(|split| votes[*split] > 0)
}

/// Index of the largest value; the first of equals, so that the order of the plan decides.
fn first_max<T>(values: &[T], compare: impl Fn(&T, &T) -> Ordering) -> Option<usize> {
    (0..values.len()).rev().max_by(|&a, &b| compare(&values[a], &values[b]))
}
