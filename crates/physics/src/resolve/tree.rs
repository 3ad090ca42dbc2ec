//! The support tree: the supporter of each body, with the table at the root.

use super::{ResolveError, SupportedBy};
use crate::Body;

/// A checked support tree.
pub(super) struct Tree {
    pub table: usize,
    pub support: Vec<Option<SupportedBy>>,
    /// Supporters before what they carry; the table first.
    pub order: Vec<usize>,
}

impl Tree {
    pub fn new(bodies: &[Body], supports: &[Option<SupportedBy>]) -> Result<Self, ResolveError> {
        let bad = |problem: String| Err(ResolveError::BadSupport { problem });
        let roots: Vec<usize> = (0..supports.len()).filter(|&k| supports[k].is_none()).collect();
        let [table] = roots[..] else {
            return bad(format!("{} objects have no supporter", roots.len()));
        };
        if bodies.len() != supports.len() {
            return bad(format!("{} bodies but {} supports", bodies.len(), supports.len()));
        }
        let mut order = vec![table];
        for next in 0..bodies.len() {
            let Some(&carrier) = order.get(next) else { break };
            order.extend((0..supports.len()).filter(|&k| supports[k].is_some_and(|s| s.parent == carrier)));
        }
        if let Some(lost) = (0..bodies.len()).find(|k| !order.contains(k)) {
            return bad(format!("{} is not carried by the table", bodies[lost].name));
        }
        Ok(Self { table, support: supports.to_vec(), order })
    }

    /// Whether `body` is `ancestor` or is carried by it, directly or not.
    pub fn is_below(&self, body: usize, ancestor: usize) -> bool {
        self.path(body).contains(&ancestor)
    }

    /// The body, its supporter, and so on up to the table.
    pub fn path(&self, body: usize) -> Vec<usize> {
        let mut path = vec![body];
        let mut at = body;
        while let Some(support) = self.support[at] {
            at = support.parent;
            path.push(at);
        }
        path
    }

    /// The other bodies in the same container; empty for a body that stands on its supporter.
    pub fn heap(&self, body: usize) -> Vec<usize> {
        let own = self.support[body].filter(|support| support.inside);
        let shares = |other: &usize| *other != body && own.is_some() && self.support[*other] == own;
        (0..self.support.len()).filter(shares).collect()
    }

    /// The body's supporter, and the other bodies in the same container.
    pub fn carriers(&self, body: usize) -> Vec<usize> {
        self.support[body].map(|support| support.parent).into_iter().chain(self.heap(body)).collect()
    }

    /// The two bodies with one supporter whose branches hold `a` and `b`; `None` where one carries the
    /// other.
    pub fn branches(&self, a: usize, b: usize) -> Option<(usize, usize)> {
        let (a_path, b_path) = (self.path(a), self.path(b));
        let pair = a_path.iter().rev().zip(b_path.iter().rev()).find(|(x, y)| x != y)?;
        Some((*pair.0, *pair.1))
    }

    /// The body and everything it carries.
    pub fn branch(&self, body: usize) -> Vec<usize> {
        self.order.iter().copied().filter(|&other| self.is_below(other, body)).collect()
    }
}
