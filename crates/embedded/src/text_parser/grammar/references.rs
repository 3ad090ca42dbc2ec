//! Reference resolution: a phrase refers to a new mention, an earlier one ("the mug", "it", "each plate") or the table.

use super::{Mention, Parser};
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Attributes, Determiner, Head, NounPhrase};

/// The referent of a noun phrase.
pub(super) enum Referent {
    Mentions(Vec<usize>),
    Table,
    Nothing,
}

impl Parser<'_, '_> {
    /// The referent of a phrase; adds a new mention if there is no earlier one.
    pub(super) fn refer(&mut self, phrase: NounPhrase, as_target: bool) -> Referent {
        let meanings = match phrase.head {
            Head::It => {
                let it = if as_target {
                    let last: Vec<usize> = self.subject.last().copied().into_iter().collect();
                    self.earlier_than(&last).or(self.salient)
                } else {
                    self.salient
                };
                return it.map_or(Referent::Nothing, |it| Referent::Mentions(vec![it]));
            }
            Head::Them => {
                let list = if self.salient_list.is_empty() {
                    self.salient.into_iter().collect()
                } else {
                    self.salient_list.clone()
                };
                return if list.is_empty() { Referent::Nothing } else { Referent::Mentions(list) };
            }
            Head::Unknown(name) => {
                let name = if name.is_empty() { return Referent::Nothing } else { name };
                if !self.parsed.unknown.contains(&name) {
                    self.parsed.unknown.push(name);
                }
                return Referent::Nothing;
            }
            Head::Objects(ref meanings) => meanings.clone(),
        };
        if let Meaning::Table(model) = &meanings[0] {
            // Attributes of later phrases complete those of the first.
            match &mut self.parsed.table {
                None => self.parsed.table = Some((model.clone(), phrase.attributes)),
                Some((known, attributes)) => {
                    if known.is_none() {
                        known.clone_from(model);
                    }
                    merge(attributes, phrase.attributes);
                }
            }
            return Referent::Table;
        }
        let earlier = self.parsed.mentions.iter().rposition(|mention| {
            mention.meanings.iter().any(|meaning| meanings.contains(meaning))
                && (phrase.attributes.color_words.is_empty()
                    || mention.attributes.color_words == phrase.attributes.color_words)
        });
        if let Some(earlier) = earlier {
            let known = &self.parsed.mentions[earlier];
            let definite = phrase.determiner == Determiner::Definite && phrase.count.is_none();
            let each = phrase.determiner == Determiner::Each;
            if definite || each {
                let attributes = phrase.attributes;
                merge(&mut self.parsed.mentions[earlier].attributes, attributes);
                return Referent::Mentions(vec![earlier]);
            }
            if known.forward && !as_target {
                let mention = &mut self.parsed.mentions[earlier];
                mention.forward = false;
                mention.count = phrase.count;
                mention.plural = phrase.plural;
                merge(&mut mention.attributes, phrase.attributes);
                return Referent::Mentions(vec![earlier]);
            }
        }
        self.parsed.mentions.push(Mention {
            meanings,
            count: phrase.count,
            plural: phrase.plural,
            stacked: phrase.stacked,
            attributes: phrase.attributes,
            words: phrase.words,
            each_of: None,
            contents: false,
            places: Vec::new(),
            forward: as_target && phrase.determiner == Determiner::Definite,
        });
        Referent::Mentions(vec![self.parsed.mentions.len() - 1])
    }

    /// The referent of "it" for these subjects: the mention they are linked to, or the one before them.
    pub(super) fn earlier_than(&self, subjects: &[usize]) -> Option<usize> {
        let first = *subjects.first()?;
        self.parsed
            .links
            .iter()
            .rev()
            .find(|link| subjects.contains(&link.from))
            .map(|link| link.to)
            .or_else(|| self.salient.filter(|it| !subjects.contains(it)))
            .or_else(|| self.subject.iter().copied().rfind(|&m| m < first))
    }
}

/// Merges later attributes into earlier ones.
pub(super) fn merge(known: &mut Attributes, more: Attributes) {
    if !more.colors.is_empty() {
        known.colors = more.colors;
        known.color_words = more.color_words;
    }
    if more.substance.is_some() {
        known.substance = more.substance;
        known.material_color = more.material_color;
        known.table_finish = more.table_finish;
    }
    if more.shape.is_some() {
        known.shape = more.shape;
    }
    if (more.scale - 1.0).abs() > 1e-9 {
        known.scale = more.scale;
    }
    known.measures.extend(more.measures);
    known.stretches.extend(more.stretches);
}
