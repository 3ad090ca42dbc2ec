//! Reference resolution: a phrase refers to a new mention, an earlier one ("the mug", "it", "each plate") or the table.
//! Color, material, size, place and order identify earlier mentions.

use super::{LinkKind, Mention, Parser, Place};
use crate::text_parser::account::Claimed;
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Attributes, Determiner, Head, NounPhrase, Selector};
use scene::description::RequestedPose;
use scene::text_account::UnrecognizedReason;

/// The referent of a noun phrase.
pub(super) enum Referent {
    Mentions(Vec<usize>),
    Table,
    Nothing,
}

impl Parser<'_, '_> {
    /// The referent of a phrase; adds a new mention if there is no earlier one.
    pub(super) fn refer(&mut self, phrase: NounPhrase, as_target: bool) -> Referent {
        self.parsed.account.used(phrase.tokens.clone());
        for (tokens, reason) in phrase.reports.clone() {
            self.report(tokens, reason);
        }
        let states = phrase.states.clone();
        let referent = self.referent(phrase, as_target);
        for (state, tokens) in states {
            match &referent {
                Referent::Mentions(mentions) => self.set_states(&mentions.clone(), &state, tokens),
                Referent::Table if state == "empty" => self.parsed.account.used(tokens),
                _ => self.report(tokens, UnrecognizedReason::NotSupported),
            }
        }
        referent
    }

    fn referent(&mut self, phrase: NounPhrase, as_target: bool) -> Referent {
        let meanings = match phrase.head {
            Head::It => {
                let it = if as_target {
                    let last: Vec<usize> = self.subject.last().copied().into_iter().collect();
                    self.earlier_than(&last).or(self.salient)
                } else {
                    self.salient
                };
                return match it {
                    Some(it) => Referent::Mentions(vec![it]),
                    None => self.no_referent(&phrase),
                };
            }
            Head::Them => {
                let list = if self.salient_list.is_empty() {
                    self.salient.into_iter().collect()
                } else {
                    self.salient_list.clone()
                };
                return if list.is_empty() { self.no_referent(&phrase) } else { Referent::Mentions(list) };
            }
            Head::All => return Referent::Mentions((0..self.parsed.mentions.len()).collect()),
            Head::One => return self.one(phrase),
            Head::Unknown(ref name) => match self.lexicon.stand_in(name).filter(|_| self.stand_ins) {
                Some(meaning) => vec![meaning],
                None => {
                    let name = name.clone();
                    self.unknown(name, &phrase);
                    return Referent::Nothing;
                }
            },
            Head::Objects(ref meanings) => meanings.clone(),
        };
        if let Meaning::Table(model) = &meanings[0] {
            self.table(model.clone(), phrase);
            return Referent::Table;
        }
        if let Some(earlier) = self.earlier(&meanings, &phrase, as_target) {
            let tokens = phrase.head_tokens.clone();
            let selected = phrase.determiner != Determiner::New || !self.parsed.mentions[earlier].forward;
            self.parsed.account.claim(tokens, Claimed::Object(earlier));
            for (property, range) in phrase.properties.clone() {
                self.claim_property(range, property, vec![earlier]);
            }
            let mention = &mut self.parsed.mentions[earlier];
            if !selected {
                mention.forward = false;
                mention.count = phrase.count;
                mention.plural = phrase.plural;
            }
            merge(&mut mention.attributes, phrase.attributes);
            return Referent::Mentions(vec![earlier]);
        }
        Referent::Mentions(vec![self.add_mention(meanings, phrase, as_target)])
    }

    /// Adds a mention with its claims.
    pub(super) fn add_mention(
        &mut self,
        meanings: Vec<Meaning>,
        phrase: NounPhrase,
        as_target: bool,
    ) -> usize {
        let index = self.parsed.mentions.len();
        self.parsed.account.claim(phrase.head_tokens.clone(), Claimed::Object(index));
        for (property, range) in phrase.properties.clone() {
            self.claim_property(range, property, vec![index]);
        }
        self.parsed.mentions.push(Mention {
            meanings,
            count: phrase.count,
            plural: phrase.plural,
            stacked: phrase.stacked,
            stack_size: phrase.stack_size.filter(|size| *size > 0),
            corners: false,
            attributes: phrase.attributes,
            words: phrase.words,
            each_of: None,
            per_person: false,
            contents: false,
            places: Vec::new(),
            pose: RequestedPose::Upright,
            state: None,
            yaw_rad: None,
            position_m: None,
            forward: as_target && phrase.determiner == Determiner::Definite,
            tokens: phrase.head_tokens,
        });
        if let Some(Selector::Side(side)) = phrase.selector {
            self.parsed.mentions[index].places.push(Place { kind: side, distance_m: None });
        }
        if let Some((group, tokens)) = phrase.group {
            self.grouped(index, group, phrase.columns.filter(|columns| *columns > 0), tokens);
        }
        index
    }

    fn no_referent(&mut self, phrase: &NounPhrase) -> Referent {
        let word = self.word_at(phrase.tokens.start);
        // "it is a nice desk": a pronoun without an antecedent has no meaning of its own.
        if !matches!(word, Some("it" | "this" | "that")) {
            self.report(phrase.tokens.clone(), UnrecognizedReason::NoReferent);
        }
        Referent::Nothing
    }

    fn unknown(&mut self, name: String, phrase: &NounPhrase) {
        if name.is_empty() {
            return;
        }
        self.report(phrase.head_tokens.clone(), UnrecognizedReason::UnknownObject);
        for (_, range) in phrase.properties.clone() {
            self.report(range, UnrecognizedReason::UnknownObject);
        }
        if !self.parsed.unknown.contains(&name) {
            self.parsed.unknown.push(name);
        }
    }

    fn table(&mut self, model: Option<String>, phrase: NounPhrase) {
        self.parsed.account.claim(phrase.head_tokens.clone(), Claimed::Table);
        let mut shapes = 0;
        for (property, range) in phrase.properties {
            shapes += usize::from(property == "shape");
            if property == "shape" && shapes > 1 {
                self.report(range, UnrecognizedReason::Contradiction);
            } else {
                self.parsed.account.claim(range, Claimed::Table);
            }
        }
        // Attributes of later phrases complete those of the first.
        match &mut self.parsed.table {
            None => self.parsed.table = Some((model, phrase.attributes)),
            Some((known, attributes)) => {
                if known.is_none() {
                    *known = model;
                }
                merge(attributes, phrase.attributes);
            }
        }
    }

    /// The earlier mention that a phrase refers to.
    fn earlier(&self, meanings: &[Meaning], phrase: &NounPhrase, as_target: bool) -> Option<usize> {
        let mentions = &self.parsed.mentions;
        let shares = |mention: &Mention| mention.meanings.iter().any(|meaning| meanings.contains(meaning));
        let compatible: Vec<usize> = (0..mentions.len())
            .filter(|&m| shares(&mentions[m]) && identifies(&phrase.attributes, &mentions[m].attributes))
            .collect();
        let same_count = |m: usize| {
            let known = mentions[m].count;
            phrase.count.is_none()
                || phrase.count == known
                || (known.is_none() && mentions[m].plural)
                || matches!((phrase.count, known), (Some([_, high]), Some([low, _])) if high < low)
        };
        match phrase.determiner {
            Determiner::Definite => {
                let candidates: Vec<usize> = compatible.into_iter().filter(|&m| same_count(m)).collect();
                self.selected(&candidates, phrase.selector).or_else(|| {
                    // "the bottle" after "a wine bottle".
                    let head = self.lexicon.vocabulary.singular_of(phrase.words.rsplit(' ').next()?);
                    let single = phrase.words.split(' ').count() == 1 && phrase.count.is_none();
                    let ends = |m: &usize| {
                        let words = self.lexicon.vocabulary.singular_of(&mentions[*m].words);
                        words.ends_with(&format!(" {head}"))
                    };
                    (0..mentions.len()).rev().find(|m| single && candidates.is_empty() && ends(m))
                })
            }
            Determiner::Each => compatible.last().copied(),
            Determiner::New => {
                let last = *compatible.last()?;
                (mentions[last].forward && !as_target).then_some(last)
            }
        }
    }

    /// The candidate that a selector selects; without one, the last.
    fn selected(&self, candidates: &[usize], selector: Option<Selector>) -> Option<usize> {
        match selector {
            None => candidates.last().copied(),
            Some(Selector::Ordinal(k)) => candidates.get(k).or(candidates.last()).copied(),
            Some(Selector::Other) => candidates
                .iter()
                .copied()
                .find(|m| Some(*m) != self.salient)
                .or(candidates.last().copied().filter(|m| self.is_several(*m))),
            Some(Selector::Side(side)) => candidates
                .iter()
                .copied()
                .rfind(|&m| self.parsed.mentions[m].places.iter().any(|place| place.kind == side)),
        }
    }

    /// The referent of "the blue one"; another object of the last category for "a blue one".
    fn one(&mut self, phrase: NounPhrase) -> Referent {
        let mentions = &self.parsed.mentions;
        if phrase.determiner == Determiner::Definite {
            let candidates: Vec<usize> = (0..mentions.len())
                .filter(|&m| identifies(&phrase.attributes, &mentions[m].attributes))
                .collect();
            let found = self
                .selected(&candidates, phrase.selector)
                .or_else(|| self.single_of(&candidates, phrase.selector));
            if let Some(found) = found {
                for (property, range) in phrase.properties {
                    self.claim_property(range, property, vec![found]);
                }
                return Referent::Mentions(vec![found]);
            }
            // "the green one" of a category of which the text has others.
            let described =
                phrase.properties.iter().any(|(property, _)| *property == "color" || *property == "size");
            if let Some(last) = self.salient.filter(|_| described) {
                let meanings = self.parsed.mentions[last].meanings.clone();
                let phrase = self.completed(phrase, last);
                return Referent::Mentions(vec![self.add_mention(meanings, phrase, false)]);
            }
        } else if let Some(last) = self.subject.last().copied().or(self.salient) {
            let meanings = mentions[last].meanings.clone();
            let phrase = self.completed(phrase, last);
            return Referent::Mentions(vec![self.add_mention(meanings, phrase, false)]);
        }
        self.report(phrase.tokens, UnrecognizedReason::NoReferent);
        Referent::Nothing
    }

    /// "the left one" of "two plates": one object of a plural mention, which becomes a mention at that side.
    fn single_of(&mut self, candidates: &[usize], selector: Option<Selector>) -> Option<usize> {
        let Some(Selector::Side(kind)) = selector else { return None };
        let free = |m: &usize| self.parsed.mentions[*m].places.is_empty();
        let &candidate = candidates.iter().rfind(|m| free(m))?;
        let single = match self.parsed.mentions[candidate].count {
            Some([low, high]) if low == high && low > 1 => {
                let part = self.duplicate(candidate);
                for (mention, count) in [(part, 1), (candidate, low - 1)] {
                    self.parsed.mentions[mention].count = Some([count; 2]);
                    self.parsed.mentions[mention].plural = count > 1;
                }
                part
            }
            _ => candidate,
        };
        self.parsed.mentions[single].places.push(Place { kind, distance_m: None });
        Some(single)
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
            .or_else(|| self.parallel_target(subjects))
            .or_else(|| self.salient.filter(|it| !subjects.contains(it)))
            .or_else(|| self.subject.iter().copied().rfind(|&m| m < first))
    }
}

impl Parser<'_, '_> {
    /// "The fork lies left of the plate, and the knife right of it": the target of the relation before.
    fn parallel_target(&self, subjects: &[usize]) -> Option<usize> {
        use scene::RelationKind::{Behind, InFrontOf, LeftOf, RightOf};
        let last = self.parsed.links.last()?;
        let sided = matches!(last.kind, LinkKind::Relation(LeftOf | RightOf | InFrontOf | Behind));
        (sided && self.subject.contains(&last.from) && !subjects.contains(&last.to)).then_some(last.to)
    }
}

/// Whether a description with these attributes can identify an object with the known ones.
fn identifies(description: &Attributes, known: &Attributes) -> bool {
    let same_size =
        |a: f64, b: f64| (a - 1.0).abs() < 1e-9 || ((a > 1.0) == (b > 1.0) && (b - 1.0).abs() > 1e-9);
    let same_stretch = description.stretches.iter().all(|(axis, factor)| {
        known.stretches.iter().any(|(other, known)| other == axis && (*known > 1.0) == (*factor > 1.0))
    });
    (description.color_words.is_empty() || description.color_words == known.color_words)
        && (description.substance.is_none() || description.substance == known.substance)
        && same_size(description.scale, known.scale)
        && same_stretch
        && (description.shape.is_none() || description.shape == known.shape)
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
    known.volume_m3 = more.volume_m3.or(known.volume_m3);
    known.mass_kg = more.mass_kg.or(known.mass_kg);
    for stretch in more.stretches {
        if !known.stretches.contains(&stretch) {
            known.stretches.push(stretch);
        }
    }
}
