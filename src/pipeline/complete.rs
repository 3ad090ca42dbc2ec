//! Stage `complete`, for each instance: a clean image of it, without what hides it.

use std::sync::Arc;

use serde::Serialize;

use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use super::reference::CompletionRef;
use super::{Context, reference, segment};
use geometry::Camera;
use imaging::Mask;
use ports::{Adapter, CompletionRequest, Ports};
use scene::{InstanceId, InstanceMask, Recognition, RecognizedObject};

pub const STAGE: Stage = Stage { name: "complete", version: 2 };

#[derive(Serialize)]
pub struct Inputs {
    image: ArtifactRef,
    known: Option<ArtifactRef>,
    object: RecognizedObject,
    visible: Mask,
    others: Mask,
    camera: Camera,
    alone: Option<CompletionRef>,
    image_generator: Adapter,
}

/// One entry per recognized object, in order.
pub fn inputs(
    reference: &reference::Output,
    recognition: &Recognition,
    masks: &segment::Output,
    ports: &Ports,
) -> Vec<(InstanceId, Inputs)> {
    let of = |((object, mask), others): ((&RecognizedObject, &InstanceMask), Mask)| {
        let drawn = reference.alone.iter().find(|alone| alone.id == object.id);
        let inputs = Inputs {
            image: reference.image.clone(),
            known: reference.known.clone(),
            object: object.clone(),
            visible: mask.visible.clone(),
            others,
            camera: recognition.camera,
            alone: drawn.map(|alone| alone.completion.clone()),
            image_generator: ports.image_generator.adapter(),
        };
        (object.id.clone(), inputs)
    };
    recognition.objects.iter().zip(&masks.masks).zip(masks.others()).map(of).collect()
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<CompletionRef, StageError> {
    let alone = match &inputs.alone {
        Some(stored) => Some(reference::completion(&context, stored).await?),
        None => None,
    };
    let request = CompletionRequest {
        reference: reference::seen(&context, &inputs.image, inputs.known.as_ref(), None).await?,
        object: inputs.object.clone(),
        visible: inputs.visible.clone(),
        others: inputs.others.clone(),
        camera: Some(inputs.camera),
        alone,
    };
    let call = context.call();
    let completion = context.services().ports.image_generator.complete(&call, request).await?;
    let alone = inputs.alone.as_ref().map(|alone| &alone.image);
    reference::put_completion(&context, "completed.png", completion, alone).await
}
