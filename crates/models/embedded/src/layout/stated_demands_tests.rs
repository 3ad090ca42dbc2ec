//! Layouts of descriptions with distances, positions, yaws and arrangements: every demand is met for twenty seeds,
//! alone and with three others.

use super::*;
use std::sync::Arc;

use catalog::{Recipe, build_cached, category};
use scene::predicates::{PosedFootprint, Unmet, unmet};
use scene::{
    Arrangement, ArrangementKind, InstanceId, ObjectSpec, Relation, RequestedPose, SceneDescription,
    TableSpec,
};

const SEEDS: u64 = 20;

fn settings() -> LayoutSettings {
    test_settings::section("layout")
}

fn rectangle(width_m: f64, depth_m: f64) -> Outline {
    let half = 0.5 * DVec2::new(width_m, depth_m);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    Outline::new(corners.map(|c| half * DVec2::from(c)).to_vec()).expect("a rectangle")
}

fn circle(diameter_m: f64) -> Outline {
    let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / 64.0;
    let corners = (0..64).map(|k| 0.5 * diameter_m * DVec2::from_angle(angle(k)));
    Outline::new(corners.collect()).expect("a circle")
}

fn id(name: &str) -> InstanceId {
    InstanceId::new(name).expect("a name")
}

/// An object of a category with its typical size, named with a number, such as `mug_1`.
fn object(name: &str) -> ObjectSpec {
    let category_name = name.rsplit_once('_').expect("a number").0;
    let recipe = Recipe::typical(category_name, None, None).expect("a category");
    ObjectSpec {
        id: id(name),
        label: name.to_owned(),
        category: category_name.to_owned(),
        size_m: recipe.size_m,
        color: None,
        material: None,
        seed: 1,
        requested: true,
        stand_in: None,
        pose: RequestedPose::Upright,
        yaw_rad: None,
        position_m: None,
        state: None,
        mass_kg: None,
        relations: Vec::new(),
    }
}

/// The object with relations: kind, target (empty = the table), distance.
fn related(name: &str, relations: &[(RelationKind, &str, Option<f64>)]) -> ObjectSpec {
    let relation = |&(kind, target, distance_m): &(RelationKind, &str, Option<f64>)| Relation {
        distance_m,
        ..Relation::new(kind, (!target.is_empty()).then(|| id(target)))
    };
    ObjectSpec { relations: relations.iter().map(relation).collect(), ..object(name) }
}

fn between(name: &str, first: &str, second: &str) -> ObjectSpec {
    let relation =
        Relation { second_target: Some(id(second)), ..Relation::new(RelationKind::Between, Some(id(first))) };
    ObjectSpec { relations: vec![relation], ..object(name) }
}

fn arrangement(kind: ArrangementKind, names: &[&str], gap_m: Option<f64>) -> Arrangement {
    Arrangement { kind, objects: names.iter().map(|name| id(name)).collect(), gap_m, center: None }
}

fn description(objects: Vec<ObjectSpec>, arrangements: Vec<Arrangement>) -> SceneDescription {
    SceneDescription {
        theme: "hobby_desk".to_owned(),
        family: "office_living".to_owned(),
        table: TableSpec::default(),
        table_size_is_stated: false,
        objects,
        arrangements,
        goal: None,
        excluded_categories: Vec::new(),
        understood: Vec::new(),
        unrecognized: Vec::new(),
        prose: String::new(),
    }
}

/// A layout with its footprints and the demands that it does not meet.
struct Sampled {
    outcome: LayoutOutcome,
    footprints: Vec<PosedFootprint>,
    unmet: Vec<Unmet>,
}

fn sample(
    description: &SceneDescription,
    outline: &Outline,
    seed: u64,
    max_yielding: Yielding,
) -> Result<Sampled, LayoutError> {
    let meshes: Vec<Arc<TexturedMesh>> = description
        .objects
        .iter()
        .map(|spec| {
            build_cached(&Recipe {
                category: spec.category.clone(),
                size_m: spec.size_m,
                color: None,
                material: None,
                seed: spec.seed,
            })
            .expect("a category")
        })
        .collect();
    let find = |id: &InstanceId| description.objects.iter().position(|object| object.id == *id);
    let objects: Vec<LayoutObject> = description
        .objects
        .iter()
        .zip(&meshes)
        .map(|(spec, mesh)| LayoutObject {
            name: spec.id.to_string(),
            category: category(&spec.category).expect("a category"),
            mesh,
            relations: spec.relations.iter().map(|r| (r.kind, r.target.as_ref().and_then(find))).collect(),
        })
        .collect();
    let stated = StatedDemands::of(description);
    let problem = LayoutProblem { objects: &objects, stated: &stated, outline, max_yielding };
    let outcome = lay_out(problem, seed, &settings(), &CancelFlag::default())?;
    let footprints: Vec<PosedFootprint> =
        meshes.iter().zip(&outcome.poses).map(|(mesh, pose)| posed_footprint(mesh, pose)).collect();
    let unmet = unmet(description, &footprints, outline);
    // Objects on the table are apart and inside.
    let supports = support_tree(&objects);
    for a in (0..objects.len()).filter(|&k| supports.supporter(k).parent.is_none()) {
        for corner in footprints[a].corners() {
            assert!(outline.depth_inside_m(*corner) > -1e-6, "{} is beyond the edge", objects[a].name);
        }
        for b in (0..a).filter(|&k| supports.supporter(k).parent.is_none()) {
            let free_m = footprints[a].distance_m(&footprints[b]);
            assert!(free_m > 0.0, "{} and {} overlap by {free_m} m", objects[a].name, objects[b].name);
        }
    }
    Ok(Sampled { outcome, footprints, unmet })
}

/// Every demand is met for all seeds, and nothing had to yield.
fn check(name: &str, description: &SceneDescription, outline: &Outline) {
    let mut failed = Vec::new();
    for seed in 1..=SEEDS {
        match sample(description, outline, seed, Yielding::Habits) {
            Ok(sampled) if sampled.unmet.is_empty() => {}
            Ok(sampled) => failed.push(format!("seed {seed}: {:?}", sampled.unmet)),
            Err(error) => failed.push(format!("seed {seed}: {error}")),
        }
    }
    assert!(failed.is_empty(), "{name}: {} of {SEEDS}: {}", failed.len(), failed.join("; "));
}

/// Descriptions with one kind of demand each.
fn single_demands() -> Vec<(&'static str, SceneDescription)> {
    use RelationKind::*;
    let pair = |kind: RelationKind, distance_m: f64| {
        description(vec![object("mug_1"), related("bowl_1", &[(kind, "mug_1", Some(distance_m))])], vec![])
    };
    let alone = |spec: ObjectSpec| description(vec![spec], vec![]);
    let row = |kind: ArrangementKind, gap_m: Option<f64>| {
        let names = ["apple_1", "apple_2", "apple_3", "apple_4"];
        description(names.map(object).to_vec(), vec![arrangement(kind, &names, gap_m)])
    };
    let mut around = row(ArrangementKind::Circle, None);
    around.objects.push(object("plate_1"));
    around.arrangements[0].center = Some(id("plate_1"));
    vec![
        ("left of", pair(LeftOf, 0.2)),
        ("right of", pair(RightOf, 0.1)),
        ("in front of", pair(InFrontOf, 0.05)),
        ("behind", pair(Behind, 0.12)),
        ("close", pair(NextTo, 0.01)),
        ("apart", pair(NextTo, 0.3)),
        ("left edge", alone(related("mug_1", &[(FromLeftEdge, "", Some(0.1))]))),
        ("right edge", alone(related("mug_1", &[(FromRightEdge, "", Some(0.25))]))),
        ("front edge", alone(related("laptop_1", &[(FromFrontEdge, "", Some(0.01))]))),
        ("back edge", alone(related("mug_1", &[(FromBackEdge, "", None)]))),
        ("back left", alone(related("mug_1", &[(AtBackLeft, "", None)]))),
        ("back right", alone(related("book_1", &[(AtBackRight, "", None)]))),
        ("front left", alone(related("mug_1", &[(AtFrontLeft, "", None)]))),
        ("front right", alone(related("mug_1", &[(AtFrontRight, "", None)]))),
        (
            "between",
            description(
                vec![object("mug_1"), object("plate_1"), between("apple_1", "mug_1", "plate_1")],
                vec![],
            ),
        ),
        (
            "facing",
            description(vec![object("mug_1"), related("laptop_1", &[(Facing, "mug_1", None)])], vec![]),
        ),
        (
            "facing each other",
            description(
                vec![
                    related("laptop_1", &[(Facing, "laptop_2", None)]),
                    related("laptop_2", &[(Facing, "laptop_1", None)]),
                ],
                vec![],
            ),
        ),
        (
            "parallel",
            description(
                vec![
                    ObjectSpec { yaw_rad: Some(0.6), ..object("book_1") },
                    related("keyboard_1", &[(ParallelTo, "book_1", None)]),
                ],
                vec![],
            ),
        ),
        ("yaw", alone(ObjectSpec { yaw_rad: Some(-0.8), ..object("laptop_1") })),
        ("position", alone(ObjectSpec { position_m: Some(DVec2::new(-0.3, 0.15)), ..object("mug_1") })),
        ("row", row(ArrangementKind::Row, None)),
        ("row with gap", row(ArrangementKind::Row, Some(0.05))),
        ("column", row(ArrangementKind::Column, Some(0.03))),
        ("grid", row(ArrangementKind::Grid { columns: 2 }, Some(0.04))),
        ("circle", row(ArrangementKind::Circle, None)),
        ("circle with gap", row(ArrangementKind::Circle, Some(0.02))),
        ("circle around a plate", around),
        ("pile", row(ArrangementKind::Pile, None)),
    ]
}

#[test]
fn every_single_demand_is_met_for_twenty_seeds() {
    for (name, description) in single_demands() {
        check(name, &description, &rectangle(1.2, 0.7));
    }
}

#[test]
fn places_between_and_rows_are_met_on_small_and_round_tables() {
    let small = ["left of", "close", "back left", "front right", "between", "row", "circle with gap", "pile"];
    for (name, description) in single_demands().into_iter().filter(|(name, _)| small.contains(name)) {
        check(name, &description, &circle(0.7));
        check(name, &description, &rectangle(0.6, 0.6));
    }
}

#[test]
fn combinations_of_four_demands_are_met_for_twenty_seeds() {
    use RelationKind::*;
    let outline = rectangle(1.4, 0.8);
    let edges = description(
        vec![
            related("mug_1", &[(FromLeftEdge, "", Some(0.1)), (FromFrontEdge, "", Some(0.2))]),
            related("bowl_1", &[(RightOf, "mug_1", Some(0.15))]),
            related("book_1", &[(Behind, "bowl_1", Some(0.05))]),
            related("laptop_1", &[(AtBackRight, "", None)]),
        ],
        vec![],
    );
    check("edges and distances", &edges, &outline);
    let pinned = description(
        vec![
            related("mug_1", &[(NextTo, "plate_1", Some(0.05)), (FromFrontEdge, "", Some(0.1))]),
            object("plate_1"),
            related("apple_1", &[(LeftOf, "plate_1", Some(0.2))]),
            ObjectSpec { position_m: Some(DVec2::new(0.4, 0.1)), yaw_rad: Some(0.3), ..object("book_1") },
        ],
        vec![],
    );
    check("pinned", &pinned, &outline);
    let facing = description(
        vec![
            object("mug_1"),
            object("plate_1"),
            between("apple_1", "mug_1", "plate_1"),
            related("laptop_1", &[(Facing, "apple_1", None), (AtBackLeft, "", None)]),
            related("keyboard_1", &[(ParallelTo, "laptop_1", None), (AtFront, "", None)]),
        ],
        vec![],
    );
    check("facing and between", &facing, &outline);
    let names = ["apple_1", "apple_2", "apple_3"];
    let mut objects = names.map(object).to_vec();
    objects[0].relations.push(Relation::new(AtBack, None));
    objects.push(related("mug_1", &[(InFrontOf, "apple_2", Some(0.08))]));
    objects.push(related("plate_1", &[(FromRightEdge, "", Some(0.05))]));
    objects.push(related("fork_1", &[(LeftOf, "plate_1", Some(0.03))]));
    let row = description(objects, vec![arrangement(ArrangementKind::Row, &names, Some(0.06))]);
    check("row with neighbors", &row, &outline);
}

#[test]
fn pyramid_of_six_has_three_layers() {
    // The image generator adds these supports.
    let names =
        ["tissue_box_1", "tissue_box_2", "tissue_box_3", "tissue_box_4", "tissue_box_5", "tissue_box_6"];
    let mut objects = names.map(object).to_vec();
    for (upper, lower) in [(3, 0), (4, 1), (5, 3)] {
        objects[upper].relations.push(Relation::new(RelationKind::On, Some(id(names[lower]))));
    }
    let description = description(objects, vec![arrangement(ArrangementKind::Pyramid, &names, None)]);
    check("pyramid", &description, &rectangle(1.2, 0.7));
}

#[test]
fn demands_yield_in_the_documented_order() {
    use RelationKind::*;
    let sampled = |objects: Vec<ObjectSpec>, outline: &Outline| {
        let description = description(objects, vec![]);
        sample(&description, outline, 1, Yielding::Relations).expect("room")
    };
    let kinds = |sampled: &Sampled| -> Vec<RelationKind> {
        let kind = |unmet: &Unmet| match unmet.demand {
            scene::predicates::UnmetDemand::Relation { relation, .. } => relation,
            ref other => panic!("{other:?}"),
        };
        sampled.unmet.iter().map(kind).collect()
    };
    // A place contradicts a distance: the place yields.
    let place = sampled(
        vec![related("mug_1", &[(AtLeft, "", None), (FromRightEdge, "", Some(0.1))])],
        &rectangle(1.2, 0.7),
    );
    assert_eq!((place.outcome.yielded, kinds(&place)), (Yielding::Places, vec![AtLeft]));
    // Next to the plate contradicts the corner: closeness yields first.
    let close = sampled(
        vec![
            related("plate_1", &[(AtBackLeft, "", None)]),
            related("mug_1", &[(NextTo, "plate_1", None), (AtFrontRight, "", None)]),
        ],
        &rectangle(1.6, 1.0),
    );
    assert_eq!((close.outcome.yielded, kinds(&close)), (Yielding::Closeness, vec![NextTo]));
    // A distance that is wider than the table.
    let far = sampled(
        vec![object("mug_1"), related("bowl_1", &[(LeftOf, "mug_1", Some(2.0))])],
        &rectangle(1.2, 0.7),
    );
    assert_eq!((far.outcome.yielded, kinds(&far)), (Yielding::Distances, vec![LeftOf]));
    // Left of and right of at once.
    let both = sampled(
        vec![object("mug_1"), related("bowl_1", &[(LeftOf, "mug_1", None), (RightOf, "mug_1", None)])],
        &rectangle(1.2, 0.7),
    );
    assert_eq!((both.outcome.yielded, both.unmet.len()), (Yielding::Relations, 1));
    assert!(both.footprints.iter().all(|footprint| footprint.bottom_m.abs() < 1e-6));
}

#[test]
fn descriptions_without_demands_keep_their_layout() {
    let objects = vec![object("laptop_1"), related("mug_1", &[(RelationKind::RightOf, "laptop_1", None)])];
    let description = description(objects, vec![]);
    let outline = rectangle(1.2, 0.7);
    assert_eq!(StatedDemands::of(&description), StatedDemands::default());
    let strict = sample(&description, &outline, 3, Yielding::Nothing).expect("room");
    let tolerant = sample(&description, &outline, 3, Yielding::Relations).expect("room");
    assert_eq!(strict.outcome, tolerant.outcome);
    assert_eq!(strict.outcome.yielded, Yielding::Nothing);
}
