//! Places at which an object can be put down so that predicates hold.
//!
//! Candidates are places over the target, in its opening, around it, or all over the table. The object is dropped
//! straight at each of them in the orientation that it has, turned about the vertical; a candidate is good if it rests
//! on what it shall, keeps away from everything else, and the predicates hold there.

use geometry::drop_cast::{PosedShape, are_closer, drop_height};
use geometry::{DQuat, DVec2, DVec3, Outline, Pose};
use tasks::{
    GoalPredicate, PosedObject, PredicateKind, Situation, evaluation::evaluate_predicate, posed_object::find,
};

use super::release::ReleaseTrials;
use super::scene::Shapes;

/// Distance between candidates on the table, meters.
const SPACING_M: f64 = 0.03;
/// Distance from objects that the object shall not touch, meters: fingers need room.
const KEEP_AWAY_M: f64 = 0.02;
/// Parts of the scene that end no higher than this above the lowest point of the object are below it, meters.
const BELOW_M: f64 = 0.001;
/// Distance of what is set aside from places that are needed, meters.
const ROOM_M: f64 = 0.06;
/// Distance of an object from the edge of the table, meters.
const EDGE_M: f64 = 0.02;
/// Turns about the vertical that are tried, in quarters of a right angle.
const TURNS: [f64; 8] = [0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 4.0];
/// Tilts of long objects that do not fit lying into an opening, radians.
const TILTS_RAD: [f64; 10] = [0.2, -0.2, 0.3, -0.3, 0.4, -0.4, 0.55, -0.55, 0.8, -0.8];
/// An object is long if its length is this many times its second extent.
const LONG: f64 = 2.0;
/// Of so many times the wanted number of tilted poses the best are tried.
const CHOICE_OF_TILTED: usize = 16;
/// Enough tilted poses in which the object stays.
const TILTED: usize = 6;
/// Height above its place at which a trial lets an object go, meters.
const TRIAL_GAP_M: f64 = 0.002;
/// The most turns that are offered at one place.
const TURNS_AT_PLACE: usize = 3;
/// The gap to a neighbor that is aimed at, meters.
const NEIGHBOR_GAP_M: f64 = 0.05;

/// Input of the search for a place.
pub(crate) struct PlaceSearch<'a> {
    pub outline: &'a Outline,
    pub shapes: &'a Shapes,
    pub table: PosedShape<'a>,
    pub start: &'a [PosedObject],
    pub now: &'a [PosedObject],
    /// The index of the object that is moved.
    pub object: usize,
    /// Number of places after which the search stops.
    pub wanted: usize,
    /// Of releases of the object.
    pub trials: &'a ReleaseTrials<'a>,
}

impl PlaceSearch<'_> {
    /// Poses of the object at which it rests and `predicates` hold, the best first. Those of `kept` are not broken.
    /// What is too long for an opening is tilted into it; the hand lets it go so.
    pub fn places(&self, predicates: &[GoalPredicate], kept: &[GoalPredicate]) -> Vec<Pose> {
        let upright = self.places_in(&[DQuat::IDENTITY], self.wanted, predicates, kept);
        let goes_in = predicates.iter().any(|predicate| predicate.predicate == PredicateKind::In);
        match self.long_axis().filter(|_| goes_in && upright.is_empty()) {
            None => upright,
            Some(axis) => {
                let across = DVec3::Z.cross(axis).normalize_or_zero();
                let tilts = TILTS_RAD.map(|tilt_rad| DQuat::from_axis_angle(across, tilt_rad));
                let tilted = self.places_in(&tilts, CHOICE_OF_TILTED * self.wanted, predicates, kept);
                // What weighs beside a container tips it.
                let off_m = |pose| (self.off_center_m(&pose, predicates), pose);
                let mut tilted: Vec<(f64, Pose)> = tilted.into_iter().map(off_m).collect();
                tilted.sort_by(|(a_m, _), (b_m, _)| a_m.total_cmp(b_m));
                let mut tilted: Vec<Pose> = tilted.into_iter().map(|(_, pose)| pose).collect();
                let gap = DVec3::new(0.0, 0.0, TRIAL_GAP_M);
                let stays = |pose: &&Pose| {
                    self.trials.succeeds(&Pose { translation_m: pose.translation_m + gap, ..**pose })
                };
                let staying: Vec<Pose> = tilted.iter().filter(stays).take(TILTED).copied().collect();
                tilted.truncate(self.wanted);
                if staying.is_empty() { tilted } else { staying }
            }
        }
    }

    /// Horizontal distance of the center of mass from the center of the container that the object goes into, meters; 0
    /// without a container.
    fn off_center_m(&self, pose: &Pose, predicates: &[GoalPredicate]) -> f64 {
        let into = predicates.iter().find(|predicate| predicate.predicate == PredicateKind::In);
        let container = into.and_then(|predicate| find(self.now, predicate.target.as_ref()?));
        let center_m = self.own().at(*pose).center_of_mass_m().truncate();
        container.map_or(0.0, |container| container.footprint().center().distance(center_m))
    }

    /// Up to `wanted` places, in the orientation of now with each of `tilts` and turned about the vertical.
    fn places_in(
        &self,
        tilts: &[DQuat],
        wanted: usize,
        predicates: &[GoalPredicate],
        kept: &[GoalPredicate],
    ) -> Vec<Pose> {
        let mut found: Vec<Pose> = Vec::new();
        for at in self.ranked(predicates) {
            for (turn, tilt) in TURNS.iter().flat_map(|turn| tilts.iter().map(move |tilt| (turn, tilt))) {
                if found.len() == wanted {
                    return found;
                }
                let turn = DQuat::from_rotation_z(turn * std::f64::consts::FRAC_PI_4) * *tilt;
                let pose = self.dropped(at, turn);
                if let Some(pose) = pose.filter(|pose| self.is_good(pose, predicates, kept)) {
                    let there = found.iter().filter(|p| p.translation_m.distance(pose.translation_m) < 1e-3);
                    if there.count() < TURNS_AT_PLACE {
                        found.push(pose);
                    }
                }
            }
        }
        found
    }

    /// The direction of a long object that lies, in the world; `None` for what is not long, or stands.
    fn long_axis(&self) -> Option<DVec3> {
        let (low, high) = self.shapes.shapes[self.object].collision().bounds(&Pose::IDENTITY);
        let size = (high - low).to_array();
        let longest = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b]))?;
        let second_m = (0..3).filter(|k| *k != longest).map(|k| size[k]).fold(0.0, f64::max);
        let axis = self.own().world_from_object.transform_vector(DVec3::AXES[longest]);
        (size[longest] > LONG * second_m && axis.z.abs() < 0.5).then_some(axis)
    }

    /// Free poses on the table, the nearest first: away from everything, and from where `taken` stand at the start,
    /// since another object shall go there.
    pub fn free_places(&self, taken: &[&PosedObject]) -> Vec<Pose> {
        let ranked = self.ranked(&[]).into_iter();
        ranked.filter_map(|at| self.free_place(at, DQuat::IDENTITY, taken)).take(self.wanted).collect()
    }

    /// The pose on the table with the origin at a place and turned from now, if it is free as in
    /// [`PlaceSearch::free_places`].
    pub fn free_place(&self, at: DVec2, turn: DQuat, taken: &[&PosedObject]) -> Option<Pose> {
        let pose = self.dropped(at, turn).filter(|pose| self.is_good(pose, &[], &[]))?;
        let placed = self.own().at(pose).footprint();
        taken.iter().all(|other| placed.distance_m(&other.footprint()) > ROOM_M).then_some(pose)
    }

    /// The pose in which another object was, put down in the own orientation.
    pub fn place_of(&self, other: &PosedObject) -> Vec<Pose> {
        let at = other.footprint().center();
        let own = self.own().footprint().center() - self.own().world_from_object.translation_m.truncate();
        let poses = TURNS.iter().filter_map(|turn| {
            let turn_rad = turn * std::f64::consts::FRAC_PI_4;
            let off = DVec2::from_angle(turn_rad).rotate(own);
            self.dropped(at - off, DQuat::from_rotation_z(turn_rad))
        });
        poses.filter(|pose| self.keeps_away(pose, &[], &[])).collect()
    }

    fn own(&self) -> &PosedObject {
        &self.now[self.object]
    }

    /// Places of the object's origin, the most promising first.
    fn ranked(&self, predicates: &[GoalPredicate]) -> Vec<DVec2> {
        let over = predicates.iter().find_map(|predicate| {
            let target = find(self.now, predicate.target.as_ref()?)?;
            match predicate.predicate {
                PredicateKind::In => Some(self.in_opening(target)),
                PredicateKind::On | PredicateKind::StackedOn => Some(over(target)),
                _ => None,
            }
        });
        let own = self.own();
        // The origin is not always at the center of the object.
        let off = own.footprint().center() - own.world_from_object.translation_m.truncate();
        if let Some(over) = over {
            return over.into_iter().map(|at| at - off).collect();
        }
        let near = predicates.iter().find_map(|p| find(self.now, p.target.as_ref()?));
        let (low, high) = self.outline.bounds();
        let steps = ((high - low) / SPACING_M).floor();
        let mut places: Vec<(f64, DVec2)> = Vec::new();
        for i in 0..=steps.x as i32 {
            for j in 0..=steps.y as i32 {
                let at = low + SPACING_M * DVec2::new(f64::from(i), f64::from(j));
                if self.outline.depth_inside_m(at) > EDGE_M {
                    places.push((self.cost_m(at - off, near), at - off));
                }
            }
        }
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        places.into_iter().map(|(_, at)| at).collect()
    }

    /// Cost of a place on the table, meters: the deviation from the wanted gap to a neighbor, or the distance from the
    /// object's present place.
    fn cost_m(&self, at: DVec2, near: Option<&PosedObject>) -> f64 {
        let own = self.own();
        let way_m = own.world_from_object.translation_m.truncate().distance(at);
        match near {
            None => way_m,
            Some(near) => {
                let pose = Pose {
                    translation_m: at.extend(own.world_from_object.translation_m.z),
                    ..own.world_from_object
                };
                let gap_m = own.at(pose).footprint().distance_m(&near.footprint());
                (gap_m - NEIGHBOR_GAP_M).abs() + 0.1 * way_m
            }
        }
    }

    /// Places in an opening, its center first.
    fn in_opening(&self, target: &PosedObject) -> Vec<DVec2> {
        let Some(opening) = target.shape.opening() else { return over(target) };
        let center = opening.center_m();
        let radius_m = opening.depth_inside_m(center).max(0.0);
        let offsets = rings(&[0.0, 0.25, 0.5, 0.75]).into_iter().map(|offset| {
            let at = center + (radius_m * offset).extend(0.0);
            target.world_from_object.transform_point(at).truncate()
        });
        offsets.collect()
    }

    /// The object dropped with its origin at a place, turned from its orientation of now.
    fn dropped(&self, at: DVec2, turn: DQuat) -> Option<Pose> {
        let rotation = (turn * self.own().world_from_object.rotation).normalize();
        let others = self.now.iter().enumerate().filter(|(index, _)| *index != self.object);
        let supporters: Vec<PosedShape> =
            others.map(|(_, other)| other.posed_shape()).chain([self.table]).collect();
        let shape = self.shapes.shapes[self.object].collision();
        let height_m = drop_height(shape, rotation, at, &supporters)?;
        Some(Pose { translation_m: at.extend(height_m), rotation })
    }

    fn is_good(&self, pose: &Pose, predicates: &[GoalPredicate], kept: &[GoalPredicate]) -> bool {
        let supports: Vec<&PosedObject> = predicates
            .iter()
            .filter(|p| {
                matches!(p.predicate, PredicateKind::In | PredicateKind::On | PredicateKind::StackedOn)
            })
            .filter_map(|p| find(self.now, p.target.as_ref()?))
            .collect();
        let placed = self.own().at(*pose);
        if supports.is_empty() {
            let footprint = placed.footprint();
            let on_table = footprint.bottom_m < 0.003;
            let inside = footprint.corners().iter().all(|p| self.outline.depth_inside_m(*p) > EDGE_M);
            if !on_table || !inside {
                return false;
            }
        }
        let containers = predicates.iter().filter(|p| p.predicate == PredicateKind::In);
        let containers: Vec<&PosedObject> =
            containers.filter_map(|p| find(self.now, p.target.as_ref()?)).collect();
        if !self.keeps_away(pose, &supports, &containers) {
            return false;
        }
        let mut then: Vec<PosedObject> = self.now.to_vec();
        then[self.object] = placed;
        let situation = Situation { table: self.outline, start: self.start, now: &then, contacts: &[] };
        predicates.iter().chain(kept).all(|predicate| evaluate_predicate(predicate, &situation).holds)
    }

    /// Whether the object at a pose is away from all others but its supports, and but what ends below it: the fingers
    /// do not get as low. It may lie on what is in the container that it goes into.
    fn keeps_away(&self, pose: &Pose, supports: &[&PosedObject], containers: &[&PosedObject]) -> bool {
        let placed = self.own().at(*pose);
        let bottom_m = placed.footprint().bottom_m;
        let ends_below = |other: &PosedObject| other.footprint().top_m < bottom_m + BELOW_M;
        let is_mate = |other: &PosedObject| {
            containers.iter().any(|container| {
                let center_m =
                    container.world_from_object.inverse().transform_point(other.center_of_mass_m());
                container.shape.opening().is_some_and(|opening| opening.depth_inside_m(center_m) > 0.0)
            })
        };
        self.now.iter().enumerate().all(|(index, other)| {
            index == self.object
                || supports.iter().any(|support| support.name == other.name)
                || !are_closer(&placed.posed_shape(), &other.posed_shape(), KEEP_AWAY_M)
                || ends_below(other)
                || is_mate(other)
        })
    }
}

/// Places over a target, its center first.
fn over(target: &PosedObject) -> Vec<DVec2> {
    let footprint = target.footprint();
    let (low, high) = footprint.bounds();
    let half = 0.5 * (high - low);
    rings(&[0.0, 0.2, 0.4, 0.6, 0.8]).into_iter().map(|offset| footprint.center() + half * offset).collect()
}

/// Points on circles about the origin.
fn rings(radii: &[f64]) -> Vec<DVec2> {
    let ring = |&radius: &f64| {
        let count = if radius == 0.0 { 1 } else { 8 };
        (0..count)
            .map(move |k| radius * DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / f64::from(count)))
    };
    radii.iter().flat_map(ring).collect()
}
