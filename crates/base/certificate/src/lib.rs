//! The certificate of a scene: measurements, thresholds and the verdict.
//!
//! A crate of its own, so that a new measurement compiles the stage that makes it and the files that show it, and no
//! algorithm.

mod scene_summary;

pub use scene_summary::SceneSummary;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use geometry::decompose::HullFit;
use geometry::json_numbers::Fraction;
use geometry::repair::Repair;
use scene::appraisal::Appraisal;
use scene::clutter::ClutterFinding;
use scene::{DepthAccount, InstanceId, Metrics, ReconstructionMethod};

/// All measurements of the stage `certify`. Rates are fractions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Certificate {
    pub verdict: Verdict,
    /// The reason for the verdict in one sentence.
    #[schemars(length(min = 1))]
    pub summary: String,
    /// One per failed check; empty for a pass.
    pub reasons: Vec<Reason>,
    pub metrics: Metrics,
    /// Number of examined pairs of bodies, the table included.
    pub pairs: usize,
    pub fidelity: Fidelity,
    pub thresholds: Thresholds,
    /// In the order of the scene.
    pub objects: Vec<ObjectCertificate>,
    /// Mesh and hulls of every body, the table first.
    pub bodies: Vec<BodyHealth>,
    /// Relative standard error of the scene's scale, from the disagreement of boxes and sizes. null if the scale was
    /// given, or was set by one object or the table.
    #[schemars(range(min = 0.0))]
    pub scale_error: Option<f64>,
    /// Colliding pairs with their penetration depth.
    pub collisions: Vec<Collision>,
    pub resolve: ResolveFinding,
    /// Ratings and tasks of a vision-language model, if requested. The verdict does not depend on them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub appraisal: Option<Appraisal>,
    /// Abilities of a robot in the scene, if the request names one. The verdict does not depend on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<RobotFinding>,
    /// Measurements of clutter, if the request asks for it. Its objects are where they fell, so the verdict does not
    /// depend on the likeness to the image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clutter: Option<ClutterFinding>,
    pub made_with: MadeWith,
}

/// A failed check.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Reason {
    pub code: ReasonCode,
    /// Names of the affected bodies; empty for the whole scene.
    pub bodies: Vec<String>,
    /// The finding in one sentence, for people.
    #[schemars(length(min = 1))]
    pub sentence: String,
}

/// The failed check. The serialized names are stable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ReasonCode {
    /// Two visual meshes interpenetrate.
    Collision,
    /// The center of mass is not above the support region.
    NotSupported,
    /// The object moves or rotates too far under gravity.
    NotAtRest,
    /// The object reaches over the table's edge.
    OverTheEdge,
    /// The visual mesh encloses no volume, as an edge has a face on one side only.
    OpenMesh,
    /// A part of the visual mesh lies outside all hulls.
    MissingCollider,
    /// A hull sticks out of the visual mesh.
    ProtrudingCollider,
    /// Hulls fill an opening of the visual mesh, such as a cavity or a handle.
    ClosedOpening,
    /// The density is outside the range of solids; the mass may be in another unit than kilograms.
    ImplausibleDensity,
    /// The friction is outside the range of real surfaces.
    ImplausibleFriction,
    /// The scene does not match the reference image.
    UnlikeImage,
}

/// Verdict on the use of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(description = "Verdict of the certificate; a quarantined scene is failed.")]
pub enum Verdict {
    Pass,
    Quarantine,
}

/// Thresholds of the verdict.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Thresholds {
    #[schemars(range(min = 0.0))]
    pub penetration_m: f64,
    /// A penetration deeper than this share of the local wall thickness is a collision, too.
    #[schemars(with = "Fraction")]
    pub wall_share: f64,
    #[schemars(range(min = 0.0))]
    pub contact_gap_m: f64,
    #[schemars(range(min = 0.0))]
    pub support_dilation_m: f64,
    #[schemars(range(min = 0.0))]
    pub dss_displacement_m: f64,
    #[schemars(range(min = 0.0))]
    pub dss_rotation_rad: f64,
    #[schemars(range(min = 0.0))]
    pub dss_duration_s: f64,
    /// An object at rest moves and overlaps less than this share of its smallest side.
    #[serde(default)]
    #[schemars(with = "Fraction")]
    pub rest_side_share: f64,
    /// An object at rest turns less than this, radians.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub rest_rotation_rad: f64,
    /// Maximum overhang of an object over the table's outline.
    #[schemars(range(min = 0.0))]
    pub outline_m: f64,
    /// Minimum mean silhouette IoU with the image that the request gives.
    #[schemars(with = "Fraction")]
    pub silhouette_iou: f64,
    /// Largest share of the image's object pixels that the scene misses.
    #[serde(default = "one")]
    #[schemars(with = "Fraction")]
    pub missed_share: f64,
    /// Largest share of the scene's object pixels that the image does not show.
    #[serde(default = "one")]
    #[schemars(with = "Fraction")]
    pub invented_share: f64,
    #[serde(flatten)]
    pub health: HealthThresholds,
}

/// A limit that nothing exceeds: reports of earlier versions have none.
fn one() -> f64 {
    1.0
}

/// Plausibility thresholds of a single body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HealthThresholds {
    /// Maximum distance by which a hull may stick out of the visual mesh.
    #[schemars(range(min = 0.0))]
    pub hull_excess_m: f64,
    /// Maximum distance of a corner of the mesh outside all hulls.
    #[schemars(range(min = 0.0))]
    pub uncovered_m: f64,
    /// As a share of the body's longest side; the larger of the two limits applies.
    #[schemars(with = "Fraction")]
    pub uncovered_share: f64,
    /// Minimum share of a mesh's openings that no hull fills.
    #[schemars(with = "Fraction")]
    pub open_share: f64,
    /// Minimum and maximum length of the longest side.
    #[schemars(inner(range(min = 0.0)))]
    pub longest_side_m: [f64; 2],
    /// Minimum and maximum of mass over enclosed volume.
    #[schemars(inner(range(min = 0.0)))]
    pub density_kg_m3: [f64; 2],
    /// Largest static friction coefficient; the dynamic one may not exceed the static one.
    #[schemars(range(min = 0.0))]
    pub friction: f64,
}

impl HealthThresholds {
    /// Maximum distance of a mesh vertex outside all hulls, meters.
    pub fn max_uncovered_m(&self, size_m: [f64; 3]) -> f64 {
        self.uncovered_m.max(self.uncovered_share * size_m.into_iter().fold(0.0, f64::max))
    }
}

/// Per-object findings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ObjectCertificate {
    pub name: InstanceId,
    /// Signed distance of the projected center of mass inside its support region, meters. A positive value is a lower
    /// bound, because the search ends with the first contacts that carry the object. Null without contacts.
    pub support_margin_m: Option<f64>,
    pub moved: Displacements,
    /// Largest displacement, and largest overlap with another body, that counts as rest, meters.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub rest_limit_m: f64,
    /// Deepest overlap of its hulls with those of another body at the end of the check under gravity, meters.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub overlap_m: f64,
    /// Signed distance of the hulls' outermost corner inside the table's outline, meters; negative outside.
    pub outline_margin_m: f64,
    pub inside_outline: bool,
    /// Intersection over union of its pixels in the reference image and in a rendering of the finished scene from the
    /// same camera, 0..1.
    #[schemars(with = "Fraction")]
    pub silhouette_iou: f64,
    /// Mean CIELAB distance (CIE 1976) over the pixels where both show the object, lighting differences included.
    /// Null if there is no such pixel.
    #[schemars(range(min = 0.0))]
    pub color_difference: Option<f64>,
    /// Reconstruction method of its mesh.
    pub method: ReconstructionMethod,
    pub rotation: RotationFinding,
}

/// Displacements of an object between the stages and under gravity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Displacements {
    /// From the pose of the stage `place` to the start of settling: dropped and separated.
    pub by_resolve: Displacement,
    /// From there to the rest pose, which is the pose of the bundle.
    pub by_settling: Displacement,
    /// From the pose of the stage `place` to the pose of the bundle.
    pub from_aligned: Displacement,
    /// During the check under gravity, from the pose of the bundle (DSS as shipped).
    pub after_shipping: Displacement,
    /// During the check under gravity, from the pose of the stage `place` (DSS as aligned).
    pub after_aligning: Displacement,
}

/// Difference between two poses of one body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Displacement {
    /// Of the origin in the world, meters.
    #[schemars(range(min = 0.0))]
    pub distance_m: f64,
    #[schemars(range(min = 0.0))]
    pub angle_rad: f64,
}

/// Mesh and hulls of one body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BodyHealth {
    pub name: String,
    /// Every edge of the visual mesh has two faces.
    pub watertight: bool,
    pub triangles: usize,
    /// Extents of the mesh's axis-aligned box, object frame.
    #[schemars(inner(range(min = 0.0)))]
    pub size_m: [f64; 3],
    /// Volume enclosed by the mesh without cavities. Overlaps of closed parts count twice.
    pub volume_m3: f64,
    pub mass_kg: f64,
    pub density_kg_m3: f64,
    pub hulls: usize,
    /// Maximum number of vertices of a hull.
    pub hull_corners: usize,
    /// Sum over the hulls; overlaps count twice.
    pub hull_volume_m3: f64,
    /// Maximum protrusion of a hull out of the visual mesh, meters.
    #[schemars(range(min = 0.0))]
    pub hull_excess_m: f64,
    /// Maximum distance of a mesh vertex outside all hulls, meters; a lower bound, measured to the face planes of the
    /// nearest hull.
    #[schemars(range(min = 0.0))]
    pub uncovered_m: f64,
    /// Fit of the hulls to the repaired mesh, from which they were made.
    pub hull_fit: HullFit,
    /// Repairs of the mesh before its decomposition into hulls. The visual mesh is not repaired.
    pub repair: Repair,
}

/// Result of the stage `resolve`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ResolveFinding {
    /// Number of rounds.
    pub rounds: usize,
    /// Actions, one sentence each.
    pub log: Vec<String>,
    /// Relaxations that the request allows, for objects without space; empty if all objects fit.
    pub gave_way: Vec<Relaxation>,
}

/// A relaxation of one object that did not fit as requested.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Relaxation {
    pub name: String,
    #[serde(flatten)]
    pub how: RelaxationKind,
}

/// Kind of a relaxation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "outcome", rename_all = "snake_case")]
pub enum RelaxationKind {
    /// Made smaller, by this factor on the requested size.
    Shrunk {
        #[schemars(with = "Fraction")]
        scale: f64,
    },
    /// Moved from its supporter to free space on the table.
    Moved { from: String },
}

/// Adapters and settings. Together with the request of `scene.json` they determine every byte of the bundle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MadeWith {
    /// Version of the program.
    pub version: String,
    pub adapters: Vec<AdapterUsed>,
    /// The resolved settings of all stages, by section.
    #[schemars(with = "serde_json::Map<String, serde_json::Value>")]
    pub settings: serde_json::Value,
}

/// The adapter that answered for a port.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct AdapterUsed {
    pub port: String,
    pub name: String,
    pub model: String,
}

/// Yaw estimate of the stage `rotate` with its confidence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RotationFinding {
    /// About world +z.
    pub yaw_rad: f64,
    /// The symmetry-equivalent yaw within half a period of 0.
    pub representative_yaw_rad: f64,
    /// Rotational symmetry of shape and texture: 1 = none, n = every 360/n degrees, 0 = any angle.
    pub symmetry_order: u32,
    /// Rotational symmetry of the shape alone.
    pub shape_symmetry_order: u32,
    /// Intersection of the shape's symmetry axis with the object's xy plane.
    pub symmetry_axis_m: [f64; 2],
    /// 0..1: agreement of the outlines and margin to the best alternative yaw.
    pub confidence: f64,
    /// (yaw in radians, loss) of the refined candidates, best first. Colors may select another one than the first.
    pub candidates: Vec<(f64, f64)>,
}

/// Earlier versions judged every scene.
fn yes() -> bool {
    true
}

/// Similarity of the finished scene and the reference image from the same camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Fidelity {
    /// Whether the verdict depends on it: the request gives the image, or a model generated it. The program's own
    /// rendering of a text or of an edited scene says nothing about what was asked for, nor does an image about objects
    /// that were dropped.
    #[serde(default = "yes")]
    pub is_judged: bool,
    /// Mean of the objects' silhouette IoUs, 0..1.
    #[schemars(with = "Fraction")]
    pub silhouette_iou: f64,
    /// Mean CIELAB distance (CIE 1976) over the pixels where both show the same object, lighting differences included.
    /// Null if there is no such pixel.
    #[schemars(range(min = 0.0))]
    pub color_difference: Option<f64>,
    /// Boxes of what was found in the image and left out, as it does not stand on the table: x0, y0 inclusive; x1, y1
    /// exclusive. It does not count as missed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out_px: Vec<[u32; 4]>,
    /// Use of the depth image; absent without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth: Option<DepthAccount>,
    /// Pixels with objects in the image and none in the scene, those of what was not recognized included.
    pub missed: Regions,
    /// Pixels with objects in the scene and none in the image.
    pub invented: Regions,
    /// Reconstruction methods in a fixed order, without unused ones.
    pub methods: Vec<MethodShare>,
    pub appearance: Appearance,
}

/// Pixels with objects in only one of the two images.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Regions {
    /// Share of all object pixels of that image, 0..1.
    #[schemars(with = "Fraction")]
    pub share: f64,
    /// The largest connected regions.
    pub largest: Vec<Region>,
}

/// A connected region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Region {
    /// The object with most of its pixels; the table for what was not recognized.
    #[schemars(with = "String")]
    pub body: InstanceId,
    /// x0, y0 inclusive; x1, y1 exclusive.
    #[schemars(inner(range(min = 0, max = 65_535)))]
    pub bbox_px: [u32; 4],
    /// Share of all pixels of the image, 0..1.
    #[schemars(with = "Fraction")]
    pub image_share: f64,
}

/// Number of objects of one reconstruction method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MethodShare {
    pub method: ReconstructionMethod,
    #[schemars(range(min = 0, max = 10_000))]
    pub objects: usize,
    /// Share of all objects, 0..1.
    #[schemars(with = "Fraction")]
    pub share: f64,
}

/// Image similarity by a feature extractor. Scores of different extractors are not comparable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Appearance {
    /// Name of the feature extractor's adapter.
    pub extractor: String,
    /// Version of the extractor, with the digest of its weights if it has any.
    pub model: String,
    /// Dot product of the two images' feature vectors, -1..1.
    #[schemars(range(min = -1.001, max = 1.001))]
    pub similarity: f64,
}

/// One colliding pair.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Collision {
    pub a: String,
    pub b: String,
    #[schemars(range(min = 0.0))]
    pub depth_m: f64,
}

/// Abilities of the robot of the request in the scene, measured in simulation.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct RobotFinding {
    /// As the request names it.
    pub name: String,
    /// Number of objects that are for grippers.
    #[schemars(range(min = 0, max = 10_000))]
    pub objects: usize,
    /// Number of objects that it can pick up where they are: a stable grasp is free of table and neighbors on its way
    /// to the object and up with it, and the arm makes both motions from some place of its base.
    #[schemars(range(min = 0, max = 10_000))]
    pub pickable: usize,
    /// Number of tasks that were proposed, each with objects that it can pick up.
    #[schemars(range(min = 0, max = 3))]
    pub tasks_proposed: usize,
    /// Number of proposed tasks that it executed successfully.
    #[schemars(range(min = 0, max = 3))]
    pub tasks_done: usize,
    /// The proposed tasks, in the order of their proposal.
    #[schemars(length(max = 3))]
    pub tasks: Vec<TaskTried>,
}

/// A proposed task, and what became of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "TriedTask")]
pub struct TaskTried {
    /// In words.
    pub instruction: String,
    /// `done`, the code of its failure (`no_path`), or the code of its refusal.
    #[schemars(regex(pattern = "^[a-z_]+$"))]
    pub outcome: String,
}
