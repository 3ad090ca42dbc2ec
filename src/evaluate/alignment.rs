//! The pipeline's own stages, from the reference picture to the metric layout, and no further.
//!
//! These are the lines of [`crate::pipeline::build_scene`] up to `place`: what is measured here is what runs there.

use std::sync::Arc;

use crate::pipeline::checkpoint::Checkpoints;
use crate::pipeline::error::StageError;
use crate::pipeline::services::Services;
use crate::pipeline::{
    Settings, canonicalize, complete, decompose, place, recognize, reconstruct, reference, rotate, segment,
};
use crate::provider::Ports;
use crate::scene::{Recognition, SceneRequest};

/// What the stages before `place` leave; `place` can be run on it again, with other yaws.
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

/// Runs the stages up to `rotate`; errors are the stages'.
pub async fn rotate_all(
    request: SceneRequest,
    checkpoints: Checkpoints,
    ports: Ports,
    settings: Arc<Settings>,
) -> Result<Rotated, StageError> {
    let stages = checkpoints.with_services(Arc::new(Services::new(ports.clone())));
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
    let canonical = stages.run_each(canonicalize::STAGE, inputs, canonicalize::run).await?;
    let inputs = decompose::inputs(&recognition, &raw, &canonical, &settings)?;
    let hulls = stages.run_each(decompose::STAGE, inputs, decompose::run).await?;
    let inputs = rotate::inputs(&reference, &recognition, &masks, &canonical, &settings);
    let yaws = stages.run_each(rotate::STAGE, inputs, rotate::run).await?;
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
    /// The layout with these yaws, one per object in order; the stage `place`.
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

    /// Runs further stages, the evaluator's own, with the same store.
    pub fn stages(&self) -> &Checkpoints<Services> {
        &self.stages
    }
}
