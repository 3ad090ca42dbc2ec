//! Facts about a scene: the values that filters, splits, statistics and licenses are computed from.

use std::collections::BTreeMap;

use serde::Deserialize;

use certificate::Verdict;
use scene::{Input, Scene, SupportRelation};

use crate::bundle::{Bundle, sha256};
use crate::coverage::covered_share;
use crate::error::DatasetError;

/// Facts of one scene. A few kilobytes.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFacts {
    pub id: String,
    /// SHA-256 of the bundle's `manifest.json`.
    pub manifest_sha256: String,
    /// Id of the scene that was edited.
    pub parent: Option<String>,
    /// SHA-256 of the normalized text that describes the scene.
    pub text_sha256: Option<String>,
    /// SHA-256 of the image that the scene was made from.
    pub image_sha256: Option<String>,
    /// SHA-256 of the objects' meshes, sorted, without repetition. The table is not among them.
    pub mesh_sha256: Vec<String>,
    pub verdict: Verdict,
    /// Codes of the failed checks, sorted, without repetition.
    pub reason_codes: Vec<String>,
    /// `rectangular`, `round`, ...
    pub table_shape: String,
    pub table_area_m2: f64,
    pub table_model: String,
    pub table_licence: String,
    /// Share of the table top that objects cover, seen from above.
    pub covered_share: f64,
    pub objects: Vec<ObjectFacts>,
}

/// Facts of one object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectFacts {
    pub category: String,
    pub stand_in: bool,
    /// Largest of the three extents.
    pub largest_extent_m: f64,
    pub mass_kg: f64,
    /// 1 on the table, 2 on or in an object on the table, and so on.
    pub support_depth: usize,
    pub support_relation: SupportRelation,
    pub licence: String,
    /// Adapter that made the mesh.
    pub mesh_by: String,
}

impl SceneFacts {
    /// Reads `scene.json` and `report.json` of the bundle.
    ///
    /// # Errors
    ///
    /// [`DatasetError::Bundle`] if one of them is missing, damaged or of an unknown format.
    pub fn read(bundle: &mut Bundle) -> Result<Self, DatasetError> {
        #[derive(Deserialize)]
        struct Report {
            scene: String,
            verdict: Verdict,
            reasons: Vec<Reason>,
        }
        #[derive(Deserialize)]
        struct Reason {
            code: String,
        }
        let refuse = |bundle: &Bundle, reason: String| DatasetError::bundle(bundle.place(), reason);
        let scene: Scene = serde_json::from_slice(&bundle.read("scene.json")?)
            .map_err(|error| refuse(bundle, format!("scene.json: {error}")))?;
        let report: Report = serde_json::from_slice(&bundle.read("report.json")?)
            .map_err(|error| refuse(bundle, format!("report.json: {error}")))?;
        if report.scene != scene.id {
            let reason = format!("report.json is of the scene {}, scene.json of {}", report.scene, scene.id);
            return Err(refuse(bundle, reason));
        }
        if !is_key(&scene.id) {
            let reason = format!(
                "the scene id {:?} is no file name; use letters, digits, - and _, up to 64",
                scene.id
            );
            return Err(refuse(bundle, reason));
        }
        let (parent, image_sha256) = match &scene.request.input {
            Input::Edit { parent, .. } | Input::Variant { parent, .. } => (Some(parent.clone()), None),
            Input::Image { sha256, .. } => (None, Some(sha256.clone())),
            Input::Text { .. } => (None, None),
        };
        let text = scene.request.input.text().map(normalized).filter(|text| !text.is_empty());
        let mut reason_codes: Vec<String> = report.reasons.into_iter().map(|reason| reason.code).collect();
        reason_codes.sort();
        reason_codes.dedup();
        let mut mesh_sha256 = Vec::with_capacity(scene.instances.len());
        for instance in &scene.instances {
            let entry = bundle.entries().get(&instance.mesh);
            let entry = entry.ok_or_else(|| refuse(bundle, format!("it has no {}", instance.mesh)))?;
            mesh_sha256.push(entry.sha256.clone());
        }
        mesh_sha256.sort();
        mesh_sha256.dedup();
        let table_shape = serde_json::to_value(scene.table.shape).ok();
        Ok(Self {
            manifest_sha256: bundle.manifest_sha256(),
            parent,
            text_sha256: text.map(|text| sha256(text.as_bytes())),
            image_sha256,
            mesh_sha256,
            verdict: report.verdict,
            reason_codes,
            table_shape: table_shape.as_ref().and_then(|v| v.as_str()).unwrap_or_default().to_owned(),
            table_area_m2: scene.table.outline_m.area_m2(),
            table_model: scene.table.model.clone(),
            table_licence: bundle.licence().to_owned(),
            covered_share: covered_share(&scene),
            objects: objects(&scene),
            id: scene.id,
        })
    }

    pub fn passed(&self) -> bool {
        self.verdict == Verdict::Pass
    }

    /// Number of objects per category.
    pub fn categories(&self) -> BTreeMap<String, u32> {
        let mut counts = BTreeMap::new();
        for object in &self.objects {
            *counts.entry(object.category.clone()).or_default() += 1;
        }
        counts
    }
}

fn objects(scene: &Scene) -> Vec<ObjectFacts> {
    // A deserialized scene has a valid tree; the chain is bounded all the same.
    let depth = |name: &str| {
        let (mut depth, mut at) = (0, name.to_owned());
        while at != scene.table.name && depth <= scene.instances.len() {
            depth += 1;
            let parent = scene.instances.iter().find(|other| other.name.as_str() == at);
            at = parent.map_or_else(|| scene.table.name.clone(), |other| other.support.parent.clone());
        }
        depth
    };
    let facts = scene.instances.iter().map(|instance| ObjectFacts {
        category: instance.category.clone(),
        stand_in: instance.stand_in.is_some(),
        largest_extent_m: instance.size_m.max_element(),
        mass_kg: instance.mass.mass_kg,
        support_depth: depth(instance.name.as_str()),
        support_relation: instance.support.relation,
        licence: instance.provenance.licence.clone(),
        mesh_by: instance.provenance.mesh_by.clone(),
    });
    facts.collect()
}

/// The words of a text in lower case, without punctuation.
pub fn normalized(text: &str) -> String {
    let lower = text.to_lowercase();
    let words = lower.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join(" ")
}

/// Whether an id can name the files of a scene: WebDataset cuts keys at the first dot.
fn is_key(id: &str) -> bool {
    let is_word = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    (1..=64).contains(&id.len()) && id.chars().all(is_word)
}
