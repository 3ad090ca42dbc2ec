//! Clauses that are not understood: with a verb of moving that no rule has read, or with a condition. Nothing in them
//! says where an object is at the start. Their objects stand apart from each other, and their words are reported.

use std::ops::Range;

use super::{Link, LinkKind, Parser};
use crate::text_parser::account::{Claim, Claimed};
use crate::text_parser::phrase::{Determiner, Head, noun_phrase};
use crate::text_parser::phrases::phrases;
use crate::text_parser::tokens::Token;
use crate::text_parser::verbs::{Frame, verbs};
use scene::RelationKind;
use scene::text_account::UnrecognizedReason;

/// Words before "if" of a polite request ("it would be nice if").
const POLITE: &[&str] = &[
    "nice",
    "great",
    "good",
    "lovely",
    "helpful",
    "kind",
    "it",
    "grateful",
    "glad",
    "happy",
    "as",
    "even",
    "wonder",
    "wondering",
    "ask",
    "see",
    "check",
    "know",
];

impl Parser<'_, '_> {
    /// A verb of moving at the current position that no rule has read ("for safety place the mug on the plate"). Before
    /// the first object of its sentence it is an instruction, elsewhere only its objects are read. Whether the rule
    /// applies.
    pub(super) fn unread_verb(&mut self) -> bool {
        let p = self.at;
        let awaits_subject = !self.pending.is_empty() || !self.pending_places.is_empty();
        if awaits_subject && self.follows_fronted() {
            return false;
        }
        let action = self.word(0).is_some_and(|word| phrases().agent.actions.has(word));
        let named = (action && self.word(1) == Some("of")).then_some((Frame::Place, 2));
        let verb = named.or_else(|| verbs().at(self.tokens, p)).filter(|(frame, _)| moves(*frame));
        let (start, end) = self.sentence_at(p);
        match verb {
            Some((frame, length)) if self.governs_object(p, length) => {
                if self.has_objects(start..p) {
                    self.objects_only(p..end);
                    return true;
                }
                self.pending.clear();
                self.pending_places.clear();
                self.instructed = true;
                self.act(frame, p, length, Vec::new());
                self.parsed.instructions.push(p..self.at);
                self.subject.clear();
                true
            }
            None if self.is_unknown_verb(p) => {
                self.objects_only(p..end);
                true
            }
            _ => false,
        }
    }

    /// "on the left put the mug": the verb only introduces what stands at the place before it.
    fn follows_fronted(&self) -> bool {
        self.word(0).is_some_and(|word| verbs().is_base(word))
    }

    /// The sentence around a token.
    pub(super) fn sentence_at(&self, at: usize) -> (usize, usize) {
        let is_end = |p: &usize| self.tokens[*p] == Token::End;
        let start = (0..at).rev().find(is_end).map_or(0, |end| end + 1);
        (start, (at..self.tokens.len()).find(is_end).unwrap_or(self.tokens.len()))
    }

    /// Whether the verb at `p` has an object after it: what is known already, or anything after a verb that is no
    /// imperative.
    fn governs_object(&self, p: usize, length: usize) -> bool {
        let Some((phrase, _)) = noun_phrase(self.lexicon, self.tokens, p + length) else { return false };
        let is_base = self.word_at(p).is_some_and(|word| verbs().is_base(word));
        let is_progressive = self.word_at(p).is_some_and(|word| word.ends_with("ing"));
        let begins = p == 0 || self.tokens[p - 1] == Token::End;
        let is_known = phrase.determiner == Determiner::Definite || self.is_pronoun(p + length);
        let is_stative = self.word_at(p).is_some_and(|word| phrases().agent.stative.has(word));
        let governs = if is_progressive { is_known && begins } else { is_known || !is_base };
        governs && !phrase.negated && !phrase.is_table() && !is_stative && phrase.head != Head::One
    }

    fn is_pronoun(&self, at: usize) -> bool {
        matches!(self.word_at(at), Some("it" | "them" | "these" | "those" | "everything"))
    }

    /// "Alice flarps the apple": a word that is not known, between a subject and an object.
    fn is_unknown_verb(&self, p: usize) -> bool {
        let vocabulary = self.lexicon.vocabulary;
        let Some(word) = self.word_at(p).filter(|word| word.len() > 2) else { return false };
        let is_known = vocabulary.is_ordinary(word)
            || vocabulary.has_word(word)
            || self.lexicon.longest_at(self.tokens, p).is_some()
            || verbs().is_form(word)
            || self.lexicon.nouns.is_noun(word);
        let definite = matches!(self.word_at(p + 1), Some("the" | "it" | "them" | "its" | "both"));
        let follows_word = p > 0 && matches!(self.tokens[p - 1], Token::Word(_));
        !is_known && definite && follows_word && self.phrase_follows(p + 1)
    }

    fn has_objects(&self, range: Range<usize>) -> bool {
        self.parsed.account.claims.iter().any(|claim| {
            matches!(claim.meaning, Claimed::Object(_) | Claimed::Table)
                && range.contains(&claim.tokens.start)
        })
    }

    /// "if the apple is ripe put it in the bowl, otherwise on the plate": an instruction under a condition that no
    /// scene shows. Whether the rule applies.
    pub(super) fn undecided(&mut self) -> bool {
        let begins = self.at == 0 || self.tokens[self.at - 1] == Token::End;
        if !begins {
            return false;
        }
        let agent = &phrases().agent;
        let (start, end) = self.sentence_at(self.at);
        let instructs = |p: usize| {
            verbs().at(self.tokens, p).is_some_and(|(frame, length)| {
                moves(frame)
                    && self.word_at(p).is_some_and(|word| verbs().is_base(word))
                    && noun_phrase(self.lexicon, self.tokens, p + length).is_some()
            })
        };
        let is_condition = |p: usize| {
            let Some(length) = agent.conditions.longest_at(self.tokens, p) else { return false };
            let polite = p > 0 && self.word_at(p - 1).is_some_and(|word| POLITE.contains(&word));
            !polite && agent.formulas.longest_at(self.tokens, p + length).is_none()
        };
        let is_alternative = |p: usize| {
            let length = agent.alternatives.length_at(self.tokens, p);
            length > 0 && (verbs().at(self.tokens, p + length).is_some())
        };
        let depends = (start..end).any(|p| is_condition(p) || is_alternative(p));
        let obliges = |p: usize| self.is_obliged_move(p) && self.path_follows(p + 1);
        if !depends || !(start..end).any(|p| instructs(p) || obliges(p)) {
            return false;
        }
        self.objects_only(start..end);
        self.instructed = true;
        true
    }

    /// Whether a participle of moving at `p` is to happen: "should be put", "has to be moved", "is to be laid".
    fn is_obliged_move(&self, p: usize) -> bool {
        let moved = self.word_at(p).and_then(|word| verbs().participle(word)).is_some_and(moves);
        let is_passive =
            p > 0 && matches!(self.word_at(p - 1), Some("be" | "get" | "being" | "gets" | "getting"));
        let asks = |at: usize| {
            matches!(
                self.word_at(at),
                Some(
                    "should"
                        | "must"
                        | "shall"
                        | "will"
                        | "would"
                        | "may"
                        | "might"
                        | "could"
                        | "to"
                        | "gets"
                )
            )
        };
        moved && is_passive && (p.saturating_sub(6)..p).any(asks)
    }

    /// Ends a sentence. Where it says that objects are to be moved, and no rule has read that, nothing in it says where
    /// they are at the start.
    pub(super) fn end_sentence(&mut self) {
        let (links, goals) = self.at_sentence;
        let end = self.at.min(self.tokens.len());
        let start = (0..end).rev().find(|&p| self.tokens[p] == Token::End).map_or(0, |before| before + 1);
        let needs = |p: usize| {
            p > start
                && self.word_at(p - 1).is_some_and(|word| phrases().agent.needs.has(word))
                && self.word_at(p).is_some_and(|word| word.ends_with("ing"))
                && verbs().at(self.tokens, p).is_some_and(|(frame, _)| moves(frame))
        };
        let falls = |p: usize| {
            let word = self.word_at(p);
            word.is_some_and(|word| phrases().list.falls.has(word)) && self.is_directed(p + 1)
        };
        let account = &self.parsed.account;
        let states_goal = |from: usize| {
            let mut claims = account.claims.iter().filter(|claim| claim.tokens.start >= from);
            claims.any(|claim| matches!(claim.meaning, Claimed::Goal(_)))
        };
        let verb = (start..end)
            .find(|&p| !account.is_understood(p) && (self.is_obliged_move(p) || needs(p) || falls(p)))
            .filter(|&verb| !states_goal(verb));
        if let Some(verb) = verb {
            let from = if self.parsed.goals.len() == goals { start } else { verb };
            self.report(verb..verb + 1, UnrecognizedReason::NotExpressible);
            self.drop_relations(from, links);
        }
        self.end_arranging();
        self.end_clause();
        self.at_sentence = (self.parsed.links.len(), self.parsed.goals.len());
    }

    /// Reports the words of relations from a token on instead of relating the objects by links after the first ones.
    fn drop_relations(&mut self, from: usize, links: usize) {
        let is_relation = |claim: &Claim| {
            matches!(claim.meaning, Claimed::Relation { .. } | Claimed::Linked { .. })
                && claim.tokens.start >= from
        };
        let (dropped, others): (Vec<Claim>, Vec<Claim>) =
            std::mem::take(&mut self.parsed.account.claims).into_iter().partition(is_relation);
        self.parsed.account.claims = others;
        let relates = |link: &Link, claim: &Claim| match &claim.meaning {
            Claimed::Relation { from, to, .. } | Claimed::Linked { from, to } => {
                let pair =
                    |one: &[usize], other: &[usize]| one.contains(&link.from) && other.contains(&link.to);
                pair(from, to) || pair(to, from)
            }
            _ => false,
        };
        let mut at = 0;
        self.parsed.links.retain(|link| {
            at += 1;
            at <= links || !dropped.iter().any(|claim| relates(link, claim))
        });
        for claim in dropped {
            self.report(claim.tokens, UnrecognizedReason::NotExpressible);
        }
    }

    /// "position a cup and a plate": the verb says that what it arranges is on the table.
    fn end_arranging(&mut self) {
        let Some((verb, first)) = self.arranging.take() else { return };
        let is_carried = |mention: &usize| {
            self.parsed.links.iter().any(|link| {
                link.from == *mention && matches!(link.kind, LinkKind::Relation(kind) if kind.is_support())
            })
        };
        let from: Vec<usize> = (first..self.parsed.mentions.len()).filter(|m| !is_carried(m)).collect();
        if !from.is_empty() {
            self.parsed
                .account
                .claim(verb, Claimed::Relation { kind: RelationKind::On, from, to: Vec::new() });
        }
    }

    /// Reads the objects that the tokens name, and reports every other word.
    pub(super) fn objects_only(&mut self, range: Range<usize>) {
        self.at = range.start;
        while self.at < range.end {
            if let Some(length) = self.conjunction_at(self.at) {
                self.at += length;
                continue;
            }
            let is_verb = self.word(0).is_some_and(|word| verbs().is_form(word))
                && self.lexicon.longest_at(self.tokens, self.at).is_none();
            let agent = self.actor_length(self.at);
            let found = noun_phrase(self.lexicon, self.tokens, self.at)
                .filter(|(phrase, end)| !phrase.negated && *end <= range.end && !is_verb && agent.is_none());
            let Some((mut phrase, end)) = found else {
                self.at += agent.unwrap_or(1);
                continue;
            };
            let named = matches!(phrase.head, Head::Objects(_))
                || matches!(phrase.head, Head::Unknown(_)) && phrase.determiner == Determiner::Definite;
            if named || phrase.head == Head::It || phrase.head == Head::Them {
                self.bare_is_definite(&mut phrase);
                self.at = end;
                if let super::Referent::Mentions(list) = self.refer(phrase, false) {
                    self.salient = list.last().copied().or(self.salient);
                    self.salient_list = list;
                }
            }
            self.at = end;
        }
        self.report_open(range);
        self.subject.clear();
        self.pending.clear();
        self.pending_places.clear();
    }

    /// Reports runs of words that no rule has used.
    fn report_open(&mut self, range: Range<usize>) {
        let agent = &phrases().agent;
        let mut p = range.start;
        while p < range.end {
            let is_open = |p: usize| {
                p < range.end
                    && self.parsed.account.is_open(p)
                    && !matches!(self.tokens[p], Token::Pause | Token::End)
            };
            let length = (p..range.end).take_while(|&p| is_open(p)).count();
            let tells = (p..p + length).any(|p| {
                self.word_at(p).is_none_or(|word| {
                    !self.lexicon.vocabulary.grammar.ignorable.contains(word)
                        || verbs().is_form(word)
                        || agent.conditions.has(word)
                })
            });
            if tells {
                self.report(p..p + length, UnrecognizedReason::NotExpressible);
            }
            p += length.max(1);
        }
    }

    /// "you can find", "one may see": what follows is described. Whether the rule applies.
    pub(super) fn perceived(&mut self) -> bool {
        let agent = &phrases().agent;
        let Some(subject) = self.actor_length(self.at) else { return false };
        let modal = self.at + subject;
        let is_modal = matches!(
            self.word_at(modal),
            Some("can" | "could" | "may" | "might" | "will" | "would" | "should" | "must")
        );
        let verb = modal + usize::from(is_modal);
        let also = usize::from(matches!(self.word_at(verb), Some("also" | "now" | "even" | "still")));
        let length = agent.perceives.length_at(self.tokens, verb + also);
        if length == 0 {
            return false;
        }
        let end = verb + also + length;
        self.parsed.account.used(self.at..end);
        self.at = end;
        self.clause_start = true;
        true
    }
}

/// Whether the verb says that its object gets elsewhere.
pub(super) fn moves(frame: Frame) -> bool {
    matches!(
        frame,
        Frame::Place
            | Frame::Take
            | Frame::Lift
            | Frame::Hand
            | Frame::Stack
            | Frame::Swap
            | Frame::Push
            | Frame::Hang
            | Frame::Pour
    )
}
