//! Commands that give objects another place: move, put, stack.

use super::Reason;
use super::cursor::{Cursor, Outcome};
use super::discourse::Target;
use scene::{EditOperation, EditPlace};

impl Cursor {
    /// Objects that exist get another place. `moves` is true for verbs whose destination begins with "to".
    pub fn relocate(&mut self, moves: bool) -> Outcome<()> {
        let start = self.at;
        let mut targets = Vec::new();
        loop {
            let from = self.at;
            if let Some(found) = self.pronoun()? {
                targets.extend(found);
            } else {
                let end = self.destination(from, moves)?;
                self.at = end;
                let phrase = self.target_text(from, end).replacen(
                    " from the ",
                    " on the ",
                    usize::from(!self.has_rank(from, end)),
                );
                self.discourse.mention(&phrase, false);
                targets.push(Target { phrase, pronoun: false });
            }
            let next = self.at + self.connector_at(self.at);
            if next == self.at || !self.is_phrase(next) {
                break;
            }
            self.at = next;
        }
        let top =
            ["on top of each other", "on top of one another", "on each other", "into a stack", "in a stack"];
        if self.take_any(&top) {
            return self.stacked(&targets);
        }
        let _ = self.word(self.at) == "," && self.preposition_at(self.at + 1).is_some() && self.take(",");
        if self.preposition_at(self.at).is_none() {
            return self
                .not_understood(start, "say where it goes: to the left of the laptop, 10 cm to the left");
        }
        if self.is_at(self.at, "closer") {
            return self.not_understood(
                self.at,
                "\"closer\" needs a distance: 10 cm to the left, or next to the laptop",
            );
        }
        let place = self.place()?;
        // What all the others are put on stays where it is.
        for target in &mut targets {
            if let Some(landmark) = place.target.as_ref().filter(|_| target.phrase == "everything") {
                target.phrase = format!("everything except {landmark}");
            }
        }
        self.discourse.place = Some(place.clone()).filter(|place| place.offset_m.is_none());
        self.placed(&targets, &place, start)
    }

    /// Existing objects at the place.
    pub fn placed(&mut self, targets: &[Target], place: &EditPlace, start: usize) -> Outcome<()> {
        let first = self.operations.len();
        for target in targets {
            if self.moved_where_made(target, place) {
                continue;
            }
            let operation = EditOperation::Move { target: target.phrase.clone(), place: place.clone() };
            self.change(target, operation, start)?;
        }
        self.now_about(targets, first);
        Ok(())
    }

    /// "add two forks and put them next to the plate" adds them there.
    pub fn moved_where_made(&mut self, target: &Target, place: &EditPlace) -> bool {
        let Some(topic) = self.discourse.topic.as_ref().filter(|_| target.pronoun) else { return false };
        let position = topic.phrases.iter().position(|phrase| *phrase == target.phrase);
        let made_at = position.and_then(|position| topic.made_at.get(position)).copied();
        match made_at.and_then(|index| self.operations.get_mut(index)) {
            Some(EditOperation::Add { place: made, .. }) if made.is_none() && place.offset_m.is_none() => {
                *made = Some(place.clone());
                true
            }
            _ => false,
        }
    }

    pub fn has_rank(&self, from: usize, to: usize) -> bool {
        (from..to).any(|index| self.is_rank_origin(from, index))
    }

    /// Index of the token at which the destination begins, which is the end of the phrase for the object.
    pub fn destination(&self, start: usize, moves: bool) -> Outcome<usize> {
        let end = self.phrase_end(start, &|_| false);
        let mut places = Vec::new();
        let mut at = self.head_end(start);
        while at < end {
            if self.is_rank_origin(start, at) {
                at += 3;
                continue;
            }
            // "back by 5 cm" is one place.
            if self.is_at(at, "by")
                && let Some((_, length)) = self.distance_at(at + 1)
            {
                at += 1 + length;
                continue;
            }
            if self.is_at(at, "closer") {
                return Ok(at);
            }
            match self.preposition_at(at) {
                Some(length) => {
                    places.push(at);
                    at += length;
                }
                None => at += 1,
            }
        }
        let directed = |&&index: &&usize| {
            let distance = self.distance_at(index).map_or(0, |(_, length)| length);
            let on_side = self.word(index) == "to" || matches!(self.word(index), "onto" | "into" | "towards");
            on_side || distance > 0
        };
        let source = |index: usize| self.is_at(index, "from the");
        match places[..] {
            [] => Ok(end),
            [only] => Ok(only),
            [first, second, ..] if source(first) => Ok(second),
            [first, ..] if directed(&&first) || self.is_at(first, "between") => Ok(first),
            _ => match places.iter().find(directed) {
                Some(&index) if moves || !self.is_at(index, "to") => Ok(index),
                // "on the table" says nothing about which object.
                _ if self.is_at(places[0], "on the table") => Ok(places[0]),
                Some(&index) => Ok(index),
                None => Err(self.error(start, end, Reason::Attachment)),
            },
        }
    }

    /// "stack the books", "stack A on B".
    pub fn stack(&mut self) -> Outcome<()> {
        let onto = ["on top of", "onto", "on", "upon", "atop", "up", "in a", "into a", "neatly"];
        let targets = self.targets(&|cursor, index| cursor.length_of_any(index, &onto).is_some())?;
        let all = [
            "on top of each other",
            "on top of one another",
            "on each other",
            "up",
            "in a pile",
            "in a stack",
            "into a stack",
            "into a pile",
            "neatly",
        ];
        if self.take_any(&all) {
            return self.stacked(&targets);
        }
        if !self.take_any(&["on top of", "onto", "on", "upon", "atop"]) {
            return self.stacked(&targets);
        }
        let start = self.at;
        let end = self.phrase_end(start, &|_| false);
        self.at = end;
        let mut below = vec![Target { phrase: self.target_text(start, end), pronoun: false }];
        if end == start || matches!(self.word(start), "a" | "an") {
            return self.not_understood(start, "name the object below");
        }
        below.extend(targets);
        self.stacked(&below)
    }

    pub fn stacked(&mut self, targets: &[Target]) -> Outcome<()> {
        let first = self.operations.len();
        let operation =
            EditOperation::Stack { targets: targets.iter().map(|target| target.phrase.clone()).collect() };
        let changed = targets.iter().any(|target| target.pronoun)
            && self.discourse.topic.as_ref().is_some_and(|topic| topic.changed_at.is_some());
        if changed {
            let phrase = targets.first().map(|target| target.phrase.clone()).unwrap_or_default();
            return Err(self.error(self.at.saturating_sub(1), self.at, Reason::Changed(phrase)));
        }
        self.operations.push(operation);
        self.now_about(targets, first);
        Ok(())
    }
}
