//! Valid and invalid answers.

use super::*;

fn answer() -> Value {
    json!({
        "table": {
            "label": "oak table", "model": "dining_table", "box": { "x0": 100, "y0": 300, "x1": 900, "y1": 800 },
        },
        "camera": { "elevation_deg": 45, "azimuth_deg": -10, "horizontal_fov_deg": 35 },
        "objects": [
            {
                "name": "mug_1", "label": "red mug", "category": "mug",
                "box": { "x0": 400, "y0": 400, "x1": 480, "y1": 500 },
            },
            {
                "name": "astrolabe_1", "label": "brass astrolabe", "category": "object",
                "box": { "x0": 600, "y0": 400, "x1": 700, "y1": 520.5 },
            },
        ],
    })
}

fn read(answer: &Value) -> Result<Detections, String> {
    let answer: Answer = serde_json::from_value(answer.clone()).map_err(|error| error.to_string())?;
    accepted(answer, &[]).map_err(|complaints| complaints.join("; "))
}

#[test]
fn accepted_converts_a_valid_answer_and_numbers_objects() {
    let detections = read(&answer()).unwrap_or_else(|complaint| panic!("{complaint}"));
    let names: Vec<&str> = detections.objects.iter().map(|object| object.id.as_str()).collect();
    assert_eq!(names, ["mug_1", "brass_astrolabe_1"]);
    assert!((detections.camera.elevation_rad - std::f64::consts::FRAC_PI_4).abs() < 1e-9);
    assert_eq!(detections.camera.table_box, [0.1, 0.3, 0.9, 0.8]);
    assert_eq!(named(&detections)[0]["name"], "mug_1");
}

#[test]
fn names_of_the_text_are_kept_and_not_given_twice() {
    let named = |name: &str| NamedObject {
        id: InstanceId::new(name).expect("a name"),
        label: name.into(),
        category: "mug".into(),
        stand_in: None,
        size_m: glam::DVec3::splat(0.1),
        size_is_stated: false,
        color: None,
        material: None,
        mass_kg: None,
        pose: Default::default(),
        supporter: None,
    };
    let mut answer = answer();
    answer["objects"][1]["name"] = json!("mango_1");
    let answer: Answer = serde_json::from_value(answer).expect("an answer");
    // The text's first mug is not in the image: the mug there gets the next number.
    let detections = accepted(answer, &[named("mango_1"), named("mug_2")])
        .unwrap_or_else(|complaints| panic!("{complaints:?}"));
    let ids: Vec<&str> = detections.objects.iter().map(|object| object.id.as_str()).collect();
    assert_eq!(ids, ["mug_1", "mango_1"]);
    let unused: Answer = serde_json::from_value(super::tests::answer()).expect("an answer");
    let detections = accepted(unused, &[named("mug_2"), named("brass_astrolabe_1")])
        .unwrap_or_else(|complaints| panic!("{complaints:?}"));
    let ids: Vec<&str> = detections.objects.iter().map(|object| object.id.as_str()).collect();
    assert_eq!(ids, ["mug_1", "brass_astrolabe_2"]);
}

#[test]
fn accepted_names_each_violation() {
    for (pointer, value, message) in [
        ("/table/model", json!("throne"), "table.model"),
        ("/table/box/x0", json!(-501), "table.box.x0"),
        ("/table/box/x1", json!(50), "table.box is empty"),
        ("/camera/elevation_deg", json!(-20), "camera.elevation_deg"),
        ("/camera/horizontal_fov_deg", json!(179), "camera.horizontal_fov_deg"),
        ("/objects/0/box/y1", json!(1001), "objects[0].box.y1"),
        ("/objects/0/category", json!(""), "objects[0].category"),
        ("/objects/0/name", json!("table"), "no name"),
        ("/objects/0/label", json!(""), "objects[0].label"),
    ] {
        let mut answer = answer();
        *answer.pointer_mut(pointer).expect(pointer) = value.clone();
        let Err(complaint) = read(&answer) else { panic!("{pointer} = {value} is taken") };
        assert!(complaint.contains(message), "{pointer} = {value}: {complaint}");
    }
}
