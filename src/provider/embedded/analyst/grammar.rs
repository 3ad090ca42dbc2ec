//! From tokens to mentions and links: clauses, lists, prepositions, pronouns, "with ..." and "each".
//!
//! A recursive-descent reader that never fails: what it cannot place it skips, and words that mean a
//! thing nobody knows are collected. Pronouns mean the last subject; "the X" means an earlier X.

mod with_list;

use super::lexicon::{Lexicon, Meaning};
use super::phrase::{Determiner, Head, Looks, NounPhrase, noun_phrase, predicate};
use super::prepositions::{Preposition, place_at, preposition_at};
use super::tokens::Token;
use crate::scene::RelationKind;

/// A group of things the text speaks about.
#[derive(Clone, Debug)]
pub(super) struct Mention {
    pub meanings: Vec<Meaning>,
    pub count: Option<[u32; 2]>,
    pub plural: bool,
    pub stacked: bool,
    pub looks: Looks,
    pub words: String,
    /// Repeated for every instance of that mention.
    pub each_of: Option<usize>,
    /// Contents of a vessel: the vague plural may be larger.
    pub contents: bool,
    pub places: Vec<RelationKind>,
    /// Only referred to so far ("the monitor" before "a monitor").
    pub forward: bool,
}

/// "from kind to": what one mention is to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Link {
    pub from: usize,
    pub kind: LinkKind,
    pub to: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LinkKind {
    Relation(RelationKind),
    /// "A with B": B in, on or beside A, as their kinds suggest.
    With,
    /// "A with B on the left": the same, and on that side if beside it.
    WithAtSide(RelationKind),
    /// One at the left, one at the right.
    Flank,
}

/// Everything a text says.
#[derive(Debug, Default)]
pub(super) struct Reading {
    pub mentions: Vec<Mention>,
    pub links: Vec<Link>,
    /// Meanings the text rules out.
    pub excluded: Vec<Meaning>,
    pub table: Option<(Option<String>, Looks)>,
    pub unknown: Vec<String>,
    /// "for four people".
    pub people: Option<u32>,
}

/// What a noun phrase turned out to be.
enum Reference {
    Mentions(Vec<usize>),
    Table,
    Nothing,
}

struct Reader<'a, 'c> {
    lexicon: &'a Lexicon<'c>,
    tokens: &'a [Token],
    at: usize,
    reading: Reading,
    /// The list being enumerated; what a following preposition speaks about.
    subject: Vec<usize>,
    /// What "it" means.
    salient: Option<usize>,
    /// What "them" means.
    salient_list: Vec<usize>,
    /// Fronted relations that wait for their subject.
    pending: Vec<(RelationKind, Vec<usize>)>,
    pending_places: Vec<RelationKind>,
    pending_each: Option<usize>,
    /// The pending relation points at what "it" means, which stays the same for the rest of the sentence.
    pending_pronoun: bool,
    /// "and" was the last thing said; the running list's last member came after a bare "and".
    said_and: bool,
    joined: bool,
    clause_start: bool,
}

/// Reads the whole text.
pub(super) fn read(lexicon: &Lexicon, tokens: &[Token]) -> Reading {
    let mut reader = Reader {
        lexicon,
        tokens,
        at: 0,
        reading: Reading::default(),
        subject: Vec::new(),
        salient: None,
        salient_list: Vec::new(),
        pending: Vec::new(),
        pending_places: Vec::new(),
        pending_each: None,
        pending_pronoun: false,
        said_and: false,
        joined: false,
        clause_start: true,
    };
    while reader.at < tokens.len() {
        let before = reader.at;
        reader.step();
        if reader.at == before {
            reader.at += 1;
        }
    }
    reader.reading
}

impl Reader<'_, '_> {
    fn word(&self, ahead: usize) -> Option<&str> {
        self.tokens.get(self.at + ahead).and_then(Token::word)
    }

    fn step(&mut self) {
        match &self.tokens[self.at] {
            Token::End => {
                self.end_clause();
                self.at += 1;
                return;
            }
            Token::Pause => {
                self.said_and = false;
                self.joined = false;
                self.at += 1;
                return;
            }
            _ => {}
        }
        let clause_start = self.clause_start;
        self.clause_start = false;
        if self.people() || self.exclusion() {
            return;
        }
        if matches!(self.word(0), Some("and" | "plus" | "also" | "then" | "while" | "but" | "or")) {
            self.said_and = self.word(0) == Some("and");
            self.at += 1;
            self.clause_start = clause_start;
            return;
        }
        // "each with a fork", "with a fork each".
        if matches!(self.word(0), Some("each" | "both"))
            && matches!(self.word(1), Some("with" | "has" | "have" | "holding" | "containing"))
        {
            self.at += 1;
            self.with_list(true);
            return;
        }
        if self.with_at().is_some() {
            self.with_list(false);
            return;
        }
        if let Some((places, length)) = place_at(self.tokens, self.at, &self.table_words()) {
            self.at += length;
            self.place(places, clause_start);
            return;
        }
        if let Some((preposition, length)) = preposition_at(self.tokens, self.at) {
            self.at += length;
            self.prepositional(preposition, clause_start);
            return;
        }
        if let Some(kind) = self.side_of_it() {
            self.relate_or_wait(kind, clause_start);
            return;
        }
        // "three mugs stacked on a tray".
        if matches!(self.word(0), Some("stacked" | "piled"))
            && let Some(&last) = self.subject.last()
        {
            self.reading.mentions[last].stacked = true;
            self.at += 1;
            return;
        }
        // "the laptop is silver".
        if matches!(self.word(0), Some("is" | "are" | "in"))
            && let Some((looks, end)) = predicate(self.lexicon, self.tokens, self.at + 1)
        {
            self.at = end;
            let described =
                if self.subject.is_empty() { self.salient_list.clone() } else { self.subject.clone() };
            for mention in described {
                merge(&mut self.reading.mentions[mention].looks, looks.clone());
            }
            return;
        }
        if let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at) {
            self.at = end;
            self.noun(phrase);
        } else {
            self.at += 1;
        }
    }

    fn end_clause(&mut self) {
        if !self.subject.is_empty() {
            self.salient_list = self.subject.clone();
        }
        self.subject.clear();
        self.pending.clear();
        self.pending_places.clear();
        self.pending_each = None;
        self.pending_pronoun = false;
        (self.said_and, self.joined) = (false, false);
        self.clause_start = true;
    }

    fn table_words(&self) -> impl Fn(&str) -> bool + use<> {
        |word: &str| {
            matches!(
                word,
                "table" | "desk" | "tabletop" | "workbench" | "bench" | "surface" | "counter" | "it"
            )
        }
    }

    /// "for four people", "set for two".
    fn people(&mut self) -> bool {
        if self.word(0) != Some("for") {
            return false;
        }
        let Some(([low, _], length)) = super::phrase::quantity(self.lexicon, self.tokens, self.at + 1) else {
            return false;
        };
        let after = self.tokens.get(self.at + 1 + length);
        let people = matches!(
            after.and_then(Token::word),
            Some("people" | "persons" | "guests" | "friends" | "diners" | "kids" | "children" | "players")
        );
        let ends = !matches!(after, Some(Token::Word(_) | Token::Number(_)))
            || matches!(after.and_then(Token::word), Some("with" | "and" | "on" | "in" | "at"));
        if !(people || ends) || low == 0 || low > 12 {
            return false;
        }
        self.reading.people = Some(low);
        self.at += 1 + length + usize::from(people);
        true
    }

    /// "without a mouse", "no plates".
    fn exclusion(&mut self) -> bool {
        let start = match self.word(0) {
            Some("without" | "except" | "excluding" | "minus") => 1,
            Some("not") if matches!(self.word(1), Some("a" | "any" | "the")) => 1,
            Some("no") => 0,
            _ => return false,
        };
        let mut p = self.at + start;
        if matches!(self.tokens.get(p).and_then(Token::word), Some("for" | "any")) {
            p += 1;
        }
        let mut found = false;
        while let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, p) {
            match phrase.head {
                Head::Things(meanings) => self.reading.excluded.extend(meanings),
                _ => break,
            }
            found = true;
            p = end;
            if matches!(self.tokens.get(p).and_then(Token::word), Some("or" | "and" | "nor"))
                && !matches!(self.tokens.get(p + 1).and_then(Token::word), Some("a" | "an" | "some" | "the"))
                && !matches!(self.tokens.get(p + 1), Some(Token::Number(_)))
            {
                p += 1;
            } else {
                break;
            }
        }
        self.at = if found { p } else { self.at + 1 };
        true
    }

    fn with_at(&self) -> Option<usize> {
        match self.word(0)? {
            "with" | "containing" | "holding" | "carrying" | "featuring" | "including" => Some(1),
            "filled" | "topped" | "loaded" | "full" if matches!(self.word(1), Some("with" | "of")) => Some(2),
            "surrounded" | "flanked" | "accompanied" if self.word(1) == Some("by") => Some(2),
            "has" | "have" | "holds" | "contains" | "carries" if !self.subject.is_empty() => Some(1),
            _ => None,
        }
    }

    /// A place of the table top: of the subject, or of what follows.
    fn place(&mut self, places: Vec<RelationKind>, clause_start: bool) {
        if self.fronted(clause_start) || self.subject.is_empty() {
            self.subject.clear();
            self.pending.clear();
            self.pending_places = places;
            return;
        }
        for mention in self.attached() {
            for &place in &places {
                if !self.reading.mentions[mention].places.contains(&place) {
                    self.reading.mentions[mention].places.push(place);
                }
            }
        }
    }

    /// Whether the phrase just read stands before its subject: a thing or a form of "to be" follows.
    fn fronted(&self, clause_start: bool) -> bool {
        let mut ahead = 0;
        if clause_start && matches!(self.tokens.get(self.at), Some(Token::Pause)) {
            return true;
        }
        while matches!(
            self.word(ahead),
            Some(
                "is" | "are"
                    | "there"
                    | "stands"
                    | "stand"
                    | "sits"
                    | "sit"
                    | "lies"
                    | "lie"
                    | "put"
                    | "place"
                    | "rests"
            )
        ) {
            ahead += 1;
        }
        let at = self.at + ahead;
        if place_at(self.tokens, at, &self.table_words()).is_some()
            || preposition_at(self.tokens, at).is_some()
        {
            return clause_start && ahead == 0 && self.subject.is_empty();
        }
        noun_phrase(self.lexicon, self.tokens, at)
            .is_some_and(|(phrase, _)| matches!(phrase.head, Head::Things(_) | Head::Unknown(_)))
    }

    /// The members of the running list a following preposition speaks about: the last one, or both of
    /// "X and Y" when they are alike in kind.
    fn attached(&self) -> Vec<usize> {
        let Some((&last, before)) = self.subject.split_last() else { return Vec::new() };
        let [.., other] = before else { return vec![last] };
        let bare = |m: usize| self.reading.links.iter().all(|link| link.from != m && link.to != m);
        let group = |m: usize| match self.reading.mentions[m].meanings.first() {
            Some(Meaning::Category(index)) => Some(self.lexicon.categories[*index].group.as_str()),
            _ => None,
        };
        let families = group(*other) == group(last) && group(last).is_some();
        if self.joined && bare(*other) && self.reading.mentions[*other].places.is_empty() && families {
            vec![*other, last]
        } else {
            vec![last]
        }
    }

    /// "to its left", "on its right".
    fn side_of_it(&mut self) -> Option<RelationKind> {
        let start = usize::from(matches!(self.word(0), Some("to" | "on" | "at")));
        if !matches!(self.word(start), Some("its" | "their" | "his" | "her")) {
            return None;
        }
        let kind = match self.word(start + 1)? {
            "left" => RelationKind::LeftOf,
            "right" => RelationKind::RightOf,
            "front" => RelationKind::InFrontOf,
            "back" | "rear" => RelationKind::Behind,
            "side" | "sides" => RelationKind::NextTo,
            _ => return None,
        };
        self.at += start + 2 + usize::from(matches!(self.word(start + 2), Some("side" | "hand")));
        Some(kind)
    }

    fn prepositional(&mut self, preposition: Preposition, clause_start: bool) {
        let kind = preposition.kind;
        // "on top", "inside", "beside": of what was said last.
        let target = noun_phrase(self.lexicon, self.tokens, self.at)
            .filter(|_| !(preposition.may_stand_alone && self.pause_follows()));
        let Some((phrase, end)) = target else {
            if preposition.may_stand_alone {
                self.relate_or_wait(kind, clause_start);
            }
            return;
        };
        let pronoun = phrase.head == Head::It;
        let subjects = match self.subject.last() {
            Some(&last) if pronoun => vec![last],
            _ => self.attached(),
        };
        self.at = end;
        let each = phrase.determiner == Determiner::Each;
        let mut targets = match self.refer(phrase, true) {
            Reference::Mentions(targets) => targets,
            Reference::Table => {
                // "on the desk": where things are anyway.
                if self.with_at().is_some() || self.fronted(clause_start) {
                    self.subject.clear();
                }
                return;
            }
            Reference::Nothing => return,
        };
        // "between the plate and the vase".
        if preposition.two_targets
            && self.word(0) == Some("and")
            && let Some((second, end)) = noun_phrase(self.lexicon, self.tokens, self.at + 1)
        {
            self.at = end;
            if let Reference::Mentions(more) = self.refer(second, true) {
                targets.extend(more);
            }
        }
        if subjects.is_empty() || self.fronted(clause_start) {
            self.subject.clear();
            self.pending_places.clear();
            self.pending = vec![(kind, targets.clone())];
            self.pending_each = each.then(|| targets[0]);
            self.pending_pronoun = pronoun;
            // "Next to the monitor, a lamp. Beside it ..." speaks of the lamp next; until then of the monitor.
            self.salient = targets.last().copied().or(self.salient);
            return;
        }
        for &subject in &subjects {
            if each && let Some(&target) = targets.first() {
                self.reading.mentions[subject].each_of = Some(target);
            }
            for &target in &targets {
                self.link(subject, kind, preposition.inverse, target);
            }
        }
    }

    fn pause_follows(&self) -> bool {
        matches!(self.tokens.get(self.at), None | Some(Token::Pause | Token::End))
    }

    /// A relation without an object: to the last thing, for the subject or for what follows.
    fn relate_or_wait(&mut self, kind: RelationKind, clause_start: bool) {
        let subjects = self.attached();
        if self.fronted(clause_start) || subjects.is_empty() {
            if let Some(it) = subjects.first().copied().or(self.salient) {
                self.subject.clear();
                self.pending = vec![(kind, vec![it])];
                self.pending_pronoun = true;
            }
            return;
        }
        let opposite = match kind {
            RelationKind::LeftOf => Some(RelationKind::RightOf),
            RelationKind::RightOf => Some(RelationKind::LeftOf),
            _ => None,
        };
        // "a mug to the left of the laptop and a phone to the right".
        let other_side = self.reading.links.iter().rev().find(|link| {
            opposite.is_some_and(|opposite| link.kind == LinkKind::Relation(opposite))
                && !subjects.contains(&link.from)
                && self.subject.contains(&link.from)
        });
        let it = other_side.map(|link| link.to).or_else(|| self.earlier_than(&subjects));
        for &subject in &subjects {
            match it {
                Some(it) => self.link(subject, kind, false, it),
                None => match kind {
                    RelationKind::LeftOf => self.reading.mentions[subject].places.push(RelationKind::AtLeft),
                    RelationKind::RightOf => {
                        self.reading.mentions[subject].places.push(RelationKind::AtRight)
                    }
                    RelationKind::InFrontOf => {
                        self.reading.mentions[subject].places.push(RelationKind::AtFront);
                    }
                    RelationKind::Behind => self.reading.mentions[subject].places.push(RelationKind::AtBack),
                    _ => {}
                },
            }
        }
    }

    /// What "it" means to these subjects: the thing they are already tied to, or the one before them.
    fn earlier_than(&self, subjects: &[usize]) -> Option<usize> {
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

    fn link(&mut self, from: usize, kind: RelationKind, inverse: bool, to: usize) {
        let (from, to) = if inverse { (to, from) } else { (from, to) };
        if from == to {
            return;
        }
        let link = Link { from, kind: LinkKind::Relation(kind), to };
        if !self.reading.links.contains(&link) {
            self.reading.links.push(link);
        }
    }

    /// A phrase in subject position.
    fn noun(&mut self, phrase: NounPhrase) {
        if phrase.negated {
            if let Head::Things(meanings) = phrase.head {
                self.reading.excluded.extend(meanings);
            }
            return;
        }
        // "a bowl of apples".
        let of = self.word(0) == Some("of");
        let referred = matches!(phrase.head, Head::It | Head::Them);
        match self.refer(phrase, false) {
            Reference::Mentions(list) => {
                let is_new = !referred;
                for &mention in &list {
                    if is_new {
                        for (kind, targets) in self.pending.clone() {
                            for target in targets {
                                self.link(mention, kind, false, target);
                            }
                        }
                        let places = self.pending_places.clone();
                        let mention = &mut self.reading.mentions[mention];
                        mention.places.extend(places);
                        if let Some(each) = self.pending_each {
                            mention.each_of = Some(each);
                        }
                    }
                    if !self.subject.contains(&mention) {
                        self.subject.push(mention);
                    }
                }
                if !self.pending_pronoun {
                    self.salient = list.last().copied().or(self.salient);
                }
                self.salient_list = self.subject.clone();
                self.joined = std::mem::take(&mut self.said_and);
                if of && let Some(&vessel) = list.last() {
                    self.contents_of(vessel);
                }
            }
            Reference::Table => self.subject.clear(),
            Reference::Nothing => {}
        }
    }

    /// After "of": what a vessel holds or a board carries.
    fn contents_of(&mut self, vessel: usize) {
        let mut p = self.at + 1;
        loop {
            let substance = self
                .tokens
                .get(p)
                .and_then(Token::word)
                .is_some_and(|word| self.lexicon.vocabulary.grammar.substances.contains(word));
            let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, p) else {
                if substance {
                    self.at = p + 1;
                }
                return;
            };
            if substance && phrase.determiner == Determiner::New && phrase.count.is_none() && !phrase.plural {
                // "a cup of tea": in the cup's name.
                self.at = p + 1;
                return;
            }
            let open = phrase.count.is_none();
            self.at = end;
            if let Reference::Mentions(list) = self.refer(phrase, false) {
                for content in list {
                    self.reading.mentions[content].contents = true;
                    self.reading.links.push(Link { from: content, kind: LinkKind::With, to: vessel });
                }
            }
            // "a bowl of apples and pears": bare plurals belong to the vessel too.
            let next = self.at + 1;
            if open
                && self.word(0) == Some("and")
                && let Some((second, _)) = noun_phrase(self.lexicon, self.tokens, next)
                && second.count.is_none()
                && second.plural
                && matches!(second.head, Head::Things(_))
            {
                p = next;
            } else {
                return;
            }
        }
    }

    /// The mentions a phrase speaks about, making new ones as needed.
    fn refer(&mut self, phrase: NounPhrase, as_target: bool) -> Reference {
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
}

/// Looks said later complete those said before.
fn merge(known: &mut Looks, more: Looks) {
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
