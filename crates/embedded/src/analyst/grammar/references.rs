//! What a phrase speaks about: something new, something said before ("the mug", "it", "each plate"), the table.

use super::{Mention, Reader};
use crate::analyst::lexicon::Meaning;
use crate::analyst::phrase::{Determiner, Head, Looks, NounPhrase};

/// What a noun phrase turned out to be.
pub(super) enum Reference {
    Mentions(Vec<usize>),
    Table,
    Nothing,
}

impl Reader<'_, '_> {
    /// The mentions a phrase speaks about, making new ones as needed.
    pub(super) fn refer(&mut self, phrase: NounPhrase, as_target: bool) -> Reference {
        let meanings = match phrase.head {
            Head::It => {
                let it = if as_target {
                    let last: Vec<usize> = self.subject.last().copied().into_iter().collect();
                    self.earlier_than(&last).or(self.salient)
                } else {
                    self.salient
                };
                return it.map_or(Reference::Nothing, |it| Reference::Mentions(vec![it]));
            }
            Head::Them => {
                let list = if self.salient_list.is_empty() {
                    self.salient.into_iter().collect()
                } else {
                    self.salient_list.clone()
                };
                return if list.is_empty() { Reference::Nothing } else { Reference::Mentions(list) };
            }
            Head::Unknown(name) => {
                let name = if name.is_empty() { return Reference::Nothing } else { name };
                if !self.reading.unknown.contains(&name) {
                    self.reading.unknown.push(name);
                }
                return Reference::Nothing;
            }
            Head::Things(ref meanings) => meanings.clone(),
        };
        if let Meaning::Table(model) = &meanings[0] {
            // The first table named, or one that says more than the first did.
            match &mut self.reading.table {
                None => self.reading.table = Some((model.clone(), phrase.looks)),
                Some((known, looks)) => {
                    if known.is_none() {
                        known.clone_from(model);
                    }
                    merge(looks, phrase.looks);
                }
            }
            return Reference::Table;
        }
        let earlier = self.reading.mentions.iter().rposition(|mention| {
            mention.meanings.iter().any(|meaning| meanings.contains(meaning))
                && (phrase.looks.color_words.is_empty()
                    || mention.looks.color_words == phrase.looks.color_words)
        });
        if let Some(earlier) = earlier {
            let known = &self.reading.mentions[earlier];
            let definite = phrase.determiner == Determiner::Definite && phrase.count.is_none();
            let each = phrase.determiner == Determiner::Each;
            if definite || each {
                let looks = phrase.looks;
                merge(&mut self.reading.mentions[earlier].looks, looks);
                return Reference::Mentions(vec![earlier]);
            }
            if known.forward && !as_target {
                let mention = &mut self.reading.mentions[earlier];
                mention.forward = false;
                mention.count = phrase.count;
                mention.plural = phrase.plural;
                merge(&mut mention.looks, phrase.looks);
                return Reference::Mentions(vec![earlier]);
            }
        }
        self.reading.mentions.push(Mention {
            meanings,
            count: phrase.count,
            plural: phrase.plural,
            stacked: phrase.stacked,
            looks: phrase.looks,
            words: phrase.words,
            each_of: None,
            contents: false,
            places: Vec::new(),
            forward: as_target && phrase.determiner == Determiner::Definite,
        });
        Reference::Mentions(vec![self.reading.mentions.len() - 1])
    }

    /// What "it" means to these subjects: the thing they are already tied to, or the one before them.
    pub(super) fn earlier_than(&self, subjects: &[usize]) -> Option<usize> {
        let first = *subjects.first()?;
        self.reading
            .links
            .iter()
            .rev()
            .find(|link| subjects.contains(&link.from))
            .map(|link| link.to)
            .or_else(|| self.salient.filter(|it| !subjects.contains(it)))
            .or_else(|| self.subject.iter().copied().rfind(|&m| m < first))
    }
}

/// Looks said later complete those said before.
pub(super) fn merge(known: &mut Looks, more: Looks) {
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
