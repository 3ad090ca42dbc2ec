//! Places of clauses as places of operations.

use scene::RelationKind::{
    AtBack, AtBackLeft, AtBackRight, AtCenter, AtFront, AtFrontLeft, AtFrontRight, AtLeft, AtRight, Between,
    FromBackEdge, FromFrontEdge, FromLeftEdge, FromRightEdge, In, On,
};
use scene::{EditPlace, RelationKind};

use super::error::{InstructionError, Reason};
use super::fold::Fold;
use crate::nominal::{NounPhrase, Quantity, Reference};
use crate::place::{Place, PlaceKind};
use crate::vocabulary::vocabulary;

/// Destination of the objects of a clause.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Destination {
    Place(EditPlace),
    Anywhere,
    /// The place of what was removed or named before.
    There,
    /// Out of what carries or contains it: "in" or "on", and the phrase of that object.
    Source {
        phrase: String,
        is_inside: bool,
    },
    OffTable,
    /// Farther from the object of a phrase.
    Away {
        phrase: String,
    },
}

impl Fold<'_, '_> {
    pub fn destination(&mut self, place: &Place, is_elliptic: bool) -> Result<Destination, InstructionError> {
        let error = |reason| self.error(&place.tokens, reason);
        let found = match &place.kind {
            PlaceKind::Related { relation, landmarks, distance_m } => {
                let [landmark] = landmarks.as_slice() else { return Err(error(Reason::SeveralLandmarks)) };
                if *relation == On && self.is_table(landmark) {
                    return Ok(Destination::Place(EditPlace { relation: Some(On), ..EditPlace::default() }));
                }
                let target = self.landmark(*relation, landmark, is_elliptic)?;
                self.discourse.landmark = Some((*relation, target.clone()));
                EditPlace { distance_m: *distance_m, ..EditPlace::related(*relation, target) }
            }
            PlaceKind::Between(landmarks) => self.between(place, landmarks)?,
            // "a fork on the left of the plate, a spoon on the right".
            PlaceKind::Region { x, y, is_edge: false, distance_m: None }
                if is_elliptic && self.beside(*x, *y).is_some() =>
            {
                self.beside(*x, *y).unwrap_or_default()
            }
            PlaceKind::Region { x, y, is_edge, distance_m } => {
                return self.region(place, (*x, *y), *is_edge, *distance_m).map(Destination::Place);
            }
            PlaceKind::Offset(offset_m) => EditPlace { offset_m: Some(*offset_m), ..EditPlace::default() },
            // A robot brings it to that side.
            PlaceKind::Direction(side) if self.all_exist => {
                let region = (side.x.round() as i8, side.y.round() as i8);
                return self.region(place, region, false, None).map(Destination::Place);
            }
            PlaceKind::Direction(_) => return Err(error(Reason::HowFar)),
            PlaceKind::Closer => {
                let why = "\"closer\" needs a distance: 10 cm to the left, or next to the laptop";
                return Err(error(Reason::NotUnderstood(why)));
            }
            PlaceKind::Source { landmarks, is_inside } => {
                let [landmark] = landmarks.as_slice() else { return Err(error(Reason::SeveralLandmarks)) };
                let phrase = self.landmark(if *is_inside { In } else { On }, landmark, false)?;
                self.discourse.landmark = Some((if *is_inside { In } else { On }, phrase.clone()));
                return Ok(Destination::Source { phrase, is_inside: *is_inside });
            }
            PlaceKind::Away(landmarks) => {
                let [landmark] = landmarks.as_slice() else { return Err(error(Reason::SeveralLandmarks)) };
                return Ok(Destination::Away {
                    phrase: self.landmark(RelationKind::NextTo, landmark, is_elliptic)?,
                });
            }
            PlaceKind::Table => EditPlace { relation: Some(On), ..EditPlace::default() },
            PlaceKind::OffTable => return Ok(Destination::OffTable),
            PlaceKind::Anywhere => return Ok(Destination::Anywhere),
            PlaceKind::There => return Ok(Destination::There),
        };
        Ok(Destination::Place(found))
    }

    /// The other side of the last landmark, where a clause repeats the one before it.
    fn beside(&self, x: i8, y: i8) -> Option<EditPlace> {
        use RelationKind::{Behind, InFrontOf, LeftOf, RightOf};
        let (earlier, landmark) = self.discourse.landmark.as_ref()?;
        let side = match (x, y) {
            (-1, 0) => LeftOf,
            (1, 0) => RightOf,
            (0, -1) => InFrontOf,
            (0, 1) => Behind,
            _ => return None,
        };
        matches!(earlier, LeftOf | RightOf | InFrontOf | Behind)
            .then(|| EditPlace::related(side, landmark.clone()))
    }

    fn is_table(&self, landmark: &NounPhrase) -> bool {
        let bare = landmark.tokens.end == landmark.body.end;
        bare && vocabulary().is_table(&landmark.noun) && landmark.reference != Reference::Pronoun
    }

    /// The phrase of the object that a place is relative to.
    fn landmark(
        &mut self,
        relation: RelationKind,
        landmark: &NounPhrase,
        is_elliptic: bool,
    ) -> Result<String, InstructionError> {
        let tokens = landmark.tokens.clone();
        if self.is_table(landmark) {
            return Err(self.error(&tokens, Reason::Table));
        }
        match landmark.reference {
            Reference::Pronoun => self.pronoun_landmark(relation, landmark, is_elliptic),
            Reference::Indefinite if !landmark.is_choice => {
                let phrase = self.chart.written(tokens.clone());
                let any = self.chart.resolves(&tokens) == Some(true) && landmark.quantity == Quantity::One;
                // "on a plate": the one that is there.
                if any { Ok(phrase) } else { Err(self.error(&tokens, Reason::NewLandmark)) }
            }
            _ => {
                let target = self.target(landmark)?;
                self.discourse.mention(&target.noun, &target.phrase, false);
                Ok(target.phrase)
            }
        }
    }

    /// "it" in a place: in a clause that repeats the one before, what that one's place was relative to.
    fn pronoun_landmark(
        &mut self,
        relation: RelationKind,
        landmark: &NounPhrase,
        is_elliptic: bool,
    ) -> Result<String, InstructionError> {
        let error = |fold: &Self, reason| Err(fold.error(&landmark.tokens, reason));
        if landmark.quantity == Quantity::Each {
            return match &self.discourse.topic {
                Some(topic) if topic.phrases.len() == 1 && !topic.is_stale && topic.is_plural => {
                    Ok(topic.phrases[0].clone())
                }
                // "a fork to the left of each plate and a knife to the right of each"
                _ if self.discourse.landmark.as_ref().is_some_and(|(_, phrase)| is_each(phrase)) => {
                    Ok(self.discourse.landmark.clone().map(|(_, phrase)| phrase).unwrap_or_default())
                }
                _ => error(self, Reason::UnclearPronoun),
            };
        }
        if let Some(topic) = self.discourse.topic.as_ref().filter(|topic| !topic.is_stale)
            && let [each] = topic.phrases.as_slice()
            && is_each(each)
            && landmark.quantity == Quantity::One
        {
            return Ok(each.clone());
        }
        let known = self.discourse.landmark.clone();
        if let Some((_, phrase)) = known.filter(|_| is_elliptic) {
            // "a glass behind the plate and some grapes on it": on the glass, or on the plate?
            // Next to it is beside the plate.
            let noun = phrase.rsplit(' ').next().unwrap_or_default();
            let holds = crate::place::destination(noun) == relation;
            return if !matches!(relation, On | In) || (relation == In && holds && self.is_of_clause(relation))
            {
                Ok(phrase)
            } else {
                error(self, Reason::UnclearPronoun)
            };
        }
        let targets = self.targets(std::slice::from_ref(landmark))?;
        match targets.as_slice() {
            [one] if !one.is_plural => Ok(one.phrase.clone()),
            _ => error(self, Reason::SeveralLandmarks),
        }
    }

    /// Whether the main objects of the clause before hold nothing that way themselves.
    fn is_of_clause(&self, relation: RelationKind) -> bool {
        let named = self.discourse.topic.iter().flat_map(|topic| &topic.phrases);
        let mut nouns = named.map(|phrase| phrase.rsplit(' ').next().unwrap_or_default());
        nouns.all(|noun| crate::place::destination(noun) != relation)
    }

    fn between(&mut self, place: &Place, landmarks: &[NounPhrase]) -> Result<EditPlace, InstructionError> {
        let error = |fold: &Self| {
            fold.error(
                &place.tokens,
                Reason::NotUnderstood("name two objects: between the mug and the plate"),
            )
        };
        let (first, second) = match landmarks {
            [both] if both.reference == Reference::Pronoun => {
                let targets = self.targets(std::slice::from_ref(both))?;
                match targets.as_slice() {
                    [first, second] => (first.phrase.clone(), second.phrase.clone()),
                    [all] => {
                        (format!("the first of {}", all.phrase), format!("the second of {}", all.phrase))
                    }
                    _ => return Err(error(self)),
                }
            }
            [both] => {
                let noun = self.chart.written(both.body.start..both.tokens.end);
                (format!("the first of the two {noun}"), format!("the second of the two {noun}"))
            }
            // "between the second and the third plate"
            [first, second] if first.noun.is_empty() && second.reference == Reference::Definite => {
                let targets = self.targets(landmarks)?;
                let [first, second] = targets.as_slice() else { return Err(error(self)) };
                (first.phrase.clone(), second.phrase.clone())
            }
            [first, second] => {
                (self.landmark(Between, first, false)?, self.landmark(Between, second, false)?)
            }
            _ => return Err(error(self)),
        };
        Ok(EditPlace { second_target: Some(second), ..EditPlace::related(Between, first) })
    }

    fn region(
        &self,
        place: &Place,
        region: (i8, i8),
        is_edge: bool,
        distance_m: Option<f64>,
    ) -> Result<EditPlace, InstructionError> {
        let error = |why| Err(self.error(&place.tokens, Reason::NotUnderstood(why)));
        let edge = match region {
            (-1, 0) => Some(FromLeftEdge),
            (1, 0) => Some(FromRightEdge),
            (0, -1) => Some(FromFrontEdge),
            (0, 1) => Some(FromBackEdge),
            _ => None,
        };
        if is_edge || distance_m.is_some() {
            let Some(edge) = edge else { return error("name one edge of the table") };
            return Ok(EditPlace { distance_m, ..EditPlace::at(edge) });
        }
        let kind = match region {
            (0, 0) => AtCenter,
            (-1, 0) => AtLeft,
            (1, 0) => AtRight,
            (0, -1) => AtFront,
            (0, 1) => AtBack,
            (-1, -1) => AtFrontLeft,
            (1, -1) => AtFrontRight,
            (-1, 1) => AtBackLeft,
            (1, 1) => AtBackRight,
            _ => return error("name one part of the table"),
        };
        Ok(EditPlace::at(kind))
    }
}

/// Whether a phrase means several objects, one at a time.
fn is_each(phrase: &str) -> bool {
    phrase.starts_with("each ") || phrase.starts_with("every ")
}
