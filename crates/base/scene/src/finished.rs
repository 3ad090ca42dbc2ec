//! The finished scene, from which every format is written.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::clutter::ClutterFinding;
use super::{Instance, Light, SceneRequest, Support, Table};
use crate::edit::EditAccount;
use crate::request::MAX_SEED;
use crate::support_tree::{InvalidSupport, SupportTree, Supporter};
use crate::text_account::TextAccount;
use crate::validation::{Violation, Violations, validated};
use geometry::Camera;
use geometry::json_numbers::Fraction;

/// Content of `scene.json`. Meshes and hulls are kept separately (`export::Assets`). A deserialized value is valid:
/// names are unique, sizes are positive, and the supports form a tree rooted at the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Self")]
pub struct Scene {
    /// `tabletopgen-scene/1`.
    #[schemars(extend("const" = Self::FORMAT))]
    pub format: String,
    /// Digest of request, seed, resolved settings and version.
    #[schemars(length(min = 1))]
    pub id: String,
    #[schemars(range(min = 0, max = MAX_SEED))]
    pub seed: u64,
    pub request: SceneRequest,
    pub frame: Frame,
    /// Camera of the reference image.
    pub camera: Camera,
    pub table: Table,
    /// The table is not among them.
    pub instances: Vec<Instance>,
    pub metrics: Metrics,
    /// Parts of the text that were understood and parts that were not; absent for scenes of images.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub text: Option<TextAccount>,
    /// The light, where an edit changed it; without one, that of the usual studio.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub light: Option<Light>,
    /// Result of the edit; absent for a scene that was made from a text or an image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edit: Option<EditAccount>,
    /// Measurements of clutter; absent where no objects were dropped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clutter: Option<ClutterFinding>,
}

validated!(Scene);

/// The paper's four physical metrics (Sec. Experiments), as fractions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(description = "Measurements of a finished scene, as shares.")]
pub struct Metrics {
    /// Colliding pairs over all pairs, the table included, on the visual meshes.
    #[schemars(with = "Fraction")]
    pub col_o: f64,
    /// 1 if any pair collides, else 0 (a rate over many scenes).
    #[schemars(with = "Fraction")]
    pub col_s: f64,
    /// Share of objects whose center of mass projects into their support region.
    #[schemars(with = "Fraction")]
    pub ss: f64,
    /// Share of objects that stay within 3 cm and 30 degrees over 5 s, from the poses of the stage `place`.
    #[schemars(with = "Fraction")]
    pub dss_aligned: f64,
    /// As `dss_aligned`, from the poses of the bundle.
    #[schemars(with = "Fraction")]
    pub dss_shipped: f64,
}

/// Coordinate conventions of the files of a bundle.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Frame {
    #[schemars(extend("const" = "+z"))]
    pub up: String,
    #[schemars(extend("const" = "right"))]
    pub handedness: String,
    pub origin: String,
    pub units: String,
}

impl Frame {
    /// Right-handed, z up, meters, origin at the center of the table top.
    pub fn world() -> Self {
        Self {
            up: "+z".into(),
            handedness: "right".into(),
            origin: "center of the table top's bounding box, z = 0 at the surface".into(),
            units: "meters, kilograms, seconds, radians".into(),
        }
    }
}

impl Scene {
    pub const FORMAT: &str = "tabletopgen-scene/1";

    /// Every violation of the guarantees.
    fn violations(&self) -> Vec<Violation> {
        let mut violations = Violations::default();
        violations.require(self.format == Self::FORMAT, "/format", format!("must be {}", Self::FORMAT));
        violations.require_size(self.table.size_m, "/table/size_m");
        for (index, instance) in self.instances.iter().enumerate() {
            let name = &instance.name;
            let unique = name.as_str() != self.table.name
                && !self.instances[..index].iter().any(|other| &other.name == name);
            let pointer = format!("/instances/{index}/name");
            violations.require(unique, pointer, format!("the name {name} is not unique"));
            violations.require_size(instance.size_m, format!("/instances/{index}/size_m"));
        }
        if let Err(error @ (InvalidSupport::UnknownParent(index) | InvalidSupport::Cycle(index))) =
            self.support_tree()
        {
            violations.require(false, format!("/instances/{index}/support/parent"), error.to_string());
        }
        violations.into_vec()
    }

    /// The supports of the instances.
    ///
    /// # Errors
    ///
    /// [`InvalidSupport`] for an unknown supporter or a cycle, which a deserialized value cannot have.
    pub fn support_tree(&self) -> Result<SupportTree, InvalidSupport> {
        let position = |name: &str| self.instances.iter().position(|other| other.name.as_str() == name);
        let supporter = |instance: &Instance| {
            let Support { parent, relation } = &instance.support;
            // An unknown name becomes an index that is out of range.
            let index = || position(parent).unwrap_or(self.instances.len());
            Supporter { parent: (*parent != self.table.name).then(index), relation: *relation }
        };
        SupportTree::new(self.instances.iter().map(supporter).collect())
    }
}
