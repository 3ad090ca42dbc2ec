//! The tree of paths in a crate file.

use std::collections::BTreeMap;

use super::compressed_integers;
use super::section::{put_packed, put_u64};

/// Paths, indexed in order of creation; index 0 is the root.
pub struct PathTree {
    /// The children of each path, in order of creation.
    below: Vec<Vec<(Element, u32)>>,
    known: BTreeMap<(u32, Element), u32>,
    empty: Option<u32>,
}

/// The last element of a path, as a token index.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Element {
    Prim(u32),
    Property(u32),
}

impl Default for PathTree {
    fn default() -> Self {
        Self { below: vec![Vec::new()], known: BTreeMap::new(), empty: None }
    }
}

impl PathTree {
    pub const ROOT: u32 = 0;

    /// The path of a prim below another prim or the root.
    pub fn prim(&mut self, parent: u32, token: u32) -> u32 {
        self.beneath(parent, Element::Prim(token))
    }

    /// The path of a property.
    pub fn property(&mut self, prim: u32, token: u32) -> u32 {
        assert!(token > 0, "the number of a property's token is stored as its negative");
        self.beneath(prim, Element::Property(token))
    }

    fn beneath(&mut self, parent: u32, element: Element) -> u32 {
        if let Some(known) = self.known.get(&(parent, element)) {
            return *known;
        }
        let number = self.numbered();
        self.known.insert((parent, element), number);
        self.below[parent as usize].push((element, number));
        number
    }

    /// The empty path. It has an index but is not in the tree.
    pub fn empty(&mut self) -> u32 {
        if let Some(number) = self.empty {
            return number;
        }
        let number = self.numbered();
        self.empty = Some(number);
        number
    }

    fn numbered(&mut self) -> u32 {
        self.below.push(Vec::new());
        self.below.len() as u32 - 1
    }

    /// The section: path count, then the tree in depth-first order as three lists. These are path indices; tokens of
    /// last elements, negative for properties; and jumps, which encode child and sibling links.
    pub fn section(&self) -> Vec<u8> {
        let mut rows = Rows::default();
        self.add_rows(&mut rows, Self::ROOT, 0, true);
        let mut bytes = Vec::new();
        put_u64(&mut bytes, self.below.len() as u64);
        put_u64(&mut bytes, rows.numbers.len() as u64);
        for row in [rows.numbers, rows.tokens, rows.jumps] {
            put_packed(&mut bytes, &compressed_integers(&row));
        }
        bytes
    }

    fn add_rows(&self, rows: &mut Rows, number: u32, token: i32, is_last: bool) {
        let row = rows.numbers.len();
        rows.numbers.push(number as i32);
        rows.tokens.push(token);
        rows.jumps.push(0);
        let below = &self.below[number as usize];
        for (k, (element, number)) in below.iter().enumerate() {
            let token = match element {
                Element::Prim(token) => *token as i32,
                Element::Property(token) => -(*token as i32),
            };
            self.add_rows(rows, *number, token, k + 1 == below.len());
        }
        rows.jumps[row] = match (below.is_empty(), is_last) {
            (true, true) => -2,
            (false, true) => -1,
            (true, false) => 0,
            // Distance from here to the next sibling.
            (false, false) => (rows.numbers.len() - row) as i32,
        };
    }
}

#[derive(Default)]
struct Rows {
    numbers: Vec<i32>,
    tokens: Vec<i32>,
    jumps: Vec<i32>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jumps_skip_subtrees() {
        let mut tree = PathTree::default();
        let root = tree.prim(PathTree::ROOT, 1);
        let first = tree.prim(root, 2);
        tree.property(first, 3);
        let second = tree.prim(root, 4);
        assert_eq!((tree.prim(root, 4), tree.empty(), tree.empty()), (second, 5, 5));
        let mut rows = Rows::default();
        tree.add_rows(&mut rows, PathTree::ROOT, 0, true);
        assert_eq!(rows.numbers, [0, 1, 2, 3, 4]);
        assert_eq!(rows.tokens, [0, 1, 2, -3, 4]);
        assert_eq!(rows.jumps, [-1, -1, 2, -2, -2]);
    }
}
