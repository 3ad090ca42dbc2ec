//! Stage `canonicalize`, for each instance: the mesh upright, facing its front, at its commonsense size, seated on the
//! origin.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use super::reference::CompletionRef;
use super::{Context, Settings, artifact_io, preview, reconstruct, reference};
use geometry::Camera;
use ports::{Adapter, Ports, Upright, UprightQuestion, UprightView};
use pose_estimation::upright::UprightSettings;
use pose_estimation::yaw::YawSettings;
use scene::{InstanceId, Recognition, RecognizedObject};

pub const STAGE: Stage = Stage { name: "canonicalize", version: 6 };

#[derive(Serialize)]
pub struct Inputs {
    raw: ArtifactRef,
    object: RecognizedObject,
    camera: Camera,
    completion: CompletionRef,
    canonicalize: UprightSettings,
    dro: YawSettings,
    analyst: Adapter,
}

/// The mesh in its canonical frame.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    /// Meters; +z up, +y its back, origin at the center of the bottom face of its box.
    pub mesh: ArtifactRef,
    /// The mesh alone, 256 x 256 pixels.
    pub image: ArtifactRef,
    /// `canonical_from_raw`.
    pub rotation_xyzw: DQuat,
    /// Factor that took the raw mesh to meters.
    pub scale: f64,
    pub size_m: DVec3,
    /// 0..1: how clearly this rotation stood out.
    pub confidence: f64,
    /// The model's answer for each set of views of the mesh, where a model was asked. The image may have overruled it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub views: Vec<UprightView>,
}

/// One entry per recognized object, in order.
pub fn inputs(
    recognition: &Recognition,
    completions: &[CompletionRef],
    raw: &[reconstruct::Output],
    ports: &Ports,
    settings: &Settings,
) -> Vec<(InstanceId, Inputs)> {
    recognition
        .objects
        .iter()
        .zip(completions)
        .zip(raw)
        .map(|((object, completion), raw)| {
            let inputs = Inputs {
                raw: raw.mesh.clone(),
                object: object.clone(),
                camera: recognition.camera,
                completion: completion.clone(),
                canonicalize: settings.canonicalize.clone(),
                dro: settings.dro.clone(),
                analyst: ports.analyst.adapter(),
            };
            (object.id.clone(), inputs)
        })
        .collect()
}

impl Inputs {
    /// Grows with the time it takes.
    pub fn effort(&self) -> u64 {
        self.raw.size
    }
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let raw_mesh = artifact_io::mesh(&context, &inputs.raw).await?;
    let question = UprightQuestion {
        raw_mesh: raw_mesh.clone(),
        object: inputs.object.clone(),
        camera: inputs.camera,
        completion: reference::completion(&context, &inputs.completion).await?,
        canonicalize: inputs.canonicalize.clone(),
        dro: inputs.dro.clone(),
    };
    let call = context.call();
    let Upright { pose, views } = context.services().ports.analyst.upright(&call, question).await?;
    let (rotation, scale) = (pose.rotation, pose.scale);
    let (mesh, drawn) = context
        .cpu(move || {
            let mesh = (*raw_mesh).clone().rotated(rotation).scaled(DVec3::splat(scale)).seated();
            let mesh = mesh.snap_to_f32();
            let drawn = preview::thumbnail(&mesh);
            (mesh, drawn)
        })
        .await?;
    let image = artifact_io::put_image(&context, "canonical.png", drawn).await?;
    let size_m = mesh.size_m();
    let mesh = artifact_io::put_mesh(&context, "canonical.glb", mesh).await?;
    let confidence = pose.confidence;
    let output = Output { mesh, image, rotation_xyzw: rotation, scale, size_m, confidence, views };
    context.put_json("canonical.json", &output).await?;
    Ok(output)
}
