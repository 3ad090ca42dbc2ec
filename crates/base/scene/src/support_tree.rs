//! Support relations of all objects of a scene as a tree rooted at the table.

use serde::{Deserialize, Serialize};

use crate::instance::SupportRelation;

/// The supporter of one object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Supporter {
    /// Index of the supporting object; `None` = the table.
    pub parent: Option<usize>,
    pub relation: SupportRelation,
}

impl Supporter {
    /// The table, with the object on top.
    pub const TABLE: Self = Self { parent: None, relation: SupportRelation::On };

    /// The object `parent`, with the supported object on top.
    pub const fn on(parent: usize) -> Self {
        Self { parent: Some(parent), relation: SupportRelation::On }
    }

    /// The object `parent`, with the supported object inside.
    pub const fn containing(parent: usize) -> Self {
        Self { parent: Some(parent), relation: SupportRelation::In }
    }

    /// Whether the supported object is inside the supporter rather than on top.
    pub fn is_container(self) -> bool {
        self.relation == SupportRelation::In
    }
}

/// The reason why supporters form no tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidSupport {
    #[error("object {0} has an unknown supporter")]
    UnknownParent(usize),
    #[error("object {0} supports itself, directly or through others")]
    Cycle(usize),
}

/// Supporters of all objects. Acyclic by construction: every chain of supporters ends at the table. The serialized form
/// is the list of supporters; a deserialized tree is checked.
///
/// ```
/// use scene::support_tree::{SupportTree, Supporter};
///
/// // A spoon in a mug, which stands on the table.
/// let tree = SupportTree::new(vec![Supporter::containing(1), Supporter::TABLE])?;
/// assert_eq!(tree.order(), [1, 0]);
/// assert_eq!(tree.ancestors(0).collect::<Vec<_>>(), [1]);
/// # Ok::<(), scene::support_tree::InvalidSupport>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Supporter>", into = "Vec<Supporter>")]
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
        let is_known = |supporter: &Supporter| supporter.parent.is_none_or(|parent| parent < count);
        if let Some(index) = supporters.iter().position(|supporter| !is_known(supporter)) {
            return Err(InvalidSupport::UnknownParent(index));
        }
        let order = breadth_first(&supporters);
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

    /// The tree of supporters that may contradict each other. Objects are visited in list order. An object stands on
    /// the table if its parent is not an index of the list or already rests on the object.
    pub fn without_contradictions(supporters: &[Supporter]) -> Self {
        let mut accepted = vec![Supporter::TABLE; supporters.len()];
        for (index, &supporter) in supporters.iter().enumerate() {
            let is_contradiction = supporter.parent.is_some_and(|parent| {
                parent >= accepted.len()
                    || parent == index
                    || ancestors(&accepted, parent).any(|other| other == index)
            });
            if !is_contradiction {
                accepted[index] = supporter;
            }
        }
        Self { order: breadth_first(&accepted), supporters: accepted }
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

    /// The supporter of each object.
    pub fn supporters(&self) -> &[Supporter] {
        &self.supporters
    }

    /// Topological order: every object comes after its supporter; objects of the same depth keep their list order
    /// below each supporter.
    pub fn order(&self) -> &[usize] {
        &self.order
    }

    /// The supporters below an object, nearest first, without the table.
    pub fn ancestors(&self, index: usize) -> impl Iterator<Item = usize> + '_ {
        ancestors(&self.supporters, index)
    }

    /// The supporters on top of which an object stands, nearest first, without the table: the supporters below the
    /// object down to the first container, which is not among them.
    pub fn ancestors_on(&self, index: usize) -> impl Iterator<Item = usize> + '_ {
        let below = move |index: usize| {
            let supporter = self.supporters[index];
            supporter.parent.filter(|_| !supporter.is_container())
        };
        std::iter::successors(below(index), move |&parent| below(parent))
    }

    /// Whether `object` is `base` or rests on it, directly or through others.
    pub fn rests_on(&self, object: usize, base: usize) -> bool {
        object == base || self.ancestors(object).any(|other| other == base)
    }

    /// The object and everything that rests on it, in topological order.
    pub fn branch(&self, base: usize) -> impl Iterator<Item = usize> + '_ {
        self.order.iter().copied().filter(move |&object| self.rests_on(object, base))
    }

    /// The objects directly on or in `parent` (`None` = the table), in list order.
    pub fn children(&self, parent: Option<usize>) -> impl Iterator<Item = usize> + '_ {
        (0..self.len()).filter(move |&index| self.supporters[index].parent == parent)
    }

    /// The objects with this supporter, in list order.
    pub fn supported_by(&self, supporter: Supporter) -> impl Iterator<Item = usize> + '_ {
        (0..self.len()).filter(move |&index| self.supporters[index] == supporter)
    }

    /// The other objects in the container of an object, in list order. Empty if the object stands on its supporter.
    pub fn container_mates(&self, index: usize) -> impl Iterator<Item = usize> + '_ {
        let own = self.supporters[index];
        self.supported_by(own).filter(move |&other| own.is_container() && other != index)
    }

    /// Puts an object on the table, with everything that rests on it.
    pub fn move_to_table(&mut self, index: usize) {
        // The chain of supporters of an object can only become shorter, so no cycle arises.
        self.supporters[index] = Supporter::TABLE;
        self.order = breadth_first(&self.supporters);
    }
}

impl TryFrom<Vec<Supporter>> for SupportTree {
    type Error = InvalidSupport;

    fn try_from(supporters: Vec<Supporter>) -> Result<Self, InvalidSupport> {
        Self::new(supporters)
    }
}

impl From<SupportTree> for Vec<Supporter> {
    fn from(tree: SupportTree) -> Self {
        tree.supporters
    }
}

fn ancestors(supporters: &[Supporter], index: usize) -> impl Iterator<Item = usize> + '_ {
    std::iter::successors(supporters[index].parent, move |&parent| supporters[parent].parent)
}

/// Objects breadth first from the table; objects of a cycle are missing.
fn breadth_first(supporters: &[Supporter]) -> Vec<usize> {
    let mut children = vec![Vec::new(); supporters.len()];
    let mut order = Vec::with_capacity(supporters.len());
    for (index, supporter) in supporters.iter().enumerate() {
        match supporter.parent {
            None => order.push(index),
            Some(parent) => children[parent].push(index),
        }
    }
    let mut next = 0;
    while let Some(&index) = order.get(next) {
        order.extend(&children[index]);
        next += 1;
    }
    order
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

    #[test]
    fn new_is_inverse_to_serialization_which_checks() {
        let spoon_in_mug = [Supporter::containing(1), Supporter::TABLE];
        let tree = SupportTree::new(spoon_in_mug.to_vec()).expect("a tree");
        let stored = serde_json::to_string(&tree).expect("numbers and words");
        assert_eq!(stored, r#"[{"parent":1,"relation":"in"},{"parent":null,"relation":"on"}]"#);
        assert_eq!(serde_json::from_str::<SupportTree>(&stored).expect("a tree"), tree);
        let cyclic = r#"[{"parent":0,"relation":"on"}]"#;
        let error = serde_json::from_str::<SupportTree>(cyclic).expect_err("a cycle");
        assert!(error.to_string().starts_with("object 0 supports itself"), "{error}");
    }

    #[test]
    fn contradicting_supporters_are_replaced_by_the_table() {
        // 0 on 1, 1 in 0 (closes a cycle), 2 on itself, 3 on an unknown object, 4 in 1.
        let stated = [
            Supporter::on(1),
            Supporter::containing(0),
            Supporter::on(2),
            Supporter::on(9),
            Supporter::containing(1),
        ];
        let tree = SupportTree::without_contradictions(&stated);
        let table = Supporter::TABLE;
        assert_eq!(tree.supporters(), [stated[0], table, table, table, stated[4]]);
        assert_eq!(tree.order(), [1, 2, 3, 0, 4]);
    }

    /// A tray (0) with a cup (1) on it, two pens in the cup (2, 4), a cap (5) on the second pen; a box (3) beside them.
    fn tray() -> SupportTree {
        SupportTree::new(vec![
            Supporter::TABLE,
            Supporter::on(0),
            Supporter::containing(1),
            Supporter::TABLE,
            Supporter::containing(1),
            Supporter::on(4),
        ])
        .expect("a tree")
    }

    #[test]
    fn relatives_of_objects_are_found() {
        let tree = tray();
        let on = |index: usize| tree.ancestors_on(index).collect::<Vec<_>>();
        assert_eq!((on(5), on(4), on(1), on(0)), (vec![4], vec![], vec![0], vec![]));
        let mates = |index: usize| tree.container_mates(index).collect::<Vec<_>>();
        assert_eq!((mates(2), mates(4), mates(1), mates(0)), (vec![4], vec![2], vec![], vec![]));
        assert_eq!(tree.branch(1).collect::<Vec<_>>(), [1, 2, 4, 5]);
        assert_eq!(tree.children(None).collect::<Vec<_>>(), [0, 3]);
        assert_eq!(tree.children(Some(1)).collect::<Vec<_>>(), [2, 4]);
        assert_eq!(tree.supported_by(Supporter::containing(1)).collect::<Vec<_>>(), [2, 4]);
        assert!(tree.supported_by(Supporter::on(1)).next().is_none());
        assert!(tree.rests_on(5, 0) && tree.rests_on(5, 5) && !tree.rests_on(0, 5) && !tree.rests_on(3, 0));
    }

    #[test]
    fn object_moves_to_the_table_with_its_load() {
        let mut tree = tray();
        tree.move_to_table(1);
        assert_eq!(tree.supporter(1), Supporter::TABLE);
        assert_eq!(tree.order(), [0, 1, 3, 2, 4, 5]);
        assert_eq!(tree.branch(1).collect::<Vec<_>>(), [1, 2, 4, 5]);
    }
}
