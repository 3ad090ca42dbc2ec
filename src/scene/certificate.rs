//! The certificate: what was measured about a scene, against which thresholds, and the verdict.

use serde::{Deserialize, Serialize};

use super::InstanceId;

/// Everything `certify` measured. Rates are fractions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    pub verdict: Verdict,
    /// One sentence per failed check; empty for a pass.
    pub reasons: Vec<String>,
    pub metrics: Metrics,
    pub fidelity: Fidelity,
    pub thresholds: Thresholds,
    pub objects: Vec<ObjectCertificate>,
    /// Standard error of the scene's scale, as a share of it: how far boxes and sizes contradict each other; `None`
    /// where the scale was given, or was set by one object or the table.
    pub scale_error: Option<f64>,
    /// Pairs that collide, with their depth.
    pub collisions: Vec<Collision>,
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
    pub contact_gap_m: f64,
    pub support_dilation_m: f64,
    pub dss_displacement_m: f64,
    pub dss_rotation_rad: f64,
    pub dss_duration_s: f64,
    /// Least mean silhouette IoU with the reference picture.
    pub silhouette_iou: f64,
}

/// Per-object findings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectCertificate {
    pub name: InstanceId,
    /// Signed distance of the projected center of mass inside its support region, meters (where positive, at
    /// least this: the search ends with the first contacts that carry); `None` where it touches nothing.
    pub support_margin_m: Option<f64>,
    /// Displacement of the origin over the shipped settle.
    pub settle_displacement_m: f64,
    pub settle_rotation_rad: f64,
    /// From the pose `place` gave to the shipped one.
    pub displacement_from_aligned_m: f64,
    pub rotation_from_aligned_rad: f64,
    pub inside_outline: bool,
    pub watertight: bool,
    pub hulls: u32,
    /// Largest distance by which a hull sticks out of the visual mesh, meters.
    pub hull_excess_m: f64,
    /// Intersection over union of its pixels in the reference picture and in the finished scene seen from
    /// the same camera, 0..1.
    pub silhouette_iou: f64,
    pub rotation: RotationFinding,
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
    pub appearance: Appearance,
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
