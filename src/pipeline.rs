//! The product on one screen: a request passes through the stages and becomes a certified bundle.
//!
//! [`run_stages`] lists the stages in order, `robot_trial` those of a robot, [`edit`] those of an edit; each stage is
//! one file below. A stage is a plain function of the struct it receives; [`checkpoint`] finds its stored result or
//! computes and commits it.

pub mod checkpoint;
pub mod error;
pub mod artifact_io;
pub mod resources;
pub mod ledger;
pub mod reference;
pub mod recognize;
pub mod segment;
pub mod complete;
pub mod reconstruct;
pub mod canonicalize;
pub mod decompose;
pub mod refine_camera;
pub mod rotate;
pub mod place;
pub mod resolve;
pub mod clutter;
pub mod grasp;
pub mod rehearse;
mod robot_trial;
pub mod preview;
mod scene_identity;
pub mod certify;
pub mod bundle;
pub mod composition;
pub mod task_scene;
pub mod catalog_body;
pub mod edit;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use checkpoint::{Checkpoints, StageContext};
use error::StageError;
use export::ExportSettings;
use geometry::decompose::DecomposeSettings;
use manipulation::execution::ExecutionSettings;
use manipulation::grasp::GraspSettings;
use physics::{CertifySettings, ResolveSettings, SettleSettings};
use ports::Ports;
use pose_estimation::top_view_layout::TopViewSettings;
use pose_estimation::upright::UprightSettings;
use pose_estimation::yaw::YawSettings;
use render::RenderSettings;
use resources::StageResources;
use scene::text_account::TextAccount;
use scene::{Input, Recognition, SceneRequest, SupportTree};
use scene_identity::SceneIdentity;
use store::artifacts::BuiltScene;

/// Resources of a stage function besides its inputs.
pub type Context = StageContext<StageResources>;

/// The stages in the order in which a scene passes through them. `refine_camera` runs only where a model judged the
/// camera, `clutter` only for a request that asks for it, `grasp` and `rehearse` only for one that names a robot.
pub const STAGES: [&str; 16] = [
    "reference",
    "recognize",
    "segment",
    "complete",
    "reconstruct",
    "canonicalize",
    "decompose",
    "refine_camera",
    "rotate",
    "place",
    "resolve",
    "clutter",
    "grasp",
    "rehearse",
    "certify",
    "bundle",
];

/// The stages that run concurrently.
pub const CONCURRENT_STAGES: [&str; 3] = ["decompose", "refine_camera", "rotate"];

/// Settings of the stages themselves; the ports carry their own.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Settings {
    pub render: RenderSettings,
    pub canonicalize: UprightSettings,
    pub decompose: DecomposeSettings,
    pub dro: YawSettings,
    pub tsa: TopViewSettings,
    pub settle: SettleSettings,
    pub resolve: ResolveSettings,
    pub no_room: resolve::NoSpaceSettings,
    pub certify: CertifySettings,
    pub fidelity: certify::FidelitySettings,
    pub health: certify::HealthSettings,
    pub appraise: certify::AppraiseSettings,
    pub preview: preview::PreviewSettings,
    pub export: ExportSettings,
    pub grasps: GraspSettings,
    pub execution: ExecutionSettings,
}

/// Results of the stages before `place`.
pub struct PreparedObjects {
    pub(in crate::pipeline) request: Arc<SceneRequest>,
    pub(in crate::pipeline) ports: Ports,
    pub(in crate::pipeline) settings: Arc<Settings>,
    pub(in crate::pipeline) reference: reference::Output,
    /// Of the text, alone or beside an image.
    pub(in crate::pipeline) account: Option<TextAccount>,
    pub recognition: Arc<Recognition>,
    /// Of the recognized objects.
    pub(in crate::pipeline) supports: SupportTree,
    pub(in crate::pipeline) masks: segment::Output,
    pub(in crate::pipeline) raw_meshes: Vec<reconstruct::Output>,
    pub canonical_meshes: Vec<canonicalize::Output>,
    pub(in crate::pipeline) hulls: Vec<decompose::Output>,
    pub yaws: Vec<rotate::Output>,
    stages: Checkpoints<StageResources>,
}

/// Last stage of [`run_stages`].
#[derive(Clone, Copy, PartialEq)]
enum Until {
    /// Objects prepared without a table, for another scene that takes them.
    ObjectsAlone,
    ObjectsPrepared,
    BundleWritten,
}

/// Result of [`run_stages`] at the end it was given.
enum Reached {
    Objects(Box<PreparedObjects>),
    Bundle(Box<BuiltScene>),
}

/// Builds the scene of a request: every stage is found or computed, and the last one leaves a bundle.
///
/// `app::pipeline::build_pipeline` wraps this function for the worker, which calls it once per job attempt.
///
/// # Errors
///
/// The error of the first stage that fails; the stages before it keep their results.
pub async fn build_scene(
    request: SceneRequest,
    checkpoints: Checkpoints,
    services: StageResources,
    settings: Arc<Settings>,
) -> Result<BuiltScene, StageError> {
    if matches!(request.input, Input::Edit { .. } | Input::Variant { .. }) {
        return edit::edit_scene(request, checkpoints, services, settings).await;
    }
    let stages = checkpoints.for_stages(&STAGES, Arc::new(services));
    match run_stages(request, stages, settings, Until::BundleWritten).await? {
        Reached::Bundle(rows) => Ok(*rows),
        Reached::Objects(_) => unreachable!("the stages ran until the bundle was written"),
    }
}

/// Runs the stages up to `rotate`, for a caller that measures or varies the layout.
///
/// # Errors
///
/// As [`build_scene`].
pub async fn prepare_objects(
    request: SceneRequest,
    checkpoints: Checkpoints,
    services: StageResources,
    settings: Arc<Settings>,
) -> Result<PreparedObjects, StageError> {
    let stages = checkpoints.for_stages(&STAGES, Arc::new(services));
    objects_until(Until::ObjectsPrepared, request, stages, settings).await
}

/// The objects of a request for another scene, without a table, with stages that have been opened already.
async fn prepare_objects_alone(
    request: SceneRequest,
    stages: Checkpoints<StageResources>,
    settings: Arc<Settings>,
) -> Result<PreparedObjects, StageError> {
    objects_until(Until::ObjectsAlone, request, stages, settings).await
}

async fn objects_until(
    until: Until,
    request: SceneRequest,
    stages: Checkpoints<StageResources>,
    settings: Arc<Settings>,
) -> Result<PreparedObjects, StageError> {
    match run_stages(request, stages, settings, until).await? {
        Reached::Objects(objects) => Ok(*objects),
        Reached::Bundle(_) => unreachable!("the stages ran until the objects were prepared"),
    }
}

/// All stages, in order.
async fn run_stages(
    request: SceneRequest,
    stages: Checkpoints<StageResources>,
    settings: Arc<Settings>,
    until: Until,
) -> Result<Reached, StageError> {
    let request = Arc::new(request.without_budget());
    let ports = stages.services().ports.clone();
    let identity = SceneIdentity::new(&request, &ports, &settings)?;

    let alone = until == Until::ObjectsAlone;
    let inputs = reference::Inputs::new(&request, &ports, alone);
    let reference = stages.run(reference::STAGE, inputs, reference::run).await?;

    let inputs = recognize::Inputs::new(&request, &reference, &ports);
    let recognize::Output { recognition, account } =
        stages.run(recognize::STAGE, inputs, recognize::run).await?;
    let recognition = Arc::new(recognition);
    let supports = recognize::support_tree(&recognition)?;

    let inputs = segment::Inputs::new(&reference, &recognition, &ports);
    let masks = stages.run(segment::STAGE, inputs, segment::run).await?;

    let inputs = complete::inputs(&reference, &recognition, &masks, &ports);
    let completions = stages.run_each(complete::STAGE, inputs, complete::run).await?;

    let mut inputs = reconstruct::inputs(&request, &reference, &recognition, &masks, &completions, &ports);
    if alone {
        inputs.truncate(recognition.objects.len());
    }
    let raw_meshes = stages.run_each(reconstruct::STAGE, inputs, reconstruct::run).await?;

    let inputs = canonicalize::inputs(&recognition, &completions, &raw_meshes, &ports, &settings);
    let effort = canonicalize::Inputs::effort;
    let canonical_meshes = stages.run_each_by(canonicalize::STAGE, inputs, effort, canonicalize::run).await?;

    // The hulls and the yaws do not need each other. Run concurrently, a slow instance leaves no core idle.
    let inputs = decompose::inputs(&recognition, &raw_meshes, &canonical_meshes, &settings)?;
    let hulls = stages.run_each_by(decompose::STAGE, inputs, decompose::Inputs::effort, decompose::run);
    let yaws = async {
        let inputs = refine_camera::Inputs::new(
            &recognition,
            &supports,
            &masks,
            &raw_meshes,
            &canonical_meshes,
            &settings,
        );
        let recognition = match inputs {
            Some(inputs) => {
                let refined = stages.run(refine_camera::STAGE, inputs, refine_camera::run).await?;
                Arc::new(refine_camera::with_refined_camera(&recognition, &refined))
            }
            None => recognition.clone(),
        };
        let inputs =
            rotate::inputs(&reference, &recognition, &supports, &masks, &canonical_meshes, &settings);
        let yaws = stages.run_each_by(rotate::STAGE, inputs, rotate::Inputs::effort, rotate::run).await?;
        Ok((recognition, yaws))
    };
    let (hulls, (recognition, yaws)) = StageError::both(futures::join!(hulls, yaws))?;

    let objects = PreparedObjects {
        request,
        ports,
        settings,
        account: account.or_else(|| reference.account.clone()),
        reference,
        recognition,
        supports,
        masks,
        raw_meshes,
        canonical_meshes,
        hulls,
        yaws,
        stages,
    };
    if until != Until::BundleWritten {
        return Ok(Reached::Objects(Box::new(objects)));
    }
    let stages = &objects.stages;

    let layout = objects.place(&objects.yaws).await?;

    let inputs = resolve::Inputs::new(&objects.recognition, &layout, &objects.settings);
    let resolved = stages.run(resolve::STAGE, inputs, resolve::run).await?;
    let (resolved, heap) = clutter::after(&objects, &layout, resolved).await?;

    let gpu = stages.services().gpu_name().await;
    let inputs = certify::Inputs::new(identity, &objects, &layout, &resolved, gpu)?.with_clutter(heap);
    let (request, composition) = (&objects.request, inputs.composition());
    let robot = robot_trial::tried(stages, request, composition, &objects.settings).await?;
    let certified = stages.run(certify::STAGE, inputs.with_robot(robot), certify::run).await?;

    let bundle = stages.run(bundle::STAGE, bundle::Inputs { certified }, bundle::run).await?;
    Ok(Reached::Bundle(Box::new(bundle.into_rows())))
}

impl PreparedObjects {
    /// The stage `place`: the metric layout with these yaws, one per object in order.
    ///
    /// # Errors
    ///
    /// The stage's error.
    pub async fn place(&self, yaws: &[rotate::Output]) -> Result<place::Output, StageError> {
        self.stages.run(place::STAGE, place::Inputs::new(self, yaws)?, place::run).await
    }

    /// Runs further stages of the caller's own with the same store.
    pub fn stages(&self) -> &Checkpoints<StageResources> {
        &self.stages
    }
}
