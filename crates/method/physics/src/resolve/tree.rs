//! The support tree in the indices of the bodies: body 0 is the table, body k + 1 is object k.

use scene::SupportTree;

/// Index of the table among the bodies.
pub(super) const TABLE: usize = 0;

/// The supports of the bodies of a problem.
#[derive(Clone, Copy)]
pub(super) struct BodyTree<'a> {
    supports: &'a SupportTree,
}

impl<'a> BodyTree<'a> {
    pub fn new(supports: &'a SupportTree) -> Self {
        Self { supports }
    }

    /// All bodies but the table, supporters before what they carry.
    pub fn order(self) -> impl Iterator<Item = usize> + 'a {
        self.supports.order().iter().map(|object| object + 1)
    }

    /// The supporter of a body other than the table.
    pub fn parent(self, body: usize) -> usize {
        self.supports.supporter(body - 1).parent.map_or(TABLE, |parent| parent + 1)
    }

    /// Whether a body other than the table is inside its supporter rather than on top.
    pub fn is_contained(self, body: usize) -> bool {
        self.supports.supporter(body - 1).is_container()
    }

    /// Whether `body` is `ancestor` or rests on it, directly or through others.
    pub fn is_below(self, body: usize, ancestor: usize) -> bool {
        ancestor == TABLE || (body != TABLE && self.supports.rests_on(body - 1, ancestor - 1))
    }

    /// The other bodies in the container of a body other than the table.
    pub fn container_mates(self, body: usize) -> impl Iterator<Item = usize> + 'a {
        self.supports.container_mates(body - 1).map(|object| object + 1)
    }

    /// The body, which is not the table, and everything it carries.
    pub fn branch(self, body: usize) -> impl Iterator<Item = usize> + 'a {
        self.supports.branch(body - 1).map(|object| object + 1)
    }

    /// The two bodies with one supporter whose branches hold `a` and `b`, which are not the table; `None` where one
    /// carries the other.
    pub fn branches(self, a: usize, b: usize) -> Option<(usize, usize)> {
        let (a_path, b_path) = (self.path_from_table(a), self.path_from_table(b));
        a_path.into_iter().zip(b_path).find(|(x, y)| x != y)
    }

    /// From the body on the table to the body itself.
    fn path_from_table(self, body: usize) -> Vec<usize> {
        let mut path = vec![body];
        path.extend(self.supports.ancestors(body - 1).map(|object| object + 1));
        path.reverse();
        path
    }
}
