//! Directions, neighborhood and places, with the verdicts of [`scene::predicates::holds`].

use scene::RelationKind;
use scene::predicates::{
    NEXT_TO_M, PosedFootprint, PosedRelation, direction_of, holds, is_at_place, place_shares,
};
use scene::text_account::PredicateKind;

use super::{Bound, Measured, Reason, Situation, Unit};
use crate::posed_object::PosedObject;

/// Overlap that a direction permits, meters: that of [`scene::predicates::holds`].
pub const MAX_DIRECTION_OVERLAP_M: f64 = 0.015;

impl Situation<'_> {
    /// Left of, right of, in front of or behind a target. Measured is the free distance along the direction.
    pub(super) fn toward(&self, kind: PredicateKind, object: &PosedObject, target: &PosedObject) -> Measured {
        let (relation, footprint, other) = (relation_of(kind), object.footprint(), target.footprint());
        let Some(way) = direction_of(relation) else { return Measured::failed(Reason::NotDecidable) };
        let along_m = (footprint.center() - other.center()).dot(way);
        let free_m = along_m - footprint.extent_m(-way) - other.extent_m(way);
        self.judged(
            relation,
            [&footprint, &other],
            None,
            Measured::at_least_m(free_m, -MAX_DIRECTION_OVERLAP_M, Reason::WrongSide),
        )
    }

    /// Next to a target: at most 15 cm apart, not overlapping.
    pub(super) fn beside(&self, object: &PosedObject, target: &PosedObject) -> Measured {
        let (footprint, other) = (object.footprint(), target.footprint());
        let free_m = footprint.distance_m(&other);
        let reason = if free_m < 0.0 { Reason::Overlapping } else { Reason::TooFar };
        let measured = Measured::at_most_m(free_m, NEXT_TO_M, reason);
        self.judged(RelationKind::NextTo, [&footprint, &other], None, measured)
    }

    /// Between two targets. Measured is the distance from the line between their centers.
    pub(super) fn between(
        &self,
        object: &PosedObject,
        target: &PosedObject,
        second: &PosedObject,
    ) -> Measured {
        let (footprint, ends) = (object.footprint(), [target.footprint(), second.footprint()]);
        let segment = ends[1].center() - ends[0].center();
        let length_m = segment.length();
        let off_m = ((footprint.center() - ends[0].center()).perp_dot(segment) / length_m.max(1e-9)).abs();
        let measured = Measured::at_most_m(off_m, (0.25 * length_m).max(0.02), Reason::NotBetween);
        self.judged(RelationKind::Between, [&footprint, &ends[0]], Some(&ends[1]), measured)
    }

    fn judged(
        &self,
        kind: RelationKind,
        [object, target]: [&PosedFootprint; 2],
        second_target: Option<&PosedFootprint>,
        measured: Measured,
    ) -> Measured {
        let target = Some(target);
        let relation = PosedRelation { kind, object, target, second_target, distance_m: None };
        Measured { holds: holds(&relation, self.table), ..measured }
    }

    /// In a region of the table. Measured is how far the center is outside of it, along the axis with the larger
    /// excess.
    pub(super) fn at_place(&self, kind: PredicateKind, object: &PosedObject) -> Measured {
        const TOLERANCE: f64 = 0.05;
        let (place, center) = (relation_of(kind), object.footprint().center());
        let Some(((low, high), is_there)) = place_shares(place).zip(is_at_place(place, center, self.table))
        else {
            return Measured::failed(Reason::NotDecidable);
        };
        let (from, to) = self.table.bounds();
        let half_m = 0.5 * (to - from);
        let shares = (center - 0.5 * (from + to)) / half_m;
        let outside = (low - shares).max(shares - high) * half_m;
        let (value, half_m) = if outside.x / half_m.x >= outside.y / half_m.y {
            (outside.x, half_m.x)
        } else {
            (outside.y, half_m.y)
        };
        let (limit, reason) = (TOLERANCE * half_m, Reason::OutsideRegion);
        Measured { holds: is_there, value, limit, bound: Bound::AtMost, unit: Unit::Meters, reason }
    }
}

/// The relation of descriptions that a predicate requires; directions and places alone.
pub(crate) fn relation_of(kind: PredicateKind) -> RelationKind {
    use PredicateKind as P;
    use RelationKind as R;
    match kind {
        P::LeftOf => R::LeftOf,
        P::RightOf => R::RightOf,
        P::InFrontOf => R::InFrontOf,
        P::Behind => R::Behind,
        P::Between => R::Between,
        P::AtCenter => R::AtCenter,
        P::AtBack => R::AtBack,
        P::AtFront => R::AtFront,
        P::AtLeft => R::AtLeft,
        P::AtRight => R::AtRight,
        P::AtBackLeft => R::AtBackLeft,
        P::AtBackRight => R::AtBackRight,
        P::AtFrontLeft => R::AtFrontLeft,
        P::AtFrontRight => R::AtFrontRight,
        P::In => R::In,
        P::StackedOn => R::StackedOn,
        P::NextTo => R::NextTo,
        _ => R::On,
    }
}
