//! `/catalog` and `/robots`: what requests can name, as it is compiled in.

use std::sync::LazyLock;

use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::json;

use super::download::has_tag;
use super::extract::TenantApi;
use crate::problem::Problem;
use catalog::{Affordance, Category, State, categories};
use robot::model::{Robot, library};
use store::Digest;

/// The objects that scenes are made of.
#[derive(Serialize, JsonSchema)]
pub(super) struct Catalog {
    categories: Vec<CategoryView>,
}

/// A category of objects.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Category")]
struct CategoryView {
    name: &'static str,
    /// In words, singular.
    label: &'static str,
    synonyms: &'static [String],
    /// Other objects, in words, for which one of this category stands in.
    stands_in_for: &'static [String],
    families: &'static [String],
    /// What it is used as, such as `cutlery`.
    group: &'static str,
    size: SizeView,
    /// Mass at the typical size, kilograms; null where it follows from volume and substance.
    #[schemars(range(min = 0.0, max = 1000.0))]
    mass_kg: Option<f64>,
    /// Main substance.
    substance: &'static str,
    /// Colors that it has where none is asked for, `#rrggbb`.
    palette: &'static [String],
    #[schemars(with = "Vec<String>")]
    affordances: &'static [Affordance],
    /// States that it can be in beside standing upright.
    #[schemars(with = "Vec<String>")]
    states: &'static [State],
}

/// Extents of an object as it stands: width, depth, height; meters.
#[derive(Serialize, JsonSchema)]
struct SizeView {
    #[schemars(inner(range(min = 0.0, max = 10.0)))]
    low_m: [f64; 3],
    #[schemars(inner(range(min = 0.0, max = 10.0)))]
    high_m: [f64; 3],
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
pub(super) struct RobotList {
    robots: Vec<RobotView>,
}

/// A robot.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Robot")]
struct RobotView {
    name: String,
    /// In words.
    title: String,
    /// Number of joints of the arm.
    #[schemars(range(min = 1, max = 100))]
    dof: usize,
    gripper: GripperView,
}

/// A parallel gripper.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Gripper")]
struct GripperView {
    /// Greatest distance of the pads, meters.
    #[schemars(range(min = 0.0, max = 10.0))]
    max_opening_m: f64,
    /// Force of a grip, newtons.
    #[schemars(range(min = 0.0, max = 10_000.0))]
    grip_force_n: f64,
    /// Force that it can hold continuously, newtons.
    #[schemars(range(min = 0.0, max = 10_000.0))]
    max_force_n: f64,
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

/// A document that stays the same as long as the program runs, and its tag.
struct FixedDocument {
    text: String,
    tag: String,
}

impl FixedDocument {
    fn new(document: &impl Serialize) -> Self {
        let text = json!(document).to_string();
        let tag = format!("\"{}\"", Digest::of(text.as_bytes()));
        Self { text, tag }
    }

    fn answer(&'static self, headers: &HeaderMap) -> Response {
        let mut fields = HeaderMap::new();
        fields.insert(header::CACHE_CONTROL, HeaderValue::from_static("private, no-cache"));
        fields.insert(header::ETAG, HeaderValue::from_static(&self.tag));
        if has_tag(headers, header::IF_NONE_MATCH, &self.tag) {
            return (StatusCode::NOT_MODIFIED, fields).into_response();
        }
        fields.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
        (fields, self.text.as_str()).into_response()
    }
}

/// `GET /catalog`.
pub async fn show(_: TenantApi, headers: HeaderMap) -> Response {
    static CATALOG: LazyLock<FixedDocument> = LazyLock::new(|| {
        FixedDocument::new(&Catalog { categories: categories().iter().map(CategoryView::new).collect() })
    });
    CATALOG.answer(&headers)
}

/// `GET /robots`.
pub async fn robots(_: TenantApi) -> Result<Response, Problem> {
    let robots = library::names().map(crate::app::tasks::robot_named);
    let robots = robots.map(|robot| robot.map(|robot| RobotView::new(&robot))).collect::<Result<_, _>>()?;
    Ok(axum::Json(RobotList { robots }).into_response())
}
