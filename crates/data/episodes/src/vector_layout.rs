//! Numbers of a state or an action: names, units, ranges, and groups such as arm and gripper.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::EpisodeError;
use crate::names::check_name;
use crate::unit_of_measure::Unit;

/// One number of a state or an action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VectorElement {
    /// Part of the robot that it belongs to, such as `arm` or `gripper`; neighbors of equal groups form one part of
    /// `modality.json`.
    pub group: String,
    /// The name without its unit.
    pub name: String,
    pub unit: Unit,
    /// The smallest and the largest value it may have, in its unit. robomimic needs it of actions.
    pub range: Option<[f32; 2]>,
    /// Limits of the robot, where they are known. Values beyond are stated in the card of a dataset, and not refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<MotionLimits>,
}

/// The smallest and the largest position of a number, in its unit, and its largest derivatives by time, in its unit per
/// second, second squared and second cubed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotionLimits {
    pub position: [f32; 2],
    pub velocity: f32,
    pub acceleration: f32,
    pub jerk: f32,
}

/// The numbers of a state or an action, in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct VectorLayout(Vec<VectorElement>);

impl MotionLimits {
    fn is_sound(&self) -> bool {
        let [min, max] = self.position;
        let rates = [self.velocity, self.acceleration, self.jerk];
        min.is_finite()
            && max.is_finite()
            && min < max
            && rates.iter().all(|rate| rate.is_finite() && *rate > 0.0)
    }
}

impl VectorElement {
    /// A number without a range.
    pub fn new(group: &str, name: &str, unit: Unit) -> Self {
        Self { group: group.to_owned(), name: name.to_owned(), unit, range: None, limits: None }
    }

    /// The same number with a range.
    pub fn within(self, min: f32, max: f32) -> Self {
        Self { range: Some([min, max]), ..self }
    }

    /// The same number with limits of its motion.
    pub fn with_limits(self, limits: MotionLimits) -> Self {
        Self { limits: Some(limits), ..self }
    }

    /// The opening between the pads of a gripper, in meters. What the servo of a gripper is asked for may be below 0,
    /// where a thin object is pressed.
    pub fn gripper_opening() -> Self {
        Self::new("gripper_opening", "gripper_opening", Unit::Meters)
    }

    /// The opening of a gripper over its largest: 0 is closed, 1 is open.
    pub fn gripper_fraction() -> Self {
        Self::new("gripper", "gripper", Unit::OpenFraction).within(0.0, 1.0)
    }

    /// The pose of the end effector in the frame of the robot's base: x, y, z in meters, the quaternion w, x, y, z, and
    /// the first two columns of the rotation's matrix.
    ///
    /// The six numbers of the columns are continuous over all rotations and have no second form, unlike quaternions:
    /// Zhou et al., "On the continuity of rotation representations in neural networks" (2019).
    pub fn end_effector_pose() -> [Self; 13] {
        let position =
            |axis: &str| Self::new("end_effector_position", &format!("end_effector_{axis}"), Unit::Meters);
        let rotation = |axis: &str| {
            let name = format!("end_effector_{axis}");
            Self::new("end_effector_rotation", &name, Unit::QuaternionComponent).within(-1.0, 1.0)
        };
        let [x, y, z] = ["x", "y", "z"].map(position);
        let [qw, qx, qy, qz] = ["qw", "qx", "qy", "qz"].map(rotation);
        let [a, b, c, d, e, f] = [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)].map(|(row, column)| {
            let name = format!("end_effector_row{row}_column{column}");
            Self::new("end_effector_rotation_6d", &name, Unit::Dimensionless).within(-1.0, 1.0)
        });
        [x, y, z, qw, qx, qy, qz, a, b, c, d, e, f]
    }

    /// The name with its unit, as every format states it.
    pub fn full_name(&self) -> String {
        format!("{}{}", self.name, self.unit.suffix())
    }
}

impl VectorLayout {
    /// A layout of these numbers; `kind` is "state" or "action".
    ///
    /// # Errors
    ///
    /// [`EpisodeError::Description`] for no numbers, names that a format could not carry, equal names, groups that
    /// are not contiguous, quaternions in another order than w, x, y, z, and ranges or limits that are empty or not
    /// finite.
    pub fn new(kind: &str, elements: Vec<VectorElement>) -> Result<Self, EpisodeError> {
        if elements.is_empty() {
            let what = format!("the {kind} has no numbers");
            return Err(EpisodeError::description(what, "name at least one"));
        }
        for (i, element) in elements.iter().enumerate() {
            check_name(kind, &element.name)?;
            check_name(kind, &element.group)?;
            let name = element.full_name();
            if elements[..i].iter().any(|earlier| earlier.full_name() == name) {
                let what = format!("the {kind} has two numbers named `{name}`");
                return Err(EpisodeError::description(what, "give each another name"));
            }
            let is_split = i > 0
                && elements[i - 1].group != element.group
                && elements[..i].iter().any(|earlier| earlier.group == element.group);
            if is_split {
                let what = format!("group `{}` of the {kind} has others between its numbers", element.group);
                return Err(EpisodeError::description(what, "put the numbers of a group beside each other"));
            }
            if let Some([min, max]) = element.range
                && !(min.is_finite() && max.is_finite() && min < max)
            {
                let what = format!("`{name}` of the {kind} has the range {min} to {max}");
                return Err(EpisodeError::description(
                    what,
                    "state a finite smallest value below the largest",
                ));
            }
            if let Some(limits) = element.limits.filter(|limits| !limits.is_sound()) {
                let what = format!("`{name}` of the {kind} has the limits {limits:?}");
                return Err(EpisodeError::description(what, "state finite limits that leave room to move"));
            }
        }
        let layout = Self(elements);
        layout.check_quaternions(kind)?;
        Ok(layout)
    }

    /// Each group with quaternion components must be four whose names end in `qw`, `qx`, `qy`, `qz`.
    fn check_quaternions(&self, kind: &str) -> Result<(), EpisodeError> {
        for (group, range) in self.quaternions() {
            let elements = &self.0[range];
            let ordered = elements.len() == 4
                && elements.iter().zip(["qw", "qx", "qy", "qz"]).all(|(element, end)| {
                    element.unit == Unit::QuaternionComponent && element.name.ends_with(end)
                });
            if !ordered {
                let what = format!("the quaternion in group `{group}` of the {kind} is in another order");
                return Err(EpisodeError::description(
                    what,
                    "name its components qw, qx, qy, qz, in this order",
                ));
            }
        }
        Ok(())
    }

    pub fn elements(&self) -> &[VectorElement] {
        &self.0
    }

    /// Number of the numbers in a vector; never 0.
    pub fn dimension(&self) -> usize {
        self.0.len()
    }

    /// The names with units, in order.
    pub fn full_names(&self) -> Vec<String> {
        self.0.iter().map(VectorElement::full_name).collect()
    }

    /// The groups and which numbers they hold, in order.
    pub fn groups(&self) -> Vec<(&str, Range<usize>)> {
        let mut groups: Vec<(&str, Range<usize>)> = Vec::new();
        for (i, element) in self.0.iter().enumerate() {
            match groups.last_mut() {
                Some((group, range)) if *group == element.group => range.end = i + 1,
                _ => groups.push((&element.group, i..i + 1)),
            }
        }
        groups
    }

    /// The groups that have components of quaternions.
    fn quaternions(&self) -> impl Iterator<Item = (&str, Range<usize>)> {
        let is_component = |element: &VectorElement| element.unit == Unit::QuaternionComponent;
        self.groups().into_iter().filter(move |(_, range)| self.0[range.clone()].iter().any(is_component))
    }

    /// The first group whose quaternion in `values` has the other sign than the same group's in the values of `other`:
    /// they are nearer to each other when one of them is negated.
    pub(crate) fn other_sign(&self, values: &[f32], other: &Self, others: &[f32]) -> Option<&str> {
        self.quaternions().find_map(|(group, range)| {
            let (_, near) = other.quaternions().find(|(near, _)| *near == group)?;
            let pairs = values[range].iter().zip(&others[near]);
            let dot: f64 = pairs.map(|(a, b)| f64::from(*a) * f64::from(*b)).sum();
            (dot < 0.0).then_some(group)
        })
    }

    /// Fault of a vector, if any, and the correction.
    pub(crate) fn fault_of(&self, kind: &str, values: &[f32]) -> Option<(String, &'static str)> {
        if values.len() != self.dimension() {
            let what = format!("the {kind} has {} numbers, the dataset {}", values.len(), self.dimension());
            return Some((what, "give one number for each name"));
        }
        for (value, element) in values.iter().zip(&self.0) {
            let name = element.full_name();
            if !value.is_finite() {
                let what = format!("`{name}` of the {kind} is {value}");
                return Some((what, "record finite numbers only"));
            }
            if let Some([min, max]) = element.range
                && !(min..=max).contains(value)
            {
                let what = format!("`{name}` of the {kind} is {value}, outside {min} to {max}");
                return Some((what, "correct the value, or describe the dataset with a wider range"));
            }
        }
        None
    }
}
