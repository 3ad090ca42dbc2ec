//! Grasps as files: isaac_grasp YAML, and a record for JSON.

use std::fmt::Write;

use geometry::Pose;
use robot::model::Robot;
use scene::grasps::{GraspFile, GraspRecord};

use super::Grasp;

/// The record of grasps for JSON.
pub fn grasp_file(robot: &Robot, grasps: &[Grasp]) -> GraspFile {
    let record = |grasp: &Grasp| GraspRecord {
        object_from_tool: grasp.object_from_tool,
        opening_m: grasp.opening_m,
        pregrasp_opening_m: grasp.pregrasp_opening_m,
        force_n: grasp.force_n,
        confidence: grasp.confidence,
        verdict: grasp.verdict,
        slip_m: grasp.slip_m,
        turn_rad: grasp.turn_rad,
    };
    GraspFile {
        robot: robot.name().to_owned(),
        gripper_frame: robot.tool().name.clone(),
        gripper_joint: gripper_joint(robot).to_owned(),
        grasps: grasps.iter().map(record).collect(),
    }
}

/// The grasps of a record, as trials found them.
pub fn grasps_of_file(file: &GraspFile) -> Vec<Grasp> {
    let grasp = |record: &GraspRecord| Grasp {
        object_from_tool: record.object_from_tool,
        opening_m: record.opening_m,
        pregrasp_opening_m: record.pregrasp_opening_m,
        force_n: record.force_n,
        confidence: record.confidence,
        verdict: record.verdict,
        slip_m: record.slip_m,
        turn_rad: record.turn_rad,
    };
    file.grasps.iter().map(grasp).collect()
}

/// The name of the joint that moves the fingers.
pub(crate) fn gripper_joint(robot: &Robot) -> &str {
    robot.links()[robot.gripper().link].joint.as_ref().map_or("", |joint| &joint.name)
}

/// The grasps in the format `isaac_grasp` 1.0: poses of the gripper's frame, here the tool, in the object's frame.
/// `object_frame` names the object.
pub fn isaac_grasp_yaml(robot: &Robot, object_frame: &str, grasps: &[Grasp]) -> String {
    let joint = gripper_joint(robot);
    let mut text = format!(
        "format: isaac_grasp\nformat_version: 1.0\nobject_frame: {object_frame}\ngripper_frame: {}\n",
        robot.tool().name
    );
    text.push_str(if grasps.is_empty() { "grasps: {}\n" } else { "grasps:\n" });
    for (index, grasp) in grasps.iter().enumerate() {
        let Pose { translation_m: p, rotation: q } = grasp.object_from_tool;
        let closed = robot.gripper_position(grasp.opening_m);
        let opened = robot.gripper_position(grasp.pregrasp_opening_m);
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "  grasp_{index}:\n    confidence: {}\n    position: [{}, {}, {}]\n    orientation: {{w: {}, xyz: [{}, \
             {}, {}]}}\n    cspace_position:\n      {joint}: {closed}\n    pregrasp_cspace_position:\n      {joint}: \
             {opened}\n",
            grasp.confidence, p.x, p.y, p.z, q.w, q.x, q.y, q.z
        );
    }
    text
}
