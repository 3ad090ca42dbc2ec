//! Support relations of all objects of a scene as a tree rooted at the table.

use crate::instance::SupportRelation;

/// The supporter of one object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Supporter {
    /// Index of the supporting object; `None` = the table.
    pub parent: Option<usize>,
    pub relation: SupportRelation,
}

/// The reason why supporters form no tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidSupport {
    #[error("object {0} has an unknown supporter")]
    UnknownParent(usize),
    #[error("object {0} supports itself, directly or through others")]
    Cycle(usize),
}

/// Supporters of all objects. Acyclic by construction: every chain of supporters ends at the table.
///
/// ```
/// use scene::instance::SupportRelation::{In, On};
/// use scene::support_tree::{SupportTree, Supporter};
///
/// // A spoon in a mug, which stands on the table.
/// let spoon = Supporter { parent: Some(1), relation: In };
/// let mug = Supporter { parent: None, relation: On };
/// let tree = SupportTree::new(vec![spoon, mug])?;
/// assert_eq!(tree.order(), [1, 0]);
/// assert_eq!(tree.ancestors(0).collect::<Vec<_>>(), [1]);
/// # Ok::<(), scene::support_tree::InvalidSupport>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SupportTree {
    supporters: Vec<Supporter>,
    order: Vec<usize>,
}

impl SupportTree {
    /// The tree of these supporters, one per object. Takes O(n) time.
    ///
    /// # Errors
    ///
    /// [`InvalidSupport`] if a parent is not an index of the list, or if parents form a cycle.
    pub fn new(supporters: Vec<Supporter>) -> Result<Self, InvalidSupport> {
        let count = supporters.len();
        let mut children = vec![Vec::new(); count];
        let mut order = Vec::with_capacity(count);
        for (index, supporter) in supporters.iter().enumerate() {
            match supporter.parent {
                None => order.push(index),
                Some(parent) if parent < count => children[parent].push(index),
                Some(_) => return Err(InvalidSupport::UnknownParent(index)),
            }
        }
        // Breadth first from the table; objects of a cycle are never reached.
        let mut next = 0;
        while let Some(&index) = order.get(next) {
            order.extend(&children[index]);
            next += 1;
        }
        if order.len() < count {
            let mut reached = vec![false; count];
            order.iter().for_each(|&index| reached[index] = true);
            let mut at = reached.iter().position(|reached| !reached).unwrap_or_default();
            // After as many steps as there are objects, the walk is inside the cycle.
            for _ in 0..count {
                at = supporters[at].parent.unwrap_or(at);
            }
            return Err(InvalidSupport::Cycle(at));
        }
        Ok(Self { supporters, order })
    }

    /// Number of objects.
    pub fn len(&self) -> usize {
        self.supporters.len()
    }

    pub fn is_empty(&self) -> bool {
        self.supporters.is_empty()
    }

    /// The supporter of an object.
    pub fn supporter(&self, index: usize) -> Supporter {
        self.supporters[index]
    }

    /// Topological order: every object comes after its supporter; objects of the same depth keep their list order
    /// below each supporter.
    pub fn order(&self) -> &[usize] {
        &self.order
    }

    /// The supporters below an object, nearest first, without the table.
    pub fn ancestors(&self, index: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(self.supporters[index].parent, move |&parent| self.supporters[parent].parent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(parents: &[Option<usize>]) -> Result<SupportTree, InvalidSupport> {
        let on = |&parent: &Option<usize>| Supporter { parent, relation: SupportRelation::On };
        SupportTree::new(parents.iter().map(on).collect())
    }

    #[test]
    fn new_orders_supporters_before_their_objects() {
        let tree = tree(&[Some(2), None, Some(1), None, Some(2)]).expect("a tree");
        assert_eq!(tree.order(), [1, 3, 2, 0, 4]);
        assert_eq!(tree.ancestors(4).collect::<Vec<_>>(), [2, 1]);
        assert_eq!((tree.len(), tree.is_empty(), tree.supporter(1).parent), (5, false, None));
        assert!(SupportTree::new(Vec::new()).expect("empty").is_empty());
    }

    #[test]
    fn new_rejects_cycles_and_unknown_parents() {
        assert_eq!(tree(&[None, Some(2)]), Err(InvalidSupport::UnknownParent(1)));
        assert_eq!(tree(&[Some(0)]), Err(InvalidSupport::Cycle(0)));
        assert_eq!(tree(&[None, Some(2), Some(1), Some(1)]), Err(InvalidSupport::Cycle(1)));
    }
}
