//! Parts of a plural: "two mugs, one red and one blue", "the left one" of two plates, "the smaller jar" of three jars.

use super::places::exclude_each_other;
use super::{Link, LinkKind, Mention, Parser, Place};
use crate::text_parser::account::Claimed;
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::measures::{read_length, trailing};
use crate::text_parser::phrase::{Determiner, Group, Head, NounPhrase, Selector};
use crate::text_parser::prepositions::{place_at, preposition_at};
use crate::text_parser::property::Property;
use crate::text_parser::quantity::quantity;
use crate::text_parser::tokens::Token;
use scene::RelationKind;

/// A plural mention of which the text tells parts apart.
#[derive(Clone, Debug)]
pub(super) struct Split {
    /// The mention before the first part was separated.
    whole: Mention,
    /// The index of the mention, which becomes the first part.
    origin: usize,
    /// Number of links when the first part was separated; the later ones belong to parts.
    links: usize,
    /// Number of claims when the first part was separated; they are about every part.
    claims: usize,
    /// Number of objects that belong to no part yet.
    left: u32,
}

impl Parser<'_, '_> {
    /// "two mugs, one red and one blue": each phrase takes its share of the plural mention before it.
    pub(super) fn split_off(&mut self, phrase: &NounPhrase) -> bool {
        let count = phrase.count.map_or(1, |count| count[0]);
        let split = match self.split.clone() {
            Some(split) => split,
            None => {
                let Some(origin) = self.whole_of(phrase) else { return false };
                let whole = self.parsed.mentions[origin].clone();
                let Some(left) = fixed_count(&whole) else { return false };
                let (links, claims) = (self.parsed.links.len(), self.parsed.account.claims.len());
                Split { whole, origin, links, claims, left }
            }
        };
        // "two large boxes and a small one": another object.
        let (whole, own) = (&split.whole.attributes, &phrase.attributes);
        let differs = (whole.scale - 1.0) * (own.scale - 1.0) < 0.0
            || whole.color_words.len() == 1
                && !own.color_words.is_empty()
                && whole.color_words != own.color_words;
        if count == 0 || count > split.left || differs {
            return false;
        }
        self.parsed.account.used(phrase.tokens.clone());
        let part = if self.split.is_none() { split.origin } else { self.copy_of_whole(&split) };
        self.set_count(part, count);
        super::references::merge(&mut self.parsed.mentions[part].attributes, phrase.attributes.clone());
        for (property, range) in phrase.properties.clone() {
            self.claim_property(range, property, vec![part]);
        }
        for range in phrase.counts.clone() {
            self.claim_property(range, Property::Count, vec![part]);
        }
        for (state, tokens) in phrase.states.clone() {
            self.set_states(&[part], &state, tokens);
        }
        if self.split.is_none() {
            self.parts.clear();
        }
        self.parts.push(part);
        let left = split.left - count;
        self.split = (left > 0).then_some(Split { left, ..split });
        if !self.subject.contains(&part) {
            self.subject.push(part);
        }
        self.all_members = false;
        self.salient = Some(part);
        self.salient_list = self.subject.clone();
        self.predicate_at = Some(self.at);
        true
    }

    /// The plural of which a phrase names a part: the last subject; for "two of them" the only objects of the last
    /// sentence that are more.
    fn whole_of(&self, phrase: &NounPhrase) -> Option<usize> {
        if !self.is_part_of_them(phrase) {
            return self.subject.last().copied().or(self.salient);
        }
        let count = phrase.count?[0];
        let list = if self.subject.is_empty() { &self.salient_list } else { &self.subject };
        let mut wholes = list
            .iter()
            .copied()
            .filter(|&m| fixed_count(&self.parsed.mentions[m]).is_some_and(|whole| whole >= count));
        wholes.next().filter(|_| wholes.next().is_none())
    }

    /// Whether a phrase is "two of them".
    pub(super) fn is_part_of_them(&self, phrase: &NounPhrase) -> bool {
        let end = phrase.tokens.end;
        phrase.head == Head::One
            && phrase.tokens.len() > 2
            && self.word_at(end - 2) == Some("of")
            && matches!(self.word_at(end - 1), Some("them" | "these" | "those"))
    }

    /// Adds a mention that is a part of another one; the first `claims` claims are about both.
    pub(super) fn add_part(&mut self, of: usize, part: Mention, claims: usize) -> usize {
        let copy = self.parsed.mentions.len();
        self.parsed.mentions.push(part);
        let claims = claims.min(self.parsed.account.claims.len());
        let mut names = Vec::new();
        for claim in &mut self.parsed.account.claims[..claims] {
            match &mut claim.meaning {
                Claimed::Object(mention) if *mention == of => names.push(claim.tokens.clone()),
                Claimed::Property { mentions, .. } if mentions.contains(&of) => mentions.push(copy),
                _ => {}
            }
        }
        for tokens in names {
            self.parsed.account.claim(tokens, Claimed::Object(copy));
        }
        copy
    }

    /// Another mention like the whole, with the links that the whole had.
    fn copy_of_whole(&mut self, split: &Split) -> usize {
        let copy = self.add_part(split.origin, split.whole.clone(), split.claims);
        self.join_arrangements(split.origin, copy);
        let links: Vec<Link> = self.parsed.links[..split.links.min(self.parsed.links.len())].to_vec();
        self.copy_links(&links, split.origin, copy);
        copy
    }

    /// Sets the number of objects of a mention; one object has its name in the singular.
    pub(super) fn set_count(&mut self, mention: usize, count: u32) {
        let mention = &mut self.parsed.mentions[mention];
        mention.count = Some([count; 2]);
        if mention.plural && count == 1 {
            mention.words = self.lexicon.vocabulary.singular_of(&mention.words);
        }
        mention.plural = count > 1;
    }

    fn copy_links(&mut self, links: &[Link], of: usize, copy: usize) {
        for link in links.iter().filter(|link| link.from == of && link.to != of) {
            self.parsed.links.push(Link { from: copy, ..*link });
        }
    }

    fn join_arrangements(&mut self, of: usize, copy: usize) {
        for arrangement in &mut self.parsed.arrangements {
            if let Some(position) = arrangement.mentions.iter().position(|&member| member == of) {
                arrangement.mentions.insert(position + 1, copy);
            }
        }
    }

    /// Ends a split mention: its remaining objects become a mention without the attributes of the others.
    pub(super) fn end_split(&mut self) -> Option<usize> {
        let split = self.split.take()?;
        let rest = self.copy_of_whole(&split);
        self.set_count(rest, split.left);
        self.parts.push(rest);
        Some(rest)
    }

    /// "one" of "two mugs, one upside down" and "two mugs, one on a book". Whether the rule applies.
    pub(super) fn counted_part(&mut self) -> bool {
        let before = self.at.checked_sub(1).map(|before| &self.tokens[before]);
        let begins = match before {
            Some(Token::Pause | Token::End) => true,
            Some(Token::Word(word)) => word == "and" || word == "with",
            _ => false,
        };
        let Some((range, length)) = quantity(self.lexicon, self.tokens, self.at) else { return false };
        let next = self.at + length;
        let several = match &self.split {
            Some(split) => range[1] <= split.left,
            None => {
                let last = self.subject.last().copied().or(self.salient);
                last.and_then(|last| fixed_count(&self.parsed.mentions[last])).is_some_and(|n| range[1] < n)
            }
        };
        let (readings, sized) = match self.word_at(next) {
            None => trailing(self.lexicon.vocabulary, self.tokens, next),
            Some(_) => (Vec::new(), next),
        };
        let described = !readings.is_empty()
            || self.state_at(next).is_some()
            || preposition_at(self.tokens, next).is_some()
            || place_at(self.tokens, next, &Self::is_table_word).is_some()
            || matches!(
                self.word_at(next),
                Some(
                    "with"
                        | "holding"
                        | "containing"
                        | "facing"
                        | "lying"
                        | "standing"
                        | "is"
                        | "are"
                        | "turned"
                )
            );
        // "1 cm behind the plate", "one behind the other".
        let measured = read_length(self.lexicon.vocabulary, self.tokens, self.at).is_some();
        let arranged = self.phrase_at(self.at).is_some() || self.stack_at(self.at).is_some();
        // "one on each side", "one in each corner", "and one lying bottle".
        let each =
            (next..next + 3).any(|p| matches!(self.word_at(p), Some("each" | "either" | "every" | "both")));
        let noun = matches!(self.word_at(next), Some("lying" | "standing" | "turned"))
            && self.lexicon.longest_at(self.tokens, next + 1).is_some();
        if each || noun {
            return false;
        }
        if !(begins && several && described) || range[0] != range[1] || measured || arranged {
            return false;
        }
        let mut phrase = NounPhrase::part(range, self.at..next);
        phrase.counts.push(self.at..next);
        // "two boxes, one 10 cm wide".
        for (reading, tokens) in readings {
            let property = phrase.attributes.add_reading(reading);
            phrase.properties.push((property, tokens));
        }
        self.at = sized;
        self.split_off(&phrase)
    }

    /// One object of a plural mention that a definite phrase selects: "the left plate", "the smaller jar", "the red
    /// mug" in a later sentence.
    pub(super) fn part_of_several(&mut self, meanings: &[Meaning], phrase: &NounPhrase) -> Option<usize> {
        let single = !phrase.plural && phrase.count.is_none_or(|count| count == [1, 1]);
        if phrase.determiner != Determiner::Definite || !single {
            return None;
        }
        if let Some(&(_, taken)) = self
            .selected_parts
            .iter()
            .rev()
            .find(|(selector, part)| Some(*selector) == phrase.selector && self.shares(*part, meanings))
        {
            return Some(taken);
        }
        let attributes = &phrase.attributes;
        let sized = (attributes.scale - 1.0).abs() > 1e-9 || !attributes.stretches.is_empty();
        let colored = !attributes.color_words.is_empty() || attributes.substance.is_some();
        let earlier = |mention: &Mention| {
            self.source.has_end(mention.tokens.end.min(phrase.tokens.start)..phrase.tokens.start)
        };
        let mentions = &self.parsed.mentions;
        let whole = (0..mentions.len()).rev().find(|&m| {
            let mention = &mentions[m];
            let open = mention.attributes.color_words.is_empty() && mention.attributes.substance.is_none();
            let plain =
                (mention.attributes.scale - 1.0).abs() < 1e-9 && mention.attributes.stretches.is_empty();
            let listed = attributes.color_words.len() == 1
                && mention.attributes.color_words.len() > 1
                && mention.attributes.color_words.contains(&attributes.color_words[0]);
            self.shares(m, meanings)
                && fixed_count(mention).is_some()
                && !mention.stacked
                && (listed
                    || phrase.selector.is_some()
                    || sized && plain
                    || colored && open && earlier(mention))
        });
        let part = match whole {
            Some(whole) => {
                let part = self.one_of(whole);
                self.take_color(whole, part, attributes.color_words.first());
                part
            }
            // The last object of those that were separated.
            None => (0..self.parsed.mentions.len()).rev().find(|&m| {
                phrase.selector.is_some()
                    && self.shares(m, meanings)
                    && self.parsed.mentions[m].places.is_empty()
                    && self.selected_parts.iter().all(|(_, part)| *part != m)
                    && self.selected_parts.iter().any(|(_, part)| self.shares(*part, meanings))
            })?,
        };
        if let Some(selector) = phrase.selector {
            self.selected_parts.push((selector, part));
            if let Selector::Side(kind) = selector
                && !self.placed_in_row(whole, part, kind)
            {
                self.parsed.mentions[part].places.push(Place { kind, distance_m: None });
            }
        }
        super::references::merge(&mut self.parsed.mentions[part].attributes, attributes.clone());
        Some(part)
    }

    fn shares(&self, mention: usize, meanings: &[Meaning]) -> bool {
        self.parsed.mentions[mention].meanings.iter().any(|meaning| meanings.contains(meaning))
    }

    /// "the yellow mug" of "three mugs: red, green and yellow": the others have the other colors.
    fn take_color(&mut self, whole: usize, part: usize, color: Option<&String>) {
        let known = &self.parsed.mentions[whole].attributes;
        let Some(k) = color.and_then(|color| known.color_words.iter().position(|word| word == color)) else {
            return;
        };
        if known.colors.len() < 2 || known.colors.len() != known.color_words.len() {
            return;
        }
        let own = (known.colors[k], known.color_words[k].clone());
        let rest = &mut self.parsed.mentions[whole].attributes;
        rest.colors.remove(k);
        rest.color_words.remove(k);
        let taken = &mut self.parsed.mentions[part].attributes;
        (taken.colors, taken.color_words) = (vec![own.0], vec![own.1]);
    }

    /// Takes one object out of a plural mention.
    pub(super) fn one_of(&mut self, whole: usize) -> usize {
        let copy = self.parsed.mentions[whole].clone();
        let left = fixed_count(&copy).unwrap_or(2) - 1;
        let part = self.add_part(whole, copy, usize::MAX);
        self.join_arrangements(whole, part);
        let links = self.parsed.links.clone();
        self.copy_links(&links, whole, part);
        self.set_count(part, 1);
        self.set_count(whole, left);
        part
    }

    /// The mention that "the other one", "the second" and "the left one" mean.
    pub(super) fn selected_one(&mut self, phrase: &NounPhrase) -> Option<usize> {
        let selector = phrase.selector?;
        let last_of_split = self.split.as_ref().is_some_and(|split| split.left == 1);
        if (selector == Selector::Other || matches!(selector, Selector::Ordinal(_)) && last_of_split)
            && let Some(rest) = self.end_split()
        {
            return Some(rest);
        }
        let siblings = |parser: &Self, of: usize| -> Vec<usize> {
            let meanings = &parser.parsed.mentions[of].meanings;
            (0..parser.parsed.mentions.len()).filter(|&m| parser.shares(m, meanings)).collect()
        };
        // The last category of which there are several objects.
        let several = (0..self.parsed.mentions.len())
            .rev()
            .find(|&m| self.is_several(m) || siblings(self, m).len() > 1)?;
        let candidates = siblings(self, several);
        let meanings = self.parsed.mentions[several].meanings.clone();
        let single = candidates.iter().all(|&m| !self.is_several(m));
        // "the other three", "the others" after one of four.
        if selector == Selector::Other {
            let named = |m: &usize| {
                Some(*m) != self.salient
                    && self.is_several(*m)
                    && phrase.count.is_none_or(|count| self.parsed.mentions[*m].count == Some(count))
                    && !self.subject.contains(m)
            };
            let open = self.selected_parts.is_empty() && self.parts.is_empty();
            let is_plural = self.tokens[phrase.tokens.clone()]
                .iter()
                .any(|token| matches!(token.word(), Some("others" | "rest" | "remaining")));
            let taken = candidates.len() > 1 && (phrase.count.is_some() || !open || is_plural);
            if let Some(rest) = candidates.iter().copied().rfind(named).filter(|_| taken) {
                return Some(rest);
            }
        }
        match selector {
            Selector::Side(side) => candidates
                .iter()
                .copied()
                .rfind(|&m| self.parsed.mentions[m].places.iter().any(|place| place.kind == side)),
            Selector::Ordinal(k) if single && self.selected_parts.is_empty() => candidates.get(k).copied(),
            Selector::Other if single => candidates.iter().copied().rfind(|m| Some(*m) != self.salient),
            Selector::Top if matches!(self.word_at(phrase.tokens.end), Some("is" | "being")) => {
                self.top_of(&candidates)
            }
            Selector::Ordinal(k) if candidates.iter().any(|&m| self.parsed.mentions[m].stacked) => {
                self.level_of(&candidates, k)
            }
            Selector::Top | Selector::Bottom => {
                candidates.iter().copied().rfind(|&m| self.parsed.mentions[m].stacked)
            }
            _ => None,
        }
        .or_else(|| self.part_of_several(&meanings, phrase))
        .or_else(|| {
            let any = !matches!(selector, Selector::Ordinal(_)) && (selector != Selector::Other || !single);
            candidates.last().copied().filter(|_| any)
        })
    }

    /// "the topmost is red": the last object of a stack, which the text tells apart from the others.
    fn top_of(&mut self, candidates: &[usize]) -> Option<usize> {
        let whole = candidates.iter().copied().rfind(|&m| self.parsed.mentions[m].stacked)?;
        fixed_count(&self.parsed.mentions[whole])?;
        let top = self.one_of(whole);
        self.parsed.mentions[top].stacked = false;
        self.parsed.links.retain(|link| link.from != top);
        self.parsed.links.push(Link::new(top, LinkKind::Relation(RelationKind::On), whole));
        Some(top)
    }

    /// "the center bowl" of a row: its place is in the row. Whether the part is a member of one.
    fn placed_in_row(&mut self, whole: Option<usize>, part: usize, side: RelationKind) -> bool {
        let row =
            self.parsed.arrangements.iter().position(|arrangement| {
                arrangement.group == Group::Row && arrangement.mentions.contains(&part)
            });
        let (Some(row), Some(whole)) = (row, whole) else { return false };
        let left = self.parsed.mentions[whole].count.map_or(1, |count| count[0]);
        if side == RelationKind::AtCenter && left > 1 {
            let copy = self.parsed.mentions[whole].clone();
            let rest = self.add_part(whole, copy, usize::MAX);
            self.join_arrangements(part, rest);
            self.set_count(rest, left / 2);
            self.set_count(whole, left - left / 2);
            self.selected_parts.push((Selector::Side(RelationKind::AtLeft), whole));
            self.selected_parts.push((Selector::Side(RelationKind::AtRight), rest));
        } else if side == RelationKind::AtLeft {
            let members = &mut self.parsed.arrangements[row].mentions;
            if let Some(at) =
                members.iter().position(|&member| member == whole).filter(|at| at + 1 < members.len())
            {
                members.swap(at, at + 1);
            }
        }
        true
    }

    /// "the former" and "the latter" of a list, or of two objects.
    pub(super) fn former_or_latter(&mut self, phrase: &NounPhrase) -> Option<usize> {
        let selector = phrase.selector?;
        let is_known = self.subject.iter().all(|mention| self.last_list.contains(mention));
        let list = if is_known && self.last_list.len() > 1 { &self.last_list } else { &self.subject };
        if list.len() > 1 {
            let list = list.clone();
            let found = if selector == Selector::Former { list.first() } else { list.last() }.copied();
            self.last_list = list;
            return found;
        }
        let both = (0..self.parsed.mentions.len()).rev().find(|&m| self.is_several(m))?;
        let meanings = self.parsed.mentions[both].meanings.clone();
        let number = usize::from(selector == Selector::Latter);
        let ordinal = NounPhrase { selector: Some(Selector::Ordinal(number)), ..phrase.clone() };
        let ordinal = NounPhrase { determiner: Determiner::Definite, ..ordinal };
        self.part_of_several(&meanings, &ordinal)
    }

    /// "the bowl on the left; the bowl on the right": a place that the known object cannot have makes another object.
    pub(super) fn at_another_place(&mut self, mut phrase: NounPhrase) -> NounPhrase {
        let Head::Objects(meanings) = &phrase.head else { return phrase };
        let definite = phrase.determiner == Determiner::Definite && phrase.selector.is_none();
        let Some((places, _)) = place_at(self.tokens, self.at, &Self::is_table_word).filter(|_| definite)
        else {
            return phrase;
        };
        let known = (0..self.parsed.mentions.len()).rev().find(|&m| self.shares(m, meanings));
        let other = known.filter(|&known| {
            let known = &self.parsed.mentions[known].places;
            known.iter().any(|known| places.iter().any(|&place| exclude_each_other(known.kind, place)))
        });
        if let Some(other) = other {
            self.parsed.mentions[other].forward = false;
            phrase.determiner = Determiner::New;
        }
        phrase
    }
}

/// The number of objects if it is stated and more than one.
fn fixed_count(mention: &Mention) -> Option<u32> {
    match mention.count {
        Some([low, high]) if low == high && (2..=64).contains(&low) => Some(low),
        _ => None,
    }
}
