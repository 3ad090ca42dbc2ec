//! Categories of objects, and robots, which requests can name, as they are compiled in.

use ::catalog::{Affordance, Category, State, categories};
use robot::model::{Robot, library};
use schemars::JsonSchema;
use serde::Serialize;

use super::tasks::robot_named;
use crate::problem::Problem;

/// The objects that scenes are made of.
#[derive(Serialize, JsonSchema)]
pub struct Catalog {
    pub categories: Vec<CategoryView>,
}

/// A category of objects.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Category")]
pub struct CategoryView {
    pub name: &'static str,
    /// In words, singular.
    pub label: &'static str,
    pub synonyms: &'static [String],
    /// Other objects, in words, for which one of this category stands in.
    pub stands_in_for: &'static [String],
    pub families: &'static [String],
    /// Functional group, such as `cutlery`.
    pub group: &'static str,
    pub size: SizeView,
    /// Mass at the typical size, kilograms; null where it follows from volume and substance.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub mass_kg: Option<f64>,
    /// Main substance.
    pub substance: &'static str,
    /// Colors that it has where none is asked for, `#rrggbb`.
    pub palette: &'static [String],
    #[schemars(with = "Vec<String>")]
    pub affordances: &'static [Affordance],
    /// States that it can be in beside standing upright.
    #[schemars(with = "Vec<String>")]
    pub states: &'static [State],
}

/// Extents of an object as it stands: width, depth, height; meters.
#[derive(Serialize, JsonSchema)]
pub struct SizeView {
    #[schemars(inner(range(min = 0.0, max = 10.0)))]
    pub low_m: [f64; 3],
    #[schemars(inner(range(min = 0.0, max = 10.0)))]
    pub high_m: [f64; 3],
}

impl CategoryView {
    fn new(category: &'static Category) -> Self {
        Self {
            name: &category.name,
            label: &category.label,
            synonyms: &category.synonyms,
            stands_in_for: &category.stands_in_for,
            families: &category.families,
            group: &category.group,
            size: SizeView { low_m: category.size.low_m.to_array(), high_m: category.size.high_m.to_array() },
            mass_kg: category.mass_kg,
            substance: &category.substance,
            palette: &category.palette,
            affordances: &category.affordances,
            states: &category.states,
        }
    }
}

/// The robots that tasks are done with.
#[derive(Serialize, JsonSchema)]
pub struct RobotList {
    pub robots: Vec<RobotView>,
}

/// A robot.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Robot")]
pub struct RobotView {
    pub name: String,
    /// In words.
    pub title: String,
    /// Number of joints of the arm.
    #[schemars(range(min = 1, max = 100))]
    pub dof: usize,
    pub gripper: GripperView,
}

/// A parallel gripper.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Gripper")]
pub struct GripperView {
    /// Greatest distance of the pads, meters.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub max_opening_m: f64,
    /// Force of a grip, newtons.
    #[schemars(range(min = 0.0, max = 10_000.0))]
    pub grip_force_n: f64,
    /// Force that it can hold continuously, newtons.
    #[schemars(range(min = 0.0, max = 10_000.0))]
    pub max_force_n: f64,
}

impl RobotView {
    fn new(robot: &Robot) -> Self {
        let gripper = robot.gripper();
        Self {
            name: robot.name().to_owned(),
            title: robot.title().to_owned(),
            dof: robot.dof(),
            gripper: GripperView {
                max_opening_m: gripper.max_opening_m,
                grip_force_n: gripper.grip_force_n,
                max_force_n: gripper.max_force_n,
            },
        }
    }
}

/// Every category that a text can name, in the order of the catalog.
pub fn catalog() -> Catalog {
    Catalog { categories: categories().iter().map(CategoryView::new).collect() }
}

/// Every robot that is built in.
///
/// # Errors
///
/// A [`Problem`], where the file of a robot cannot be read.
pub fn robots() -> Result<RobotList, Problem> {
    let robots = library::names().map(|name| robot_named(name).map(|robot| RobotView::new(&robot)));
    Ok(RobotList { robots: robots.collect::<Result<_, _>>()? })
}
