//! Reasons why a format could not be read, and differences between a format and the scene.

use std::collections::BTreeMap;

use mesh_io::gltf::GltfError;
use scene::StandIn;
use zip::result::ZipError;

pub use super::usd::LayerError;

/// Reason why a format could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    #[error("{0} is missing")]
    Missing(String),
    #[error("{0} is not UTF-8")]
    NotUtf8(String),
    #[error("{place}: {reason}")]
    Within { place: String, reason: Box<ReadError> },
    #[error("{owner} has no {part}")]
    Lacks { owner: String, part: String },
    #[error("there is no {0}")]
    Absent(String),
    #[error("{what} {fault}")]
    Wrong { what: String, fault: &'static str },
    #[error("there is not one root")]
    NotOneRoot,
    #[error("{text:?} is no {kind}")]
    NotA { text: String, kind: &'static str },
    #[error("{text:?} in <{element}> is no number")]
    ElementNotNumber { text: String, element: String },
    #[error("{face:?} is no triangle of {corners} corners")]
    NotTriangle { face: String, corners: usize },
    #[error("{attribute} has {found} numbers instead of {wanted}")]
    NumberCount { attribute: String, found: usize, wanted: &'static str },
    #[error("a {solid} has {sizes} sizes")]
    SizeCount { solid: String, sizes: usize },
    #[error("a collision is a {0}")]
    CollisionKind(String),
    #[error("the collider {path} is a {kind:?}")]
    ColliderKind { path: String, kind: String },
    #[error("the {whole}'s {name} is not the one of its own {own}")]
    OtherThanOwn { whole: &'static str, name: String, own: &'static str },
    #[error("friction differs between {0}")]
    FrictionDiffers(String),
    #[error("programs would read different frictions of {name}: {found:?}")]
    ProgramsDiffer { name: String, found: Vec<[f64; 2]> },
    #[error("{file} is not in the package {package}")]
    OutsidePackage { file: String, package: String },
    #[error("{path}: {field} is {found:?} instead of {wanted}")]
    Field { path: String, field: &'static str, found: Option<String>, wanted: &'static str },
    #[error("{layer} of {name} does not make {collider} a collider of {program}")]
    NoCollider { layer: String, name: String, collider: String, program: &'static str },
    #[error("{layer} of {name} lets contacts of {collider} begin at a distance")]
    DistantContacts { layer: String, name: String, collider: String },
    #[error("{prim} lacks {schema}")]
    NoSchema { prim: String, schema: &'static str },
    #[error("{collider} is not bound to {material}")]
    NotBound { collider: String, material: String },
    #[error("{name} is compressed in the package or begins at byte {begin}")]
    PackageAlignment { name: String, begin: u64 },
    #[error("{name} in the package: {error}")]
    PackageEntry { name: String, error: std::io::Error },
    #[error("the package: {0}")]
    Package(#[from] ZipError),
    #[error(transparent)]
    Layer(#[from] LayerError),
    #[error(transparent)]
    Xml(#[from] roxmltree::Error),
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    #[error(transparent)]
    Gltf(#[from] GltfError),
}

impl ReadError {
    pub(super) fn missing(what: impl Into<String>) -> Self {
        Self::Missing(what.into())
    }

    pub(super) fn lacks(owner: impl Into<String>, part: impl Into<String>) -> Self {
        Self::Lacks { owner: owner.into(), part: part.into() }
    }

    pub(super) fn wrong(what: impl Into<String>, fault: &'static str) -> Self {
        Self::Wrong { what: what.into(), fault }
    }

    pub(super) fn not_a(kind: &'static str, text: &str) -> Self {
        Self::NotA { text: text.to_owned(), kind }
    }

    /// The error with the place of its cause.
    pub(super) fn within(self, place: impl Into<String>) -> Self {
        Self::Within { place: place.into(), reason: Box::new(self) }
    }
}

/// First difference between a format and the scene beyond the tolerances.
#[derive(Debug, thiserror::Error)]
pub enum Difference {
    #[error("{0} is missing")]
    Missing(String),
    #[error("{found} {of} instead of {wanted}")]
    Count { found: usize, of: String, wanted: usize },
    #[error("{owner} has {found} {of} instead of {wanted}")]
    CountOf { owner: String, found: usize, of: &'static str, wanted: usize },
    #[error("{body}: {found} hulls")]
    HullCount { body: String, found: usize },
    #[error("{body}: hull {hull} {fault}")]
    Hull { body: String, hull: usize, fault: &'static str },
    #[error("{body}: movable {found}")]
    Movable { body: String, found: bool },
    #[error("{body}: {quantity} differs by {difference}")]
    Quantity { body: String, quantity: &'static str, difference: f64 },
    #[error("{body}: {difference}")]
    Visual { body: String, difference: Box<Difference> },
    #[error("no visual mesh is of {0}")]
    NoVisualOf(String),
    #[error("a vertex of {path} is {off_m} m off")]
    Vertex { path: String, off_m: f64 },
    #[error("{body}: the {what} is {found:?} instead of {wanted:?}")]
    Words { body: String, what: &'static str, found: String, wanted: String },
    #[error("{body}: the label is {found:?} instead of {wanted:?}")]
    Label { body: String, found: Option<String>, wanted: String },
    #[error("{body}: the mark of a stand-in is {found:?} instead of {wanted:?}")]
    StandIn { body: String, found: Option<Box<StandIn>>, wanted: Option<Box<StandIn>> },
    #[error("the stand-ins are {found:?} instead of {wanted:?}")]
    StandIns { found: BTreeMap<String, StandIn>, wanted: BTreeMap<String, StandIn> },
    #[error("the mesh of {0}")]
    Mesh(String),
    #[error("a vertex of the scene by {off_m} m")]
    SceneVertex { off_m: f64 },
    #[error("no node is {0}")]
    NoNode(String),
    #[error("the pose of {body} by {translation_m} m, {rotation_rad} rad")]
    Pose { body: String, translation_m: f64, rotation_rad: f64 },
    /// A file of a mesh.
    #[error(transparent)]
    Unreadable(#[from] ReadError),
}
