//! Events before the instruction ("the pen fell out of the cup, put it back"), states that are to end ("the mug should
//! no longer be on the tray"), and containers that everything is to leave.

use std::ops::Range;

use super::action::{Action, Part, Path, PathKind};
use super::goals::{GoalDraft, GoalKind};
use super::{LinkKind, Parser, Referent};
use crate::text_parser::phrase::noun_phrase;
use crate::text_parser::phrases::phrases;
use crate::text_parser::prepositions::preposition_at;
use crate::text_parser::property::Property;
use crate::text_parser::tokens::Token;
use crate::text_parser::verbs::Frame;
use scene::RelationKind;
use scene::text_account::PredicateKind;

impl Parser<'_, '_> {
    /// After a subject: what has happened to it, or that it stays. Whether the rule applies.
    pub(super) fn happened(&mut self) -> bool {
        if self.subject.is_empty() {
            return false;
        }
        self.falls() || self.leaves_state() || self.remains()
    }

    /// "fell off the plate", "has rolled out of the box", "fell over".
    fn falls(&mut self) -> bool {
        let start = self.at;
        let mut p = start;
        while matches!(self.word_at(p), Some("has" | "have" | "was" | "were" | "just" | "got" | "is")) {
            p += 1;
        }
        if !self.word_at(p).is_some_and(|word| phrases().list.falls.has(word)) {
            return false;
        }
        p += 1;
        if matches!(self.word_at(p), Some("over" | "down"))
            && !matches!(self.word_at(p + 1), Some("the" | "a"))
        {
            self.at = p + 1;
            let subject = self.subject.clone();
            self.claim_property(start..self.at, Property::State, subject.clone());
            for mention in subject {
                self.parsed.mentions[mention].pose = scene::description::RequestedPose::LyingOnSide;
            }
            return true;
        }
        let (kind, length) = match (self.word_at(p), self.word_at(p + 1)) {
            (Some("off"), Some("of")) => (RelationKind::On, 2),
            (Some("off"), _) => (RelationKind::On, 1),
            (Some("out"), Some("of" | "from")) => (RelationKind::In, 2),
            (Some("from"), _) => (RelationKind::On, 1),
            _ => return false,
        };
        let at = p + length;
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, at) else { return false };
        self.parsed.account.used(start..end);
        self.at = end;
        let subject = self.subject.clone();
        if let Referent::Mentions(targets) = self.refer(phrase, true) {
            let path = self.path(PathKind::Relation(kind), start..at);
            let path =
                if self.word_at(p) == Some("from") { Path { kind: PathKind::At, ..path } } else { path };
            self.fallen = Some((subject.clone(), Path { targets, directed: true, ..path }));
        }
        self.salient = subject.last().copied();
        self.salient_list = subject;
        true
    }

    /// The place that an object has fallen from, for "put it back".
    pub(super) fn place_before(&self, action: &Action) -> Option<Path> {
        let returns = matches!(self.word_at(action.verb.start), Some("return" | "restore" | "replace"))
            || action.verb.clone().any(|at| self.word_at(at) == Some("back"))
            || action.particles.iter().any(|range| self.word_at(range.start) == Some("back"));
        let (objects, path) = self.fallen.as_ref()?;
        let same = action.objects.iter().all(|part| objects.contains(&part.mention));
        (returns && same).then(|| path.clone())
    }

    /// "should no longer be on the book", "must not be in the bowl anymore".
    fn leaves_state(&mut self) -> bool {
        let start = self.at;
        let joined = matches!(self.word(0), Some("shouldnt" | "mustnt"));
        let modal = if joined { 1 } else { self.modal_length(start) };
        let mut p = start + modal;
        let not = self.longest(&["not", "no longer", "never", "no more"], p);
        if modal == 0 || !joined && not == 0 {
            return false;
        }
        p += not;
        p += usize::from(matches!(self.word_at(p), Some("be" | "stay" | "stand" | "lie" | "remain" | "sit")));
        let Some((preposition, length)) = preposition_at(self.tokens, p) else { return false };
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, p + length) else { return false };
        if phrase.is_table() || preposition.inverse || !preposition.kind.is_support() {
            return false;
        }
        let after = self.longest(&["anymore", "any more", "any longer", "at the end", "in the end"], end);
        self.parsed.account.used(start..end + after);
        let subject = self.subject.clone();
        self.at = end + after;
        if let Referent::Mentions(targets) = self.refer(phrase, true) {
            let mut action = self.new_action(Frame::Take, start..p);
            action.objects = subject.into_iter().map(|mention| Part { mention, take: None }).collect();
            let path = self.path(PathKind::Relation(preposition.kind), p..p + length);
            action.sources.push(Path { targets, ..path });
            self.conclude(action);
        }
        self.instructed = true;
        self.parsed.instructions.push(start..self.at);
        self.subject.clear();
        true
    }

    /// "stays where it is", "remains untouched".
    fn remains(&mut self) -> bool {
        if !matches!(self.word(0), Some("stays" | "stay" | "remains" | "remain")) {
            return false;
        }
        let manner = [
            "where it is",
            "where they are",
            "in place",
            "put",
            "there",
            "untouched",
            "as it is",
            "as they are",
            "in its place",
            "where it was",
            "unmoved",
        ];
        let length = 1 + self.longest(&manner, self.at + 1);
        let ends = matches!(self.tokens.get(self.at + length), None | Some(Token::Pause | Token::End))
            || self.word(length) == Some("and");
        if length == 1 && !ends && preposition_at(self.tokens, self.at + 1).is_none() {
            return false;
        }
        self.parsed.account.used(self.at..self.at + length);
        self.at += length;
        // "the apple stays in the bowl and the pear goes on the plate".
        if length == 1
            && let Some((preposition, words)) = preposition_at(self.tokens, self.at)
            && let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at + words)
            && !phrase.is_table()
            && !preposition.inverse
            && preposition.kind.is_support()
        {
            let path = self.path(PathKind::Relation(preposition.kind), self.at..self.at + words);
            self.at = end;
            let subject = std::mem::take(&mut self.subject);
            if let Referent::Mentions(targets) = self.refer(phrase, true) {
                self.start_relation(&subject, &Path { targets, ..path });
            }
        }
        true
    }

    /// Everything leaves the host; what it holds may be said later.
    pub(super) fn empties(&mut self, host: usize, tokens: Range<usize>) {
        self.parsed.account.used(tokens.clone());
        self.emptied.push((host, tokens));
        self.salient = Some(host);
        self.instructed = true;
    }

    /// Whether the instruction is that everything leaves something: "unload the rack", "take everything out of the
    /// box".
    pub(super) fn empties_host(&mut self, action: &Action) -> bool {
        if !action.paths.is_empty() || !action.tools.is_empty() {
            return false;
        }
        let verb = self.word_at(action.verb.start);
        let hosts: Vec<usize> = match action.objects[..] {
            [one] if action.sources.is_empty() && matches!(verb, Some("unload" | "unpack" | "empty")) => {
                vec![one.mention]
            }
            _ if action.everything => Self::targets(&action.sources),
            _ => return false,
        };
        for &host in &hosts {
            self.empties(host, action.verb.clone());
        }
        for path in &action.sources {
            self.parsed.account.used(path.tokens.clone());
        }
        !hosts.is_empty()
    }

    /// States at the end of the text that what the emptied hosts hold leaves them.
    pub(super) fn leave_emptied(&mut self) {
        for (host, tokens) in std::mem::take(&mut self.emptied) {
            let mut held: Vec<usize> = self
                .parsed
                .links
                .iter()
                .filter(|link| link.to == host && link.from != host)
                .filter(|link| match link.kind {
                    LinkKind::Relation(kind) => kind.is_support(),
                    LinkKind::With | LinkKind::At => true,
                    _ => false,
                })
                .map(|link| link.from)
                .collect();
            // "a cup and a plate are in it": the members of the list before the last.
            let is_placed = |m: usize| {
                self.parsed.links.iter().any(|link| {
                    link.from == m && matches!(link.kind, LinkKind::Relation(kind) if kind.is_support())
                })
            };
            let mut more = Vec::new();
            for &last in &held {
                let start = |m: usize| self.parsed.mentions[m].tokens.clone();
                let joined = (host + 1..last).rev().take_while(|&m| {
                    !is_placed(m)
                        && start(m).end <= start(last).start
                        && start(m).start > tokens.end
                        && (start(m).end..start(last).start).all(|at| {
                            !matches!(self.tokens[at], Token::End)
                                && !self.word_at(at).is_some_and(|word| matches!(word, "is" | "are" | "it"))
                        })
                });
                more.extend(joined.map(|m| (m, last)));
            }
            for (object, last) in more {
                let link =
                    self.parsed.links.iter().find(|link| link.from == last && link.to == host).copied();
                self.parsed.links.extend(link.map(|link| super::Link { from: object, ..link }));
                held.push(object);
            }
            if held.is_empty() {
                self.not_expressible(tokens);
                continue;
            }
            for object in held {
                let goal = GoalDraft::new(PredicateKind::Off, object).to(host);
                self.add_goal(GoalDraft { kind: GoalKind::AwayFromSupport, ..goal }, tokens.clone());
            }
        }
    }
}
