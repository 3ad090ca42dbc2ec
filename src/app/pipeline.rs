//! The pipeline as the worker takes it, and the check of a request's own settings.

use std::sync::Arc;

use futures::FutureExt;

use super::features::Features;
use super::remote::Remote;
use super::{App, network};
use crate::config::{Config, ConfigErrors, Resolved};
use crate::pipeline;
use crate::pipeline::Settings;
use crate::pipeline::error::StageError;
use crate::pipeline::resources::StageResources;
use crate::problem::FieldError;
use crate::worker::{BuildScene, JobContext};
use embedded::single_view_reconstruction::{ReadingNetwork, SingleViewSettings};
use embedded::{EmbeddedSettings, analyst};
use gpu::Compute;
use ports::Ports;
use remote::settings::AnalystProvider;
use scene::SceneRequest;
use scene::request::RequestOptions;
use scene::text_account::TextAccount;

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
    let models = Models {
        features: Features::load(resolved)?,
        network: network::load(resolved)?,
        remote: Remote::load(resolved)?,
        compute: Arc::new(Compute::new(&resolved.config.compute)),
    };
    let resolved = Arc::new(resolved.clone());
    // Adapters hold tables and catalogs; jobs without settings of their own share them.
    let shared = assembled(&resolved, &models);
    Ok(Arc::new(move |context: JobContext| {
        let (resolved, models, shared) = (resolved.clone(), models.clone(), shared.clone());
        async move {
            let JobContext { request, checkpoints, .. } = context;
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

impl App {
    /// Violations of a request of which only the configuration knows: settings in `options.set`, and unknown robots.
    pub fn violations(&self, request: &SceneRequest) -> Vec<FieldError> {
        let mut errors: Vec<FieldError> = unknown_robot(&request.options).into_iter().collect();
        if !request.options.set.is_empty() {
            let wrong =
                self.resolved.with(&request.options.set).err().map_or_else(Vec::new, |errors| errors.0);
            let place = |key: &str| format!("/options/set/{}", key.replace('~', "~0").replace('/', "~1"));
            errors.extend(wrong.into_iter().map(|error| FieldError::new(place(&error.key), error.detail)));
        }
        errors
    }

    /// The account of a request's text by the embedded parser, without making a scene; `None` for an image, and where a
    /// remote model reads texts.
    ///
    /// # Errors
    ///
    /// That of the field `/text`.
    pub fn account(&self, request: &SceneRequest) -> Result<Option<TextAccount>, FieldError> {
        let analysts = &self.config().providers.analyst;
        let is_embedded = analysts.iter().all(|provider| *provider == AnalystProvider::Embedded);
        let Some(text) = request.input.text().filter(|_| is_embedded) else { return Ok(None) };
        let described = analyst::describe(text, request.seed, &request.options, &self.config().analyst);
        let account = described.map(|description| Some(description.account()));
        account.map_err(|error| FieldError::new("/text", error.to_string()))
    }
}

fn unknown_robot(options: &RequestOptions) -> Option<FieldError> {
    let name = options.robot.as_deref()?;
    let known: Vec<&str> = robot::model::library::names().collect();
    let detail = || format!("must be one of {}, not {name:?}", known.join(", "));
    (!known.contains(&name)).then(|| FieldError::new("/options/robot", detail()))
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
        photograph: SingleViewSettings { sizes: config.photograph, naming: config.category_fit },
        descriptor: config.descriptor,
        render: config.render,
        decompose: config.decompose,
        settle: config.settle,
        resolve: config.resolve,
        certify: config.certify,
    }
}
