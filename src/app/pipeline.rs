//! The pipeline as the worker takes it: which adapter answers which port, and the settings of its stages.

use std::sync::Arc;

use futures::FutureExt;

use super::features::Features;
use super::network;
use super::remote::Remote;
use crate::config::{Config, ConfigErrors, Resolved};
use crate::pipeline;
use crate::pipeline::Settings;
use crate::pipeline::error::StageError;
use crate::pipeline::resources::StageResources;
use crate::worker::{BuildScene, JobContext};
use embedded::EmbeddedSettings;
use embedded::single_view_reconstruction::{ReadingNetwork, SingleViewSettings};
use gpu::Compute;
use ports::Ports;
use scene::SceneRequest;

/// Models made when the program started: networks read from files of weights, and remote models.
#[derive(Clone)]
struct Models {
    features: Features,
    network: Arc<ReadingNetwork>,
    remote: Remote,
    compute: Arc<Compute>,
}

/// Builds scenes with the configured adapters, each with the settings its request asks for. Weights and keys are read
/// here, so that those that will not do are found before any work.
pub fn build_pipeline(resolved: &Resolved) -> Result<BuildScene, ConfigErrors> {
    build_pipeline_with(resolved, &Remote::load(resolved)?)
}

/// The same with remote models that others use, too.
pub fn build_pipeline_with(resolved: &Resolved, remote: &Remote) -> Result<BuildScene, ConfigErrors> {
    let models = Models {
        features: Features::load(resolved)?,
        network: network::load(resolved)?,
        remote: remote.clone(),
        compute: Arc::new(Compute::new(&resolved.config.compute)),
    };
    let resolved = Arc::new(resolved.clone());
    // Adapters hold tables and catalogs; jobs without settings of their own share them.
    let shared = assembled(&resolved, &models);
    Ok(Arc::new(move |context: JobContext| {
        let (resolved, models, shared) = (resolved.clone(), models.clone(), shared.clone());
        async move {
            let JobContext { request, checkpoints } = context;
            let (ports, settings) = match request.options.set.is_empty() {
                true => shared,
                false => own(&resolved, &models, &request)?,
            };
            let services = StageResources::new(ports, models.compute.clone());
            pipeline::build_scene(request, checkpoints, services, settings).await
        }
        .boxed()
    }))
}

/// The settings of one request; it was checked when it came, but the server may have been configured
/// anew since.
fn own(
    resolved: &Resolved,
    models: &Models,
    request: &SceneRequest,
) -> Result<(Ports, Arc<Settings>), StageError> {
    Ok(assembled(&with_own(resolved, request)?, models))
}

/// The settings of the stages for one request.
pub(super) fn own_settings(resolved: &Resolved, request: &SceneRequest) -> Result<Settings, StageError> {
    Ok(stages(&with_own(resolved, request)?.config))
}

fn with_own(resolved: &Resolved, request: &SceneRequest) -> Result<Resolved, StageError> {
    // Laying the layers again takes longer than a copy.
    if request.options.set.is_empty() {
        return Ok(resolved.clone());
    }
    resolved.with(&request.options.set).map_err(|errors| {
        StageError::permanent(
            "settings_invalid",
            format!("the request's own settings do not fit this server any more: {errors}"),
        )
    })
}

fn assembled(resolved: &Resolved, models: &Models) -> (Ports, Arc<Settings>) {
    let ports = embedded::ports(&adapters(&resolved.config), models.network.clone());
    (models.remote.answer(models.features.answer(ports)), Arc::new(stages(&resolved.config)))
}

/// Settings of the stages in the configuration.
pub fn stages(config: &Config) -> Settings {
    let config = config.clone();
    Settings {
        render: config.render,
        canonicalize: config.canonicalize,
        decompose: config.decompose,
        dro: config.dro,
        tsa: config.tsa,
        settle: config.settle,
        resolve: config.resolve,
        no_room: config.no_room,
        certify: config.certify,
        fidelity: config.fidelity,
        health: config.health,
        appraise: config.appraise,
        preview: config.preview,
        export: config.export,
        grasps: config.grasps,
        execution: config.execution,
    }
}

/// Settings of the embedded adapters in the configuration.
pub fn adapters(config: &Config) -> EmbeddedSettings {
    let config = config.clone();
    EmbeddedSettings {
        analyst: config.analyst,
        layout: config.layout,
        image_generator: config.image_generator,
        mesh_generator: config.mesh_generator,
        photograph: SingleViewSettings { sizes: config.photograph, naming: config.category_fit },
        descriptor: config.descriptor,
        render: config.render,
        decompose: config.decompose,
        settle: config.settle,
        resolve: config.resolve,
        certify: config.certify,
    }
}
