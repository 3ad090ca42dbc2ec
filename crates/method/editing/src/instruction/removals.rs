//! Commands that remove objects, take them out of others, or replace them.

use super::Reason;
use super::cursor::{Cursor, Outcome};
use super::discourse::{Target, is_plural};
use super::nouns::{NewObjects, definite};
use scene::{EditOperation, EditPlace, RelationKind};

const SOURCES: &[&str] = &["out of", "off of", "off", "from", "away", "out"];

/// Phrases that remove an object with everything on or in it.
const CONTENTS: &[&str] = &[
    "with everything on it",
    "with everything in it",
    "with everything inside",
    "with its contents",
    "with all its contents",
    "with their contents",
    "with what is on it",
    "with what is in it",
    "including its contents",
    "including everything on it",
    "including everything in it",
    "along with everything on it",
    "along with everything in it",
    "together with its contents",
    "together with everything on it",
    "and everything on it",
    "and everything in it",
    "and its contents",
];

const WHOLE_TABLE: &[&str] =
    &["from the table", "off the table", "from the scene", "off the desk", "from the desk", "off my desk"];

impl Cursor {
    /// Removal, or a move where something is taken out of or off something.
    pub fn remove(&mut self, takes: bool) -> Outcome<()> {
        let start = self.at;
        let stops = |cursor: &Self, index: usize| {
            let source = cursor.length_of_any(index, SOURCES).is_some();
            (source && !cursor.is_rank_origin(cursor.at, index))
                || cursor.length_of_any(index, CONTENTS).is_some()
        };
        let targets = self.targets(&stops)?;
        let away =
            self.is_at(self.at, "away") || (self.is_at(self.at, "out") && !self.is_at(self.at, "out of"));
        self.at += usize::from(away);
        let with_contents = self.take_any(CONTENTS);
        let begins = |index: usize| ["put", "place", "set", "lay", "move"].contains(&self.word(index));
        let next = self.at + self.connector_at(self.at);
        if takes && next > self.at && begins(next) && matches!(self.word(next + 1), "it" | "them") {
            self.now_about(&targets, self.operations.len());
            return Ok(());
        }
        let removed = self.take_any(WHOLE_TABLE) || away || with_contents || !takes;
        if removed && !stops(self, self.at) {
            let first = self.operations.len();
            for target in &targets {
                let phrase = target.phrase.clone();
                if is_table(&phrase) {
                    return Err(self.error(start, self.at, Reason::Table));
                }
                self.change(target, EditOperation::Remove { target: phrase, with_contents }, start)?;
            }
            self.now_about(&targets, first);
            return Ok(());
        }
        let from = self.at;
        let inside = self.take("out of");
        if !takes || !(inside || self.take_any(&["off of", "off"])) {
            return Err(self.error(start, self.phrase_end(start, &|_| false), Reason::RemoveFrom));
        }
        let source_start = self.at;
        let source = self.phrase_end(source_start, &|index| self.preposition_at(index).is_some());
        self.at = source;
        let preposition = if inside { "in" } else { "on" };
        let source = self.target_text(source_start, source);
        if source.is_empty() {
            return self.not_understood(from, "name the object that it is on or in");
        }
        let targets: Vec<Target> = targets
            .into_iter()
            .map(|target| Target { phrase: format!("{} {preposition} {source}", target.phrase), ..target })
            .collect();
        let place = EditPlace { relation: Some(RelationKind::On), ..EditPlace::default() };
        self.placed(&targets, &place, start)
    }

    /// "replace X with Y", "swap X for Y".
    pub fn replace(&mut self, verb: usize, separators: &'static [&'static str]) -> Outcome<()> {
        let start = self.at;
        let targets = self.targets(&|cursor, index| cursor.length_of_any(index, separators).is_some())?;
        if !self.take_any(separators) {
            let two = targets.len() > 1 || matches!(self.word(verb), "swap" | "exchange");
            let reason = if two {
                Reason::Swap
            } else {
                Reason::NotUnderstood("say what replaces it: with a wine glass")
            };
            return Err(self.error(verb, self.at, reason));
        }
        if self.is_definite(self.at) {
            return Err(self.error(verb, self.phrase_end(self.at, &|_| false), Reason::Swap));
        }
        let end = self
            .phrase_end(self.at, &|index| self.preposition_at(index).is_some() || self.is_at(index, "with"));
        let from = self.at;
        let plural_targets = targets.len() > 1 || targets.iter().any(|target| is_plural(&target.phrase));
        let object = match self.new_objects(end)? {
            NewObjects::Objects { object, count } if count == 1 || plural_targets => object,
            _ => return Err(self.error(from, end, Reason::OneForOne)),
        };
        if targets.iter().any(|target| is_table(&target.phrase)) {
            return Err(self.error(verb, self.at, Reason::Table));
        }
        for target in &targets {
            let operation = EditOperation::Replace { target: target.phrase.clone(), object: object.clone() };
            self.change(target, operation, start)?;
        }
        let phrase = definite(&object, 1);
        self.now_about_new(vec![phrase], Vec::new(), plural_targets);
        Ok(())
    }
}

/// Whether the phrase names the table.
pub(super) fn is_table(phrase: &str) -> bool {
    let lower = phrase.to_lowercase();
    let noun = ["the ", "my ", "this ", "our "].iter().find_map(|article| lower.strip_prefix(article));
    crate::references::vocabulary().is_table(noun.unwrap_or(&lower))
}
