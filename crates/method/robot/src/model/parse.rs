//! From a robot's file to a checked robot: what refers to what, and which values make sense.

mod joints;
mod shapes;

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};

use crate::model::error::{ModelError, Refusal, refuse};
use crate::model::file::{GripperFile, HomeFile, RobotFile, VariantFile};
use crate::model::library;
use crate::model::limits::JointLimits;
use crate::model::link::{Link, MovingKind, PositionSource};
use crate::model::robot::{Gripper, Home, IgnoredPair, Material, Robot, Tool};

impl Robot {
    /// Reads the robot of a file, in the variant named or as the file states it.
    ///
    /// `source_name` is what errors call the file, for example its path.
    ///
    /// # Errors
    /// Where the text is not TOML, a key is unknown or missing, a value is out of range, or a name refers to nothing.
    /// The error names the key, as in `links[3].joint.limits.position`.
    pub fn parse(text: &str, source_name: &str, variant: Option<&str>) -> Result<Self, ModelError> {
        read(text, variant).map_err(|refusal| refusal.in_file(source_name))
    }

    /// Reads a robot of `config/robots/`, in the variant named or as its file states it.
    ///
    /// # Errors
    /// Where no file has that name, or the file has no such variant.
    pub fn built_in(name: &str, variant: Option<&str>) -> Result<Self, ModelError> {
        let text = library::text(name)?;
        Self::parse(text, &format!("config/robots/{name}.toml"), variant)
    }
}

fn read(text: &str, variant: Option<&str>) -> Result<Robot, Refusal> {
    let deserializer = toml::Deserializer::parse(text)
        .map_err(|error| Refusal { path: "the whole file".to_owned(), problem: error.to_string() })?;
    let mut file: RobotFile = serde_path_to_error::deserialize(deserializer)
        .map_err(|e| Refusal { path: e.path().to_string(), problem: e.inner().message().to_owned() })?;
    if let Some(variant) = variant {
        let Some(change) = file.variants.remove(variant) else {
            let known: Vec<_> = file.variants.keys().map(String::as_str).collect();
            return refuse("variants", format!("no variant {variant:?}; there are {known:?}"));
        };
        apply(&mut file, variant, change)?;
    }
    check(file, variant.map(str::to_owned))
}

fn apply(file: &mut RobotFile, variant: &str, change: VariantFile) -> Result<(), Refusal> {
    if change.reason.trim().is_empty() {
        return refuse(format!("variants.{variant}.reason"), "state what the variant is for");
    }
    for (name, change) in change.joints {
        let joint =
            file.links.iter_mut().filter_map(|link| link.joint.as_mut()).find(|joint| joint.name == name);
        let Some(joint) = joint else {
            return refuse(format!("variants.{variant}.joints.{name}"), "no joint has this name");
        };
        joint.origin = change.origin.unwrap_or(joint.origin);
        joint.limits = change.limits.or(joint.limits);
    }
    file.home = change.home.unwrap_or_else(|| file.home.clone());
    file.sources.push(format!("Variant {variant}: {}", change.reason));
    Ok(())
}

fn check(file: RobotFile, variant: Option<String>) -> Result<Robot, Refusal> {
    check_name("name", &file.name)?;
    if file.sources.is_empty() {
        return refuse("sources", "state where the numbers come from");
    }
    let materials = materials(&file.materials)?;
    let mut links: Vec<Link> = Vec::with_capacity(file.links.len());
    for (k, link) in file.links.iter().enumerate() {
        let path = format!("links[{k}]");
        check_name(&format!("{path}.name"), &link.name)?;
        if links.iter().any(|other| other.name == link.name) {
            return refuse(format!("{path}.name"), format!("two links are named {:?}", link.name));
        }
        let joint = joints::joint(&path, link, &links, &file.gripper)?;
        let shapes = shapes::shapes(&path, &link.shapes, &materials)?;
        let tolerance = link.sphere_tolerance_m.unwrap_or(file.sphere_tolerance_m);
        links.push(Link {
            name: link.name.clone(),
            joint,
            inertia: shapes::inertia(&path, link.inertia, &shapes)?,
            shapes,
            sphere_tolerance_m: positive(&format!("{path}.sphere_tolerance_m"), tolerance)?,
        });
    }
    let arm_links = joints::number_arm(&mut links)?;
    let arm_limits: Vec<JointLimits> =
        arm_links.iter().filter_map(|link| Some(links[*link].joint.as_ref()?.moving()?.limits)).collect();
    let gripper = gripper(&file.gripper, &links)?;
    Ok(Robot {
        tool: tool(&file, &links)?,
        home: home(&file.home, &arm_limits, &gripper)?,
        ignored_pairs: ignored_pairs(&file, &links)?,
        name: file.name,
        variant,
        title: file.title,
        sources: file.sources,
        materials,
        links,
        arm_links,
        arm_limits,
        gripper,
    })
}

fn materials(colors: &BTreeMap<String, [f64; 3]>) -> Result<Vec<Material>, Refusal> {
    let material = |(name, srgb): (&String, &[f64; 3])| {
        check_name("materials", name)?;
        if !srgb.iter().all(|channel| (0.0..=1.0).contains(channel)) {
            return refuse(format!("materials.{name}"), "each channel must be in 0..=1");
        }
        Ok(Material { name: name.clone(), srgb: *srgb })
    };
    colors.iter().map(material).collect()
}

fn gripper(file: &GripperFile, links: &[Link]) -> Result<Gripper, Refusal> {
    let carried = links.iter().enumerate().find_map(|(index, link)| {
        let joint = link.joint.as_ref().filter(|joint| joint.name == file.joint)?;
        Some((index, joint.moving()?))
    });
    let Some((link, joint)) = carried else {
        return refuse("gripper.joint", format!("no moving joint is named {:?}", file.joint));
    };
    if joint.kind != MovingKind::Prismatic || joint.limits.min_position != 0.0 {
        return refuse("gripper.joint", "the joint must slide, from position 0, where the gripper is closed");
    }
    let opening_per_position = positive("gripper.opening_per_position", file.opening_per_position)?;
    let grip_force_n = positive("gripper.grip_force_n", file.grip_force_n)?;
    if file.max_force_n < grip_force_n {
        return refuse("gripper.max_force_n", "must not be below grip_force_n");
    }
    Ok(Gripper {
        link,
        opening_per_position,
        max_opening_m: opening_per_position * joint.limits.max_position,
        grip_force_n,
        max_force_n: positive("gripper.max_force_n", file.max_force_n)?,
        pad_friction: positive("gripper.pad_friction", file.pad_friction)?,
    })
}

fn tool(file: &RobotFile, links: &[Link]) -> Result<Tool, Refusal> {
    check_name("tool.name", &file.tool.name)?;
    if links.iter().any(|link| link.name == file.tool.name) {
        return refuse("tool.name", "a link has the same name");
    }
    Ok(Tool {
        name: file.tool.name.clone(),
        link: link_named("tool.link", links, &file.tool.link)?,
        link_from_tool: pose("tool", file.tool.xyz_m, file.tool.rpy_deg)?,
    })
}

fn home(file: &HomeFile, limits: &[JointLimits], gripper: &Gripper) -> Result<Home, Refusal> {
    if file.positions.len() != limits.len() {
        let problem =
            format!("{} positions for the {} joints of the arm", file.positions.len(), limits.len());
        return refuse("home.positions", problem);
    }
    if let Some(k) = (0..limits.len()).find(|k| !limits[*k].admits(file.positions[*k])) {
        return refuse(format!("home.positions[{k}]"), "outside of the limits of the joint");
    }
    if !(0.0..=gripper.max_opening_m).contains(&file.opening_m) {
        return refuse("home.opening_m", format!("must be in 0..={}", gripper.max_opening_m));
    }
    Ok(Home { positions: file.positions.clone(), opening_m: file.opening_m })
}

fn ignored_pairs(file: &RobotFile, links: &[Link]) -> Result<Vec<IgnoredPair>, Refusal> {
    let pair = |(k, pair): (usize, &crate::model::file::IgnoredPairFile)| {
        let path = format!("ignored_pairs[{k}]");
        if pair.reason.trim().is_empty() {
            return refuse(format!("{path}.reason"), "state why the links need no check");
        }
        let [a, b] = &pair.links;
        let path = format!("{path}.links");
        let (a, b) = (link_named(&path, links, a)?, link_named(&path, links, b)?);
        if a == b {
            return refuse(path, "a link is in no pair with itself");
        }
        Ok(IgnoredPair { links: (a.min(b), a.max(b)), reason: pair.reason.clone() })
    };
    file.ignored_pairs.iter().enumerate().map(pair).collect()
}

fn link_named(path: &str, links: &[Link], name: &str) -> Result<usize, Refusal> {
    match links.iter().position(|link| link.name == name) {
        Some(index) => Ok(index),
        None => refuse(path, format!("no link is named {name:?} here or above")),
    }
}

/// Names become those of XML elements and USD prims.
fn check_name(path: &str, name: &str) -> Result<(), Refusal> {
    let starts = name.starts_with(|c: char| c.is_ascii_alphabetic());
    if starts && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return Ok(());
    }
    refuse(
        path,
        format!("{name:?} must start with a letter and consist of ASCII letters, digits and underscores"),
    )
}

fn positive(path: &str, value: f64) -> Result<f64, Refusal> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        refuse(path, format!("{value} must be above 0"))
    }
}

fn finite<const N: usize>(path: &str, values: [f64; N]) -> Result<[f64; N], Refusal> {
    if values.iter().all(|value| value.is_finite()) { Ok(values) } else { refuse(path, "must be finite") }
}

/// The pose of a translation and of turns about the fixed axes x, y and z, in this order.
fn pose(path: &str, xyz_m: [f64; 3], rpy_deg: [f64; 3]) -> Result<Isometry3<f64>, Refusal> {
    let [roll, pitch, yaw] = finite(&format!("{path}.rpy_deg"), rpy_deg)?.map(f64::to_radians);
    let translation = Translation3::from(finite(&format!("{path}.xyz_m"), xyz_m)?);
    Ok(Isometry3::from_parts(translation, UnitQuaternion::from_euler_angles(roll, pitch, yaw)))
}

/// The source of a joint's position before the joints of the arm are numbered.
const UNNUMBERED: PositionSource = PositionSource::Arm(usize::MAX);

#[cfg(test)]
mod tests;
