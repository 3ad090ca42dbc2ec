//! The product on one screen: a request walks through twelve stages and becomes a certified bundle.
//!
//! Each line of [`rotate_all`] and then of [`build_scene`] is a stage, each stage one file below. A stage is a
//! plain function of the struct it receives; [`checkpoint`] finds its result again or computes and commits it.

pub mod checkpoint;
pub mod error;
pub mod carry;
pub mod services;
pub mod ledger;
pub mod reference;
pub mod recognize;
pub mod segment;
pub mod complete;
pub mod reconstruct;
pub mod canonicalize;
pub mod decompose;
pub mod rotate;
pub mod place;
pub mod resolve;
pub mod preview;
pub mod certify;
pub mod bundle;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use checkpoint::{Checkpoints, StageContext};
use error::{StageError, StageErrorClass};
use export::ExportSettings;
use geometry::decompose::DecomposeSettings;
use physics::{CertifySettings, ResolveSettings, SettleSettings};
use ports::Ports;
use pose_estimation::canonicalize::CanonicalizeSettings;
use pose_estimation::dro::DroSettings;
use pose_estimation::tsa::TsaSettings;
use render::RenderSettings;
use scene::{Recognition, SceneRequest};
use services::Services;
use store::artifacts::BuiltRows;

/// What a stage function gets besides its inputs.
pub type Context = StageContext<Services>;

/// The stages in the order a scene travels.
pub const STAGES: [&str; 12] = [
    "reference",
    "recognize",
    "segment",
    "complete",
    "reconstruct",
    "canonicalize",
    "decompose",
    "rotate",
    "place",
    "resolve",
    "certify",
    "bundle",
];

/// Of these, the ones that run at the same time.
pub const SIDE_BY_SIDE: [&str; 2] = ["decompose", "rotate"];

/// Settings of the stages themselves; the ports carry their own.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Settings {
    pub render: RenderSettings,
    pub canonicalize: CanonicalizeSettings,
    pub decompose: DecomposeSettings,
    pub dro: DroSettings,
    pub tsa: TsaSettings,
    pub settle: SettleSettings,
    pub resolve: ResolveSettings,
    pub no_room: resolve::NoRoomSettings,
    pub certify: CertifySettings,
    pub fidelity: certify::FidelitySettings,
    pub health: certify::HealthSettings,
    pub appraise: certify::AppraiseSettings,
    pub preview: preview::PreviewSettings,
    pub export: ExportSettings,
}

/// Two results, or the failure of one; an interruption tells less than any other failure.
fn both<A, B>(results: (Result<A, StageError>, Result<B, StageError>)) -> Result<(A, B), StageError> {
    match results {
        (Ok(a), Ok(b)) => Ok((a, b)),
        (Err(error), Ok(_)) | (Ok(_), Err(error)) => Err(error),
        (Err(a), Err(b)) => Err(if a.class == StageErrorClass::Interrupted { b } else { a }),
    }
}

/// What the stages before `place` leave. `place` can be run on it with other yaws, as the benchmark does.
pub struct Rotated {
    request: Arc<SceneRequest>,
    ports: Ports,
    settings: Arc<Settings>,
    stages: Checkpoints<Services>,
    reference: reference::Output,
    pub recognition: Arc<Recognition>,
    masks: segment::Output,
    raw: Vec<reconstruct::Output>,
    pub canonical: Vec<canonicalize::Output>,
    hulls: Vec<decompose::Output>,
    pub yaws: Vec<rotate::Output>,
}

/// From the request to objects with hulls and yaws: every stage up to `rotate` is found or computed.
pub async fn rotate_all(
    request: SceneRequest,
    checkpoints: Checkpoints,
    ports: Ports,
    settings: Arc<Settings>,
) -> Result<Rotated, StageError> {
    let request = request.shaping();
    let services = Services::new(ports.clone(), checkpoints.device().clone());
    let stages = checkpoints.with_services(Arc::new(services));
    let request = Arc::new(request);

    let inputs = reference::Inputs::new(&request, &ports);
    let reference = stages.run(reference::STAGE, inputs, reference::run).await?;

    let inputs = recognize::Inputs::new(&request, &reference, &ports);
    let recognition = Arc::new(stages.run(recognize::STAGE, inputs, recognize::run).await?);

    let inputs = segment::Inputs::new(&reference, &recognition, &ports);
    let masks = stages.run(segment::STAGE, inputs, segment::run).await?;

    let inputs = complete::inputs(&reference, &recognition, &masks, &ports);
    let completions = stages.run_each(complete::STAGE, inputs, complete::run).await?;

    let inputs = reconstruct::inputs(&request, &reference, &recognition, &completions, &ports);
    let raw = stages.run_each(reconstruct::STAGE, inputs, reconstruct::run).await?;

    let inputs = canonicalize::inputs(&recognition, &completions, &raw, &ports, &settings);
    let canonical = stages
        .run_each_by(canonicalize::STAGE, inputs, canonicalize::Inputs::effort, canonicalize::run)
        .await?;

    // Neither needs the other: side by side, a slow instance of one stage leaves no processor idle.
    let inputs = decompose::inputs(&recognition, &raw, &canonical, &settings)?;
    let hulls = stages.run_each_by(decompose::STAGE, inputs, decompose::Inputs::effort, decompose::run);
    let rotated = async {
        let recognition = match rotate::camera::Inputs::new(&recognition, &masks, &raw, &canonical, &settings)
        {
            Some(inputs) => {
                let refined = stages.run(rotate::camera::STAGE, inputs, rotate::camera::run).await?;
                Arc::new(rotate::camera::seen_by(&recognition, &refined))
            }
            None => recognition.clone(),
        };
        let gpu = rotate::gpu(stages.services(), &settings).await;
        let inputs = rotate::inputs(&reference, &recognition, &masks, &canonical, &settings, gpu);
        let yaws = stages.run_each_by(rotate::STAGE, inputs, rotate::Inputs::effort, rotate::run).await?;
        Ok((recognition, yaws))
    };
    let (hulls, (recognition, yaws)) = both(futures::join!(hulls, rotated))?;

    Ok(Rotated {
        request,
        ports,
        settings,
        stages,
        reference,
        recognition,
        masks,
        raw,
        canonical,
        hulls,
        yaws,
    })
}

impl Rotated {
    /// The metric layout with these yaws, one per object in order.
    pub async fn placed(&self, yaws: &[rotate::Output]) -> Result<place::Output, StageError> {
        let inputs = place::Inputs::new(
            &self.request,
            &self.reference,
            &self.recognition,
            &self.masks,
            &self.raw,
            &self.canonical,
            &self.hulls,
            yaws,
            &self.ports,
            &self.settings,
        )?;
        self.stages.run(place::STAGE, inputs, place::run).await
    }

    /// Runs further stages, the caller's own, with the same store.
    pub fn stages(&self) -> &Checkpoints<Services> {
        &self.stages
    }
}

/// Builds the scene of a request: every stage is found or computed, and the last one leaves a bundle.
pub async fn build_scene(
    request: SceneRequest,
    checkpoints: Checkpoints,
    ports: Ports,
    settings: Arc<Settings>,
) -> Result<BuiltRows, StageError> {
    let request = request.shaping();
    let identity = certify::SceneIdentity::new(&request, &ports, &settings)?;
    let objects = rotate_all(request, checkpoints, ports, settings).await?;
    let (stages, settings) = (&objects.stages, &objects.settings);

    let layout = objects.placed(&objects.yaws).await?;

    let inputs = resolve::Inputs::new(&objects.recognition, &layout, settings);
    let resolved = stages.run(resolve::STAGE, inputs, resolve::run).await?;

    let gpu = stages.services().gpu_name().await;
    let inputs = certify::Inputs::new(
        identity,
        &objects.reference,
        &objects.recognition,
        &objects.masks,
        &objects.raw,
        &objects.canonical,
        &objects.hulls,
        &objects.yaws,
        &layout,
        &resolved,
        &objects.ports,
        settings,
        gpu,
    )?;
    let certified = stages.run(certify::STAGE, inputs, certify::run).await?;

    let bundle = stages.run(bundle::STAGE, bundle::Inputs { certified }, bundle::run).await?;
    Ok(bundle.into_rows())
}
