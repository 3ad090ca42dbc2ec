//! Tests of the written files: counts and limits as in the model; independent programs judge the rest.

use super::*;

fn robots() -> [Robot; 3] {
    let gantry = include_str!("../../tests/robots/gantry.toml");
    [
        Robot::built_in("panda", None).expect("built in"),
        Robot::built_in("piper", Some("old_zero")).expect("built in"),
        Robot::parse(gantry, "gantry.toml", None).expect("a robot"),
    ]
}

fn children<'a>(
    node: roxmltree::Node<'a, 'a>,
    name: &'a str,
) -> impl Iterator<Item = roxmltree::Node<'a, 'a>> {
    node.descendants().filter(move |child| child.has_tag_name(name))
}

#[test]
fn urdf_has_every_link_joint_and_limit() {
    for robot in robots() {
        let text = write_urdf(&robot);
        let document = roxmltree::Document::parse(&text).expect("XML");
        let root = document.root_element();
        // The tool frame is one more link, and one more joint.
        let links = robot.links().len();
        assert_eq!(root.children().filter(|node| node.has_tag_name("link")).count(), links + 1);
        assert_eq!(root.children().filter(|node| node.has_tag_name("joint")).count(), links);
        for (joint, limits) in robot.arm_links().iter().zip(robot.limits()) {
            let name = &robot.links()[*joint].joint.as_ref().expect("a joint").name;
            let node =
                children(root, "joint").find(|node| node.attribute("name") == Some(name)).expect("the joint");
            let limit = children(node, "limit").next().expect("limits");
            let value = |key| limit.attribute(key).and_then(|text| text.parse::<f64>().ok());
            assert_eq!(value("lower"), Some(limits.min_position));
            assert_eq!(value("upper"), Some(limits.max_position));
            assert_eq!(value("velocity"), Some(limits.max_velocity));
            assert_eq!(value("effort"), Some(limits.max_effort));
        }
        assert_eq!(children(root, "mimic").count(), 1);
    }
}

#[test]
fn mjcf_has_one_servo_for_each_joint_of_the_arm_and_one_for_the_gripper() {
    for robot in robots() {
        let text = write_mjcf(&robot);
        let document = roxmltree::Document::parse(&text).expect("XML");
        let root = document.root_element();
        assert_eq!(children(root, "position").count(), robot.dof() + 1);
        let key = children(root, "key").next().expect("the home pose");
        let count = |name| key.attribute(name).expect("numbers").split(' ').count();
        assert_eq!(count("qpos"), robot.dof() + 2);
        assert_eq!(count("ctrl"), robot.dof() + 1);
        let shapes: usize = robot.links().iter().map(|link| link.shapes.len()).sum();
        let geoms = children(root, "geom").filter(|geom| geom.attribute("type").is_some());
        assert_eq!(geoms.count(), shapes);
    }
}

#[test]
fn targets_of_the_gripper_in_mjcf_reach_the_greatest_force_on_the_thinnest_objects() {
    for robot in robots() {
        let text = write_mjcf(&robot);
        let document = roxmltree::Document::parse(&text).expect("XML");
        let root = document.root_element();
        let servo = children(root, "position").find(|node| node.attribute("tendon").is_some());
        let numbers = |key| -> Vec<f64> {
            let text = servo.and_then(|node| node.attribute(key)).expect("numbers");
            text.split(' ').map(|number| number.parse().expect("a number")).collect()
        };
        let [low, high]: [f64; 2] = numbers("ctrlrange").try_into().expect("two");
        let force_n = numbers("forcerange")[1];
        let gripper = robot.gripper();
        assert_eq!(force_n, 2.0 * gripper.max_force_n);
        assert!((-low * numbers("kp")[0] - force_n).abs() < 1e-9, "{}: {low} when closed", robot.name());
        assert_eq!(-low, robot.gripper_lead(gripper.max_force_n));
        assert_eq!(high, robot.gripper_position(gripper.max_opening_m));
    }
}

#[test]
fn pairs_that_are_not_checked_are_excluded() {
    for robot in robots() {
        let excluded = excluded_pairs(&robot);
        let checked = checked_pairs(&robot);
        assert!(excluded.iter().all(|pair| !checked.contains(pair)));
        let colliding = robot.links().iter().filter(|link| link.shapes.iter().any(|s| s.collides())).count();
        assert_eq!(excluded.len() + checked.len(), colliding * (colliding - 1) / 2);
        assert!(excluded.contains(&(0, robot.arm_links()[0])), "{}: neighbors", robot.name());
    }
}

#[test]
fn usd_prims_are_closed_and_joints_name_both_bodies() {
    for robot in robots() {
        let text = write_usd(&robot);
        assert_eq!(text.matches('{').count(), text.matches('}').count());
        assert_eq!(text.matches("rel physics:body0 =").count(), robot.links().len() - 1);
        assert_eq!(text.matches("rel physics:body1 =").count(), robot.links().len());
        assert!(text.contains(&format!("defaultPrim = \"{}\"", model_name(&robot))));
    }
}
