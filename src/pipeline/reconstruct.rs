//! Stage `reconstruct`, for each instance and the table: a textured mesh of it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use super::reference::CompletionRef;
use super::{Context, artifact_io, reference, segment};
use geometry::{Camera, Outline};
use imaging::Mask;
use ports::{Adapter, Ports, ReconstructionRequest, TablePhotograph, TableRequest};
use runtime::seed::child_seed;
use scene::{InstanceId, Recognition, RecognizedObject, RecognizedTable, ReconstructionMethod, SceneRequest};

pub const STAGE: Stage = Stage { name: "reconstruct", version: 10 };

/// Name of the table among the instances of this stage.
const TABLE: &str = "table";

#[derive(Serialize)]
pub struct Inputs {
    subject: Subject,
    mesh_generator: Adapter,
}

#[derive(Serialize)]
#[serde(rename_all = "snake_case")]
enum Subject {
    Object(Box<Object>),
    Table(Box<Table>),
}

#[derive(Serialize)]
struct Table {
    table: RecognizedTable,
    /// `None` if the reference image was rendered.
    photograph: Option<Photograph>,
}

#[derive(Serialize)]
struct Photograph {
    image: ArtifactRef,
    camera: Camera,
    bare_top: Mask,
}

#[derive(Serialize)]
struct Object {
    object: RecognizedObject,
    completion: CompletionRef,
    camera: Camera,
    rendered: bool,
    seed: u64,
}

/// A mesh as generated.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    /// An object's: unit-sized, in any of 24 orientations. The table's: metric, in the world frame.
    pub mesh: ArtifactRef,
    /// Edge of the table's top; `None` for objects.
    pub outline_m: Option<Outline>,
    /// `None` for the table.
    pub method: Option<ReconstructionMethod>,
    pub made_by: String,
    pub licence: String,
    pub notes: Vec<String>,
}

/// The objects in the order of recognition, then the table.
pub fn inputs(
    request: &SceneRequest,
    reference: &reference::Output,
    recognition: &Recognition,
    masks: &segment::Output,
    completions: &[CompletionRef],
    ports: &Ports,
) -> Vec<(InstanceId, Inputs)> {
    let mesh_generator = ports.mesh_generator.adapter();
    let mut inputs: Vec<(InstanceId, Inputs)> = recognition
        .objects
        .iter()
        .zip(completions)
        .map(|(object, completion)| {
            let subject = Subject::Object(Box::new(Object {
                object: object.clone(),
                completion: completion.clone(),
                camera: recognition.camera,
                rendered: reference.known.is_some(),
                seed: child_seed(child_seed(request.seed, "reconstruct"), object.id.as_str()),
            }));
            (object.id.clone(), Inputs { subject, mesh_generator: mesh_generator.clone() })
        })
        .collect();
    if let Ok(id) = InstanceId::new(TABLE) {
        let camera = recognition.camera;
        let photograph = reference.known.is_none().then(|| Photograph {
            image: reference.image.clone(),
            camera,
            bare_top: masks.uncovered(camera.width_px, camera.height_px),
        });
        let table = Table { table: recognition.table.clone(), photograph };
        inputs.push((id, Inputs { subject: Subject::Table(Box::new(table)), mesh_generator }));
    }
    inputs
}

/// Result of a stage for the table, which comes after the objects; `None` where objects alone are made.
pub fn of_table<'a, T>(recognition: &Recognition, made: &'a [T]) -> Option<&'a T> {
    made.get(recognition.objects.len())
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let (call, generator) = (context.call(), &context.services().ports.mesh_generator);
    match &inputs.subject {
        Subject::Object(subject) => {
            let request = ReconstructionRequest {
                object: subject.object.clone(),
                completion: reference::completion(&context, &subject.completion).await?,
                camera: subject.camera,
                rendered: subject.rendered,
                seed: subject.seed,
            };
            let raw = generator.reconstruct(&call, request).await?;
            Ok(Output {
                mesh: artifact_io::put_mesh(&context, "raw.glb", raw.mesh).await?,
                outline_m: None,
                method: Some(raw.method),
                made_by: raw.made_by,
                licence: raw.licence,
                notes: raw.notes,
            })
        }
        Subject::Table(subject) => {
            let photograph = match &subject.photograph {
                Some(Photograph { image, camera, bare_top }) => Some(TablePhotograph {
                    image: artifact_io::image(&context, image).await?,
                    camera: *camera,
                    bare_top: bare_top.clone(),
                }),
                None => None,
            };
            let request = TableRequest { table: subject.table.clone(), photograph };
            let raw = generator.table(&call, request).await?;
            Ok(Output {
                mesh: artifact_io::put_mesh(&context, "mesh.glb", raw.mesh).await?,
                outline_m: Some(raw.outline_m),
                method: None,
                made_by: raw.made_by,
                licence: raw.licence,
                notes: Vec::new(),
            })
        }
    }
}
