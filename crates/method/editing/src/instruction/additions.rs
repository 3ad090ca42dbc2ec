//! Commands that make objects: add, put, "with a sandwich on it", "instead".

use super::Reason;
use super::clauses::Frame;
use super::cursor::{Cursor, Outcome};
use super::nouns::{NewObjects, definite};
use crate::references::vocabulary;
use catalog::stand_in::Obstacle;
use scene::{EditOperation, EditPlace, RelationKind};

impl Cursor {
    /// New objects, or a move where the objects exist: "put a mug on the tray", "put the mug on the tray".
    pub fn add_or_move(&mut self, frame: Frame) -> Outcome<()> {
        if self.is_definite(self.at) {
            // "set the mug's color to green"
            let owner = self.phrase_end(self.at, &|index| self.is_at(index, "'s"));
            if self.length_of_any(owner, &["'s color to", "'s colour to", "'s material to"]).is_some() {
                return self.change_to();
            }
            return self.relocate(frame == Frame::Move);
        }
        if frame == Frame::Move {
            return self.relocate(true);
        }
        self.add()
    }

    pub fn add(&mut self) -> Outcome<()> {
        let start = self.at;
        let mut items: Vec<(usize, NewObjects, Option<EditOperation>)> = Vec::new();
        loop {
            let from = self.at;
            let end = self
                .phrase_end(from, &|index| self.preposition_at(index).is_some() || self.is_at(index, "with"));
            let new = self.new_objects(end)?;
            if let NewObjects::Objects { object, count } = &new {
                self.discourse.mention(&definite(object, *count), false);
            }
            let with = self.added_with(&new)?;
            items.push((from, new, with));
            let next = self.at + self.connector_at(self.at);
            if next == self.at || !self.is_phrase(next) || self.is_definite(next) {
                break;
            }
            self.at = next;
        }
        // "give me a spoon, to the right of the bowl"
        if self.word(self.at) == "," && self.preposition_at(self.at + 1).is_some() {
            self.at += 1;
        }
        let pronoun_at = self.at;
        let instead = self.is_at(self.at, "there") || self.is_at(self.at, "in its place");
        let removed = self.discourse.topic.as_ref().is_some_and(|topic| topic.removed);
        let mut place = None;
        if instead && removed {
            self.at += if self.is_at(self.at, "there") { 1 } else { 3 };
            let _ = self.take("instead");
            return self.add_instead(start, &items);
        }
        if self.is_at(self.at, "instead") && removed {
            self.at += 1;
            return self.add_instead(start, &items);
        }
        let anywhere =
            self.take_any(&["anywhere on the table", "somewhere on the table", "anywhere", "somewhere"]);
        if !anywhere && self.preposition_at(self.at).is_some() {
            let found = self.place()?;
            if found.offset_m.is_some() {
                return Err(self.error(pronoun_at, self.at, Reason::OffsetOfNew));
            }
            let is_drink = |new: &NewObjects| match new {
                NewObjects::Objects { object, .. } => vocabulary().is_drink(object),
                NewObjects::Clutter { .. } => false,
            };
            if found.relation == Some(RelationKind::In) && items.iter().any(|(_, new, _)| is_drink(new)) {
                return Err(self.error(
                    start,
                    self.at,
                    Reason::NotPlaceable(Obstacle::Substance.explanation()),
                ));
            }
            place = Some(found);
        }
        self.discourse.place.clone_from(&place);
        let by_pronoun = (pronoun_at..self.at).any(|index| matches!(self.word(index), "it" | "that"));
        let (mut phrases, mut made_at, mut plural) = (Vec::new(), Vec::new(), false);
        for (_, new, with) in items {
            match new {
                NewObjects::Objects { object, count } => {
                    phrases.push(definite(&object, count));
                    plural |= count > 1;
                    let operation = EditOperation::Add { object, count, place: place.clone() };
                    made_at.push(if by_pronoun {
                        self.add_with_pronoun(operation)
                    } else {
                        self.operations.push(operation);
                        self.operations.len() - 1
                    });
                    self.operations.extend(with);
                }
                NewObjects::Clutter { count, theme } => {
                    if place.as_ref().is_some_and(|place| {
                        place.relation != Some(RelationKind::On) || place.target.is_some()
                    }) {
                        return Err(self.error(pronoun_at, self.at, Reason::ClutterPlace));
                    }
                    self.operations.push(EditOperation::Clutter { count, theme });
                }
            }
        }
        if !phrases.is_empty() {
            self.now_about_new(phrases, made_at, plural);
        }
        Ok(())
    }

    /// "with a sandwich on it" after a new object.
    pub fn added_with(&mut self, new: &NewObjects) -> Outcome<Option<EditOperation>> {
        let start = self.at;
        if !self.take("with") {
            return Ok(None);
        }
        let NewObjects::Objects { object, count: 1 } = new else {
            return self.not_understood(start, "add one object at a time");
        };
        let supporter = definite(object, 1);
        let end = self.phrase_end(self.at, &|index| self.preposition_at(index).is_some());
        let inner = self.new_objects(end)?;
        let relation = match self
            .length_of_any(self.at, &["in it", "inside it", "on it", "on top of it", "inside"])
        {
            Some(length) => {
                let relation = if self.is_at(self.at, "on") { RelationKind::On } else { RelationKind::In };
                self.at += length;
                relation
            }
            None => return self.not_understood(start, "say where it is: a plate with a bun on it"),
        };
        match inner {
            NewObjects::Objects { object, count } => {
                let place = Some(EditPlace::related(relation, supporter));
                Ok(Some(EditOperation::Add { object, count, place }))
            }
            NewObjects::Clutter { .. } => self.not_understood(start, "name the objects"),
        }
    }

    /// "remove the laptop and put a tablet there instead" replaces the laptop.
    pub fn add_instead(
        &mut self,
        start: usize,
        items: &[(usize, NewObjects, Option<EditOperation>)],
    ) -> Outcome<()> {
        let removed = self.discourse.topic.take().map_or(Vec::new(), |topic| topic.phrases);
        let ([(_, NewObjects::Objects { object, count: 1 }, None)], [target]) = (items, &removed[..]) else {
            return Err(self.error(start, self.at, Reason::OneForOne));
        };
        match self.operations.last_mut() {
            Some(EditOperation::Remove { target: last, with_contents: false }) if last == target => {
                let (target, object) = (target.clone(), object.clone());
                let phrase = definite(&object, 1);
                self.operations.pop();
                self.operations.push(EditOperation::Replace { target, object });
                self.now_about_new(vec![phrase], Vec::new(), false);
                Ok(())
            }
            _ => Err(self.error(start, self.at, Reason::OneForOne)),
        }
    }
}
