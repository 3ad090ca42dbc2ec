//! The wire form of operations, and their violations.

use super::*;

fn read(json: &str) -> EditOperation {
    serde_json::from_str(json).expect(json)
}

#[test]
fn operations_are_read_from_their_wire_form_and_written_the_same() {
    for json in [
        r#"{"op":"add","object":"a spoon","where":{"relation":"in","target":"mug_1"}}"#,
        r#"{"op":"remove","target":"the desk lamp"}"#,
        r#"{"op":"move","target":"mug_1","where":{"position_m":[0.1,-0.2],"yaw_rad":1.5}}"#,
        r#"{"op":"move","target":"mug_1","where":{"offset_m":[-0.1,0.0]}}"#,
        r#"{"op":"rotate","target":"mug_1","by_rad":0.5}"#,
        r#"{"op":"stack","targets":["the books"]}"#,
        r#"{"op":"tidy"}"#,
        r#"{"op":"rearrange"}"#,
        r#"{"op":"remake","target":"mug_1"}"#,
        r#"{"op":"set_physics","target":"all mugs","mass_factor":1.2}"#,
        r#"{"op":"relight","azimuth_rad":0.5,"elevation_rad":0.9,"intensity":1.0}"#,
        r#"{"op":"move_camera","turn_rad":0.2,"distance_factor":1.1}"#,
    ] {
        let operation = read(json);
        assert_eq!(operation.violations(), [], "{json}");
        assert_eq!(serde_json::to_string(&operation).expect("text"), json);
    }
}

#[test]
fn violations_point_at_the_wrong_field() {
    let pointers = |json: &str| -> Vec<String> {
        violations(&[read(json)]).into_iter().map(|violation| violation.pointer).collect()
    };
    let cases = [
        (r#"{"op":"add","object":"","count":99}"#, vec!["/0/object", "/0/count"]),
        (r#"{"op":"move","target":"a","where":{}}"#, vec!["/0/where"]),
        (r#"{"op":"move","target":"a","where":{"relation":"left_of"}}"#, vec!["/0/where/target"]),
        (
            r#"{"op":"move","target":"a","where":{"relation":"at_left","target":"b"}}"#,
            vec!["/0/where/target"],
        ),
        (
            r#"{"op":"move","target":"a","where":{"relation":"between","target":"b"}}"#,
            vec!["/0/where/second_target"],
        ),
        (r#"{"op":"move","target":"a","where":{"offset_m":[0.1,0],"relation":"at_left"}}"#, vec!["/0/where"]),
        (r#"{"op":"move","target":"a","where":{"offset_m":[9,0]}}"#, vec!["/0/where/offset_m"]),
        (r#"{"op":"add","object":"a","where":{"offset_m":[0.1,0]}}"#, vec!["/0/where/offset_m"]),
        (r#"{"op":"rotate","target":"a"}"#, vec!["/0"]),
        (r#"{"op":"resize","target":"a","factor":9}"#, vec!["/0/factor"]),
        (r#"{"op":"recolor","target":"a"}"#, vec!["/0"]),
        (r#"{"op":"stack","targets":[]}"#, vec!["/0/targets"]),
        (r#"{"op":"set_physics","target":"a"}"#, vec!["/0"]),
        (r#"{"op":"set_physics","target":"a","mass_factor":0}"#, vec!["/0/mass_factor"]),
        (
            r#"{"op":"relight","azimuth_rad":7,"elevation_rad":2,"intensity":9}"#,
            vec!["/0/azimuth_rad", "/0/elevation_rad", "/0/intensity"],
        ),
        (r#"{"op":"move_camera"}"#, vec!["/0"]),
        (r#"{"op":"move_camera","distance_factor":9}"#, vec!["/0/distance_factor"]),
    ];
    for (json, expected) in cases {
        assert_eq!(pointers(json), expected, "{json}");
    }
    assert_eq!(violations(&[]).len(), 1);
}

#[test]
fn unknown_fields_are_refused() {
    assert!(serde_json::from_str::<EditOperation>(r#"{"op":"remove","target":"a","x":1}"#).is_err());
    assert!(serde_json::from_str::<EditOperation>(r#"{"op":"explode"}"#).is_err());
}
