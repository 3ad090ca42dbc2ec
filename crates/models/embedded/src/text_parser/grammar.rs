//! The grammar: tokens to mentions and links, with clauses, lists, prepositions, pronouns, "with ..." and "each".
//!
//! A recursive-descent parser that never fails: it skips unparsable tokens, which the account of the text then reports.
//! Pronouns refer to the last subject; "the X" refers to an earlier X (references.rs); prepositions link subjects to
//! objects (relations.rs); instructions state goals (instruction.rs).

mod action;
mod action_objects;
mod agents;
mod answers;
mod arrangements;
mod attachment;
mod betweenness;
mod contents;
mod clauses;
mod colon_lists;
mod distance_statements;
mod desired_state;
mod distances;
mod ellipsis;
mod exceptions;
mod exclusion;
mod fillers;
mod examples;
mod flanks;
mod formations;
mod frames;
mod goals;
mod implied_ends;
mod instruction;
mod mishaps;
mod moving_parts;
mod openings;
mod orientation;
mod outcome;
mod part_states;
mod partitives;
mod possessives;
mod parts;
mod path_places;
mod paths;
mod places;
mod pouring;
mod predicates;
mod references;
mod relations;
mod remarks;
mod stack_levels;
mod stated_counts;
mod states;
mod steps;
mod subordinate;
mod table_size;
mod targets;
mod unnamed;
mod unread;
mod with_list;

use std::ops::Range;

use glam::DVec2;

use super::account::{Account, Claimed};
use super::lexicon::{Lexicon, Meaning};
use super::phrase::{Attributes, Determiner, Group, Head, NounPhrase, Selector};
use super::property::Property;
use super::tokens::{Source, Token, word};
use super::verbs::Frame;
pub(super) use goals::{GoalDraft, GoalKind};
use parts::Split;
use references::Referent;
use scene::RelationKind;
use scene::description::RequestedPose;
use scene::text_account::UnrecognizedReason;
pub(super) use states::category_shows;

/// A group of objects of the text with common attributes.
#[derive(Clone, Debug)]
pub(super) struct Mention {
    pub meanings: Vec<Meaning>,
    pub count: Option<[u32; 2]>,
    pub plural: bool,
    pub stacked: bool,
    /// Number of objects of each of several stacks.
    pub stack_size: Option<usize>,
    /// Whether each object is at a corner of its own.
    pub corners: bool,
    pub attributes: Attributes,
    pub words: String,
    /// As [`NounPhrase::stand_in`].
    pub stand_in: Option<String>,
    /// Repeated for every instance of that mention.
    pub each_of: Option<usize>,
    /// Repeated for every person.
    pub per_person: bool,
    /// Whether the mention is the contents of a vessel; its vague plural may be larger.
    pub contents: bool,
    pub places: Vec<Place>,
    pub pose: RequestedPose,
    pub state: Option<String>,
    pub yaw_rad: Option<f64>,
    pub position_m: Option<DVec2>,
    /// Whether the mention is only referred to so far ("the monitor" before "a monitor").
    pub forward: bool,
    /// The head in the text.
    pub tokens: Range<usize>,
}

/// A named part of the table top, or a distance from one of its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub kind: RelationKind,
    pub distance_m: Option<f64>,
}

/// A relation between two mentions: "from kind to".
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link {
    pub from: usize,
    pub kind: LinkKind,
    pub to: usize,
    /// The second object of "between".
    pub second: Option<usize>,
    pub distance_m: Option<f64>,
}

impl Link {
    pub fn new(from: usize, kind: LinkKind, to: usize) -> Self {
        Self { from, kind, to, second: None, distance_m: None }
    }
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
    /// In the target if it is a container, otherwise on it.
    At,
}

/// A regular arrangement of mentions.
#[derive(Clone, Debug)]
pub(super) struct ArrangementDraft {
    pub group: Group,
    pub columns: Option<usize>,
    pub mentions: Vec<usize>,
    pub gap_m: Option<f64>,
    pub center: Option<usize>,
}

/// The parse of a text.
#[derive(Debug, Default)]
pub(super) struct ParsedText {
    pub mentions: Vec<Mention>,
    pub links: Vec<Link>,
    pub arrangements: Vec<ArrangementDraft>,
    pub goals: Vec<GoalDraft>,
    /// Tokens of the instructions.
    pub instructions: Vec<Range<usize>>,
    /// Meanings excluded by the text.
    pub excluded: Vec<Meaning>,
    pub table: Option<(Option<String>, Attributes)>,
    /// Unknown nouns.
    pub unknown: Vec<String>,
    /// "for four people".
    pub people: Option<u32>,
    /// "set for four".
    pub is_set_for_people: bool,
    /// Whether the text says that nothing else is on the table.
    pub nothing_else: bool,
    pub account: Account,
}

/// A relation whose subject follows.
#[derive(Clone, Debug)]
struct PendingRelation {
    kind: RelationKind,
    inverse: bool,
    targets: Vec<usize>,
    second: Option<usize>,
    distance_m: Option<f64>,
    tokens: Range<usize>,
}

struct Parser<'a, 'c> {
    lexicon: &'a Lexicon<'c>,
    source: &'a Source,
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
    pending: Vec<PendingRelation>,
    pending_places: Vec<(Place, Range<usize>)>,
    pending_each: Option<usize>,
    /// Whether the target of the pending relation is the referent of "it", which is fixed for the rest of the sentence.
    pending_pronoun: bool,
    pending_per_person: bool,
    /// Whether the next mention is at every corner.
    pending_corners: bool,
    /// Whether the last member of the current list follows a bare "and".
    after_and: bool,
    joined: bool,
    clause_start: bool,
    /// Target of the preposition that has just been read ("a cup on a saucer" before "on a tray").
    chain: Option<usize>,
    /// A plural mention that is being split ("two mugs, one red ...").
    split: Option<Split>,
    /// The parts of the last split mention.
    parts: Vec<usize>,
    /// Objects that a place or an order identified ("the left one"), with what selected them.
    selected_parts: Vec<(Selector, usize)>,
    /// Number of members of the current list to which a predicate has been applied.
    predicated: usize,
    /// Position at which a predicate may follow without a verb ("the cup is white, the saucer blue").
    predicate_at: Option<usize>,
    /// The relation that the last verb of the sentence stated ("the left one holds ..., the right one ...").
    gap: Option<LinkKind>,
    /// The edge of the table that the sentence has named.
    last_edge: Option<RelationKind>,
    /// The list of the sentence before; "the former" and "the latter" refer to it.
    last_list: Vec<usize>,
    /// The referent of "it" when the sentence before ended.
    last_salient: Option<usize>,
    /// The object of the last preposition and the position after it, for a relative clause.
    last_target: Option<(usize, usize)>,
    /// The subject of "each plate has ...".
    each_subject: Option<usize>,
    /// A set of which the text is about to name the members ("some fruit, such as ...").
    open_set: Option<usize>,
    /// Group that every following member of the list is ("two towers: ..."); a stack is no group.
    each_member: Option<Option<Group>>,
    /// Arrangement of the next phrase ("stack three saucers", "line up four mugs").
    arranged_next: Option<(Frame, Range<usize>)>,
    /// An arrangement that the following members of the list join.
    open_group: Option<usize>,
    /// Whether the next preposition applies to the whole list ("all in a basket").
    all_members: bool,
    /// States of mentions, also those that cannot be shown.
    stated: Vec<(usize, String)>,
    /// Whether an instruction has been read; later clauses may continue it.
    instructed: bool,
    /// Referent of "it" before the current instruction.
    before_action: Option<usize>,
    /// Objects of the last instruction.
    acted: Vec<usize>,
    /// Objects of instructions that a later sentence may introduce ("put the eggs in the bowl; there are two eggs").
    expected: Vec<usize>,
    /// Objects of "each egg".
    each: Vec<usize>,
    /// The objects that have fallen, and from what.
    fallen: Option<(Vec<usize>, action::Path)>,
    /// Containers that everything is to leave, with the words that ask for it.
    emptied: Vec<(usize, Range<usize>)>,
    /// Objects that may be there, and need not.
    permitted: Vec<usize>,
    /// Whether the text tells what the robot does ("picks the cup and puts it down").
    is_narrated: bool,
    /// Numbers of links and goals when the sentence began.
    at_sentence: (usize, usize),
    /// The verb that arranges the objects of the sentence on the table, and the first mention after it.
    arranging: Option<(Range<usize>, usize)>,
    stand_ins: bool,
}

/// Maximum number of mentions that are read; a scene has fewer objects.
const MAX_MENTIONS: usize = 256;

/// Parses the whole text. Without stand-ins, nouns outside the catalog are reported.
pub(super) fn parse(lexicon: &Lexicon, source: &Source, stand_ins: bool) -> ParsedText {
    let account = Account::new(source.tokens.len());
    let mut reader = Parser {
        lexicon,
        source,
        tokens: &source.tokens,
        at: 0,
        parsed: ParsedText { account, ..ParsedText::default() },
        subject: Vec::new(),
        salient: None,
        salient_list: Vec::new(),
        pending: Vec::new(),
        pending_places: Vec::new(),
        pending_each: None,
        pending_pronoun: false,
        pending_per_person: false,
        pending_corners: false,
        after_and: false,
        joined: false,
        clause_start: true,
        chain: None,
        split: None,
        parts: Vec::new(),
        selected_parts: Vec::new(),
        predicated: 0,
        predicate_at: None,
        gap: None,
        last_edge: None,
        last_list: Vec::new(),
        last_salient: None,
        last_target: None,
        each_subject: None,
        open_set: None,
        each_member: None,
        arranged_next: None,
        open_group: None,
        all_members: false,
        stated: Vec::new(),
        instructed: false,
        before_action: None,
        acted: Vec::new(),
        expected: Vec::new(),
        each: Vec::new(),
        fallen: None,
        emptied: Vec::new(),
        permitted: Vec::new(),
        is_narrated: false,
        at_sentence: (0, 0),
        arranging: None,
        stand_ins,
    };
    while reader.at < reader.tokens.len() && reader.parsed.mentions.len() < MAX_MENTIONS {
        let before = reader.at;
        reader.step();
        if reader.at <= before {
            reader.at = before + 1;
        }
    }
    reader.end_sentence();
    reader.leave_emptied();
    reader.drop_excluded();
    reader.parsed
}

impl<'a> Parser<'a, '_> {
    fn word(&self, ahead: usize) -> Option<&'a str> {
        word(self.tokens, self.at + ahead)
    }

    fn word_at(&self, at: usize) -> Option<&'a str> {
        word(self.tokens, at)
    }

    fn report(&mut self, tokens: Range<usize>, reason: UnrecognizedReason) {
        self.parsed.account.report(tokens, reason);
    }

    fn end_clause(&mut self) {
        if !self.subject.is_empty() {
            self.salient_list = self.subject.clone();
        }
        if self.subject.len() > 1 {
            self.last_list = self.subject.clone();
        }
        self.last_salient = self.salient;
        self.end_split();
        self.subject.clear();
        for pending in std::mem::take(&mut self.pending) {
            // Claimed if a phrase has followed.
            if !self.parsed.account.is_claimed(&pending.tokens) {
                self.report(pending.tokens, UnrecognizedReason::NoReferent);
            }
        }
        self.parts.clear();
        (self.predicated, self.predicate_at) = (0, None);
        (self.gap, self.last_edge, self.each_member) = (None, None, None);
        (self.each_subject, self.open_set) = (None, None);
        self.pending_places.clear();
        self.pending_each = None;
        self.pending_pronoun = false;
        self.pending_per_person = false;
        (self.after_and, self.joined) = (false, false);
        self.chain = None;
        self.open_group = None;
        self.all_members = false;
        self.clause_start = true;
    }

    fn is_table_word(word: &str) -> bool {
        matches!(
            word,
            "table"
                | "desk"
                | "tabletop"
                | "workbench"
                | "bench"
                | "surface"
                | "counter"
                | "countertop"
                | "it"
                | "workspace"
        )
    }

    /// A phrase in subject position.
    fn noun(&mut self, phrase: NounPhrase) {
        if phrase.negated {
            self.exclude(phrase);
            return;
        }
        self.begin_clause();
        if phrase.head == Head::One && self.elliptic(&phrase) {
            return;
        }
        if let Some(level) = self.stack_level(&phrase) {
            self.apply_pending(level);
            self.subject.push(level);
            self.salient = Some(level);
            self.salient_list = self.subject.clone();
            return;
        }
        // "one is green, the rest are white" says nothing more of the first.
        if phrase.selector == Some(Selector::Other) && self.finite_verb_at(self.at) {
            self.subject.clear();
        }
        let phrase = self.at_another_place(phrase);
        let like_before = self.is_like_before(&phrase);
        let each = phrase.determiner == Determiner::Each;
        let described = self.shares_adjectives(&phrase);
        let on_stack = self.continues_stack(&phrase);
        // "a bowl of apples".
        let of = self.word(0) == Some("of");
        let referred = matches!(phrase.head, Head::It | Head::Them);
        let is_table = phrase.is_table();
        match self.refer(phrase, false) {
            Referent::Mentions(list) => {
                for &mention in &list {
                    if !referred {
                        self.apply_pending(mention);
                    }
                    // The phrase read last is the one that follows the others.
                    self.subject.retain(|&member| member != mention || referred);
                    if !self.subject.contains(&mention) {
                        self.subject.push(mention);
                    }
                    if let Some(group) = self.open_group
                        && let Some(arrangement) = self.parsed.arrangements.get_mut(group)
                        && !arrangement.mentions.contains(&mention)
                    {
                        arrangement.mentions.push(mention);
                    }
                }
                if !self.pending_pronoun {
                    self.salient = list.last().copied().or(self.salient);
                }
                self.salient_list = self.subject.clone();
                self.joined = std::mem::take(&mut self.after_and);
                self.all_members = false;
                self.each_subject = list.last().copied().filter(|_| each);
                if let (Some(first), [mention]) = (described, &list[..]) {
                    self.share_adjectives(first, *mention);
                }
                if let (Some(below), [mention]) = (on_stack, &list[..]) {
                    let kind = LinkKind::Relation(RelationKind::On);
                    self.parsed.links.push(Link::new(*mention, kind, below));
                }
                if !referred && let [mention] = list[..] {
                    self.arrange_member(mention, like_before);
                    self.join_open_set(mention);
                }
                if of && let Some(&vessel) = list.last() {
                    self.contents_of(vessel);
                }
                if let Some(&host) = list.last() {
                    self.gapped(host);
                }
            }
            Referent::Table => {
                self.subject.clear();
                if is_table {
                    self.table_attributes();
                }
            }
            Referent::Nothing => {}
        }
        self.chain = None;
    }

    /// Applies what stands before a phrase to its mention.
    fn apply_pending(&mut self, mention: usize) {
        if let Some((frame, tokens)) = self.arranged_next.take() {
            if frame == Frame::Stack && matches!(self.word_at(tokens.start), Some("pile" | "heap")) {
                self.parsed.mentions[mention].stacked = true;
                self.claim_property(tokens.clone(), Property::Arrangement, vec![mention]);
                self.grouped(mention, Group::Pile, None, tokens);
            } else if frame == Frame::Stack {
                self.parsed.mentions[mention].stacked = true;
                self.claim_property(tokens, Property::Arrangement, vec![mention]);
            } else {
                self.arrange(vec![mention], Group::Row, None, tokens);
                // "line up a fork, a spoon and a knife".
                if !self.is_several(mention) {
                    self.open_group = Some(self.parsed.arrangements.len() - 1);
                }
            }
        }
        for pending in self.pending.clone() {
            for &target in &pending.targets {
                self.relate(mention, &pending, target);
            }
        }
        for (place, tokens) in self.pending_places.clone() {
            self.set_place(mention, place, tokens);
        }
        if let Some(each) = self.pending_each {
            self.parsed.mentions[mention].each_of = Some(each);
        }
        if std::mem::take(&mut self.pending_corners) {
            self.parsed.mentions[mention].corners = true;
            self.parsed.mentions[mention].count = Some([4, 4]);
        }
        if self.pending_per_person {
            self.parsed.mentions[mention].per_person = true;
        }
    }

    /// Attributes of the table after a verb: "the desk is white".
    fn table_attributes(&mut self) {
        if !matches!(self.word(0), Some("is")) {
            return;
        }
        let Some((attributes, properties, end)) =
            super::phrase::predicate(self.lexicon, self.tokens, self.at + 1)
        else {
            return;
        };
        let shape = self.table_shape();
        let contradicts = self.is_other_shape(shape.as_deref(), attributes.shape.as_deref());
        for (property, range) in properties {
            if contradicts && property == Property::Shape {
                self.report(range, UnrecognizedReason::Contradiction);
            } else {
                self.parsed.account.claim(range, Claimed::Table);
            }
        }
        if let Some((_, known)) = &mut self.parsed.table {
            let shape = if contradicts { shape } else { attributes.shape.clone() };
            references::merge(known, super::phrase::Attributes { shape, ..attributes });
        }
        self.at = end;
    }

    /// Adds a claim of a property of mentions.
    fn claim_property(&mut self, tokens: Range<usize>, property: Property, mentions: Vec<usize>) {
        self.parsed.account.claim(tokens, Claimed::Property { property, mentions });
    }
}
