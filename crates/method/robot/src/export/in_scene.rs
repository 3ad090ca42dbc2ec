//! A robot in a scene: one more file for each format, beside those of the robot and of the scene.
//!
//! MJCF and USD refer to both files; URDF, which has no references, is the scene's file with the robot's elements. The
//! base is fixed to the world at `world_from_base`.

use nalgebra::Isometry3;

use super::mjcf::write_option;
use super::model_name;
use super::numbers::{rpy, spaced, tuple, wxyz, xyz};
use super::urdf::write_elements;
use crate::model::Robot;
use markup::xml::XmlDocument;

/// Prefix of the robot's names in the combined MJCF file.
pub fn mjcf_prefix(robot: &Robot) -> String {
    format!("{}_", model_name(robot))
}

/// MJCF: the scene's file with the robot attached. Names of the robot have [`mjcf_prefix`]. The paths are relative to
/// the written file; the scene's file must be in the same folder, since its meshes are found from there.
pub fn write_mjcf_in_scene(
    robot: &Robot,
    robot_path: &str,
    scene_path: &str,
    world_from_base: &Isometry3<f64>,
) -> String {
    let name = model_name(robot);
    let mut document = XmlDocument::new();
    document.open("mujoco", &[("model", &format!("scene_with_{name}"))]);
    document.empty("include", &[("file", scene_path)]);
    write_option(&mut document);
    document.open("asset", &[]);
    document.empty("model", &[("name", &name), ("file", robot_path)]);
    document.close();
    document.open("worldbody", &[]);
    let (position, rotation) = (spaced(&xyz(world_from_base)), spaced(&wxyz(&world_from_base.rotation)));
    document.open("frame", &[("pos", &position), ("quat", &rotation)]);
    document.empty(
        "attach",
        &[("model", &name), ("body", &robot.links()[0].name), ("prefix", &mjcf_prefix(robot))],
    );
    document.finish()
}

/// URDF: the scene's text with the links and joints of the robot, and a fixed joint from `scene_root` to its base.
/// `None` for a text that does not end a robot.
pub fn write_urdf_in_scene(
    robot: &Robot,
    scene_urdf: &str,
    scene_root: &str,
    world_from_base: &Isometry3<f64>,
) -> Option<String> {
    let end = scene_urdf.rfind("</robot>")?;
    let mut elements = XmlDocument::fragment();
    write_elements(&mut elements, robot);
    let base = &robot.links()[0].name;
    elements.open("joint", &[("name", &format!("{scene_root}_to_{}", model_name(robot))), ("type", "fixed")]);
    elements.empty("parent", &[("link", scene_root)]);
    elements.empty("child", &[("link", base)]);
    let (position, turns) = (spaced(&xyz(world_from_base)), spaced(&rpy(world_from_base)));
    elements.empty("origin", &[("xyz", &position), ("rpy", &turns)]);
    elements.close();
    let (scene, rest) = scene_urdf.split_at(end);
    let indented: String = elements.finish().lines().map(|line| format!("  {line}\n")).collect();
    Some(format!("{}\n{indented}{rest}", scene.trim_end()))
}

/// USD: a layer over the scene's layer, whose default prim is `scene_root`, that references the robot's.
pub fn write_usd_in_scene(
    robot: &Robot,
    robot_path: &str,
    scene_path: &str,
    scene_root: &str,
    world_from_base: &Isometry3<f64>,
) -> String {
    let name = model_name(robot);
    let position = tuple(&xyz(world_from_base));
    let rotation = tuple(&wxyz(&world_from_base.rotation));
    format!(
        r#"#usda 1.0
(
    defaultPrim = "{scene_root}"
    kilogramsPerUnit = 1
    metersPerUnit = 1
    subLayers = [@{scene_path}@]
    upAxis = "Z"
)

over "{scene_root}"
{{
    def Xform "{name}" (
        prepend references = @{robot_path}@
    )
    {{
        double3 xformOp:translate = {position}
        quatd xformOp:orient = {rotation}
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]

        over "joints"
        {{
            over "base_joint"
            {{
                point3f physics:localPos0 = {position}
                quatf physics:localRot0 = {rotation}
            }}
        }}
    }}
}}
"#
    )
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;

    fn base() -> Isometry3<f64> {
        let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, 0.5);
        Isometry3::from_parts(Vector3::new(-0.6, 0.1, -0.02).into(), turn)
    }

    #[test]
    fn combined_urdf_is_one_tree() {
        let scene = "<?xml version=\"1.0\"?>\n<robot name=\"scene\">\n  <link name=\"world\"/>\n</robot>\n";
        for name in ["panda", "piper"] {
            let robot = Robot::built_in(name, None).expect("built in");
            let text = write_urdf_in_scene(&robot, scene, "world", &base()).expect("a robot ends");
            let document = roxmltree::Document::parse(&text).expect("XML");
            let root = document.root_element();
            let count = |tag: &str| root.children().filter(|node| node.has_tag_name(tag)).count();
            // World, links and tool frame; each but the world has one parent.
            assert_eq!(count("link"), robot.links().len() + 2);
            assert_eq!(count("joint"), count("link") - 1);
        }
        let robot = Robot::built_in("panda", None).expect("built in");
        assert_eq!(write_urdf_in_scene(&robot, "<sdf/>", "world", &base()), None);
    }

    #[test]
    fn combined_mjcf_attaches_the_base_where_it_stands() {
        let robot = Robot::built_in("panda", None).expect("built in");
        let text = write_mjcf_in_scene(&robot, "panda.xml", "scene.xml", &base());
        let document = roxmltree::Document::parse(&text).expect("XML");
        let frame = document.descendants().find(|node| node.has_tag_name("frame")).expect("a frame");
        assert_eq!(frame.attribute("pos"), Some("-0.6 0.1 -0.02"));
        let attached = frame.first_element_child().expect("a robot");
        assert_eq!(attached.attribute("body"), Some("link0"));
        assert_eq!(attached.attribute("prefix"), Some("panda_"));
    }
}
