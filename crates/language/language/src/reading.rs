//! The reading of a text: the sequence of clauses that leaves the fewest words unread at the smallest cost.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::chart::{Chart, Referents};
use crate::clause::Clause;
use crate::construction::{Act, Construction};

/// Cost of a word that is part of nothing.
const UNREAD: f64 = 12.0;
/// Cost of a clause, so that of equal readings the one with fewer is taken.
const CLAUSE: f64 = 0.4;
/// Cost of polite and joining words.
const PARTICLE: f64 = 0.05;
/// Cost of a clause that begins without a joining word before it.
const UNJOINED: f64 = 4.0;

/// A text as clauses.
#[derive(Debug)]
pub(crate) struct Reading {
    pub clauses: Vec<Clause>,
    /// Tokens that are part of nothing, in order.
    pub unread: Vec<Range<usize>>,
}

/// A reading of the tokens before some index.
#[derive(Clone)]
struct Hypothesis {
    cost: f64,
    clauses: Vec<Clause>,
    unread: Vec<usize>,
}

/// State that decides how a reading may go on: the act of the clause before, and whether a clause may begin.
type State = (Option<Act>, bool);

impl Chart<'_> {
    /// The reading of the whole text by these constructions.
    pub(crate) fn read(&self, constructions: &[Construction]) -> Reading {
        self.read_some(constructions, &|_| true)
    }

    /// As [`Self::read`], by those with some acts.
    pub(crate) fn read_some(&self, constructions: &[Construction], has_act: &dyn Fn(Act) -> bool) -> Reading {
        let length = self.tokens.len();
        let mut open: Vec<BTreeMap<State, Hypothesis>> = vec![BTreeMap::new(); length + 1];
        open[0].insert((None, true), Hypothesis { cost: 0.0, clauses: Vec::new(), unread: Vec::new() });
        for at in 0..length {
            let here = std::mem::take(&mut open[at]);
            if here.is_empty() {
                continue;
            }
            let fitting: Vec<(&Construction, Vec<_>)> = constructions
                .iter()
                .filter(|construction| has_act(construction.act))
                .map(|construction| (construction, self.clauses_at(at, construction)))
                .filter(|(_, spans)| !spans.is_empty())
                .collect();
            let particles = self.particles(at);
            for ((act, may_begin), hypothesis) in here {
                for &(end, is_stop) in &particles {
                    let mut next = hypothesis.clone();
                    next.cost += PARTICLE;
                    keep(&mut open[end], (act.filter(|_| !is_stop), true), next);
                }
                let mut skipped = hypothesis.clone();
                skipped.cost += UNREAD;
                skipped.unread.push(at);
                keep(&mut open[at + 1], (act, may_begin), skipped);
                let joint = if may_begin { 0.0 } else { UNJOINED };
                for (construction, spans) in &fitting {
                    let repeats = &construction.repeats;
                    if !repeats.is_empty() && act.is_none_or(|act| !repeats.contains(&act)) {
                        continue;
                    }
                    for span in spans.iter().filter(|span| span.end > at) {
                        let mut next = hypothesis.clone();
                        next.cost += span.cost + CLAUSE + joint;
                        let mut clause = span.value.clone();
                        // "move the mug there and a fork here": nothing new is made.
                        if clause.is_elliptic && clause.act == Act::Put && act == Some(Act::Move) {
                            clause.act = Act::Move;
                        }
                        // What is excepted or added says nothing of the verb.
                        let carried = if matches!(clause.act, Act::Except | Act::Likewise | Act::Aside) {
                            act
                        } else {
                            Some(clause.act)
                        };
                        let state = (carried, false);
                        next.clauses.push(clause);
                        keep(&mut open[span.end], state, next);
                    }
                }
            }
        }
        let last = std::mem::take(&mut open[length]);
        let best = last.into_values().min_by(|a, b| a.cost.total_cmp(&b.cost));
        let best = best.unwrap_or(Hypothesis { cost: 0.0, clauses: Vec::new(), unread: Vec::new() });
        Reading { clauses: best.clauses, unread: ranges(&best.unread) }
    }

    /// Ends of polite and joining words at an index, and whether a sentence ends there.
    fn particles(&self, at: usize) -> Vec<(usize, bool)> {
        let mut found = Vec::new();
        if self.word(at) == "." {
            found.push((at + 1, true));
        }
        for class in ["connector", "opening", "closing"] {
            found.extend(self.lengths(class, at).into_iter().map(|length| (at + length, false)));
        }
        found
    }
}

fn keep(open: &mut BTreeMap<State, Hypothesis>, state: State, next: Hypothesis) {
    match open.get(&state) {
        Some(known) if known.cost <= next.cost => {}
        _ => {
            open.insert(state, next);
        }
    }
}

fn ranges(indices: &[usize]) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for &index in indices {
        match found.last_mut() {
            Some(last) if last.end == index => last.end += 1,
            _ => found.push(index..index + 1),
        }
    }
    found
}

/// The clauses of an instruction for an edit, and the words that are part of none.
pub(crate) fn edits_of<'a>(text: &'a str, referents: &'a dyn Referents) -> (Chart<'a>, Reading) {
    let chart = Chart::new(text, referents);
    let reading = chart.read(crate::construction::edits());
    (chart, reading)
}

/// The clauses of an instruction for a robot: those of edits that make, change or name no objects.
pub(crate) fn tasks_of<'a>(text: &'a str, referents: &'a dyn Referents) -> (Chart<'a>, Reading) {
    let chart = Chart::new(text, referents);
    let reading = chart.read_some(crate::construction::edits(), &|act| {
        !matches!(
            act,
            Act::Add
                | Act::Remove
                | Act::RemoveWithContents
                | Act::Replace
                | Act::Resize
                | Act::Grow
                | Act::Shrink
                | Act::Recolor
                | Act::Rename
                | Act::Tidy
                | Act::Clutter
                | Act::Rearrange
                | Act::Remake
                | Act::SetPhysics
                | Act::RestyleTable
                | Act::Relight
                | Act::MoveCamera
                | Act::Likewise
        )
    });
    (chart, reading)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::EnglishNouns;
    use crate::construction::examples;

    #[test]
    fn every_example_is_one_clause_with_its_act() {
        let mut wrong = Vec::new();
        for (act, text) in examples() {
            let (_, reading) = edits_of(&text, &EnglishNouns);
            let acts: Vec<Act> = reading.clauses.iter().map(|clause| clause.act).collect();
            if acts != [act] || !reading.unread.is_empty() {
                wrong.push(format!("{act:?}: {text}: {acts:?}, unread {:?}", reading.unread));
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }
}
