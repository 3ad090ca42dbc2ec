//! A table of situations with the right answers, and the limits of each predicate.

use glam::{DQuat, DVec3};
use scene::text_account::{GoalPredicate, PredicateKind as P};

use super::*;
use crate::test_scenes::{container, id, solid_box, table};
use geometry::Pose;

/// Name of an object or of a target, extents, center of the bottom, tilt about x in degrees.
type Row = (&'static str, [f64; 3], [f64; 3], f64);

/// A case: predicate, objects at the start, objects now, verdict, reason.
struct Case {
    name: &'static str,
    kind: P,
    others: &'static [&'static str],
    start: &'static [Row],
    now: &'static [Row],
    reason: Reason,
}

const CUBE: [f64; 3] = [0.05, 0.05, 0.05];
const BOX: [f64; 3] = [0.16, 0.12, 0.08];
const BOARD: [f64; 3] = [0.3, 0.2, 0.02];
const STICK: [f64; 3] = [0.02, 0.02, 0.18];

/// The object is called `a`; what is called `box...` is open at the top.
const CASES: &[Case] = &[
    Case {
        name: "in the box",
        kind: P::In,
        others: &["box"],
        start: &[],
        now: &[("a", CUBE, [0.02, 0.0, 0.004], 0.0), ("box", BOX, [0.0, 0.0, 0.0], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "beside the box",
        kind: P::In,
        others: &["box"],
        start: &[],
        now: &[("a", CUBE, [0.2, 0.0, 0.0], 0.0), ("box", BOX, [0.0; 3], 0.0)],
        reason: Reason::OutsideOpening,
    },
    Case {
        name: "on the rim, mostly outside",
        kind: P::In,
        others: &["box"],
        start: &[],
        now: &[("a", CUBE, [0.09, 0.0, 0.08], 0.0), ("box", BOX, [0.0; 3], 0.0)],
        reason: Reason::OutsideOpening,
    },
    Case {
        name: "above the opening",
        kind: P::In,
        others: &["box"],
        start: &[],
        now: &[("a", CUBE, [0.0, 0.0, 0.12], 0.0), ("box", BOX, [0.0; 3], 0.0)],
        reason: Reason::AboveRim,
    },
    Case {
        name: "center of mass just below the rim",
        kind: P::In,
        others: &["box"],
        start: &[],
        now: &[("a", CUBE, [0.0, 0.0, 0.054], 0.0), ("box", BOX, [0.0; 3], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "in a solid block",
        kind: P::In,
        others: &["block"],
        start: &[],
        now: &[("a", CUBE, [0.0, 0.0, 0.08], 0.0), ("block", BOX, [0.0; 3], 0.0)],
        reason: Reason::NoOpening,
    },
    Case {
        name: "under the box",
        kind: P::In,
        others: &["box"],
        start: &[],
        now: &[("a", CUBE, [0.0; 3], 0.0), ("box", BOX, [0.0, 0.0, 0.05], 0.0)],
        reason: Reason::UnderFloor,
    },
    Case {
        name: "a stick that stands out",
        kind: P::In,
        others: &["box"],
        start: &[],
        now: &[("a", STICK, [0.0, 0.0, 0.004], 0.0), ("box", BOX, [0.0; 3], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "a stick held over the floor",
        kind: P::In,
        others: &["box"],
        start: &[],
        now: &[("a", STICK, [0.0, 0.0, 0.03], 0.0), ("box", BOX, [0.0; 3], 0.0)],
        reason: Reason::AboveRim,
    },
    Case {
        name: "out of the box",
        kind: P::OutOf,
        others: &["box"],
        start: &[],
        now: &[("a", CUBE, [0.2, 0.0, 0.0], 0.0), ("box", BOX, [0.0; 3], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "still in the box",
        kind: P::OutOf,
        others: &["box"],
        start: &[],
        now: &[("a", CUBE, [0.0, 0.0, 0.004], 0.0), ("box", BOX, [0.0; 3], 0.0)],
        reason: Reason::StillInside,
    },
    Case {
        name: "on the board",
        kind: P::On,
        others: &["board"],
        start: &[],
        now: &[("a", CUBE, [0.1, 0.0, 0.021], 0.0), ("board", BOARD, [0.0; 3], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "hovering above the board",
        kind: P::On,
        others: &["board"],
        start: &[],
        now: &[("a", CUBE, [0.1, 0.0, 0.025], 0.0), ("board", BOARD, [0.0; 3], 0.0)],
        reason: Reason::NoContact,
    },
    Case {
        name: "leaning over the edge of the board",
        kind: P::On,
        others: &["board"],
        start: &[],
        now: &[("a", CUBE, [0.165, 0.0, 0.02], 0.0), ("board", BOARD, [0.0; 3], 0.0)],
        reason: Reason::NoSupportUnderCenter,
    },
    Case {
        name: "touching the side of the board",
        kind: P::On,
        others: &["board"],
        start: &[],
        now: &[("a", CUBE, [0.176, 0.0, 0.0], 0.0), ("board", BOARD, [0.0; 3], 0.0)],
        reason: Reason::NotAbove,
    },
    Case {
        name: "on the table",
        kind: P::On,
        others: &[],
        start: &[],
        now: &[("a", CUBE, [0.1, 0.0, 0.0], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "on the board, not on the table",
        kind: P::On,
        others: &[],
        start: &[],
        now: &[("a", CUBE, [0.1, 0.0, 0.02], 0.0), ("board", BOARD, [0.0; 3], 0.0)],
        reason: Reason::NoContact,
    },
    Case {
        name: "off the board",
        kind: P::Off,
        others: &["board"],
        start: &[],
        now: &[("a", CUBE, [0.3, 0.0, 0.0], 0.0), ("board", BOARD, [0.0; 3], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "not off the board",
        kind: P::Off,
        others: &["board"],
        start: &[],
        now: &[("a", CUBE, [0.0, 0.0, 0.02], 0.0), ("board", BOARD, [0.0; 3], 0.0)],
        reason: Reason::StillSupported,
    },
    Case {
        name: "a cube on a cube",
        kind: P::StackedOn,
        others: &["b"],
        start: &[],
        now: &[("a", CUBE, [0.02, 0.01, 0.05], 0.0), ("b", CUBE, [0.0; 3], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "far from the center of the board",
        kind: P::StackedOn,
        others: &["b"],
        start: &[],
        now: &[("a", [0.1, 0.1, 0.1], [0.045, 0.045, 0.05], 0.0), ("b", [0.07, 0.07, 0.05], [0.0; 3], 0.0)],
        reason: Reason::NoSupportUnderCenter,
    },
    Case {
        name: "left",
        kind: P::LeftOf,
        others: &["b"],
        start: &[],
        now: &[("a", CUBE, [-0.2, 0.05, 0.0], 0.0), ("b", CUBE, [0.0; 3], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "right, not left",
        kind: P::LeftOf,
        others: &["b"],
        start: &[],
        now: &[("a", CUBE, [0.2, 0.0, 0.0], 0.0), ("b", CUBE, [0.0; 3], 0.0)],
        reason: Reason::WrongSide,
    },
    Case {
        name: "behind rather than right",
        kind: P::RightOf,
        others: &["b"],
        start: &[],
        now: &[("a", CUBE, [0.1, 0.3, 0.0], 0.0), ("b", CUBE, [0.0; 3], 0.0)],
        reason: Reason::WrongSide,
    },
    Case {
        name: "in front",
        kind: P::InFrontOf,
        others: &["b"],
        start: &[],
        now: &[("a", CUBE, [0.0, -0.2, 0.0], 0.0), ("b", CUBE, [0.0; 3], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "behind",
        kind: P::Behind,
        others: &["b"],
        start: &[],
        now: &[("a", CUBE, [0.0, 0.2, 0.0], 0.0), ("b", CUBE, [0.0; 3], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "next to",
        kind: P::NextTo,
        others: &["b"],
        start: &[],
        now: &[("a", CUBE, [0.15, 0.0, 0.0], 0.0), ("b", CUBE, [0.0; 3], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "25 cm apart",
        kind: P::NextTo,
        others: &["b"],
        start: &[],
        now: &[("a", CUBE, [0.3, 0.0, 0.0], 0.0), ("b", CUBE, [0.0; 3], 0.0)],
        reason: Reason::TooFar,
    },
    Case {
        name: "on it, not next to it",
        kind: P::NextTo,
        others: &["b"],
        start: &[],
        now: &[("a", CUBE, [0.0, 0.0, 0.05], 0.0), ("b", CUBE, [0.0; 3], 0.0)],
        reason: Reason::Overlapping,
    },
    Case {
        name: "between",
        kind: P::Between,
        others: &["b", "c"],
        start: &[],
        now: &[
            ("a", CUBE, [0.0, 0.02, 0.0], 0.0),
            ("b", CUBE, [-0.2, 0.0, 0.0], 0.0),
            ("c", CUBE, [0.2, 0.0, 0.0], 0.0),
        ],
        reason: Reason::Holds,
    },
    Case {
        name: "beyond both",
        kind: P::Between,
        others: &["b", "c"],
        start: &[],
        now: &[
            ("a", CUBE, [0.3, 0.0, 0.0], 0.0),
            ("b", CUBE, [-0.2, 0.0, 0.0], 0.0),
            ("c", CUBE, [0.2, 0.0, 0.0], 0.0),
        ],
        reason: Reason::NotBetween,
    },
    Case {
        name: "at the left side",
        kind: P::AtLeft,
        others: &[],
        start: &[],
        now: &[("a", CUBE, [-0.4, 0.1, 0.0], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "not at the back",
        kind: P::AtBack,
        others: &[],
        start: &[],
        now: &[("a", CUBE, [-0.4, -0.1, 0.0], 0.0)],
        reason: Reason::OutsideRegion,
    },
    Case {
        name: "farther away",
        kind: P::AwayFrom,
        others: &["b"],
        start: &[("a", CUBE, [0.1, 0.0, 0.0], 0.0), ("b", CUBE, [0.0; 3], 0.0)],
        now: &[("a", CUBE, [0.2, 0.0, 0.0], 0.0), ("b", CUBE, [0.0; 3], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "hardly farther away",
        kind: P::AwayFrom,
        others: &["b"],
        start: &[("a", CUBE, [0.1, 0.0, 0.0], 0.0), ("b", CUBE, [0.0; 3], 0.0)],
        now: &[("a", CUBE, [0.12, 0.0, 0.0], 0.0), ("b", CUBE, [0.0; 3], 0.0)],
        reason: Reason::NotMoved,
    },
    Case {
        name: "swapped",
        kind: P::Swapped,
        others: &["b"],
        start: &[("a", CUBE, [-0.2, 0.0, 0.0], 0.0), ("b", CUBE, [0.2, 0.1, 0.0], 0.0)],
        now: &[("a", CUBE, [0.18, 0.1, 0.0], 0.0), ("b", CUBE, [-0.2, 0.03, 0.0], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "one of them is where it was",
        kind: P::Swapped,
        others: &["b"],
        start: &[("a", CUBE, [-0.2, 0.0, 0.0], 0.0), ("b", CUBE, [0.2, 0.1, 0.0], 0.0)],
        now: &[("a", CUBE, [0.2, 0.1, 0.05], 0.0), ("b", CUBE, [0.2, 0.1, 0.0], 0.0)],
        reason: Reason::NotExchanged,
    },
    Case {
        name: "above the other's place",
        kind: P::Swapped,
        others: &["b"],
        start: &[("a", CUBE, [-0.2, 0.0, 0.0], 0.0), ("b", CUBE, [0.2, 0.1, 0.0], 0.0)],
        now: &[("a", CUBE, [0.2, 0.1, 0.04], 0.0), ("b", CUBE, [-0.2, 0.0, 0.0], 0.0)],
        reason: Reason::NotExchanged,
    },
    Case {
        name: "lifted",
        kind: P::Lifted,
        others: &[],
        start: &[("a", CUBE, [0.0; 3], 0.0)],
        now: &[("a", CUBE, [0.0, 0.0, 0.05], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "lifted by 3 cm",
        kind: P::Lifted,
        others: &[],
        start: &[("a", CUBE, [0.0; 3], 0.0)],
        now: &[("a", CUBE, [0.0, 0.0, 0.03], 0.0)],
        reason: Reason::NotRisen,
    },
    Case {
        name: "put on a block",
        kind: P::Lifted,
        others: &[],
        start: &[("a", CUBE, [0.0; 3], 0.0), ("b", CUBE, [0.2, 0.0, 0.0], 0.0)],
        now: &[("a", CUBE, [0.2, 0.0, 0.05], 0.0), ("b", CUBE, [0.2, 0.0, 0.0], 0.0)],
        reason: Reason::OnAnotherObject,
    },
    Case {
        name: "pushed",
        kind: P::Moved,
        others: &[],
        start: &[("a", CUBE, [0.0; 3], 0.0)],
        now: &[("a", CUBE, [0.04, 0.0, 0.0], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "hardly pushed",
        kind: P::Moved,
        others: &[],
        start: &[("a", CUBE, [0.0; 3], 0.0)],
        now: &[("a", CUBE, [0.02, 0.0, 0.0], 0.0)],
        reason: Reason::NotMoved,
    },
    Case {
        name: "upright",
        kind: P::Upright,
        others: &[],
        start: &[],
        now: &[("a", STICK, [0.0; 3], 10.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "leaning",
        kind: P::Upright,
        others: &[],
        start: &[],
        now: &[("a", STICK, [0.0; 3], 20.0)],
        reason: Reason::WrongPosture,
    },
    Case {
        name: "lying",
        kind: P::LyingOnSide,
        others: &[],
        start: &[],
        now: &[("a", STICK, [0.0, 0.0, 0.01], 85.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "upside down",
        kind: P::UpsideDown,
        others: &[],
        start: &[],
        now: &[("a", CUBE, [0.0, 0.0, 0.05], 180.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "standing, not upside down",
        kind: P::UpsideDown,
        others: &[],
        start: &[],
        now: &[("a", CUBE, [0.0; 3], 0.0)],
        reason: Reason::WrongPosture,
    },
    Case {
        name: "covered",
        kind: P::Closed,
        others: &[],
        start: &[],
        now: &[("box a", BOX, [0.0; 3], 0.0), ("lid", [0.16, 0.12, 0.01], [0.0, 0.0, 0.08], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "lid beside it",
        kind: P::Closed,
        others: &[],
        start: &[],
        now: &[("box a", BOX, [0.0; 3], 0.0), ("lid", [0.16, 0.12, 0.01], [0.3, 0.0, 0.0], 0.0)],
        reason: Reason::NotCovered,
    },
    Case {
        name: "open",
        kind: P::Opened,
        others: &[],
        start: &[],
        now: &[("box a", BOX, [0.0; 3], 0.0), ("lid", [0.16, 0.12, 0.01], [0.3, 0.0, 0.0], 0.0)],
        reason: Reason::Holds,
    },
    Case {
        name: "not open",
        kind: P::Opened,
        others: &[],
        start: &[],
        now: &[("box a", BOX, [0.0; 3], 0.0), ("lid", [0.16, 0.12, 0.01], [0.0, 0.0, 0.08], 0.0)],
        reason: Reason::Covered,
    },
    Case {
        name: "a block neither opens",
        kind: P::Opened,
        others: &[],
        start: &[],
        now: &[("a", CUBE, [0.0; 3], 0.0)],
        reason: Reason::NotDecidable,
    },
    Case {
        name: "a block nor closes",
        kind: P::Closed,
        others: &[],
        start: &[],
        now: &[("a", CUBE, [0.0; 3], 0.0)],
        reason: Reason::NotDecidable,
    },
    Case {
        name: "pressed",
        kind: P::Pressed,
        others: &[],
        start: &[],
        now: &[("a", CUBE, [0.0; 3], 0.0)],
        reason: Reason::NotDecidable,
    },
    Case {
        name: "a missing target",
        kind: P::On,
        others: &["b"],
        start: &[],
        now: &[("a", CUBE, [0.0; 3], 0.0)],
        reason: Reason::MissingObject,
    },
];

fn objects(rows: &[Row]) -> Vec<PosedObject> {
    let posed = |(name, size_m, at_m, tilt): &Row| {
        let object = match name.strip_prefix("box ") {
            Some(name) => container(name, *size_m, *at_m),
            None if name.starts_with("box") => container(name, *size_m, *at_m),
            None => solid_box(name, *size_m, *at_m),
        };
        let rotation = DQuat::from_rotation_x(tilt.to_radians());
        object.at(Pose { translation_m: DVec3::from(*at_m), rotation })
    };
    rows.iter().map(posed).collect()
}

fn predicate(kind: P, others: &[&str]) -> GoalPredicate {
    let other = |k: usize| others.get(k).map(|name| id(name));
    GoalPredicate { predicate: kind, object: id("a"), target: other(0), second_target: other(1) }
}

#[test]
fn predicates_have_the_right_verdicts() {
    let mut faults = Vec::new();
    for case in CASES {
        let now = objects(case.now);
        let start = if case.start.is_empty() { now.clone() } else { objects(case.start) };
        let table = table();
        let situation = Situation { table: &table, start: &start, now: &now, contacts: &[] };
        let outcome = evaluate_predicate(&predicate(case.kind, case.others), &situation);
        let expected = (case.reason == Reason::Holds, case.reason);
        if (outcome.holds, outcome.reason) != expected {
            faults.push(format!("{}: {outcome:?}", case.name));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn turn_about_the_vertical_is_measured() {
    let start = objects(&[("a", CUBE, [0.0; 3], 0.0)]);
    let table = table();
    for (degrees, holds) in [(20.0, false), (40.0, true), (-90.0, true), (350.0, false)] {
        let turned = Pose::upright(DVec3::ZERO, f64::to_radians(degrees));
        let now = vec![start[0].at(turned)];
        let situation = Situation { table: &table, start: &start, now: &now, contacts: &[] };
        assert_eq!(evaluate_predicate(&predicate(P::Rotated, &[]), &situation).holds, holds, "{degrees}");
    }
}

#[test]
fn reported_contact_counts_where_hulls_are_apart() {
    let now = objects(&[("a", CUBE, [0.0, 0.0, 0.026], 0.0), ("b", BOARD, [0.0; 3], 0.0)]);
    let table = table();
    let contacts = [Contact { first: ContactBody::Object(id("b")), second: ContactBody::Object(id("a")) }];
    let verdict = |contacts: &[Contact]| {
        let situation = Situation { table: &table, start: &now, now: &now, contacts };
        evaluate_predicate(&predicate(P::On, &["b"]), &situation).holds
    };
    assert!(!verdict(&[]) && verdict(&contacts));
}

#[test]
fn measured_value_is_compared_with_its_limit() {
    let now = objects(&[("a", CUBE, [0.0, 0.0, 0.05], 0.0)]);
    let start = objects(&[("a", CUBE, [0.0; 3], 0.0)]);
    let table = table();
    let situation = Situation { table: &table, start: &start, now: &now, contacts: &[] };
    let outcome = evaluate_predicate(&predicate(P::Lifted, &[]), &situation);
    assert!((outcome.measured - 0.05).abs() < 1e-9 && outcome.limit == LIFT_M);
    assert_eq!((outcome.bound, outcome.unit), (Bound::AtLeast, Unit::Meters));
}
