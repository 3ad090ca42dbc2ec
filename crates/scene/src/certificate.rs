//! The certificate: what was measured about a scene, against which thresholds, and the verdict.

use serde::{Deserialize, Serialize};

use super::appraisal::Appraisal;
use super::{InstanceId, ReconstructionMethod};
use geometry::decompose::HullFit;
use geometry::repair::Repair;

/// Everything `certify` measured. Rates are fractions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    pub verdict: Verdict,
    /// Why in one sentence, for a pass as for a quarantine.
    pub summary: String,
    /// One per failed check; empty for a pass.
    pub reasons: Vec<Reason>,
    pub metrics: Metrics,
    /// Pairs of bodies that were looked at, the table included.
    pub pairs: usize,
    pub fidelity: Fidelity,
    pub thresholds: Thresholds,
    /// In the order of the scene.
    pub objects: Vec<ObjectCertificate>,
    /// Mesh and hulls of every body, the table first.
    pub bodies: Vec<BodyHealth>,
    /// Standard error of the scene's scale, as a share of it: how far boxes and sizes contradict each other; `None`
    /// where the scale was given, or was set by one object or the table.
    pub scale_error: Option<f64>,
    /// Pairs that collide, with their depth.
    pub collisions: Vec<Collision>,
    pub resolve: ResolveFinding,
    /// What a model thinks of the scene, where one was asked; the verdict does not depend on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub appraisal: Option<Appraisal>,
    pub made_with: MadeWith,
}

/// A failed check.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reason {
    pub code: ReasonCode,
    /// Names of the bodies it is about; empty where it is about the whole scene.
    pub bodies: Vec<String>,
    /// What was found, for people.
    pub sentence: String,
}

/// Which check failed; programs may rely on the words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReasonCode {
    /// Two visual meshes interpenetrate.
    Collision,
    /// The center of mass does not lie above what carries the object.
    NotSupported,
    /// Moves or turns too far under gravity.
    NotAtRest,
    /// Reaches over the table's edge.
    OverTheEdge,
    /// The visual mesh encloses no volume, as an edge has a face on one side only.
    OpenMesh,
    /// A part of the visual mesh lies outside all hulls.
    MissingCollider,
    /// A hull sticks out of the visual mesh.
    ProtrudingCollider,
    /// Hulls fill a cavity or a handle that the visual mesh has open.
    ClosedOpening,
    /// Heavier or lighter for its volume than any solid: the unit may not be the kilogram.
    ImplausibleDensity,
    /// Friction that no pair of surfaces shows.
    ImplausibleFriction,
    /// Does not look like the reference picture.
    UnlikePicture,
}

/// May the scene be used?
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    Pass,
    Quarantine,
}

/// The paper's four physical metrics (Sec. Experiments), as fractions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// Colliding pairs over all pairs, the table included, on the visual meshes.
    pub col_o: f64,
    /// Whether any pair collides (0 or 1 for one scene).
    pub col_s: f64,
    /// Objects whose center of mass projects into their support region.
    pub ss: f64,
    /// Objects that stay within 3 cm and 30 degrees over 5 s, from the poses `place` gave.
    pub dss_aligned: f64,
    /// The same from the poses of the bundle.
    pub dss_shipped: f64,
}

/// The numbers the verdict compares with.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Thresholds {
    pub penetration_m: f64,
    /// A collision is also what is deeper than this share of the local wall.
    pub wall_share: f64,
    pub contact_gap_m: f64,
    pub support_dilation_m: f64,
    pub dss_displacement_m: f64,
    pub dss_rotation_rad: f64,
    pub dss_duration_s: f64,
    /// How far an object may reach over the table's outline.
    pub outline_m: f64,
    /// Least mean silhouette IoU with the reference picture.
    pub silhouette_iou: f64,
    #[serde(flatten)]
    pub health: HealthThresholds,
}

/// What a body must be like to be believed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HealthThresholds {
    pub hull_excess_m: f64,
    pub uncovered_m: f64,
    /// Of a body's longest side, where that is more.
    pub uncovered_share: f64,
    /// Least share of a mesh's openings that no hull fills.
    pub open_share: f64,
    /// Of the longest side, least and most.
    pub longest_side_m: [f64; 2],
    /// Mass over the volume the mesh encloses, least and most.
    pub density_kg_m3: [f64; 2],
    /// Largest static friction coefficient; the dynamic one may not exceed the static one.
    pub friction: f64,
}

impl HealthThresholds {
    /// How far a corner of a body's mesh may lie outside all hulls, meters.
    pub fn most_uncovered_m(&self, size_m: [f64; 3]) -> f64 {
        self.uncovered_m.max(self.uncovered_share * size_m.into_iter().fold(0.0, f64::max))
    }
}

/// Per-object findings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectCertificate {
    pub name: InstanceId,
    /// Signed distance of the projected center of mass inside its support region, meters (where positive, at
    /// least this: the search ends with the first contacts that carry); `None` where it touches nothing.
    pub support_margin_m: Option<f64>,
    pub moved: Displacements,
    /// How far the hulls' farthest corner lies inside the table's outline, meters; negative outside.
    pub outline_margin_m: f64,
    pub inside_outline: bool,
    /// Intersection over union of its pixels in the reference picture and in the finished scene seen from
    /// the same camera, 0..1.
    pub silhouette_iou: f64,
    /// Mean CIELAB distance (CIE 1976) where both show it, the difference of their light included; `None` where no
    /// pixel does.
    pub color_difference: Option<f64>,
    /// How its mesh was made.
    pub method: ReconstructionMethod,
    pub rotation: RotationFinding,
}

/// How far an object was moved, and how far it would move.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Displacements {
    /// From the pose `place` gave to the one given to gravity, by dropping and pushing apart.
    pub by_resolve: Displacement,
    /// From there to the rest pose, which is shipped.
    pub by_settling: Displacement,
    /// From the pose `place` gave to the shipped one.
    pub from_aligned: Displacement,
    /// In the time of the check under gravity, from the shipped pose (DSS as shipped).
    pub after_shipping: Displacement,
    /// The same from the pose `place` gave (DSS as aligned).
    pub after_aligning: Displacement,
}

/// Between two poses of one body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Displacement {
    /// Of the origin, world, meters.
    pub distance_m: f64,
    pub angle_rad: f64,
}

/// Mesh and hulls of one body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyHealth {
    pub name: String,
    /// Every edge of the visual mesh has a face on either side.
    pub watertight: bool,
    pub triangles: usize,
    /// Extents of the mesh's axis-aligned box, object frame.
    pub size_m: [f64; 3],
    /// Enclosed by the mesh, cavities subtracted; where closed parts overlap, the overlap counts twice.
    pub volume_m3: f64,
    pub mass_kg: f64,
    pub density_kg_m3: f64,
    pub hulls: usize,
    /// Most corners of a hull.
    pub hull_corners: usize,
    /// Sum over the hulls; overlaps count twice.
    pub hull_volume_m3: f64,
    /// Largest distance by which a hull sticks out of the visual mesh, meters.
    pub hull_excess_m: f64,
    /// Largest distance of a corner of the mesh outside all hulls, meters; a lower bound, measured to the planes
    /// of the nearest hull's faces.
    pub uncovered_m: f64,
    /// How well the hulls stand for the mesh they were made of, which is the repaired one.
    pub hull_fit: HullFit,
    /// What was done to the mesh before hulls were made of it; the visual mesh stays as it came.
    pub repair: Repair,
}

/// What `resolve` did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResolveFinding {
    /// Rounds it took.
    pub rounds: usize,
    /// What was done, one sentence each.
    pub log: Vec<String>,
    /// What was conceded, as the request allows, where there was no room; empty where there was.
    pub gave_way: Vec<GaveWay>,
}

/// An object for which there was no room as it was wanted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GaveWay {
    pub name: String,
    #[serde(flatten)]
    pub how: Concession,
}

/// What was done with it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "outcome", rename_all = "snake_case")]
pub enum Concession {
    /// Made smaller: the factor on the size it was to have.
    Shrunk { scale: f64 },
    /// Moved to free space on the table from what was to carry it.
    Moved { from: String },
}

/// What answered and with which settings; with the request of `scene.json` this decides every byte.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MadeWith {
    /// Version of the program.
    pub version: String,
    pub adapters: Vec<AdapterUsed>,
    /// The resolved settings of all stages, by section.
    pub settings: serde_json::Value,
}

/// Which adapter answered a port.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AdapterUsed {
    pub port: String,
    pub name: String,
    pub model: String,
}

/// The yaw that `rotate` found, and how sure it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RotationFinding {
    /// About world +z.
    pub yaw_rad: f64,
    /// The yaw that is canonical for the symmetry: another pose of the same look, within half a period of 0.
    pub representative_yaw_rad: f64,
    /// Of shape and look: 1 = none, n = every 360/n degrees, 0 = any angle.
    pub symmetry_order: u32,
    /// Of the shape alone.
    pub shape_symmetry_order: u32,
    /// Where the axis of the shape's symmetry meets the object's xy plane.
    pub symmetry_axis_m: [f64; 2],
    /// 0..1: how well the outlines agree, and how much worse the best other yaw is.
    pub confidence: f64,
    /// (yaw in radians, loss) of the refined candidates, best first; colors may choose another than the first.
    pub candidates: Vec<(f64, f64)>,
}

/// How much the finished scene looks like the reference picture, seen from the same camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fidelity {
    /// Mean of the objects' silhouette IoUs, 0..1.
    pub silhouette_iou: f64,
    /// Mean CIELAB distance (CIE 1976) over the pixels where both show the same object, the difference of their light
    /// included; `None` where no pixel does.
    pub color_difference: Option<f64>,
    /// What shows objects in the picture and none in the scene.
    pub missed: Regions,
    /// What shows objects in the scene and none in the picture.
    pub invented: Regions,
    /// How the objects' meshes were made; methods in a fixed order, only those that made some.
    pub methods: Vec<MethodShare>,
    pub appearance: Appearance,
}

/// Pixels that show objects in one picture only.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Regions {
    /// Of all pixels that show objects in that picture, 0..1.
    pub share: f64,
    /// The largest ones that hang together.
    pub largest: Vec<Region>,
}

/// Pixels that hang together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// The object that most of them show.
    pub body: InstanceId,
    /// x0, y0 inclusive; x1, y1 exclusive.
    pub bbox_px: [u32; 4],
    /// Of all pixels of the picture, 0..1.
    pub picture_share: f64,
}

/// How many objects were made one way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MethodShare {
    pub method: ReconstructionMethod,
    pub objects: usize,
    /// Of all objects, 0..1.
    pub share: f64,
}

/// How alike two pictures look to a feature extractor; the scores of different ones are not comparable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Appearance {
    /// Name of the adapter that gave the features.
    pub extractor: String,
    /// Its version, with the digest of its weights where it has some.
    pub model: String,
    /// Dot product of the two pictures' feature vectors, -1..1.
    pub similarity: f64,
}

/// One colliding pair.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Collision {
    pub a: String,
    pub b: String,
    pub depth_m: f64,
}
