//! The grammar: tokens to mentions and links, with clauses, lists, prepositions, pronouns, "with ..." and "each".
//!
//! A recursive-descent parser that never fails: it skips unparsable tokens and collects unknown nouns. Pronouns refer
//! to the last subject; "the X" refers to an earlier X (references.rs); prepositions link subjects to objects
//! (relations.rs).

mod references;
mod relations;
mod with_list;

use super::lexicon::{Lexicon, Meaning};
use super::phrase::{Attributes, Determiner, Head, NounPhrase, noun_phrase, predicate};
use super::prepositions::{place_at, preposition_at, reciprocal_at};
use super::quantity::quantity;
use super::tokens::{Token, word};
use references::{Referent, merge};
use scene::RelationKind;

/// A group of objects of the text with common attributes.
#[derive(Clone, Debug)]
pub(super) struct Mention {
    pub meanings: Vec<Meaning>,
    pub count: Option<[u32; 2]>,
    pub plural: bool,
    pub stacked: bool,
    pub attributes: Attributes,
    pub words: String,
    /// Repeated for every instance of that mention.
    pub each_of: Option<usize>,
    /// Whether the mention is the contents of a vessel; its vague plural may be larger.
    pub contents: bool,
    pub places: Vec<RelationKind>,
    /// Whether the mention is only referred to so far ("the monitor" before "a monitor").
    pub forward: bool,
}

/// A relation between two mentions: "from kind to".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Link {
    pub from: usize,
    pub kind: LinkKind,
    pub to: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LinkKind {
    Relation(RelationKind),
    /// "A with B": B in, on or beside A, depending on their categories.
    With,
    /// "A with B on the left": like `With`, and on this side if B is beside A.
    WithAtSide(RelationKind),
    /// One object on the left, one on the right.
    Flank,
}

/// The parse of a text.
#[derive(Debug, Default)]
pub(super) struct ParsedText {
    pub mentions: Vec<Mention>,
    pub links: Vec<Link>,
    /// Meanings excluded by the text.
    pub excluded: Vec<Meaning>,
    pub table: Option<(Option<String>, Attributes)>,
    pub unknown: Vec<String>,
    /// "for four people".
    pub people: Option<u32>,
}

struct Parser<'a, 'c> {
    lexicon: &'a Lexicon<'c>,
    tokens: &'a [Token],
    at: usize,
    parsed: ParsedText,
    /// The current list; the subject of a following preposition.
    subject: Vec<usize>,
    /// Referent of "it".
    salient: Option<usize>,
    /// Referents of "them".
    salient_list: Vec<usize>,
    /// Fronted relations before their subject.
    pending: Vec<(RelationKind, Vec<usize>)>,
    pending_places: Vec<RelationKind>,
    pending_each: Option<usize>,
    /// Whether the target of the pending relation is the referent of "it", which is fixed for the rest of the sentence.
    pending_pronoun: bool,
    /// Whether the last member of the current list follows a bare "and".
    after_and: bool,
    joined: bool,
    clause_start: bool,
}

/// Parses the whole text.
pub(super) fn parse(lexicon: &Lexicon, tokens: &[Token]) -> ParsedText {
    let mut reader = Parser {
        lexicon,
        tokens,
        at: 0,
        parsed: ParsedText::default(),
        subject: Vec::new(),
        salient: None,
        salient_list: Vec::new(),
        pending: Vec::new(),
        pending_places: Vec::new(),
        pending_each: None,
        pending_pronoun: false,
        after_and: false,
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
    reader.parsed
}

impl Parser<'_, '_> {
    fn word(&self, ahead: usize) -> Option<&str> {
        word(self.tokens, self.at + ahead)
    }

    fn step(&mut self) {
        match &self.tokens[self.at] {
            Token::End => {
                self.end_clause();
                self.at += 1;
                return;
            }
            Token::Pause => {
                self.after_and = false;
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
            self.after_and = self.word(0) == Some("and");
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
        // "on each other" stacks them; "next to each other" is the default for objects of one category.
        if let Some((kind, length)) = reciprocal_at(self.tokens, self.at) {
            if let (RelationKind::On, Some(&last)) = (kind, self.subject.last()) {
                self.parsed.mentions[last].stacked = true;
            }
            self.at += length;
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
            self.parsed.mentions[last].stacked = true;
            self.at += 1;
            return;
        }
        // "the laptop is silver".
        if matches!(self.word(0), Some("is" | "are" | "in"))
            && let Some((attributes, end)) = predicate(self.lexicon, self.tokens, self.at + 1)
        {
            self.at = end;
            let described =
                if self.subject.is_empty() { self.salient_list.clone() } else { self.subject.clone() };
            for mention in described {
                merge(&mut self.parsed.mentions[mention].attributes, attributes.clone());
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
        (self.after_and, self.joined) = (false, false);
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
        let Some(([low, _], length)) = quantity(self.lexicon, self.tokens, self.at + 1) else {
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
        self.parsed.people = Some(low);
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
                Head::Objects(meanings) => self.parsed.excluded.extend(meanings),
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

    /// A phrase in subject position.
    fn noun(&mut self, phrase: NounPhrase) {
        if phrase.negated {
            if let Head::Objects(meanings) = phrase.head {
                self.parsed.excluded.extend(meanings);
            }
            return;
        }
        // "a bowl of apples".
        let of = self.word(0) == Some("of");
        let referred = matches!(phrase.head, Head::It | Head::Them);
        match self.refer(phrase, false) {
            Referent::Mentions(list) => {
                let is_new = !referred;
                for &mention in &list {
                    if is_new {
                        for (kind, targets) in self.pending.clone() {
                            for target in targets {
                                self.link(mention, kind, false, target);
                            }
                        }
                        let places = self.pending_places.clone();
                        let mention = &mut self.parsed.mentions[mention];
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
                self.joined = std::mem::take(&mut self.after_and);
                if of && let Some(&vessel) = list.last() {
                    self.contents_of(vessel);
                }
            }
            Referent::Table => self.subject.clear(),
            Referent::Nothing => {}
        }
    }

    /// After "of": the contents of a vessel or the load of a board.
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
                // "a cup of tea": a part of the cup's name.
                self.at = p + 1;
                return;
            }
            let open = phrase.count.is_none();
            self.at = end;
            if let Referent::Mentions(list) = self.refer(phrase, false) {
                for content in list {
                    self.parsed.mentions[content].contents = true;
                    self.parsed.links.push(Link { from: content, kind: LinkKind::With, to: vessel });
                }
            }
            // "a bowl of apples and pears": bare plurals are also contents of the vessel.
            let next = self.at + 1;
            if open
                && self.word(0) == Some("and")
                && let Some((second, _)) = noun_phrase(self.lexicon, self.tokens, next)
                && second.count.is_none()
                && second.plural
                && matches!(second.head, Head::Objects(_))
            {
                p = next;
            } else {
                return;
            }
        }
    }
}
