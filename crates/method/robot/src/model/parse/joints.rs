//! Checks of joints: kinds, axes, limits, what mimics what, and which joints form the arm.

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};

use super::{UNNUMBERED, check_name, finite, link_named, pose};
use crate::model::error::{Refusal, refuse};
use crate::model::file::{
    DriveFile, GripperFile, JointFile, JointKindFile, LimitsFile, LinkFile, OriginFile,
};
use crate::model::limits::JointLimits;
use crate::model::link::{Joint, JointDrive, JointMotion, Link, MovingJoint, MovingKind, PositionSource};

/// The joint that carries the link at `path`; `above` are the links before it.
pub(super) fn joint(
    path: &str,
    link: &LinkFile,
    above: &[Link],
    gripper: &GripperFile,
) -> Result<Option<Joint>, Refusal> {
    let Some(file) = &link.joint else {
        let problem = "only the first link, the base, has no joint";
        return if above.is_empty() { Ok(None) } else { refuse(format!("{path}.joint"), problem) };
    };
    let path = format!("{path}.joint");
    if above.is_empty() {
        return refuse(path, "the first link is the base and has no joint");
    }
    check_name(&format!("{path}.name"), &file.name)?;
    if above.iter().filter_map(|link| link.joint.as_ref()).any(|joint| joint.name == file.name) {
        return refuse(format!("{path}.name"), format!("two joints are named {:?}", file.name));
    }
    Ok(Some(Joint {
        name: file.name.clone(),
        parent: link_named(&format!("{path}.parent"), above, &file.parent)?,
        parent_from_joint: origin(&format!("{path}.origin"), file.origin)?,
        motion: motion(&path, file, above, gripper)?,
    }))
}

fn origin(path: &str, file: OriginFile) -> Result<Isometry3<f64>, Refusal> {
    match file {
        OriginFile::Pose(file) => pose(&format!("{path}.pose"), file.xyz_m, file.rpy_deg),
        OriginFile::ModifiedDh(dh) => {
            finite(&format!("{path}.modified_dh"), [dh.alpha_deg, dh.a_m, dh.theta_deg, dh.d_m])?;
            let turn = |axis: Unit<Vector3<f64>>, angle_deg: f64| {
                UnitQuaternion::from_axis_angle(&axis, angle_deg.to_radians())
            };
            let about_x =
                Isometry3::from_parts(Translation3::identity(), turn(Vector3::x_axis(), dh.alpha_deg));
            let translation = Translation3::new(dh.a_m, 0.0, dh.d_m);
            Ok(about_x * Isometry3::from_parts(translation, turn(Vector3::z_axis(), dh.theta_deg)))
        }
    }
}

fn motion(
    path: &str,
    file: &JointFile,
    above: &[Link],
    gripper: &GripperFile,
) -> Result<JointMotion, Refusal> {
    let kind = match file.kind {
        JointKindFile::Revolute => MovingKind::Revolute,
        JointKindFile::Prismatic => MovingKind::Prismatic,
        JointKindFile::Fixed => {
            let moves =
                file.axis.is_some() || file.limits.is_some() || file.mimic.is_some() || file.drive.is_some();
            let problem = "a fixed joint has no axis, limits, mimic or drive";
            return if moves { refuse(path, problem) } else { Ok(JointMotion::Fixed) };
        }
    };
    let Some(axis) = file.axis.and_then(|axis| Unit::try_new(Vector3::from(axis), 1e-9)) else {
        return refuse(format!("{path}.axis"), "a joint that moves needs an axis that is not zero");
    };
    let Some(limits) = file.limits else {
        return refuse(format!("{path}.limits"), "a joint that moves needs limits");
    };
    Ok(JointMotion::Moving(MovingJoint {
        kind,
        axis,
        limits: checked_limits(&format!("{path}.limits"), limits)?,
        drive: checked_drive(&format!("{path}.drive"), file.drive)?,
        source: source(path, file, above, gripper)?,
    }))
}

fn source(
    path: &str,
    file: &JointFile,
    above: &[Link],
    gripper: &GripperFile,
) -> Result<PositionSource, Refusal> {
    let Some(mimic) = &file.mimic else {
        let moves_gripper = file.name == gripper.joint;
        let itself = PositionSource::Gripper { multiplier: 1.0, offset: 0.0 };
        return Ok(if moves_gripper { itself } else { UNNUMBERED });
    };
    let path = format!("{path}.mimic");
    let is_above = above.iter().filter_map(|link| link.joint.as_ref()).any(|joint| joint.name == mimic.joint);
    if mimic.joint != gripper.joint || !is_above {
        let problem = format!("only the gripper's joint {:?}, stated above, can be mimicked", gripper.joint);
        return refuse(format!("{path}.joint"), problem);
    }
    let [multiplier, offset] = finite(&path, [mimic.multiplier, mimic.offset])?;
    Ok(PositionSource::Gripper { multiplier, offset })
}

fn checked_limits(path: &str, file: LimitsFile) -> Result<JointLimits, Refusal> {
    let limits = JointLimits::from(file);
    finite(&format!("{path}.position"), file.position)?;
    if limits.min_position >= limits.max_position {
        return refuse(format!("{path}.position"), "the first bound must be below the second");
    }
    for (key, value) in [
        ("velocity", limits.max_velocity),
        ("acceleration", limits.max_acceleration),
        ("jerk", limits.max_jerk),
        ("effort", limits.max_effort),
    ] {
        super::positive(&format!("{path}.{key}"), value)?;
    }
    Ok(limits)
}

fn checked_drive(path: &str, file: Option<DriveFile>) -> Result<JointDrive, Refusal> {
    let Some(file) = file else {
        return refuse(path, "a joint that moves needs a drive");
    };
    for (key, value) in [
        ("stiffness", file.stiffness),
        ("damping", file.damping),
        ("joint_damping", file.joint_damping),
        ("joint_friction", file.joint_friction),
        ("armature", file.armature),
    ] {
        if !(value >= 0.0 && value.is_finite()) {
            return refuse(format!("{path}.{key}"), format!("{value} must not be below 0"));
        }
    }
    Ok(JointDrive {
        stiffness: file.stiffness,
        damping: file.damping,
        joint_damping: file.joint_damping,
        joint_friction: file.joint_friction,
        armature: file.armature,
    })
}

/// Numbers the joints of the arm, which form a chain from the base; gives the links that they carry.
pub(super) fn number_arm(links: &mut [Link]) -> Result<Vec<usize>, Refusal> {
    let mut arm: Vec<usize> = Vec::new();
    for index in 0..links.len() {
        let (before, from_here) = links.split_at_mut(index);
        let Some(joint) = from_here[0].joint.as_mut() else { continue };
        let JointMotion::Moving(moving) = &mut joint.motion else { continue };
        if moving.source != UNNUMBERED {
            continue;
        }
        let carrier = moving_ancestor(before, joint.parent);
        if carrier != arm.last().copied() {
            let problem = "the joints of the arm form one chain, each carried by the one before";
            return refuse(format!("links[{index}].joint.parent"), problem);
        }
        moving.source = PositionSource::Arm(arm.len());
        arm.push(index);
    }
    if arm.is_empty() { refuse("links", "the arm has no joint that moves") } else { Ok(arm) }
}

/// The nearest link at or above `index` that a moving joint carries.
fn moving_ancestor(links: &[Link], mut index: usize) -> Option<usize> {
    loop {
        let joint = links[index].joint.as_ref()?;
        if joint.moving().is_some() {
            return Some(index);
        }
        index = joint.parent;
    }
}
