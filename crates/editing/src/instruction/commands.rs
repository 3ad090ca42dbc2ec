//! Commands about which objects there are and where: add, remove, replace, move, stack, tidy.

use super::changes::Frame;
use super::cursor::{Cursor, Outcome};
use super::discourse::Target;
use super::nouns::{NewObjects, definite};
use super::Reason;
use scene::{EditOperation, EditPlace, RelationKind};

impl Cursor {
    /// New objects, or a move where the objects exist: "put a mug on the tray", "put the mug on the tray".
    pub fn add_or_move(&mut self, frame: Frame) -> Outcome<()> {
        if self.is_definite(self.at) {
            return self.relocate(frame == Frame::Move);
        }
        if frame == Frame::Move {
            return self.relocate(true);
        }
        self.add()
    }

    fn add(&mut self) -> Outcome<()> {
        let start = self.at;
        let mut items: Vec<(usize, NewObjects, Option<EditOperation>)> = Vec::new();
        loop {
            let from = self.at;
            let end = self.phrase_end(from, &|index| {
                self.preposition_at(index).is_some() || self.is_at(index, "with")
            });
            let new = self.new_objects(end)?;
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
        if self.take_any(&["anywhere on the table", "somewhere on the table", "anywhere", "somewhere"]) {
        } else if self.preposition_at(self.at).is_some() {
            let found = self.place()?;
            if found.offset_m.is_some() {
                return Err(self.error(pronoun_at, self.at, Reason::OffsetOfNew));
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
                    if place.as_ref().is_some_and(|place| place.relation != Some(RelationKind::On) || place.target.is_some())
                    {
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
    fn added_with(&mut self, new: &NewObjects) -> Outcome<Option<EditOperation>> {
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
        let relation = match self.length_of_any(self.at, &["in it", "inside it", "on it", "on top of it", "inside"]) {
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
    fn add_instead(&mut self, start: usize, items: &[(usize, NewObjects, Option<EditOperation>)]) -> Outcome<()> {
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
                let phrase = self.target_text(from, end).replacen(" from the ", " on the ", usize::from(!self.has_rank(from, end)));
                targets.push(Target { phrase, pronoun: false });
            }
            let next = self.at + self.connector_at(self.at);
            if next == self.at || !self.is_phrase(next) {
                break;
            }
            self.at = next;
        }
        let top = ["on top of each other", "on top of one another", "on each other", "into a stack", "in a stack"];
        if self.take_any(&top) {
            return self.stacked(&targets);
        }
        let _ = self.word(self.at) == "," && self.preposition_at(self.at + 1).is_some() && self.take(",");
        if self.preposition_at(self.at).is_none() {
            return self.not_understood(start, "say where it goes: to the left of the laptop, 10 cm to the left");
        }
        if self.is_at(self.at, "closer") {
            return self.not_understood(self.at, "\"closer\" needs a distance: 10 cm to the left, or next to the laptop");
        }
        let place = self.place()?;
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
    fn moved_where_made(&mut self, target: &Target, place: &EditPlace) -> bool {
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

    fn has_rank(&self, from: usize, to: usize) -> bool {
        (from..to).any(|index| self.is_rank_origin(from, index))
    }

    /// Where the destination begins: the end of the phrase for the object.
    fn destination(&self, start: usize, moves: bool) -> Outcome<usize> {
        let end = self.phrase_end(start, &|_| false);
        let mut places = Vec::new();
        let mut at = self.head_end(start);
        while at < end {
            if self.is_rank_origin(start, at) {
                at += 3;
                continue;
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

    /// Removal, or a move where something is taken out of or off something.
    pub fn remove(&mut self, takes: bool) -> Outcome<()> {
        let start = self.at;
        let sources = ["out of", "off of", "off", "from", "with", "including", "along with", "together with", "away", "out"];
        let stops = |cursor: &Self, index: usize| {
            cursor.length_of_any(index, &sources).is_some() && !cursor.is_rank_origin(cursor.at, index)
        };
        let targets = self.targets(&stops)?;
        let mut with_contents = false;
        let away = self.is_at(self.at, "away") || (self.is_at(self.at, "out") && !self.is_at(self.at, "out of"));
        self.at += usize::from(away);
        let contents = [
            "with everything on it", "with everything in it", "with everything inside", "with its contents",
            "with all its contents", "including its contents", "including everything on it", "including everything in it",
            "along with everything on it", "along with everything in it", "together with its contents",
            "together with everything on it", "and everything on it", "and everything in it", "and its contents",
            "with what is on it", "with what is in it", "with their contents",
        ];
        if self.take_any(&contents) {
            with_contents = true;
        }
        let begins = |index: usize| ["put", "place", "set", "lay", "move"].contains(&self.word(index));
        let next = self.at + self.connector_at(self.at);
        if takes && next > self.at && begins(next) && matches!(self.word(next + 1), "it" | "them") {
            self.now_about(&targets, self.operations.len());
            return Ok(());
        }
        let removal = ["from the table", "off the table", "from the scene", "off the desk", "from the desk", "off my desk"];
        let removed = self.take_any(&removal) || away || with_contents || !takes;
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
            let reason = if two { Reason::Swap } else { Reason::NotUnderstood("say what replaces it: with a wine glass") };
            return Err(self.error(verb, self.at, reason));
        }
        if self.is_definite(self.at) {
            return Err(self.error(verb, self.phrase_end(self.at, &|_| false), Reason::Swap));
        }
        let end = self.phrase_end(self.at, &|index| self.preposition_at(index).is_some() || self.is_at(index, "with"));
        let from = self.at;
        let plural_targets = targets.len() > 1 || targets.iter().any(|target| super::discourse::is_plural(&target.phrase));
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

    /// "stack the books", "stack A on B".
    pub fn stack(&mut self) -> Outcome<()> {
        let onto = ["on top of", "onto", "on", "upon", "atop", "up", "in a", "into a", "neatly"];
        let targets = self.targets(&|cursor, index| cursor.length_of_any(index, &onto).is_some())?;
        let all = [
            "on top of each other", "on top of one another", "on each other", "up", "in a pile", "in a stack",
            "into a stack", "into a pile", "neatly",
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

    fn stacked(&mut self, targets: &[Target]) -> Outcome<()> {
        let first = self.operations.len();
        let operation = EditOperation::Stack { targets: targets.iter().map(|target| target.phrase.clone()).collect() };
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

/// Whether the phrase names the table.
pub(super) fn is_table(phrase: &str) -> bool {
    let lower = phrase.to_lowercase();
    let noun = ["the ", "my ", "this ", "our "].iter().find_map(|article| lower.strip_prefix(article));
    crate::references::vocabulary().is_table(noun.unwrap_or(&lower))
}
