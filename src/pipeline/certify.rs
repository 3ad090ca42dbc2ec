//! Stage `certify`: the certificate. What was built is measured (collisions, support, stability, containment,
//! likeness to the image), rendered, rated by a model where that is wanted, written in every format and read back.

pub(super) mod plausibility;
mod grasp;
mod clutter;
mod finished_demands;
pub(super) mod upright_frame;
mod measure;
mod vlm_rating;
mod write;
mod sheet;
mod track;
#[cfg(test)]
pub(super) mod tests;

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::checkpoint::{ArtifactRef, Stage};
use super::clutter::Heap;
use super::composition::{BodyParts, Composition};
use super::error::StageError;
use super::preview::PreviewSettings;
use super::resolve::{Loaded, load};
use super::scene_identity::SceneIdentity;
use super::{
    Context, PreparedObjects, Settings, artifact_io, place, reconstruct, rehearse, resolve, segment,
};
use certificate::{Appearance, ResolveFinding, SceneSummary, Verdict};
use export::ExportSettings;
use physics::{CertifySettings, SettleSettings};
use ports::{Adapter, Ports};
use render::RenderSettings;
use scene::{Input, Metrics, Provenance, SceneDescription};
use store::Digest;

pub use plausibility::HealthSettings;
pub(crate) use plausibility::uncovered_m;
pub use vlm_rating::AppraiseSettings;

pub const STAGE: Stage = Stage { name: "certify", version: 27 };

/// Section `[fidelity]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct FidelitySettings {
    /// Least mean silhouette IoU of the finished scene with the image of the request, 0..1; a scene below it is
    /// quarantined. More quarantines more scenes; 0 accepts whatever stands still.
    pub min_silhouette_iou: f64,
    /// Largest share of the image's object pixels that the scene misses, 0..1; less quarantines more scenes.
    pub max_missed_share: f64,
    /// Largest share of the scene's object pixels that the image does not show, 0..1; less quarantines more scenes.
    pub max_invented_share: f64,
}

#[derive(Clone, Serialize)]
pub struct Inputs {
    identity: SceneIdentity,
    composition: Composition,
    /// The demands of the text, where it is known which object is which.
    #[serde(skip_serializing_if = "Option::is_none")]
    stated: Option<Arc<SceneDescription>>,
    certify: CertifySettings,
    settle: SettleSettings,
    fidelity: FidelitySettings,
    health: HealthSettings,
    preview: PreviewSettings,
    render: RenderSettings,
    export: ExportSettings,
    feature_extractor: Adapter,
    /// The parent's bundle, of an edit: what is packed there is copied. The request in the key names it already.
    #[serde(skip)]
    parent_bundle: Option<Digest>,
    /// Absent where the request names no robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    robot: Option<Arc<rehearse::Output>>,
    /// Absent where no model is asked for its opinion.
    #[serde(skip_serializing_if = "Option::is_none")]
    appraise: Option<vlm_rating::RatingRequest>,
    /// Name of the GPU that renders the previews; absent where the CPU does.
    #[serde(skip_serializing_if = "Option::is_none")]
    gpu: Option<String>,
}

/// The certified scene.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    /// Every file of the bundle.
    pub archive: ArtifactRef,
    pub verdict: Verdict,
    pub reasons: Vec<String>,
    pub metrics: Metrics,
    /// Summary of the scene for the API.
    pub summary: serde_json::Value,
}

impl Inputs {
    /// Inputs of the certificate.
    ///
    /// # Errors
    ///
    /// `table_missing`, where no table was reconstructed.
    pub fn new(
        identity: SceneIdentity,
        objects: &PreparedObjects,
        layout: &place::Output,
        resolved: &resolve::Output,
        gpu: Option<String>,
    ) -> Result<Self, StageError> {
        let PreparedObjects { ports, settings, reference, recognition, masks, .. } = objects;
        let PreparedObjects { raw_meshes, canonical_meshes, hulls, yaws, .. } = objects;
        let missing = || StageError::permanent("table_missing", "certifying: there is no table; run again");
        let provenance = |raw: &reconstruct::Output, more: Vec<String>| Provenance {
            mesh_by: raw.made_by.clone(),
            licence: raw.licence.clone(),
            notes: raw.notes.iter().cloned().chain(more).collect(),
        };
        let (table, bodies_on_table) = resolved.bodies.split_first().ok_or_else(missing)?;
        let table_hulls = reconstruct::of_table(recognition, hulls).ok_or_else(missing)?;
        let table_mesh = reconstruct::of_table(recognition, raw_meshes).ok_or_else(missing)?;
        let mut bodies = vec![BodyParts {
            resolved: table.clone(),
            mesh: table.mesh.clone(),
            thumbnail: None,
            hulls: table.hulls.clone(),
            hull_excess_m: table_hulls.max_excess_m,
            hull_fit: table_hulls.fit,
            repair: table_hulls.repair,
            scale: 1.0,
            symmetry_order: 1,
            provenance: provenance(table_mesh, Vec::new()),
            grasp: None,
        }];
        for (index, ((resolved, placed), yaw)) in
            bodies_on_table.iter().zip(&layout.instances).zip(yaws).enumerate()
        {
            let rescaled = (placed.scale != 1.0)
                .then(|| format!("rescaled by {:.2} to the box of the top view", placed.scale));
            let shrunk = (resolved.scale != 1.0)
                .then(|| format!("made smaller, to {:.2} of its size, as there was no room", resolved.scale));
            let scale = placed.scale * resolved.scale;
            bodies.push(BodyParts {
                resolved: resolved.clone(),
                mesh: resolved.mesh.clone(),
                thumbnail: Some(canonical_meshes[index].image.clone()),
                hulls: resolved.hulls.clone(),
                hull_excess_m: scale * hulls[index].max_excess_m,
                hull_fit: hulls[index].fit.scaled(scale),
                repair: hulls[index].repair,
                scale,
                symmetry_order: yaw.symmetry_order,
                provenance: provenance(&raw_meshes[index], rescaled.into_iter().chain(shrunk).collect()),
                grasp: None,
            });
        }
        let composition = Composition {
            image: reference.image.clone(),
            recognition: recognition.clone(),
            masks: masks.masks.clone(),
            unread: masks.unread.clone(),
            bodies,
            supports: resolved.supports.clone(),
            table: layout.table.clone(),
            yaws: yaws.to_vec(),
            methods: raw_meshes.iter().filter_map(|raw| raw.method).collect(),
            top_view: layout.top_view.clone(),
            scale_error: layout.consensus.map(|consensus| consensus.log_alpha_error),
            resolve: ResolveFinding {
                rounds: resolved.rounds,
                log: resolved.log.clone(),
                gave_way: resolved.gave_way.clone(),
            },
            account: objects.account.clone(),
            light: None,
            edit: None,
            clutter: None,
        };
        let stated = reference.stated.clone();
        Ok(Self { stated, ..Self::of(identity, composition, ports, settings, gpu) })
    }

    /// Inputs of the certificate of a scene that has been put together already.
    pub fn of(
        identity: SceneIdentity,
        composition: Composition,
        ports: &Ports,
        settings: &Settings,
        gpu: Option<String>,
    ) -> Self {
        Self {
            identity,
            composition: composition.with_stand_ins(),
            stated: None,
            certify: settings.certify.clone(),
            settle: settings.settle.clone(),
            fidelity: settings.fidelity.clone(),
            health: settings.health.clone(),
            preview: settings.preview.clone(),
            render: settings.render.clone(),
            export: settings.export.clone(),
            feature_extractor: ports.feature_extractor.adapter(),
            parent_bundle: None,
            robot: None,
            appraise: vlm_rating::RatingRequest::new(&settings.appraise, ports.analyst.adapter()),
            gpu,
        }
    }

    /// The scene, as it is certified.
    pub fn composition(&self) -> &Composition {
        &self.composition
    }

    /// Returns the inputs with the abilities of a robot in the scene.
    pub fn with_robot(self, robot: Option<Arc<rehearse::Output>>) -> Self {
        Self { robot, ..self }
    }

    /// Returns the inputs with what was dropped.
    pub fn with_clutter(mut self, heap: Option<Heap>) -> Self {
        self.composition.clutter = heap;
        self
    }

    /// Returns the inputs of an edit whose parent has this bundle.
    pub fn with_parent(self, bundle: Digest) -> Self {
        Self { parent_bundle: Some(bundle), ..self }
    }
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let parts = inputs
        .composition
        .bodies
        .iter()
        .map(|body| load(&context, &body.resolved.name, &body.mesh, &body.hulls));
    let loaded: Vec<Loaded> = futures::future::try_join_all(parts).await?;
    let (inputs, loaded) = context
        .cpu(move || {
            let inputs = finished_demands::evaluated(inputs, &loaded);
            upright_frame::in_upright_frames(inputs, loaded)
        })
        .await??;
    let loaded = Arc::new(loaded);
    let reference = artifact_io::image(&context, &inputs.composition.image).await?;
    let mut drawn = write::StoredImages {
        reference_png: context.get(&inputs.composition.image).await?,
        thumbnails: Vec::new(),
    };
    for body in &inputs.composition.bodies {
        drawn.thumbnails.push(match &body.thumbnail {
            Some(thumbnail) => Some(context.get(thumbnail).await?),
            None => None,
        });
    }

    let (given, geometry, image) = (inputs.clone(), loaded.clone(), reference.clone());
    let cancel = context.cancel().clone();
    // One that was given up since fails: the key says that the previews are the GPU's.
    let gpu = inputs.gpu.as_ref().and_then(|_| context.services().compute.opened());
    let (images, measured) = context
        .cpu(move || {
            rayon::join(
                || write::render(&given, &geometry, &image, &drawn, gpu),
                || measure::measure(&given, &geometry, &cancel),
            )
        })
        .await?;
    let measured = measured?;
    context.put("track.json", "application/json", measured.tracks(&inputs).to_json()?).await?;
    // The next try finds the device given up, and makes a key of the CPU's.
    let images = Arc::new(images.map_err(|error| {
        tracing::warn!(%error, "the GPU failed; this process goes on with the CPU");
        StageError::transient("gpu_failed", format!("previews: {error}; trying again on the CPU"))
    })?);
    let seen = vec![reference.clone(), images.scene_view.clone()];
    let call = context.call();
    let features = context.services().ports.feature_extractor.features(&call, seen).await?;
    let similarity = match features.as_slice() {
        [a, b] => a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum(),
        _ => 0.0,
    };
    let Adapter { name: extractor, model, .. } = inputs.feature_extractor.clone();
    let appearance = Appearance { extractor, model, similarity };
    let appraisal = match &inputs.appraise {
        Some(asked) => {
            let (image, scene) = (reference.clone(), images.scene_view.clone());
            Some(vlm_rating::appraise(&context, asked, &inputs, &loaded, image, scene).await?)
        }
        None => None,
    };

    if matches!(inputs.identity.request.input, Input::Image { .. }) {
        let top_view = artifact_io::image(&context, &inputs.composition.top_view).await?;
        let (given, rendered) = (inputs.clone(), images.clone());
        let drawn = move || {
            sheet::drawn(&sheet::Panels {
                image: &reference,
                masks: &segment::drawn_on(&reference, &given.composition.masks),
                top_view: &top_view,
                scene: &rendered.scene_view,
                agreement: &rendered.agreement,
                above: &rendered.top_view,
            })
        };
        let drawn = context.cpu(drawn).await?;
        artifact_io::put_image(&context, "sheet.png", drawn).await?;
    }

    // Without the parent's bundle everything is packed anew.
    let packed_before = match &inputs.parent_bundle {
        Some(bundle) => context.blob(bundle, "the parent's bundle").await.ok(),
        None => None,
    };
    let given = inputs.clone();
    let certified = context
        .cpu(move || {
            let mut certificate =
                measure::certificate(&given, &loaded, &measured, &images.likeness, appearance)?;
            certificate.appraisal = appraisal;
            certificate.clutter = clutter::finding(&given, &loaded, &images.hidden)?;
            certificate.robot = given.robot.as_ref().map(|tried| tried.finding.clone());
            write::files(&given, &loaded, certificate, &images.images, packed_before.as_deref())
        })
        .await??;
    context.put_json("report.json", &certified.certificate).await?;
    let certificate = &certified.certificate;
    let composition = &inputs.composition;
    let summary = SceneSummary {
        bundle_id: &inputs.identity.id,
        objects: composition.recognition.objects.len(),
        categories: composition.recognition.objects.iter().map(|object| object.category.as_str()).collect(),
        table: &composition.recognition.table.label,
        verdict_text: &certificate.summary,
        text: composition.account.as_ref(),
        edit: composition.edit.as_ref(),
        fidelity: &certificate.fidelity,
        resolve: &composition.resolve.log,
        gave_way: &composition.resolve.gave_way,
        robot: certificate.robot.as_ref(),
    };
    Ok(Output {
        archive: context.put("scene.zip", "application/zip", certified.archive).await?,
        verdict: certificate.verdict,
        reasons: certificate.reasons.iter().map(|reason| reason.sentence.clone()).collect(),
        metrics: certificate.metrics,
        summary: json!(summary),
    })
}
