//! Colors and materials: "dark blue", "white marble", "wooden".

use crate::chart::{Chart, Span};
use crate::vocabulary::vocabulary;

/// A color, a material, or both, as written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Appearance {
    pub color: Option<String>,
    pub material: Option<String>,
}

impl Chart<'_> {
    pub(crate) fn appearances_at(&self, at: usize) -> Vec<Span<Appearance>> {
        let mut found = Vec::new();
        for (length, color) in self.colors_at(at) {
            let end = at + length;
            found.push(Span {
                end,
                cost: 0.0,
                value: Appearance { color: Some(color.clone()), material: None },
            });
            let and = usize::from(self.word(end) == "and");
            for (more, material) in self.materials_at(end + and) {
                let value = Appearance { color: Some(color.clone()), material: Some(material) };
                found.push(Span { end: end + and + more, cost: 0.0, value });
            }
        }
        for (length, material) in self.materials_at(at) {
            found.push(Span {
                end: at + length,
                cost: 0.0,
                value: Appearance { color: None, material: Some(material) },
            });
        }
        found
    }

    /// Colors of one word or two.
    fn colors_at(&self, at: usize) -> Vec<(usize, String)> {
        self.words_of(at, |words| vocabulary().is_color(words))
    }

    fn materials_at(&self, at: usize) -> Vec<(usize, String)> {
        self.words_of(at, |words| vocabulary().is_material(words))
    }

    fn words_of(&self, at: usize, is: impl Fn(&str) -> bool) -> Vec<(usize, String)> {
        let lengths = (1..=2).filter(|length| at + length <= self.tokens.len());
        lengths.map(|length| (length, self.words(at..at + length))).filter(|(_, words)| is(words)).collect()
    }
}
