//! Pronouns: "it", "them", "each", "one of them", "the latter", "everything".

use super::{Chunk, Determiner, Head, Selector, noun_ahead, starts_noun};
use crate::text_parser::quantity::quantity;

impl Chunk<'_, '_> {
    /// A pronoun; the position after it.
    pub(super) fn pronoun(&mut self) -> Option<usize> {
        let p = self.at;
        let noun = starts_noun(self.lexicon, self.tokens, p + 1);
        // "one of them".
        if let Some((range, length)) = quantity(self.lexicon, self.tokens, p)
            && self.word(length - 1) == Some("of")
            && matches!(self.word(length), Some("them" | "these" | "those" | "which"))
            && self.word(0) != Some("both")
        {
            self.phrase.count = Some(range);
            self.counted(p..p + length + 1);
            self.phrase.head = Head::One;
            return Some(p + length + 1);
        }
        let determiner_follows = self.word(1).is_some_and(|next| {
            matches!(
                next,
                "the" | "a" | "an" | "my" | "on" | "in" | "inside" | "under" | "at" | "to" | "of" | "with"
            )
        });
        match self.word(0)? {
            "it" | "this" | "that" | "itself" if !noun => Some(p + 1),
            "each" | "every"
                if !noun
                    && !matches!(self.word(1), Some("one" | "person" | "guest" | "place" | "corner"))
                    && (self.word(1) != Some("of") || matches!(self.word(2), Some("them" | "these"))) =>
            {
                self.phrase.determiner = Determiner::Each;
                let of = self.word(1) == Some("of") && matches!(self.word(2), Some("them" | "these"));
                Some(if of { p + 3 } else { p + 1 })
            }
            "each" | "every" if self.word(1) == Some("one") => {
                self.phrase.determiner = Determiner::Each;
                Some(p + 2)
            }
            "both" if determiner_follows && self.word(1) != Some("of") => None,
            "them" if matches!(self.word(1), Some("both" | "all" | "each")) => {
                self.phrase.head = Head::Them;
                Some(p + 2)
            }
            "them" | "these" | "those" | "both" | "they" if !noun => {
                self.phrase.head = Head::Them;
                let of = self.word(1) == Some("of") && matches!(self.word(2), Some("them" | "these"));
                Some(if of { p + 3 } else { p + 1 })
            }
            "all" if self.word(1) == Some("of") && matches!(self.word(2), Some("them" | "these")) => {
                self.phrase.head = Head::Them;
                Some(p + 3)
            }
            "latter" | "former" if p > 0 => {
                self.phrase.selector = pronoun_selector(self.word(0)?);
                Some(p + 1)
            }
            "the"
                if matches!(self.word(1), Some("latter" | "former" | "same")) && self.phrase_ends(p + 2) =>
            {
                self.phrase.selector = pronoun_selector(self.word(1)?);
                Some(p + 2)
            }
            "everything" => {
                self.phrase.head = Head::All;
                let on_table = self.word(1) == Some("on")
                    && self.word(2) == Some("the")
                    && matches!(self.word(3), Some("table" | "desk"));
                Some(if on_table { p + 4 } else { p + 1 })
            }
            _ => None,
        }
    }

    /// Whether no noun follows.
    fn phrase_ends(&self, at: usize) -> bool {
        !noun_ahead(self.lexicon, self.tokens, at)
    }
}

fn pronoun_selector(word: &str) -> Option<Selector> {
    match word {
        "latter" => Some(Selector::Latter),
        "former" => Some(Selector::Former),
        _ => None,
    }
}
