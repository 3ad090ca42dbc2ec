//! Operations of an edit, each as an object with a name of its own.

use schemars::{JsonSchema, Schema};
use serde_json::{Value, json};

/// Operations, carried out in order.
#[derive(JsonSchema)]
pub struct EditOperations(#[schemars(length(min = 1, max = 64))] pub Vec<scene::EditOperation>);

/// One operation; `op` says which.
#[derive(JsonSchema)]
#[schemars(untagged)]
pub enum EditOperation {
    Add(AddOperation),
    Remove(RemoveOperation),
    Replace(ReplaceOperation),
    Move(MoveOperation),
    Rotate(RotateOperation),
    Resize(ResizeOperation),
    Recolor(RecolorOperation),
    Relabel(RelabelOperation),
    RestyleTable(RestyleTableOperation),
    Stack(StackOperation),
    Swap(SwapOperation),
    Arrange(ArrangeOperation),
    Tidy(TidyOperation),
    Clutter(ClutterOperation),
    Remake(RemakeOperation),
    Rearrange(RearrangeOperation),
    SetPhysics(SetPhysicsOperation),
    Relight(RelightOperation),
    MoveCamera(MoveCameraOperation),
}

/// New objects: a phrase as in a text ("a red mug"), without a place; anywhere on the table unless `where` is given.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct AddOperation {
    #[schemars(extend("const" = "add"))]
    pub op: String,
    pub object: Phrase,
    #[schemars(default = "one", range(min = 1, max = 32))]
    pub count: u32,
    #[schemars(rename = "where")]
    pub place: Option<EditPlace>,
}

/// Removes objects.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct RemoveOperation {
    #[schemars(extend("const" = "remove"))]
    pub op: String,
    pub target: Reference,
    /// Remove also what stands on or in them; otherwise it comes to rest below.
    #[schemars(default)]
    pub with_contents: bool,
}

/// Another object at the same place, on or in the same supporter.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ReplaceOperation {
    #[schemars(extend("const" = "replace"))]
    pub op: String,
    pub target: Reference,
    pub object: Phrase,
}

/// Another place; what stands on or in the object moves with it.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct MoveOperation {
    #[schemars(extend("const" = "move"))]
    pub op: String,
    pub target: Reference,
    #[schemars(rename = "where")]
    pub place: EditPlace,
}

/// A turn about the vertical axis, counter-clockwise from above: exactly one of `by_rad`, `to_rad` and `facing`.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct RotateOperation {
    #[schemars(extend("const" = "rotate"))]
    pub op: String,
    pub target: Reference,
    #[schemars(range(min = -6.3, max = 6.3))]
    pub by_rad: Option<f64>,
    /// 0 faces the front edge.
    #[schemars(range(min = -6.3, max = 6.3))]
    pub to_rad: Option<f64>,
    pub facing: Option<Reference>,
}

/// Another size.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ResizeOperation {
    #[schemars(extend("const" = "resize"))]
    pub op: String,
    pub target: Reference,
    /// On all three extents.
    #[schemars(range(min = 0.5, max = 2.0))]
    pub factor: f64,
}

/// Another color, another material, or both; at least one of them. Materials change mass and friction.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct RecolorOperation {
    #[schemars(extend("const" = "recolor"))]
    pub op: String,
    pub target: Reference,
    pub color: Option<String>,
    pub material: Option<String>,
}

/// Another label; the mesh stays.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct RelabelOperation {
    #[schemars(extend("const" = "relabel"))]
    pub op: String,
    pub target: Reference,
    pub label: Phrase,
}

/// Another appearance of the table, by material, color, or both; at least one of them. Its shape and size stay.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct RestyleTableOperation {
    #[schemars(extend("const" = "restyle_table"))]
    pub op: String,
    pub material: Option<String>,
    pub color: Option<String>,
}

/// One object on the other, the first at the bottom. One phrase for several stacks the largest first.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct StackOperation {
    #[schemars(extend("const" = "stack"))]
    pub op: String,
    #[schemars(length(min = 1, max = 32))]
    pub targets: Vec<Reference>,
}

/// Two objects change places: two phrases, or one that means two.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct SwapOperation {
    #[schemars(extend("const" = "swap"))]
    pub op: String,
    #[schemars(length(min = 1, max = 2))]
    pub targets: Vec<Reference>,
}

/// Objects in a row or a column: in the order of the phrases, sorted, or as they stand.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ArrangeOperation {
    #[schemars(extend("const" = "arrange"))]
    pub op: String,
    #[schemars(length(min = 1, max = 32))]
    pub targets: Vec<Reference>,
    pub arrangement: scene::ArrangedAs,
    pub sort_by: Option<scene::SortedBy>,
    /// An edge or a part of the table; where the objects are unless it is given.
    #[schemars(rename = "where")]
    pub place: Option<EditPlace>,
}

/// Objects that stand on the table are aligned with its edges and moved apart.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct TidyOperation {
    #[schemars(extend("const" = "tidy"))]
    pub op: String,
}

/// More objects of the scene's theme, or of the one that is given.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct ClutterOperation {
    #[schemars(extend("const" = "clutter"))]
    pub op: String,
    #[schemars(range(min = 1, max = 32))]
    pub count: u32,
    pub theme: Option<String>,
}

/// Another mesh of the same kind, with the same name, in the same place.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct RemakeOperation {
    #[schemars(extend("const" = "remake"))]
    pub op: String,
    pub target: Reference,
}

/// New places for what stands on the table. Relations that a text states still hold, and what rests on or in an object
/// moves with it.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct RearrangeOperation {
    #[schemars(extend("const" = "rearrange"))]
    pub op: String,
}

/// Another mass or friction, by factors; one of them or both.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields, transform = needs_factor)]
pub struct SetPhysicsOperation {
    #[schemars(extend("const" = "set_physics"))]
    pub op: String,
    pub target: Reference,
    #[schemars(default)]
    pub mass_factor: OptionalFactor,
    #[schemars(default)]
    pub friction_factor: OptionalFactor,
}

/// A key light at another place. Azimuth 0 is at the front edge, pi/2 at the right.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct RelightOperation {
    #[schemars(extend("const" = "relight"))]
    pub op: String,
    #[schemars(range(min = -6.3, max = 6.3))]
    pub azimuth_rad: f64,
    #[schemars(range(min = 0.2, max = 1.5))]
    pub elevation_rad: f64,
    /// Of the usual brightness.
    #[schemars(range(min = 0.3, max = 2.0))]
    pub intensity: f64,
}

/// Another view of the reference camera: turned about the center of the table and raised, nearer or farther, or with
/// another focal length; at least one of them.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields, transform = needs_movement)]
pub struct MoveCameraOperation {
    #[schemars(extend("const" = "move_camera"))]
    pub op: String,
    #[schemars(range(min = -6.3, max = 6.3))]
    pub turn_rad: Option<f64>,
    #[schemars(range(min = -1.0, max = 1.0))]
    pub raise_rad: Option<f64>,
    #[schemars(default)]
    pub distance_factor: OptionalFactor,
    #[schemars(default)]
    pub focal_factor: OptionalFactor,
}

/// A place, by exactly one of `relation`, `position_m` and `offset_m`.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct EditPlace {
    pub relation: Option<EditRelation>,
    /// The other object; absent for the table.
    pub target: Option<Reference>,
    /// The second object of `between`.
    pub second_target: Option<Reference>,
    /// Free distance to the target or to the edge.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub distance_m: Option<f64>,
    /// Center of the object on the table top, from its center, to the right and to the back.
    #[schemars(inner(range(min = -5.0, max = 5.0)), length(equal = 2))]
    pub position_m: Option<Vec<f64>>,
    /// Displacement from where a moved object is, to the right and to the back.
    #[schemars(inner(range(min = -5.0, max = 5.0)), length(equal = 2))]
    pub offset_m: Option<Vec<f64>>,
    /// Rotation about the vertical axis; 0 faces the front edge. Chosen where it is absent.
    #[schemars(range(min = -6.3, max = 6.3))]
    pub yaw_rad: Option<f64>,
}

/// A relation to an object, a region of the table, or a distance from one of its edges.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum EditRelation {
    On,
    In,
    LeftOf,
    RightOf,
    InFrontOf,
    Behind,
    NextTo,
    Between,
    AtCenter,
    AtBack,
    AtFront,
    AtLeft,
    AtRight,
    AtBackLeft,
    AtBackRight,
    AtFrontLeft,
    AtFrontRight,
    FromLeftEdge,
    FromRightEdge,
    FromFrontEdge,
    FromBackEdge,
}

/// A factor.
#[derive(Default, JsonSchema)]
pub struct OptionalFactor(#[schemars(range(min = 0.25, max = 4.0))] pub Option<f64>);

/// Words for a new object, or a label.
#[derive(JsonSchema)]
pub struct Phrase(#[schemars(length(min = 1, max = 200), regex(pattern = r"\S"))] pub String);

/// An object of the scene: its name (`mug_1`) or a phrase ("the red mug", "the second book from the left", "all
/// spoons"). A phrase that fits several objects where one is meant fails the job, which names them.
#[derive(JsonSchema)]
pub struct Reference(#[schemars(length(min = 1, max = 200), regex(pattern = r"\S"))] pub String);

fn one() -> u32 {
    1
}

/// Requires one of some fields, and not as null.
fn one_at_least(schema: &mut Schema, fields: &[&str]) {
    let alternatives: Vec<Value> = fields
        .iter()
        .map(|field| json!({ "required": [field], "properties": { *field: { "not": { "type": "null" } } } }))
        .collect();
    schema.insert("anyOf".to_owned(), alternatives.into());
}

fn needs_factor(schema: &mut Schema) {
    one_at_least(schema, &["mass_factor", "friction_factor"]);
}

fn needs_movement(schema: &mut Schema) {
    one_at_least(schema, &["turn_rad", "raise_rad", "distance_factor", "focal_factor"]);
}
