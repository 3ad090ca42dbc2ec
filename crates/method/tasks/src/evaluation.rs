//! Evaluation of the predicates of a goal from poses, contacts and convex hulls.
//!
//! Each predicate compares one measured value with one limit. The tolerances are those of success tests in use
//! (ManiSkill, robosuite, RoboTwin, LIBERO) where these agree, and of [`scene::predicates`] for directions and places.
//! A predicate compares now with the start where it is about a change. Takes microseconds per predicate, and up to a
//! millisecond where hulls of many parts are near each other.

mod change;
mod closure;
mod containment;
mod posture;
mod side;
mod support;

use geometry::Outline;
use scene::InstanceId;
use scene::text_account::{GoalPredicate, PredicateKind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::contact::{Contact, ContactBody};
use crate::goal::{Arity, Goal, arity};
use crate::posed_object::{PosedObject, find};

pub use change::{LIFT_M, MOVE_M, SWAP_M, TURN_RAD};
pub use containment::MIN_INSERTION_M;
pub use posture::TILT_RAD;
pub use side::MAX_DIRECTION_OVERLAP_M;
pub(crate) use side::relation_of;
pub use support::{CONTACT_GAP_M, OVERHANG_M, STACK_MARGIN_M};

/// State of the scene by which predicates are decided. World frame.
#[derive(Clone, Copy)]
pub struct Situation<'a> {
    /// Edge of the table top.
    pub table: &'a Outline,
    /// The objects at the start of the task.
    pub start: &'a [PosedObject],
    /// The same objects now.
    pub now: &'a [PosedObject],
    /// Contacts that a simulation reports now; hulls at most [`CONTACT_GAP_M`] apart count as touching without them.
    pub contacts: &'a [Contact],
}

/// The verdict about one predicate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(description = "Whether a predicate holds, and the value that decides.")]
pub struct PredicateOutcome {
    pub predicate: GoalPredicate,
    pub holds: bool,
    /// The value that decides, meters or radians; 0 where nothing can be measured.
    #[schemars(range(min = -1_000_000.0, max = 1_000_000.0))]
    pub measured: f64,
    #[schemars(range(min = -1_000_000.0, max = 1_000_000.0))]
    pub limit: f64,
    /// Side of the limit on which the measured value must be: `at_least` or `at_most`.
    #[schemars(with = "String")]
    pub bound: Bound,
    /// `meters` or `radians`.
    #[schemars(with = "String")]
    pub unit: Unit,
    /// Meaning of the measured value, or the reason why the predicate does not hold.
    #[schemars(with = "String")]
    pub reason: Reason,
}

/// Side of a limit on which a value must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    AtLeast,
    AtMost,
}

/// Unit of a measured value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    Meters,
    Radians,
}

/// Reason why a predicate holds or not. The names are stable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// The predicate holds.
    Holds,
    /// An object of the predicate is not in the scene.
    MissingObject,
    /// Poses and contacts do not show it (poured, wiped, pressed).
    NotDecidable,
    /// The target has no opening.
    NoOpening,
    /// The center of mass is beside the opening.
    OutsideOpening,
    /// The center of mass is above the rim.
    AboveRim,
    /// The center of mass is below the floor of the cavity.
    UnderFloor,
    /// The object is still in the container.
    StillInside,
    /// The object does not touch the target.
    NoContact,
    /// The object is not higher than the bottom of the target.
    NotAbove,
    /// The center of mass is not above the target.
    NoSupportUnderCenter,
    /// The centers are too far apart for a stack.
    OffCenter,
    /// The object is still on the target.
    StillSupported,
    /// The object is on the wrong side of the target, or too far off that direction.
    WrongSide,
    /// The objects are too far apart.
    TooFar,
    /// The objects overlap, seen from above.
    Overlapping,
    /// The object is not between the targets.
    NotBetween,
    /// The object is outside the region of the table.
    OutsideRegion,
    /// The object is not where the other one was.
    NotExchanged,
    /// The object has not risen enough.
    NotRisen,
    /// The object rests on another one.
    OnAnotherObject,
    /// The object has not moved enough.
    NotMoved,
    /// The object has not turned enough.
    NotTurned,
    /// The upright axis has another direction.
    WrongPosture,
    /// Something covers the opening.
    Covered,
    /// Nothing covers the opening.
    NotCovered,
}

/// A measured value with its limit.
#[derive(Clone, Copy, Debug)]
struct Measured {
    holds: bool,
    value: f64,
    limit: f64,
    bound: Bound,
    unit: Unit,
    /// Ignored if it holds.
    reason: Reason,
}

impl Measured {
    fn new(value: f64, limit: f64, bound: Bound, unit: Unit, reason: Reason) -> Self {
        let holds = match bound {
            Bound::AtLeast => value >= limit,
            Bound::AtMost => value <= limit,
        };
        Self { holds, value, limit, bound, unit, reason }
    }

    fn at_least_m(value_m: f64, limit_m: f64, reason: Reason) -> Self {
        Self::new(value_m, limit_m, Bound::AtLeast, Unit::Meters, reason)
    }

    fn at_most_m(value_m: f64, limit_m: f64, reason: Reason) -> Self {
        Self::new(value_m, limit_m, Bound::AtMost, Unit::Meters, reason)
    }

    /// A predicate that does not hold and has no measured value.
    fn failed(reason: Reason) -> Self {
        let (bound, unit) = (Bound::AtLeast, Unit::Meters);
        Self { holds: false, value: 0.0, limit: 0.0, bound, unit, reason }
    }

    /// The opposite condition.
    fn negated(self, reason: Reason) -> Self {
        let bound = match self.bound {
            Bound::AtLeast => Bound::AtMost,
            Bound::AtMost => Bound::AtLeast,
        };
        Self { holds: !self.holds, bound, reason, ..self }
    }
}

/// The verdict about every predicate of a goal, in its order. A goal is reached if all hold.
///
/// What each predicate measures, and its limit:
///
/// | predicate | measured | limit |
/// |---|---|---|
/// | `in`, `out_of` | least depth of the center of mass inside the cavity | 0 m |
/// | the same, standing out | depth of the lowest point below the rim | a third of the cavity, at least 1 cm |
/// | `on`, `off` | distance of the center of mass beyond the edge of the target | 1 cm |
/// | the same, without contact | vertical gap | 3 mm |
/// | `stacked_on` | as `on`; then horizontal distance of the centers | half the diagonal of the target + 5 mm |
/// | directions, `next_to`, `between`, places | as [`scene::predicates::holds`] | as there |
/// | `away_from` | growth of the free distance since the start | 3 cm |
/// | `swapped` | larger distance of one object's center from where the other's was | 5 cm |
/// | `lifted` | rise of the lowest point since the start | 4 cm, resting on nothing |
/// | `moved` | horizontal displacement since the start | 3 cm |
/// | `rotated` | turn about the vertical since the start | 30 degrees |
/// | `upright`, `lying_on_side`, `upside_down` | angle from the posture | 15 degrees |
/// | `opened`, `closed` | depth of the opening's center inside the footprint of a cover | 0 m |
pub fn evaluate(goal: &Goal, situation: &Situation) -> Vec<PredicateOutcome> {
    goal.predicates().iter().map(|predicate| evaluate_predicate(predicate, situation)).collect()
}

/// The verdict about one predicate.
pub fn evaluate_predicate(predicate: &GoalPredicate, situation: &Situation) -> PredicateOutcome {
    let measured = situation.measure(predicate).unwrap_or_else(Measured::failed);
    PredicateOutcome {
        predicate: predicate.clone(),
        holds: measured.holds,
        measured: measured.value,
        limit: measured.limit,
        bound: measured.bound,
        unit: measured.unit,
        reason: if measured.holds { Reason::Holds } else { measured.reason },
    }
}

/// Whether poses and contacts decide predicates of this kind.
pub fn is_decidable(kind: PredicateKind) -> bool {
    use PredicateKind::{PouredInto, Pressed, UsedOn};
    !matches!(kind, PouredInto | UsedOn | Pressed)
}

impl Situation<'_> {
    fn measure(&self, predicate: &GoalPredicate) -> Result<Measured, Reason> {
        use PredicateKind as P;
        let kind = predicate.predicate;
        let object = self.now(&predicate.object)?;
        // The arity of a goal is checked, that of a predicate alone is not.
        let target = || self.now(predicate.target.as_ref().ok_or(Reason::MissingObject)?);
        let second = || self.now(predicate.second_target.as_ref().ok_or(Reason::MissingObject)?);
        let before = |name: &InstanceId| find(self.start, name).ok_or(Reason::MissingObject);
        Ok(match kind {
            P::In => self.contained(object, target()?),
            P::OutOf => self.contained(object, target()?).negated(Reason::StillInside),
            P::On if predicate.target.is_none() => self.on_table(object),
            P::On => self.supported(object, target()?),
            P::Off => self.supported(object, target()?).negated(Reason::StillSupported),
            P::StackedOn => self.stacked(object, target()?),
            P::LeftOf | P::RightOf | P::InFrontOf | P::Behind => self.toward(kind, object, target()?),
            P::NextTo => self.beside(object, target()?),
            P::Between => self.between(object, target()?, second()?),
            P::AtCenter
            | P::AtBack
            | P::AtFront
            | P::AtLeft
            | P::AtRight
            | P::AtBackLeft
            | P::AtBackRight
            | P::AtFrontLeft
            | P::AtFrontRight => self.at_place(kind, object),
            P::AwayFrom => {
                let target = target()?;
                change::parted([object, target], [before(&object.name)?, before(&target.name)?])
            }
            P::Swapped => {
                let target = target()?;
                change::swapped([object, target], [before(&object.name)?, before(&target.name)?])
            }
            P::Lifted => self.lifted(object, before(&object.name)?),
            P::Moved => change::moved(object, before(&object.name)?),
            P::Rotated => change::rotated(object, before(&object.name)?),
            P::Upright | P::LyingOnSide | P::UpsideDown => posture::posture(kind, object),
            P::Closed => self.closed(object),
            P::Opened => self.closed(object).opposite_where_decided(),
            P::PouredInto | P::UsedOn | P::Pressed => Measured::failed(Reason::NotDecidable),
        })
    }

    fn now(&self, name: &InstanceId) -> Result<&PosedObject, Reason> {
        find(self.now, name).ok_or(Reason::MissingObject)
    }

    /// Whether a contact is reported.
    fn reports(&self, a: &ContactBody, b: &ContactBody) -> bool {
        self.contacts.iter().any(|contact| contact.is_between(a, b))
    }
}

impl Measured {
    fn opposite_where_decided(self) -> Self {
        if self.reason == Reason::NotDecidable { self } else { self.negated(Reason::Covered) }
    }
}

/// Whether a predicate needs an object beside the first.
pub fn needs_target(kind: PredicateKind) -> bool {
    matches!(arity(kind), Arity::Target | Arity::TwoTargets)
}

#[cfg(test)]
mod tests;
