//! The trees of the planner, with fast nearest neighbors.

use crate::collision::arm::MAX_JOINTS;
use crate::collision::lane_arm::Configuration;
use crate::collision::lanes::{Backend, LANE_COUNT, LaneTask, Lanes};

/// Configurations, each with the one it was reached from.
///
/// The nearest neighbor is found by looking at all, eight at a time. Trees of this planner hold tens to thousands of
/// configurations, and below some thousands no other structure is faster.
pub struct Tree {
    /// `blocks[b][joint][k]` belongs to configuration `8 b + k`; places that are empty are at infinity.
    blocks: Vec<[[f32; LANE_COUNT]; MAX_JOINTS]>,
    nodes: Vec<Node>,
    backend: Backend,
    dof: usize,
}

/// A configuration in a tree.
#[derive(Clone, Copy)]
pub struct Node {
    pub configuration: Configuration,
    /// The root has none.
    pub parent: Option<usize>,
    /// Samples farther than this are not tried from here.
    pub radius: f32,
}

impl Tree {
    pub fn new(dof: usize, backend: Backend) -> Self {
        Self { blocks: Vec::new(), nodes: Vec::new(), backend, dof }
    }

    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    pub fn node(&self, index: usize) -> &Node {
        &self.nodes[index]
    }

    pub fn set_radius(&mut self, index: usize, radius: f32) {
        self.nodes[index].radius = radius;
    }

    /// Adds a configuration and answers its index.
    pub fn add(&mut self, configuration: Configuration, parent: Option<usize>) -> usize {
        let index = self.nodes.len();
        let lane = index % LANE_COUNT;
        if lane == 0 {
            self.blocks.push([[f32::INFINITY; LANE_COUNT]; MAX_JOINTS]);
        }
        if let Some(block) = self.blocks.last_mut() {
            for (row, position) in block.iter_mut().zip(configuration) {
                row[lane] = position;
            }
        }
        self.nodes.push(Node { configuration, parent, radius: f32::INFINITY });
        index
    }

    /// The nearest configuration and its distance; the tree must have at least one.
    pub fn nearest(&self, configuration: &Configuration) -> (usize, f32) {
        let (index, square) = self.backend.run(Nearest { tree: self, configuration });
        (index, square.sqrt())
    }

    /// The configurations from the one at `index` back to the root.
    pub fn branch(&self, index: usize) -> impl Iterator<Item = Configuration> {
        let nodes = std::iter::successors(Some(index), |&index| self.nodes[index].parent);
        nodes.map(|index| self.nodes[index].configuration)
    }
}

struct Nearest<'a> {
    tree: &'a Tree,
    configuration: &'a Configuration,
}

impl LaneTask for Nearest<'_> {
    type Output = (usize, f32);

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) -> (usize, f32) {
        let dof = self.tree.dof.min(MAX_JOINTS);
        let mut asked = [L::splat(token, 0.0); MAX_JOINTS];
        for (lanes, position) in asked.iter_mut().zip(self.configuration) {
            *lanes = L::splat(token, *position);
        }
        let (mut best, mut nearest) = (0, f32::INFINITY);
        let mut bound = L::splat(token, nearest);
        for (index, block) in self.tree.blocks.iter().enumerate() {
            let mut square = L::splat(token, 0.0);
            for joint in 0..dof {
                let difference = L::from_array(token, block[joint]) - asked[joint];
                square = square + difference * difference;
            }
            let mut nearer = square.below(bound);
            if nearer == 0 {
                continue;
            }
            let squares = square.to_array();
            while nearer != 0 {
                let lane = nearer.trailing_zeros() as usize;
                if squares[lane] < nearest {
                    (best, nearest) = (LANE_COUNT * index + lane, squares[lane]);
                }
                nearer &= nearer - 1;
            }
            bound = L::splat(token, nearest);
        }
        (best, nearest)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn the_nearest_is_the_nearest() {
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let mut tree = Tree::new(6, Backend::fastest());
        let mut random = || -> Configuration {
            std::array::from_fn(|joint| if joint < 6 { rng.random_range(-3.0..3.0) } else { 0.0 })
        };
        for count in 1..200 {
            tree.add(random(), (count > 1).then_some(0));
            let asked = random();
            let square = |index: usize| -> f32 {
                tree.node(index).configuration.iter().zip(asked).map(|(a, b)| (a - b) * (a - b)).sum()
            };
            let expected = (0..count).min_by(|&a, &b| square(a).total_cmp(&square(b))).expect("a node");
            let (index, distance) = tree.nearest(&asked);
            assert_eq!(index, expected);
            assert!((distance - square(expected).sqrt()).abs() < 1e-5);
        }
    }
}
