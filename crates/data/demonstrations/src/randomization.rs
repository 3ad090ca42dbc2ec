//! Differences between the demonstrations of a dataset, and their amplitudes.

use scene::Violation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The amplitude of each axis; 0 leaves it as in the scene. Numbers are drawn evenly from `-x` to `x`, factors from
/// `1 - x` to `1 + x`. Each axis has random numbers of its own, so that switching one on does not change the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(
    rename = "RandomizationAmplitudes",
    description = "Numbers are drawn evenly from -x to x, factors from 1 - x to 1 + x; what is absent does not vary."
)]
pub struct Randomization {
    /// Positions of objects on the table, along each axis, meters, with all that they carry.
    #[schemars(range(min = 0.0, max = 0.3))]
    pub position_m: f64,
    /// Yaws of objects, radians.
    #[schemars(range(min = 0.0, max = 3.15))]
    pub yaw_rad: f64,
    /// The probability that an object is absent which the task does not name.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub absent_distractors: f64,
    /// Maximum number of other objects of the catalog; the number is drawn evenly from none on.
    #[schemars(with = "u32", range(min = 0, max = 8))]
    pub added_distractors: f64,
    /// Factor of the colors of objects, each channel.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub object_color: f64,
    /// Factor of the color of the table, each channel.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub table_color: f64,
    /// The probability that an object has another material of the same color.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub object_material: f64,
    /// The probability that the top of the table has another material of the catalog.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub table_material: f64,
    /// Azimuth of the light, radians; half of it for the elevation.
    #[schemars(range(min = 0.0, max = 3.15))]
    pub light_direction_rad: f64,
    /// Factor of the light's brightness.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub light_brightness: f64,
    /// Factor of the color of the backdrop, each channel.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub backdrop_color: f64,
    /// The joints of the arm at the start, radians.
    #[schemars(range(min = 0.0, max = 0.3))]
    pub start_rad: f64,
    /// Cameras along each of their axes, meters.
    #[schemars(range(min = 0.0, max = 0.2))]
    pub camera_position_m: f64,
    /// Cameras about each of their axes, radians.
    #[schemars(range(min = 0.0, max = 0.2))]
    pub camera_angle_rad: f64,
    /// Factor of the focal length.
    #[schemars(range(min = 0.0, max = 0.2))]
    pub focal_length: f64,
    /// Factor of each object's mass.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub mass: f64,
    /// Factor of each object's friction.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub friction: f64,
}

/// An axis: its name, its largest amplitude, its unit, and what it is of.
pub struct Axis {
    pub name: &'static str,
    pub max: f64,
    pub unit: &'static str,
    pub of: &'static str,
    amplitude: fn(&Randomization) -> f64,
}

const fn axis(
    name: &'static str,
    max: f64,
    unit: &'static str,
    of: &'static str,
    amplitude: fn(&Randomization) -> f64,
) -> Axis {
    Axis { name, max, unit, of, amplitude }
}

const PROBABILITY: &str = "probability";
const OBJECTS: &str = "objects";

/// All axes.
pub const AXES: [Axis; 17] = [
    axis("position_m", 0.3, "m", "objects along x and y, with what they carry", |r| r.position_m),
    axis("yaw_rad", 3.15, "rad", "objects about the vertical", |r| r.yaw_rad),
    axis("absent_distractors", 1.0, PROBABILITY, "absence of objects that the task does not name", |r| {
        r.absent_distractors
    }),
    axis("added_distractors", 8.0, OBJECTS, "other objects of the catalog on the table", |r| {
        r.added_distractors
    }),
    axis("object_color", 0.5, "factor", "colors of objects, each channel", |r| r.object_color),
    axis("table_color", 0.5, "factor", "color of the table, each channel", |r| r.table_color),
    axis("object_material", 1.0, PROBABILITY, "another material of objects, in the same color", |r| {
        r.object_material
    }),
    axis("table_material", 1.0, PROBABILITY, "another material of the table's top", |r| r.table_material),
    axis("light_direction_rad", 3.15, "rad", "azimuth of the light, half of it for the elevation", |r| {
        r.light_direction_rad
    }),
    axis("light_brightness", 0.5, "factor", "brightness of the light", |r| r.light_brightness),
    axis("backdrop_color", 0.5, "factor", "color of the backdrop, each channel", |r| r.backdrop_color),
    axis("start_rad", 0.3, "rad", "joints of the arm at the start", |r| r.start_rad),
    axis("camera_position_m", 0.2, "m", "cameras along each of their axes", |r| r.camera_position_m),
    axis("camera_angle_rad", 0.2, "rad", "cameras about each of their axes", |r| r.camera_angle_rad),
    axis("focal_length", 0.2, "factor", "focal length", |r| r.focal_length),
    axis("mass", 0.5, "factor", "mass of each object", |r| r.mass),
    axis("friction", 0.5, "factor", "friction of each object", |r| r.friction),
];

impl Randomization {
    /// Nothing varies, but for the motion where no direct path is free.
    pub const NONE: Self = Self {
        position_m: 0.0,
        yaw_rad: 0.0,
        absent_distractors: 0.0,
        added_distractors: 0.0,
        object_color: 0.0,
        table_color: 0.0,
        object_material: 0.0,
        table_material: 0.0,
        light_direction_rad: 0.0,
        light_brightness: 0.0,
        backdrop_color: 0.0,
        start_rad: 0.0,
        camera_position_m: 0.0,
        camera_angle_rad: 0.0,
        focal_length: 0.0,
        mass: 0.0,
        friction: 0.0,
    };

    /// The axes that leave the scene what was asked for, by a usual amount: no other objects, no other materials.
    pub const USUAL: Self = Self {
        position_m: 0.05,
        yaw_rad: 0.5,
        absent_distractors: 0.2,
        added_distractors: 0.0,
        object_color: 0.15,
        table_color: 0.2,
        object_material: 0.0,
        table_material: 0.0,
        light_direction_rad: 0.6,
        light_brightness: 0.2,
        backdrop_color: 0.2,
        start_rad: 0.05,
        camera_position_m: 0.02,
        camera_angle_rad: 0.02,
        focal_length: 0.03,
        mass: 0.2,
        friction: 0.2,
    };

    /// Every axis, further than usual: for policies that are to work elsewhere too.
    pub const WIDE: Self = Self {
        position_m: 0.08,
        yaw_rad: 1.0,
        absent_distractors: 0.3,
        added_distractors: 3.0,
        object_color: 0.25,
        table_color: 0.3,
        object_material: 0.3,
        table_material: 0.5,
        light_direction_rad: 1.2,
        light_brightness: 0.3,
        backdrop_color: 0.4,
        start_rad: 0.1,
        camera_position_m: 0.03,
        camera_angle_rad: 0.05,
        focal_length: 0.06,
        mass: 0.3,
        friction: 0.3,
    };

    /// The amplitudes of a name: `none`, `usual` or `wide`.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "none" => Some(Self::NONE),
            "usual" => Some(Self::USUAL),
            "wide" => Some(Self::WIDE),
            _ => None,
        }
    }

    /// Every amplitude that is out of its range.
    pub fn violations(&self) -> Vec<Violation> {
        let fault = |axis: &Axis| {
            let amplitude = (axis.amplitude)(self);
            let is_within = (0.0..=axis.max).contains(&amplitude);
            match axis.unit == OBJECTS && amplitude.fract() != 0.0 {
                true => Some(format!("must be a whole number from 0 to {}", axis.max)),
                false => (!is_within).then(|| format!("must be from 0 to {}", axis.max)),
            }
        };
        let wrong = AXES.iter().filter_map(|axis| Some((axis.name, fault(axis)?)));
        wrong.map(|(name, detail)| Violation { pointer: format!("/{name}"), detail }).collect()
    }

    /// The axes that vary, as a table in Markdown.
    pub fn table(&self) -> String {
        let varied: Vec<&Axis> = AXES.iter().filter(|axis| (axis.amplitude)(self) > 0.0).collect();
        if varied.is_empty() {
            return "Nothing varies, and where a direct path is free not even the motion.".to_owned();
        }
        let row = |axis: &&Axis| {
            let amplitude = (axis.amplitude)(self);
            let range = match axis.unit {
                "factor" => format!("{:.2} to {:.2}", 1.0 - amplitude, 1.0 + amplitude),
                PROBABILITY => format!("{amplitude}"),
                OBJECTS => format!("0 to {amplitude}"),
                unit => format!("-{amplitude} to {amplitude} {unit}"),
            };
            format!("| `{}` | {range} | {} |\n", axis.name, axis.of)
        };
        let rows: String = varied.iter().map(row).collect();
        format!("| axis | drawn evenly from | of |\n| --- | --- | --- |\n{rows}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amplitudes_outside_their_ranges_are_named() {
        assert!(Randomization::USUAL.violations().is_empty());
        let wrong = Randomization { mass: 0.6, yaw_rad: -0.1, start_rad: f64::NAN, ..Randomization::NONE };
        let pointers: Vec<String> = wrong.violations().into_iter().map(|v| v.pointer).collect();
        assert_eq!(pointers, ["/yaw_rad", "/start_rad", "/mass"]);
        let wrong = Randomization { added_distractors: 1.5, ..Randomization::WIDE };
        let pointers: Vec<String> = wrong.violations().into_iter().map(|v| v.pointer).collect();
        assert_eq!(pointers, ["/added_distractors"]);
    }

    #[test]
    fn wide_is_further_than_usual_in_every_axis() {
        for axis in AXES {
            let (usual, wide) =
                ((axis.amplitude)(&Randomization::USUAL), (axis.amplitude)(&Randomization::WIDE));
            assert!(usual < wide && wide <= axis.max, "{}", axis.name);
        }
        assert!(Randomization::WIDE.violations().is_empty());
    }

    #[test]
    fn every_field_is_an_axis() {
        let fields = serde_json::to_value(Randomization::USUAL).expect("numbers");
        let names: Vec<&str> = fields.as_object().expect("an object").keys().map(String::as_str).collect();
        let mut axes: Vec<&str> = AXES.iter().map(|axis| axis.name).collect();
        axes.sort_unstable();
        let mut sorted = names;
        sorted.sort_unstable();
        assert_eq!(axes, sorted);
    }
}
