//! Settled scenes of descriptions with poses, arrangements, contradictions and small tables.

use super::tests::{call, image_generator};
use super::*;
use crate::mesh_generator::{EmbeddedMeshGenerator, MeshSettings};
use catalog::Recipe;
use geometry::{DVec2, DVec3};
use ports::{MeshGenerator, ReconstructionRequest, UprightQuestion, stood_up};
use scene::predicates::UnmetDemand;
use scene::{
    Arrangement, ArrangementKind, InstanceId, ObjectSpec, Relation, RelationKind, RequestedPose, TableSpec,
};

fn id(name: &str) -> InstanceId {
    InstanceId::new(name).expect("a name")
}

/// An object of a category with its typical size, named with a number, such as `mug_1`.
fn object(name: &str) -> ObjectSpec {
    let category_name = name.rsplit_once('_').expect("a number").0;
    ObjectSpec {
        id: id(name),
        label: name.to_owned(),
        category: category_name.to_owned(),
        size_m: Recipe::typical(category_name, None, None).expect("a category").size_m,
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

fn description(table: (&str, DVec3), objects: Vec<ObjectSpec>) -> SceneDescription {
    SceneDescription {
        theme: "hobby_desk".to_owned(),
        family: "office_living".to_owned(),
        table: TableSpec { model: Some(table.0.to_owned()), size_m: Some(table.1), ..TableSpec::default() },
        table_size_is_stated: true,
        objects,
        arrangements: Vec::new(),
        goal: None,
        excluded_categories: Vec::new(),
        understood: Vec::new(),
        unrecognized: Vec::new(),
        prose: String::new(),
    }
}

const DESK: (&str, DVec3) = ("dining_table", DVec3::new(1.4, 0.8, 0.74));

async fn reference(description: SceneDescription) -> GeneratedReference {
    image_generator().reference(&call(2), Arc::new(description), 5).await.expect("a reference image")
}

#[tokio::test]
async fn objects_in_requested_poses_settle_so_and_are_recognized_and_stood_up_so() {
    let objects = vec![
        ObjectSpec { pose: RequestedPose::LyingOnSide, ..object("wine_bottle_1") },
        ObjectSpec { pose: RequestedPose::UpsideDown, ..object("bowl_1") },
        object("book_1"),
    ];
    let generated = reference(description(DESK, objects.clone())).await;
    assert_eq!(generated.unmet, []);
    let truth = generated.ground_truth.expect("ground truth");
    for ((spec, object), instance) in
        objects.iter().zip(&truth.known.recognition.objects).zip(&truth.truth.instances)
    {
        // The mesh is rotated, so the settled pose is upright in its frame.
        assert!((instance.rotation_xyzw * DVec3::Z).z > 0.97, "{}: {}", spec.id, instance.rotation_xyzw);
        assert_eq!(object.tipped.is_some(), !spec.pose.is_upright());
        assert!((object.size_m - instance.size_m).abs().max_element() < 0.01, "{}", spec.id);
        if let Some(tipped) = &object.tipped {
            assert_eq!(tipped.upright_size_m, spec.size_m);
        }
    }
    let bottle = &truth.known.recognition.objects[0];
    assert!(bottle.size_m.x > 2.0 * bottle.size_m.z, "{}", bottle.size_m);

    // The mesh generator rebuilds it in any orientation, and standing it up gives the rendered mesh.
    let photograph = image_generator().photograph;
    for (k, object) in truth.known.recognition.objects.iter().enumerate().take(2) {
        let request = ReconstructionRequest {
            object: object.clone(),
            completion: truth.alone[k].completion.clone(),
            camera: truth.known.recognition.camera,
            rendered: true,
            seed: 11,
        };
        let meshes = MeshSettings { wear: 0.3 };
        let generator = EmbeddedMeshGenerator { photograph: photograph.clone(), meshes };
        let raw = generator.reconstruct(&call(1), request).await.expect("a mesh");
        let question = UprightQuestion {
            raw_mesh: Arc::new(raw.mesh),
            object: object.clone(),
            camera: truth.known.recognition.camera,
            completion: truth.alone[k].completion.clone(),
            canonicalize: test_settings::section("canonicalize"),
            dro: test_settings::section("dro"),
        };
        let typical =
            catalog::build_cached(&Recipe::typical(&object.category, None, None).expect("a category"));
        let pose = object.tipped.as_ref().expect("a tipped object").pose;
        let example = crate::requested_pose::posed(&typical.expect("a mesh"), pose);
        let stood = stood_up(&question, example.as_ref(), &[], &CancelFlag::default()).expect("a pose");
        let mesh = (*question.raw_mesh).clone().rotated(stood.rotation).scaled(DVec3::splat(stood.scale));
        let size_m = mesh.size_m();
        assert!((size_m / object.size_m - 1.0).abs().max_element() < 0.1, "{}: {size_m}", object.id);
    }
}

/// A pyramid of objects of one category, named with the numbers from 1.
fn pyramid(category_name: &str, count: usize) -> SceneDescription {
    let names: Vec<String> = (1..=count).map(|number| format!("{category_name}_{number}")).collect();
    let mut objects: Vec<ObjectSpec> = names.iter().map(|name| object(name)).collect();
    // Objects of a request differ in size; those of a pyramid do not.
    for (k, object) in objects.iter_mut().enumerate() {
        object.size_m *= 1.0 + 0.01 * k as f64;
    }
    let mut description = description(DESK, objects);
    description.arrangements.push(Arrangement {
        kind: ArrangementKind::Pyramid,
        objects: names.iter().map(|name| id(name)).collect(),
        gap_m: None,
        center: None,
    });
    description
}

#[tokio::test]
async fn pyramid_of_boxes_stands_after_settling() {
    for (category_name, count, layers) in [("cube", 3, 2), ("cube", 6, 3), ("soda_can", 6, 3), ("book", 3, 2)]
    {
        let generated = reference(pyramid(category_name, count)).await;
        assert_eq!(generated.unmet, [], "{category_name}");
        let instances = generated.ground_truth.expect("ground truth").truth.instances;
        let top_m = instances.iter().map(|instance| instance.translation_m.z).fold(0.0, f64::max);
        let height_m = f64::from(layers - 1) * instances[0].size_m.z;
        assert!((top_m / height_m - 1.0).abs() < 0.05, "{count} of {category_name}: {top_m} of {height_m}");
    }
}

#[tokio::test]
async fn pyramid_of_what_cannot_be_stacked_stands_on_the_table_and_is_reported() {
    let generated = reference(pyramid("tennis_ball", 6)).await;
    let is_pyramid = |demand: &UnmetDemand| matches!(demand, UnmetDemand::Arrangement { .. });
    assert!(generated.unmet.iter().any(|unmet| is_pyramid(&unmet.demand)), "{:?}", generated.unmet);
}

#[tokio::test]
async fn contradictory_relations_are_reported_and_do_not_fail() {
    use RelationKind::{LeftOf, RightOf};
    let mut bowl = object("bowl_1");
    bowl.relations = [LeftOf, RightOf].map(|kind| Relation::new(kind, Some(id("mug_1")))).to_vec();
    let generated = reference(description(DESK, vec![object("mug_1"), bowl])).await;
    let is_side =
        |demand: &UnmetDemand| matches!(demand, UnmetDemand::Relation { relation: LeftOf | RightOf, .. });
    assert_eq!(generated.unmet.len(), 1, "{:?}", generated.unmet);
    assert!(generated.unmet.iter().all(|unmet| is_side(&unmet.demand)));
}

#[tokio::test]
async fn table_grows_for_a_stated_distance_unless_its_size_is_stated() {
    let mut bowl = object("bowl_1");
    let far = Relation { distance_m: Some(0.6), ..Relation::new(RelationKind::LeftOf, Some(id("mug_1"))) };
    bowl.relations.push(far);
    let small = description(("square_table", DVec3::new(0.7, 0.7, 0.74)), vec![object("mug_1"), bowl]);
    let stated = reference(small.clone()).await;
    assert_eq!(stated.unmet.len(), 1);
    let grown = reference(SceneDescription { table_size_is_stated: false, ..small }).await;
    assert_eq!(grown.unmet, []);
    let size_m = |generated: &GeneratedReference| {
        generated.ground_truth.as_ref().expect("ground truth").known.recognition.table.size_m
    };
    assert_eq!(size_m(&stated), DVec3::new(0.7, 0.7, 0.74));
    assert!(size_m(&grown).x > 0.75 && size_m(&grown).z == 0.74, "{}", size_m(&grown));
}

#[tokio::test]
async fn low_and_small_round_tables_carry_their_objects() {
    for (diameter_m, height_m) in [(0.9, 0.45), (0.6, 0.42)] {
        let mut mug = object("mug_1");
        mug.position_m = Some(DVec2::new(0.05, 0.0));
        let table = ("round_table", DVec3::new(diameter_m, diameter_m, height_m));
        let generated = reference(description(table, vec![mug, object("apple_1"), object("book_1")])).await;
        assert_eq!(generated.unmet, []);
        let truth = generated.ground_truth.expect("ground truth").truth;
        for instance in &truth.instances {
            let away_m = instance.translation_m.truncate().length();
            assert!(instance.translation_m.z.abs() < 0.01 && away_m < 0.5 * diameter_m, "{}", instance.name);
        }
    }
}
