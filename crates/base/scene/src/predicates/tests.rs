//! Examples of every relation and arrangement, on both sides of their tolerances.

use super::*;
use crate::description::ArrangementKind;

/// A box of this width and depth standing on the table.
fn block(x: f64, y: f64, width: f64, depth: f64) -> PosedFootprint {
    raised(x, y, width, depth, 0.0)
}

fn raised(x: f64, y: f64, width: f64, depth: f64, bottom_m: f64) -> PosedFootprint {
    let half = 0.5 * DVec2::new(width, depth);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let points = corners.map(|c| DVec2::new(x, y) + half * DVec2::from(c));
    PosedFootprint::new(&points, 0.0, bottom_m, bottom_m + 0.1)
}

fn cube(x: f64, y: f64) -> PosedFootprint {
    block(x, y, 0.1, 0.1)
}

fn yawed(mut object: PosedFootprint, yaw_rad: f64) -> PosedFootprint {
    object.yaw_rad = yaw_rad;
    object
}

/// 1.2 m by 0.8 m.
fn table() -> Outline {
    Outline::new([(-0.6, -0.4), (0.6, -0.4), (0.6, 0.4), (-0.6, 0.4)].map(DVec2::from).to_vec())
        .expect("a rectangle")
}

#[test]
fn relations_to_one_object_hold_within_their_tolerances() {
    use RelationKind::*;
    // The target is a cube at the origin.
    let cases: &[(RelationKind, PosedFootprint, Option<f64>, bool)] = &[
        (LeftOf, cube(-0.2, 0.0), None, true),
        (LeftOf, cube(-0.2, 0.19), None, true),
        (LeftOf, cube(-0.2, 0.21), None, false),
        (LeftOf, cube(0.2, 0.0), None, false),
        (LeftOf, cube(-0.07, 0.0), None, false),
        (RightOf, cube(0.5, 0.1), None, true),
        (RightOf, cube(0.0, 0.2), None, false),
        (InFrontOf, cube(0.0, -0.2), None, true),
        (InFrontOf, cube(0.0, 0.2), None, false),
        (Behind, cube(0.05, 0.2), None, true),
        (Behind, cube(0.0, -0.2), None, false),
        (RightOf, cube(0.3, 0.0), Some(0.2), true),
        (RightOf, cube(0.305, 0.03), Some(0.2), true),
        (RightOf, cube(0.32, 0.0), Some(0.2), false),
        (RightOf, cube(-0.3, 0.0), Some(0.2), false),
        (NextTo, cube(0.2, 0.1), None, true),
        (NextTo, cube(0.3, 0.0), None, false),
        (NextTo, cube(0.05, 0.0), None, false),
        (NextTo, cube(0.3, 0.0), Some(0.2), true),
        (NextTo, cube(0.13, 0.14), Some(0.05), true),
        (NextTo, cube(0.13, 0.0), Some(0.05), false),
        (Around, cube(0.5, 0.0), None, true),
        (Around, cube(0.8, 0.0), None, false),
        (Facing, cube(0.0, 0.3), None, true),
        (Facing, cube(0.04, 0.3), None, true),
        (Facing, cube(0.0, -0.3), None, false),
        (Facing, yawed(cube(0.3, 0.0), -FRAC_PI_2), None, true),
        (Facing, yawed(cube(0.3, 0.0), -FRAC_PI_2 + 0.17), None, true),
        (Facing, yawed(cube(0.3, 0.0), -FRAC_PI_2 + 0.18), None, false),
        (ParallelTo, yawed(cube(0.3, 0.0), PI + 0.1), None, true),
        (ParallelTo, yawed(cube(0.3, 0.0), 0.2), None, false),
        // A ruler whose long side is its own y axis.
        (ParallelTo, yawed(block(0.3, 0.0, 0.4, 0.03), PI / 2.0), None, true),
        (ParallelTo, block(0.3, 0.0, 0.03, 0.4), None, false),
        (On, raised(0.04, 0.0, 0.1, 0.1, 0.1), None, true),
        (On, raised(0.0, 0.0, 0.1, 0.1, 0.0), None, false),
        (On, raised(0.07, 0.0, 0.1, 0.1, 0.1), None, false),
        (On, raised(0.0, 0.0, 0.1, 0.1, 0.2), None, false),
        (StackedOn, raised(0.0, 0.01, 0.1, 0.1, 0.1), None, true),
        (In, raised(0.0, 0.0, 0.05, 0.05, 0.01), None, true),
        (In, raised(0.0, 0.0, 0.05, 0.05, 0.1), None, false),
        (In, cube(0.2, 0.0), None, false),
        (AtLeft, cube(-0.4, 0.0), None, false),
    ];
    let target = cube(0.0, 0.0);
    for (kind, object, distance_m, expected) in cases {
        let relation = PosedRelation {
            kind: *kind,
            object,
            target: Some(&target),
            second_target: None,
            distance_m: *distance_m,
        };
        assert_eq!(holds(&relation, &table()), *expected, "{kind:?} {distance_m:?} {:?}", object.center());
    }
}

#[test]
fn relations_to_the_table_hold_within_their_tolerances() {
    use RelationKind::*;
    let cases: &[(RelationKind, PosedFootprint, Option<f64>, bool)] = &[
        (AtCenter, cube(0.1, 0.1), None, true),
        (AtCenter, cube(0.3, 0.0), None, false),
        (AtLeft, cube(-0.3, 0.3), None, true),
        (AtLeft, cube(0.0, 0.0), None, false),
        (AtRight, cube(0.3, 0.0), None, true),
        (AtFront, cube(0.0, -0.2), None, true),
        (AtFront, cube(0.0, 0.2), None, false),
        (AtBack, cube(0.5, 0.2), None, true),
        (AtBackLeft, cube(-0.4, 0.3), None, true),
        (AtBackLeft, cube(-0.4, 0.0), None, false),
        (AtBackRight, cube(0.4, 0.3), None, true),
        (AtFrontLeft, cube(-0.4, -0.3), None, true),
        (AtFrontRight, cube(0.4, -0.3), None, true),
        (AtFrontRight, cube(-0.4, -0.3), None, false),
        (FromLeftEdge, cube(-0.45, 0.1), Some(0.1), true),
        (FromLeftEdge, cube(-0.43, 0.1), Some(0.1), false),
        (FromRightEdge, cube(0.35, 0.1), Some(0.2), true),
        (FromFrontEdge, cube(0.0, -0.3), Some(0.05), true),
        (FromBackEdge, cube(0.0, -0.3), Some(0.65), true),
        (FromBackEdge, cube(0.0, 0.3), None, true),
        (FromBackEdge, cube(0.0, 0.0), None, false),
        (Facing, cube(0.0, 0.3), None, true),
        (Facing, yawed(cube(0.0, 0.3), PI), None, false),
        (On, cube(0.0, 0.0), None, true),
        (LeftOf, cube(-0.4, 0.0), None, false),
    ];
    for (kind, object, distance_m, expected) in cases {
        let relation =
            PosedRelation { kind: *kind, object, target: None, second_target: None, distance_m: *distance_m };
        assert_eq!(holds(&relation, &table()), *expected, "{kind:?} {distance_m:?} {:?}", object.center());
    }
}

#[test]
fn between_needs_the_central_third_and_no_overlap() {
    let (first, second) = (cube(-0.3, 0.0), cube(0.3, 0.0));
    let is_between = |object: &PosedFootprint| {
        let relation = PosedRelation {
            kind: RelationKind::Between,
            object,
            target: Some(&first),
            second_target: Some(&second),
            distance_m: None,
        };
        holds(&relation, &table())
    };
    assert!(is_between(&cube(0.09, 0.1)));
    assert!(!is_between(&cube(0.11, 0.0)), "beyond the central third");
    assert!(!is_between(&cube(0.0, 0.16)), "beside the segment");
    assert!(!is_between(&block(0.0, 0.0, 0.55, 0.1)), "overlaps both");
}

#[test]
fn arrangements_hold_in_their_order_with_their_gaps() {
    use ArrangementKind::*;
    let at =
        |points: &[(f64, f64)]| -> Vec<PosedFootprint> { points.iter().map(|&(x, y)| cube(x, y)).collect() };
    let ring = |radius_m: f64, count: u32| -> Vec<PosedFootprint> {
        let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(count);
        (0..count).map(|k| DVec2::from_angle(angle(k)) * radius_m).map(|p| cube(p.x, p.y)).collect()
    };
    let layered = |points: &[(f64, f64)]| -> Vec<PosedFootprint> {
        points.iter().map(|&(x, z)| raised(x, 0.0, 0.1, 0.1, z)).collect()
    };
    let reversed = |mut objects: Vec<PosedFootprint>| {
        objects.reverse();
        objects
    };
    let row = at(&[(0.0, 0.0), (0.15, 0.01), (0.3, 0.0)]);
    let pyramid = layered(&[(0.0, 0.0), (0.1, 0.0), (0.2, 0.0), (0.05, 0.1), (0.15, 0.1), (0.1, 0.2)]);
    let fallen = layered(&[(0.0, 0.0), (0.1, 0.0), (0.2, 0.0), (0.05, 0.1), (0.15, 0.1), (0.3, 0.0)]);
    let grid = at(&[(0.0, 0.0), (0.15, 0.0), (0.0, 0.15), (0.15, 0.15), (0.0, 0.3)]);
    let cases: Vec<(ArrangementKind, Vec<PosedFootprint>, Option<f64>, bool)> = vec![
        (Row, row.clone(), None, true),
        (Row, row.clone(), Some(0.05), true),
        (Row, row.clone(), Some(0.07), false),
        (Row, reversed(row.clone()), None, false),
        (Column, row.clone(), None, false),
        (Column, at(&[(0.0, 0.0), (0.0, 0.15), (0.01, 0.3)]), Some(0.05), true),
        (Row, at(&[(0.0, 0.0), (0.15, 0.06)]), None, false),
        (Row, at(&[(0.0, 0.0), (0.05, 0.0)]), None, false),
        (Grid { columns: 2 }, grid.clone(), None, true),
        (Grid { columns: 2 }, grid.clone(), Some(0.05), true),
        (Grid { columns: 3 }, grid, None, false),
        (Circle, ring(0.2, 5), None, true),
        (Circle, reversed(ring(0.2, 5)), None, false),
        (Circle, row.clone(), None, false),
        (Pile, at(&[(0.0, 0.0), (0.11, 0.05), (0.05, 0.11), (0.05, 0.02)]), None, true),
        (Pile, row.clone(), None, false),
        (Pyramid, pyramid.clone(), None, true),
        (Pyramid, pyramid[..5].to_vec(), None, true),
        (Pyramid, fallen, None, false),
        (Row, row[..1].to_vec(), None, false),
    ];
    for (number, (kind, objects, gap_m, expected)) in cases.iter().enumerate() {
        let refs: Vec<&PosedFootprint> = objects.iter().collect();
        assert_eq!(arrangement_holds(*kind, &refs, *gap_m, None), *expected, "case {number}: {kind:?}");
    }
    let around: Vec<PosedFootprint> = ring(0.2, 4);
    let refs: Vec<&PosedFootprint> = around.iter().collect();
    assert!(arrangement_holds(Circle, &refs, None, Some(&cube(0.0, 0.0))));
    assert!(!arrangement_holds(Circle, &refs, None, Some(&cube(0.1, 0.0))), "not at the center");
}

#[test]
fn pyramid_layers_use_every_object_once() {
    assert_eq!(pyramid_layers(10), [4, 3, 2, 1]);
    assert_eq!(pyramid_layers(5), [3, 2]);
    assert_eq!(pyramid_layers(4), [3, 1]);
    for count in 1..40 {
        let layers = pyramid_layers(count);
        assert_eq!(layers.iter().sum::<usize>(), count);
        assert!(layers.windows(2).all(|pair| pair[1] < pair[0]), "{layers:?}");
    }
}

#[test]
fn sides_of_a_setting_are_those_of_the_person_at_the_plate() {
    let object = |id: &str, relations: serde_json::Value| {
        serde_json::json!({
            "id": id, "label": "a thing", "category": "plate", "size_m": [0.1, 0.1, 0.1], "seed": 1,
            "requested": true, "relations": relations,
        })
    };
    let table_spec = serde_json::json!({ "shape": "square", "size_m": [1.2, 0.8, 0.7] });
    for (plate, fork, seated, is_met) in [
        // At the far edge the person's left is the viewer's right.
        (cube(0.0, 0.3), cube(0.2, 0.3), true, true),
        (cube(0.0, 0.3), cube(0.2, 0.3), false, false),
        (cube(0.0, 0.3), cube(-0.2, 0.3), true, false),
        // At the right edge it is nearer to the viewer.
        (cube(0.5, 0.0), cube(0.5, -0.2), true, true),
        (cube(0.5, 0.0), cube(0.3, 0.0), true, false),
        (cube(0.0, -0.3), cube(-0.2, -0.3), true, true),
    ] {
        let relation = serde_json::json!([{ "kind": "left_of", "target": "plate_1", "seated": seated }]);
        let description = serde_json::from_value(serde_json::json!({
            "theme": "dining_table", "family": "dining_kitchen", "table": table_spec, "prose": "",
            "objects": [object("plate_1", serde_json::json!([])), object("fork_1", relation)],
        }))
        .expect("a description");
        let context = format!("plate at {}, fork at {}", plate.center(), fork.center());
        assert_eq!(unmet(&description, &[plate, fork], &table()).is_empty(), is_met, "{context}");
    }
}
