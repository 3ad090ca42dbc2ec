//! Concessions where there is no room: the job fails, objects are made smaller, or an object is moved to free space.
//!
//! Nothing is done unless it is asked for. Where a table is too full all that stands on it is made smaller alike, so
//! that objects keep their proportions; where an object does not find its place in or on another, it alone is, with
//! what it carries. An object is moved only where it was wanted in or on another one: then it stands on the table, on
//! the free place nearest to where it was wanted. World frame, meters; the same parts give the same answer.

use std::f64::consts::TAU;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::Part;
use certificate::{Relaxation, RelaxationKind};
use geometry::{ConvexHull, Outline};
use scene::{SupportTree, Supporter};

/// Section `[no_room]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct NoSpaceSettings {
    /// Treatment of an object that has to be given up.
    pub outcome: OnNoSpace,
    /// Nothing is made smaller than this share of its size, 0.1..1. Less makes room on fuller tables.
    pub min_scale: f64,
}

/// Treatment of an object that has to be given up.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum OnNoSpace {
    /// The job fails and names it.
    Fail,
    /// Objects are made smaller until there is room.
    Shrink,
    /// Objects are moved to free space on the table.
    Move,
}

/// The bodies as they are to be resolved now, and what was conceded so far.
pub(super) struct Attempt {
    /// The table first.
    pub parts: Vec<Part>,
    /// Of the parts after the table.
    pub supports: SupportTree,
    /// Factors on the sizes that the layout gave.
    pub scales: Vec<f64>,
    moved: Vec<Relaxation>,
}

/// Reason why the last try failed.
pub(super) struct Infeasible {
    /// Names of the objects to be given up.
    pub names: Vec<String>,
    /// The table is too full, so that any object could make room.
    pub crowded: bool,
}

/// Objects are made smaller in steps of this factor.
const STEP: f64 = 0.9;
/// Free space around what is moved, and to the table's edge, meters.
const MARGIN_M: f64 = 0.005;
/// Distance between candidate positions, meters.
const PLACES_M: f64 = 0.01;

impl Attempt {
    pub fn new(parts: Vec<Part>, supports: SupportTree) -> Self {
        Self { scales: vec![1.0; parts.len()], parts, supports, moved: Vec::new() }
    }

    /// Concedes what the settings allow; whether that is anything. `hulls` are those of the parts as they are now.
    pub fn give_way(
        &mut self,
        stuck: &Infeasible,
        settings: &NoSpaceSettings,
        hulls: &[&[ConvexHull]],
        outline: &Outline,
    ) -> bool {
        let named: Vec<usize> =
            (1..self.parts.len()).filter(|&k| stuck.names.contains(&self.parts[k].name)).collect();
        match settings.outcome {
            OnNoSpace::Fail => false,
            OnNoSpace::Shrink if stuck.crowded => {
                let all: Vec<usize> = self.supports.children(None).map(|object| object + 1).collect();
                self.shrink(&all, settings.min_scale)
            }
            OnNoSpace::Shrink => self.shrink(&named, settings.min_scale),
            OnNoSpace::Move => {
                let is_on_table = |&k: &usize| self.supports.supporter(k - 1) == Supporter::TABLE;
                let wanted: Vec<usize> = named.into_iter().filter(|k| !is_on_table(k)).collect();
                wanted.into_iter().filter(|k| self.move_to_table(*k, hulls, outline)).count() > 0
            }
        }
    }

    /// Concessions so far, object by object.
    pub fn gave_way(&self) -> Vec<Relaxation> {
        let shrunk = self.parts.iter().zip(&self.scales).filter(|(_, scale)| **scale != 1.0);
        let shrunk = shrunk.map(|(part, &scale)| Relaxation {
            name: part.name.clone(),
            how: RelaxationKind::Shrunk { scale },
        });
        self.moved.iter().cloned().chain(shrunk).collect()
    }

    /// The part and what it carries.
    fn branch(&self, root: usize) -> Vec<usize> {
        self.supports.branch(root - 1).map(|object| object + 1).collect()
    }

    /// Makes the branches smaller by one step, each about its root's origin; whether any could be.
    fn shrink(&mut self, roots: &[usize], min_scale: f64) -> bool {
        let inside_another =
            |root: usize| roots.iter().any(|&other| other != root && self.branch(other).contains(&root));
        let outermost: Vec<usize> = roots.iter().copied().filter(|&root| !inside_another(root)).collect();
        let mut any = false;
        for root in outermost {
            let branch = self.branch(root);
            if branch.iter().any(|&k| self.scales[k] * STEP < min_scale) {
                continue;
            }
            let about = self.parts[root].aligned.translation_m;
            for &k in &branch {
                self.scales[k] *= STEP;
                let at = &mut self.parts[k].aligned.translation_m;
                *at = about + STEP * (*at - about);
            }
            any = true;
        }
        any
    }

    /// Stands the part on the table, on the nearest free place; whether there is one.
    fn move_to_table(&mut self, root: usize, hulls: &[&[ConvexHull]], outline: &Outline) -> bool {
        let branch = self.branch(root);
        let own = self.footprint(&branch, hulls);
        let others: Vec<[DVec2; 2]> = (1..self.parts.len())
            .filter(|k| !branch.contains(k))
            .map(|k| self.footprint(&[k], hulls))
            .collect();
        let Some(way) = free_place(own, &others, outline) else { return false };
        let from = self.supports.supporter(root - 1).parent.map_or(0, |parent| parent + 1);
        let from = self.parts[from].name.clone();
        self.supports.move_to_table(root - 1);
        for &k in &branch {
            self.parts[k].aligned.translation_m += way.extend(0.0);
        }
        self.moved
            .push(Relaxation { name: self.parts[root].name.clone(), how: RelaxationKind::Moved { from } });
        true
    }

    /// Lowest and highest corner of the parts seen from above.
    fn footprint(&self, parts: &[usize], hulls: &[&[ConvexHull]]) -> [DVec2; 2] {
        let corners = parts.iter().flat_map(|&k| {
            let pose = self.parts[k].aligned;
            hulls[k].iter().flat_map(|hull| &hull.points).map(move |p| pose.transform_point(*p).truncate())
        });
        corners.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
    }
}

/// The shortest way for a box to where it is clear of all others and inside the outline.
fn free_place([low, high]: [DVec2; 2], others: &[[DVec2; 2]], outline: &Outline) -> Option<DVec2> {
    let clear = |way: &DVec2| {
        let (low, high) = (low + *way - MARGIN_M, high + *way + MARGIN_M);
        let corners = [low, high, DVec2::new(low.x, high.y), DVec2::new(high.x, low.y)];
        corners.iter().all(|&corner| outline.contains(corner))
            && others.iter().all(|[from, to]| low.cmpgt(*to).any() || high.cmplt(*from).any())
    };
    let (from, to) = outline.bounds();
    let rings = ((to - from).length() / PLACES_M).ceil() as u32;
    (0..rings)
        .flat_map(|ring| {
            let count = if ring == 0 { 1 } else { 8 + 2 * ring.min(20) };
            let reach_m = PLACES_M * f64::from(ring);
            (0..count).map(move |k| reach_m * DVec2::from_angle(TAU * f64::from(k) / f64::from(count)))
        })
        .find(clear)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::pipeline::checkpoint::ArtifactRef;
    use geometry::Pose;
    use geometry::convex_hull::convex_hull;
    use geometry::shapes::{block, rectangle};
    use store::Digest;

    fn part(name: &str, at: DVec2) -> Part {
        let artifact = ArtifactRef {
            name: name.into(),
            digest: Digest::of(name.as_bytes()),
            media_type: "application/octet-stream".into(),
            size: 1,
        };
        Part {
            name: name.into(),
            category: "cube".into(),
            material: None,
            mass_kg: None,
            mesh: artifact.clone(),
            hulls: artifact,
            aligned: Pose::upright(at.extend(0.0), 0.0),
        }
    }

    /// A tray with a cup on it that holds a pen, and a box beside them, all cubes of 10 cm.
    fn attempt() -> Attempt {
        let parts = vec![
            part("table", DVec2::ZERO),
            part("tray", DVec2::ZERO),
            part("cup", DVec2::new(0.02, 0.0)),
            part("pen", DVec2::new(0.03, 0.0)),
            part("box", DVec2::new(0.2, 0.0)),
        ];
        let supporters = vec![Supporter::TABLE, Supporter::on(0), Supporter::containing(1), Supporter::TABLE];
        Attempt::new(parts, SupportTree::new(supporters).expect("a tree"))
    }

    fn give_way(attempt: &mut Attempt, outcome: OnNoSpace, name: &str, crowded: bool, side_m: f64) -> bool {
        let hull = convex_hull(&block(DVec3::splat(0.1)).positions, 64, 0.0).expect("a cube");
        let hulls: Vec<&[ConvexHull]> = (0..5).map(|_| std::slice::from_ref(&hull)).collect();
        let outline = Outline::new(rectangle(side_m, side_m)).expect("a square");
        let settings = NoSpaceSettings { outcome, min_scale: 0.7 };
        attempt.give_way(&Infeasible { names: vec![name.into()], crowded }, &settings, &hulls, &outline)
    }

    #[test]
    fn nothing_is_conceded_unless_asked() {
        let mut attempt = attempt();
        assert!(!give_way(&mut attempt, OnNoSpace::Fail, "pen", true, 1.0));
        assert!(attempt.gave_way().is_empty());
    }

    #[test]
    fn full_table_shrinks_all_objects_alike_and_not_below_the_minimum() {
        let mut attempt = attempt();
        for step in 1..=3 {
            assert!(give_way(&mut attempt, OnNoSpace::Shrink, "box", true, 1.0));
            assert!(attempt.scales[1..].iter().all(|scale| (scale - STEP.powi(step)).abs() < 1e-12));
        }
        assert!(!give_way(&mut attempt, OnNoSpace::Shrink, "box", true, 1.0));
        assert_eq!((attempt.scales[0], attempt.gave_way().len()), (1.0, 4));
        // What stands on the tray has come nearer to its center, and the tray and the box stay where they are.
        let x = |k: usize| attempt.parts[k].aligned.translation_m.x;
        assert!((x(3) - 0.03 * STEP.powi(3)).abs() < 1e-12 && x(1) == 0.0 && x(4) == 0.2);
    }

    #[test]
    fn what_does_not_fit_shrinks_alone_with_what_it_carries() {
        let mut attempt = attempt();
        assert!(give_way(&mut attempt, OnNoSpace::Shrink, "cup", false, 1.0));
        assert_eq!(attempt.scales, [1.0, 1.0, STEP, STEP, 1.0]);
        let message = attempt.gave_way();
        assert_eq!(
            message[0],
            Relaxation { name: "cup".into(), how: RelaxationKind::Shrunk { scale: STEP } }
        );
    }

    #[test]
    fn what_does_not_fit_in_another_moves_to_the_nearest_free_place_and_stands_on_the_table() {
        let mut attempt = attempt();
        assert!(give_way(&mut attempt, OnNoSpace::Move, "cup", false, 1.0));
        assert_eq!(attempt.supports.supporter(1), Supporter::TABLE);
        let way = |k: usize, x: f64| attempt.parts[k].aligned.translation_m - DVec3::new(x, 0.0, 0.0);
        assert!((way(2, 0.02) - way(3, 0.03)).length() < 1e-12, "the pen goes with it");
        let apart = attempt.parts[2].aligned.translation_m.abs().max_element();
        assert!(apart > 0.1 && apart < 0.13, "{apart}");
        assert_eq!(
            attempt.gave_way(),
            [Relaxation { name: "cup".into(), how: RelaxationKind::Moved { from: "tray".into() } }]
        );
        // It stands on the table already, so moving it again does not help; and a full table has no free position.
        assert!(!give_way(&mut attempt, OnNoSpace::Move, "cup", false, 1.0));
        assert!(!give_way(&mut self::attempt(), OnNoSpace::Move, "cup", false, 0.12));
    }
}
