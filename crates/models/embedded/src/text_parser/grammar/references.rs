//! Reference resolution: a phrase refers to a new mention, an earlier one ("the mug", "it", "each plate") or the table.
//! Color, material, size, place and order identify earlier mentions.

use super::{LinkKind, Mention, Parser, Place};
use crate::text_parser::account::Claimed;
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Attributes, Determiner, Head, NounPhrase, Selector};
use crate::text_parser::property::Property;
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
        let (states, counts) = (phrase.states.clone(), phrase.counts.clone());
        let counted_from = phrase.counted_from.clone();
        let referent = self.referent(phrase, as_target);
        if let Referent::Mentions(mentions) = &referent {
            for tokens in counts {
                self.claim_property(tokens, Property::Count, mentions.clone());
            }
            if let Some((kind, tokens)) = counted_from {
                for &mention in mentions {
                    self.set_place(mention, Place { kind, distance_m: None }, tokens.clone());
                }
            }
        }
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
        if let Head::Unknown(name) = &phrase.head
            && let Some(earlier) = self.abbreviated(name, &phrase)
        {
            self.parsed.account.claim(phrase.head_tokens, Claimed::Object(earlier));
            return Referent::Mentions(vec![earlier]);
        }
        let meanings = match phrase.head {
            Head::It => {
                // "unload the rack: a plate is in it".
                let emptied = self.emptied.last().map(|(host, _)| *host).filter(|_| as_target);
                if let Some(it) = self.former_or_latter(&phrase).or(emptied) {
                    return Referent::Mentions(vec![it]);
                }
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
            Head::Unknown(ref name) if self.lexicon.short_name(name).is_some() => {
                self.lexicon.short_name(name).into_iter().collect()
            }
            Head::Unknown(ref name) => match self.lexicon.stand_in(name).filter(|_| self.stand_ins) {
                Some(meaning) => vec![meaning],
                None => {
                    let name = name.clone();
                    self.unknown(name, &phrase);
                    return Referent::Nothing;
                }
            },
            Head::Objects(ref meanings) => match phrase.stand_in.clone().filter(|_| !self.stand_ins) {
                Some(name) => {
                    self.unknown(name, &phrase);
                    return Referent::Nothing;
                }
                None => meanings.clone(),
            },
        };
        if let Meaning::Table(model) = &meanings[0] {
            self.table(model.clone(), phrase);
            return Referent::Table;
        }
        if let Some(earlier) = self.earlier(&meanings, &phrase, as_target) {
            let tokens = phrase.head_tokens.clone();
            let is_open = self.parsed.mentions[earlier].forward || self.expected.contains(&earlier);
            let selected = phrase.determiner != Determiner::New || !is_open;
            if !selected {
                self.introduce(earlier, &phrase);
            }
            self.parsed.account.claim(tokens, Claimed::Object(earlier));
            for (property, range) in phrase.properties.clone() {
                self.claim_property(range, property, vec![earlier]);
            }
            let mention = &mut self.parsed.mentions[earlier];
            merge(&mut mention.attributes, phrase.attributes);
            return Referent::Mentions(vec![earlier]);
        }
        if let Some(part) = self.part_of_several(&meanings, &phrase) {
            self.parsed.account.claim(phrase.head_tokens, Claimed::Object(part));
            for (property, range) in phrase.properties {
                self.claim_property(range, property, vec![part]);
            }
            return Referent::Mentions(vec![part]);
        }
        if phrase.same && matches!(meanings[0], Meaning::Vague(_)) {
            let phrase = NounPhrase { plural: true, ..phrase };
            let meanings = self.same_kind(meanings);
            return Referent::Mentions(vec![self.add_mention(meanings, phrase, as_target)]);
        }
        Referent::Mentions(vec![self.add_mention(meanings, phrase, as_target)])
    }

    /// "the same fruit": the kind that the text has named before.
    fn same_kind(&self, meanings: Vec<Meaning>) -> Vec<Meaning> {
        let Some(Meaning::Vague(index)) = meanings.first() else { return meanings };
        let members = &self.lexicon.themes.vague[*index].members;
        let named = self.parsed.mentions.iter().rev().flat_map(|mention| mention.meanings.first());
        let known = named.into_iter().find(|meaning| match meaning {
            Meaning::Category(category) => members.contains(&self.lexicon.categories[*category].name),
            _ => false,
        });
        known.map_or(meanings.clone(), |known| vec![known.clone()])
    }

    /// "the deck" after "a deck of cards".
    fn abbreviated(&self, name: &str, phrase: &NounPhrase) -> Option<usize> {
        let is_definite = phrase.determiner == Determiner::Definite && phrase.properties.is_empty();
        (0..self.parsed.mentions.len()).rev().find(|&m| {
            let words = &self.parsed.mentions[m].words;
            is_definite && words.starts_with(name) && words[name.len()..].starts_with(" of ")
        })
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
            stand_in: phrase.stand_in,
            each_of: None,
            per_person: false,
            contents: false,
            places: Vec::new(),
            pose: RequestedPose::Upright,
            state: None,
            yaw_rad: None,
            position_m: None,
            forward: phrase.determiner == Determiner::Each && phrase.count.is_none()
                || as_target && phrase.determiner == Determiner::Definite,
            tokens: phrase.head_tokens,
        });
        if let Some(selector @ Selector::Ordinal(_)) = phrase.selector {
            self.selected_parts.push((selector, index));
        }
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

    pub(super) fn table(&mut self, model: Option<String>, phrase: NounPhrase) {
        self.parsed.account.claim(phrase.head_tokens.clone(), Claimed::Table);
        let mut shape = self.table_shape().or_else(|| self.shape_of_model(model.as_deref()));
        let mut attributes = phrase.attributes;
        for (property, range) in phrase.properties {
            if property != Property::Shape {
                self.parsed.account.claim(range, Claimed::Table);
                continue;
            }
            let own = self.word_at(range.start).map(str::to_owned);
            if self.is_other_shape(shape.as_deref(), own.as_deref()) {
                self.report(range, UnrecognizedReason::Contradiction);
                attributes.shape = shape.clone();
            } else {
                self.parsed.account.claim(range, Claimed::Table);
                shape = shape.or(own);
            }
        }
        // Attributes of later phrases complete those of the first.
        match &mut self.parsed.table {
            None => self.parsed.table = Some((model, attributes)),
            Some((known, earlier)) => {
                if known.is_none() {
                    *known = model;
                }
                merge(earlier, attributes);
            }
        }
    }

    /// The shape of the table that the text has stated, as a key of `[shapes]`.
    pub(super) fn table_shape(&self) -> Option<String> {
        let (model, attributes) = self.parsed.table.as_ref()?;
        attributes.shape.clone().or_else(|| self.shape_of_model(model.as_deref()))
    }

    /// The shape in the name of a table model ("round_table").
    fn shape_of_model(&self, model: Option<&str>) -> Option<String> {
        let word = model?.split('_').next()?;
        self.lexicon.vocabulary.shapes.contains_key(word).then(|| word.to_owned())
    }

    /// Whether two words of `[shapes]` name different shapes.
    pub(super) fn is_other_shape(&self, known: Option<&str>, more: Option<&str>) -> bool {
        let shape = |word: &str| self.lexicon.vocabulary.shapes.get(word);
        matches!((known.and_then(shape), more.and_then(shape)), (Some(known), Some(more)) if known != more)
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
                if let Some(expected) = self.introduced(&compatible, phrase) {
                    return Some(expected);
                }
                let last = *compatible.last()?;
                // "pen left of laptop" in notes without articles.
                let bare = as_target && phrase.count.is_none() && !phrase.plural && !self.is_several(last);
                (mentions[last].forward && !as_target || bare).then_some(last)
            }
        }
    }

    /// The candidate that a selector selects; without one, the last.
    fn selected(&self, candidates: &[usize], selector: Option<Selector>) -> Option<usize> {
        match selector {
            None => candidates.last().copied(),
            Some(Selector::Ordinal(k)) => candidates.get(k).copied().filter(|_| {
                candidates.iter().all(|m| !self.is_several(*m)) && self.selected_parts.is_empty()
            }),
            Some(Selector::Other) => candidates
                .iter()
                .copied()
                .find(|m| Some(*m) != self.salient)
                .or(candidates.last().copied().filter(|m| self.is_several(*m))),
            Some(Selector::Top | Selector::Bottom) => candidates
                .iter()
                .copied()
                .rfind(|&m| self.parsed.mentions[m].stacked)
                .or(candidates.last().copied()),
            Some(Selector::Former | Selector::Latter) => None,
            Some(Selector::Side(side)) => candidates
                .iter()
                .copied()
                .rfind(|&m| self.parsed.mentions[m].places.iter().any(|place| place.kind == side)),
        }
    }

    /// The referent of "the blue one"; another object of the last category for "a blue one".
    fn one(&mut self, phrase: NounPhrase) -> Referent {
        if phrase.determiner == Determiner::Definite {
            let found = match phrase.selector {
                Some(_) => self.selected_one(&phrase),
                None => self.described_one(&phrase),
            };
            if let Some(found) = found {
                if self.parsed.mentions[found].attributes.color_words.is_empty() {
                    merge(&mut self.parsed.mentions[found].attributes, phrase.attributes);
                }
                for (property, range) in phrase.properties {
                    self.claim_property(range, property, vec![found]);
                }
                return Referent::Mentions(vec![found]);
            }
            // "the green one" of a category of which the text has others.
            let described = phrase
                .properties
                .iter()
                .any(|(property, _)| *property == Property::Color || *property == Property::Size)
                || matches!(phrase.selector, Some(Selector::Ordinal(_)));
            if let Some(last) = self.salient.filter(|_| described) {
                let meanings = self.parsed.mentions[last].meanings.clone();
                let phrase = self.completed(phrase, last);
                return Referent::Mentions(vec![self.add_mention(meanings, phrase, false)]);
            }
        } else if let Some(last) = self.subject.last().copied().or(self.salient) {
            let meanings = self.parsed.mentions[last].meanings.clone();
            let phrase = self.completed(phrase, last);
            return Referent::Mentions(vec![self.add_mention(meanings, phrase, false)]);
        }
        if let Some(block) = self.colored_block(&phrase) {
            return Referent::Mentions(vec![block]);
        }
        self.report(phrase.tokens, UnrecognizedReason::NoReferent);
        Referent::Nothing
    }

    /// "the blue one": the last object of this description, or one of several without a description.
    fn described_one(&mut self, phrase: &NounPhrase) -> Option<usize> {
        let mentions = &self.parsed.mentions;
        let identified =
            (0..mentions.len()).rev().find(|&m| identifies(&phrase.attributes, &mentions[m].attributes));
        let several = (0..mentions.len()).rev().find(|&m| self.is_several(m));
        match (identified, several) {
            (Some(found), _) => Some(found),
            (None, Some(several)) => {
                let meanings = mentions[several].meanings.clone();
                self.part_of_several(&meanings, phrase)
            }
            _ => None,
        }
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
            .or_else(|| self.last_salient.filter(|it| !subjects.contains(it)))
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
    if !more.variants.is_empty() {
        known.variants = more.variants;
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
