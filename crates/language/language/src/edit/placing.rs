//! Clauses that give objects a place, or take them from one.

use scene::{EditOperation, EditPlace, RelationKind};

use super::discourse::{Changes, Topic};
use super::error::Reason;
use super::fold::{Fold, Outcome, Step, located};
use super::new_objects::{NewObjects, definite, new_objects};
use super::places::Destination;
use super::targets::Target;
use crate::clause::Clause;
use crate::construction::Act;
use crate::nominal::{NounPhrase, Quantity, Reference};
use crate::vocabulary::vocabulary;

impl Fold<'_, '_> {
    /// New objects are made, existing ones moved.
    pub fn put(&mut self, clause: &Clause) -> Outcome<()> {
        // "every plate gets a fork on its left": the place is about the plate.
        let received = clause.objects("new");
        if !received.is_empty() {
            let receivers = self.targets(clause.objects(""))?;
            self.now_about(receivers, Changes::Nothing);
        }
        let phrases = if received.is_empty() { clause.objects("") } else { received };
        // "it needs to come off the tray and be put behind it"
        let it = [self.topic_phrase()];
        let phrases = if phrases.is_empty() { it.as_slice() } else { phrases };
        let all_exist = self.all_exist || clause.act == Act::Move;
        // "red cubes in the basket", without a verb, are those that are there.
        let is_there = |phrase: &NounPhrase| {
            let is_bare = phrase.tokens.start == phrase.body.start && phrase.tokens.start == clause.start;
            is_bare && self.chart.resolves(&phrase.tokens) == Some(true)
        };
        let is_new = |phrase: &&NounPhrase| {
            phrase.reference == Reference::Indefinite && !all_exist && !is_there(phrase)
        };
        let destination =
            clause.place().map(|place| self.destination(place, clause.is_elliptic)).transpose()?;
        let (new, existing): (Vec<&NounPhrase>, Vec<&NounPhrase>) = phrases.iter().partition(is_new);
        if !existing.is_empty() {
            let existing: Vec<NounPhrase> = existing.into_iter().cloned().collect();
            self.move_to(clause, &existing, destination.clone())?;
        }
        if new.is_empty() { Ok(()) } else { self.add(clause, &new, destination) }
    }

    /// A pronoun for what the clause before was about.
    pub fn topic_phrase(&self) -> NounPhrase {
        let is_plural = self.discourse.topic.as_ref().is_some_and(|topic| topic.is_plural);
        let here = self.clause.start..self.clause.start;
        NounPhrase {
            tokens: here.clone(),
            reference: Reference::Pronoun,
            quantity: if is_plural { Quantity::All } else { Quantity::One },
            body: here,
            noun: String::new(),
            is_choice: false,
            is_rest: false,
            is_additional: false,
        }
    }

    pub fn add(
        &mut self,
        clause: &Clause,
        phrases: &[&NounPhrase],
        destination: Option<Destination>,
    ) -> Outcome<()> {
        let place = match destination {
            None | Some(Destination::Anywhere) => None,
            Some(Destination::There) => return self.add_instead(clause, phrases),
            Some(Destination::Place(place)) if place.offset_m.is_some() => {
                return self.refuse(Reason::OffsetOfNew);
            }
            Some(Destination::Place(place)) => Some(place),
            Some(Destination::Source { .. } | Destination::OffTable | Destination::Away { .. }) => {
                return self
                    .refuse(Reason::NotUnderstood("give the place of a new object: next to the laptop"));
            }
        };
        self.discourse.place.clone_from(&place);
        let (mut made, mut made_at, mut is_plural) = (Vec::new(), Vec::new(), phrases.len() > 1);
        for phrase in phrases {
            let last_noun = self.discourse.last_noun().map(str::to_owned);
            let new = new_objects(self.chart, phrase, last_noun.as_deref());
            match new.map_err(|reason| self.error(&phrase.tokens, reason))? {
                NewObjects::Clutter { count, theme } => {
                    if place.as_ref().is_some_and(|place| {
                        place.relation != Some(RelationKind::On) || place.target.is_some()
                    }) {
                        return self.refuse(Reason::ClutterPlace);
                    }
                    self.push(EditOperation::Clutter { count, theme });
                }
                NewObjects::Objects { object, count } => {
                    if place.as_ref().is_some_and(|place| place.relation == Some(RelationKind::In))
                        && vocabulary().is_drink(&object)
                    {
                        let why = catalog::stand_in::Obstacle::Substance.explanation();
                        return Err(self.error(&phrase.tokens, Reason::NotPlaceable(why)));
                    }
                    let named = definite(&object, count);
                    self.discourse.mention(&phrase.noun, &named, false);
                    made.push(named);
                    is_plural |= count > 1;
                    if place.is_none() {
                        made_at.push(self.steps.len());
                    }
                    let place = place
                        .clone()
                        .filter(|place| place.target.is_some() || place.relation != Some(RelationKind::On));
                    self.push(EditOperation::Add { object, count, place });
                }
            }
        }
        if !made.is_empty() {
            self.discourse.topic = Some(Topic { phrases: made, is_plural, made_at, ..Topic::default() });
            self.stale_at = None;
        }
        Ok(())
    }

    /// "remove the laptop and put a tablet there" replaces the laptop.
    pub fn add_instead(&mut self, _clause: &Clause, phrases: &[&NounPhrase]) -> Outcome<()> {
        let removed = self.discourse.topic.as_ref().filter(|topic| topic.is_removed);
        let Some(topic) = removed.cloned() else {
            let Some(place) = self.discourse.place.clone() else { return self.refuse(Reason::NoAntecedent) };
            return self.add(_clause, phrases, Some(Destination::Place(place)));
        };
        let ([phrase], [target]) = (phrases, topic.phrases.as_slice()) else {
            return self.refuse(Reason::OneForOne);
        };
        let new =
            new_objects(self.chart, phrase, None).map_err(|reason| self.error(&phrase.tokens, reason))?;
        let NewObjects::Objects { object, count: 1 } = new else { return self.refuse(Reason::OneForOne) };
        match self.steps.last() {
            Some(Step::Operation(EditOperation::Remove { target: last, with_contents: false }))
                if last == target =>
            {
                self.steps.pop();
                self.clauses.pop();
                self.push(EditOperation::Replace { target: target.clone(), object: object.clone() });
                self.discourse.topic =
                    Some(Topic { phrases: vec![definite(&object, 1)], ..Topic::default() });
                Ok(())
            }
            _ => self.refuse(Reason::OneForOne),
        }
    }

    pub fn move_to(
        &mut self,
        clause: &Clause,
        phrases: &[NounPhrase],
        destination: Option<Destination>,
    ) -> Outcome<()> {
        let mut targets = self.targets(phrases)?;
        let place = match destination {
            Some(Destination::Place(place)) => place,
            Some(Destination::There) => match self.discourse.place.clone() {
                Some(place) => place,
                None => return self.refuse(Reason::NoAntecedent),
            },
            Some(Destination::OffTable) => return self.remove_targets(targets, false),
            Some(Destination::Source { phrase, is_inside }) => {
                return self.take_out(targets, &phrase, is_inside);
            }
            Some(Destination::Away { phrase: landmark }) => {
                for target in &targets {
                    self.push_step(Step::Away { target: target.phrase.clone(), landmark: landmark.clone() });
                }
                self.now_about(targets, Changes::Place);
                return Ok(());
            }
            Some(Destination::Anywhere) => {
                EditPlace { relation: Some(RelationKind::On), ..EditPlace::default() }
            }
            None => {
                // "add the mug" or "I want the mug" does not say where.
                return self.refuse(Reason::NotUnderstood(
                    "say where it goes: to the left of the laptop, 10 cm to the left",
                ));
            }
        };
        // "each" and plurals give a place for each of several objects.
        let several = clause.place().is_some_and(|place| place.has_several_landmarks());
        // "put a mug on every plate": as many mugs as there are plates.
        if several && self.all_exist {
            for (target, phrase) in targets.iter_mut().zip(phrases) {
                if phrase.reference == Reference::Indefinite && !target.is_plural {
                    target.phrase = format!("the {}", vocabulary().plural_of(&phrase.noun));
                    target.is_plural = true;
                }
            }
        }
        if several && targets.iter().any(|target| !target.is_plural) {
            return self.refuse(Reason::SeveralLandmarks);
        }
        if let Some(landmark) = &place.target {
            for target in targets.iter_mut().filter(|target| target.phrase == "everything") {
                target.phrase = format!("everything except {landmark}");
            }
        }
        self.discourse.place = Some(place.clone()).filter(|place| place.offset_m.is_none());
        if self.place_what_was_made(&targets, &place) || self.place_what_was_taken(&targets, &place) {
            return Ok(());
        }
        for target in &targets {
            self.push(EditOperation::Move { target: target.phrase.clone(), place: place.clone() });
        }
        self.now_about(targets, Changes::Place);
        Ok(())
    }

    /// "add two forks and put them next to the plate" adds them there.
    pub fn place_what_was_made(&mut self, targets: &[Target], place: &EditPlace) -> bool {
        let Some(topic) = &mut self.discourse.topic else { return false };
        let all = targets.iter().all(|target| target.is_pronoun) && topic.made_at.len() == targets.len();
        if !all || targets.is_empty() || place.offset_m.is_some() {
            return false;
        }
        for index in std::mem::take(&mut topic.made_at) {
            if let Some(Step::Operation(EditOperation::Add { place: made, .. })) = self.steps.get_mut(index) {
                *made = Some(place.clone());
            }
        }
        true
    }

    /// "take the spoon out of the mug and lay it on the napkin" moves it there.
    pub fn place_what_was_taken(&mut self, targets: &[Target], place: &EditPlace) -> bool {
        let taken = self.discourse.taken_at.take().filter(|_| targets.iter().all(|target| target.is_pronoun));
        let Some(first) = taken.filter(|_| !targets.is_empty()) else { return false };
        for step in &mut self.steps[first..] {
            if let Step::TakeOut { target, carrier, is_inside } = step {
                let target = located(target, carrier, *is_inside);
                *step = Step::Operation(EditOperation::Move { target, place: place.clone() });
            }
        }
        true
    }

    pub fn take(&mut self, clause: &Clause) -> Outcome<()> {
        let Some(place) = clause.place() else { return self.refuse(Reason::Empty) };
        let destination = self.destination(place, false)?;
        let targets = self.targets(clause.objects(""))?;
        match destination {
            Destination::OffTable => self.remove_targets(targets, false),
            Destination::Source { phrase, is_inside } => self.take_out(targets, &phrase, is_inside),
            other => self.move_to(clause, clause.objects(""), Some(other)),
        }
    }

    /// Objects leave what carries them and come to stand on the table.
    pub fn take_out(&mut self, targets: Vec<Target>, carrier: &str, is_inside: bool) -> Outcome<()> {
        let first = self.steps.len();
        let mut moved = Vec::new();
        for mut target in targets {
            let (phrase, carrier) = (target.phrase.clone(), carrier.to_owned());
            if !target.is_pronoun {
                let there = located(&phrase, &carrier, is_inside);
                let is_there = self.chart.referents.resolves(&there) != Some(false);
                // "from the pile" does not help to find it.
                if is_there {
                    target.phrase = there;
                } else {
                    self.push_step(Step::TakeOut { target: phrase, carrier: String::new(), is_inside });
                    moved.push(target);
                    continue;
                }
            }
            self.push_step(Step::TakeOut { target: phrase, carrier, is_inside });
            moved.push(target);
        }
        self.now_about(moved, Changes::Place);
        self.discourse.taken_at = Some(first);
        Ok(())
    }
}
