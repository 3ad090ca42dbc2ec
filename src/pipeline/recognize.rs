//! Stage `recognize`: what the image shows: camera, table, objects with their commonsense sizes, and what stands
//! on what. The text beside an image is described first; the stage searches for the objects that it names.

mod text_beside_image;

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use super::{Context, artifact_io, reference};
use geometry::Pose;
use imaging::Image;
use ports::{Adapter, Ports, RecognitionHints};
use render::annotate::{draw_axes, draw_polyline};
use scene::request::RequestOptions;
use scene::text_account::TextAccount;
use scene::{
    DepthAccount, Input, Recognition, RecognizedTable, SceneDescription, SceneRequest, SupportTree,
    TableShape,
};

pub const STAGE: Stage = Stage { name: "recognize", version: 9 };

#[derive(Serialize)]
pub struct Inputs {
    image: ArtifactRef,
    known: Option<ArtifactRef>,
    /// Without depths, the key is that of the image alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    depth: Option<ArtifactRef>,
    seed: u64,
    options: RequestOptions,
    analyst: Adapter,
    /// The text beside the image. Without one, the key is that of the image alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    text: Option<String>,
}

/// The content of the image, and the account of the text beside it.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    #[serde(flatten)]
    pub recognition: Recognition,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub account: Option<TextAccount>,
}

impl Inputs {
    pub fn new(request: &SceneRequest, reference: &reference::Output, ports: &Ports) -> Self {
        let text = match &request.input {
            Input::Image { text, .. } => text.clone(),
            Input::Text { .. } | Input::Edit { .. } | Input::Variant { .. } => None,
        };
        Self {
            image: reference.image.clone(),
            known: reference.known.clone(),
            depth: reference.depth.clone(),
            seed: request.seed,
            options: reference::options_for_key(request),
            analyst: match text {
                Some(_) => ports.analyst.adapter_with_hints(),
                None => ports.analyst.adapter(),
            },
            text,
        }
    }
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let (call, ports) = (context.call(), &context.services().ports);
    let (known, depth) = (inputs.known.as_ref(), inputs.depth.as_ref());
    let seen = reference::seen(&context, &inputs.image, known, depth).await?;
    let described = described(&context, &inputs).await?;
    let hints = described.as_ref().map(|(_, hints)| hints.clone());
    let options = inputs.options.clone();
    let mut recognition = ports.analyst.recognize(&call, seen.clone(), inputs.seed, options, hints).await?;
    check(&recognition, &seen.image)?;
    if inputs.depth.is_some() {
        recognition.depth.get_or_insert_with(not_measured);
    }
    let account =
        described.map(|(description, hints)| text_beside_image::account(&description, &hints, &recognition));
    context.put_json("recognition.json", &recognition).await?;
    let message = recognition.clone();
    let drawn = context.cpu(move || drawn_on(&seen.image, &message)).await?;
    artifact_io::put_image(&context, "camera.png", drawn).await?;
    Ok(Output { recognition, account })
}

/// The account of a depth image that the analyst did not use.
fn not_measured() -> DepthAccount {
    let note = "the analyst of this server does not measure depths, so the image alone was used; set providers.analyst to \
                embedded";
    DepthAccount { is_used: false, note: note.to_owned() }
}

/// The description of the text beside the image, and what it says about the image.
async fn described(
    context: &Context,
    inputs: &Inputs,
) -> Result<Option<(SceneDescription, Arc<RecognitionHints>)>, StageError> {
    let Some(text) = inputs.text.clone() else { return Ok(None) };
    let (call, analyst) = (context.call(), &context.services().ports.analyst);
    // Limits of the request are those of the image; a text may name more than is found.
    let options = RequestOptions { max_objects: None, table: None, ..inputs.options.clone() };
    let description = analyst.describe(&call, text, inputs.seed, options).await?;
    let hints = RecognitionHints::of(&description).map_err(|invalid| {
        StageError::permanent("text_not_usable", format!("reading the text beside the image: {invalid}"))
    })?;
    context.put_json("description.json", &description).await?;
    Ok(Some((description, Arc::new(hints))))
}

/// The supports of the recognized objects, which every later stage uses.
///
/// # Errors
///
/// `recognition_inconsistent`, where they form no tree. The stage checks that.
pub fn support_tree(recognition: &Recognition) -> Result<SupportTree, StageError> {
    recognition.support_tree().map_err(|error| inconsistent(&error.to_string()))
}

fn inconsistent(what: &str) -> StageError {
    StageError::permanent("recognition_inconsistent", format!("recognizing the image: {what}"))
}

/// Ports answer data, and data is checked: a camera of this image, at least one object, and what
/// [`Recognition::validate`] demands.
fn check(recognition: &Recognition, image: &Image) -> Result<(), StageError> {
    let camera = &recognition.camera;
    if (camera.width_px, camera.height_px) != (image.width_px(), image.height_px()) {
        return Err(inconsistent("the camera belongs to an image of another size"));
    }
    if recognition.objects.is_empty() {
        return Err(StageError::permanent(
            "nothing_on_the_table",
            "no object was found on the table; send an image of a table with objects on it",
        ));
    }
    recognition.validate().map_err(|invalid| inconsistent(&invalid.to_string()))
}

/// The image with the world's axes and the edge of the table top, as the camera sees them.
fn drawn_on(image: &Image, recognition: &Recognition) -> Image {
    let camera = &recognition.camera;
    let mut drawn = image.clone();
    let edge: Option<Vec<_>> = top_edge(&recognition.table)
        .into_iter()
        .map(|corner| camera.project(corner.extend(0.0)).map(|(pixel, _)| pixel))
        .collect();
    if let Some(edge) = edge {
        draw_polyline(&mut drawn, &edge, true, [0, 110, 220, 255], 1.5);
    }
    draw_axes(&mut drawn, camera, &Pose::IDENTITY, 0.15, 3.0);
    drawn
}

/// Edge of the top in the world, as far as it was recognized: its outline, or what its shape and extents say.
fn top_edge(table: &RecognizedTable) -> Vec<DVec2> {
    let half = 0.5 * table.size_m.truncate();
    match (&table.outline_m, table.shape) {
        (Some(outline), _) => outline.corners().to_vec(),
        (None, TableShape::Round | TableShape::Oval) => {
            (0..96).map(|k| half * DVec2::from_angle(TAU * f64::from(k) / 96.0)).collect()
        }
        (None, _) => {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| half * DVec2::new(x, y)).into()
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use geometry::{Camera, Outline};
    use scene::{CameraKnowledge, InstanceId, RecognizedObject, StandsOn};

    #[test]
    fn contradictory_recognition_is_refused() {
        let object = |name: &str, stands_on: StandsOn| RecognizedObject {
            id: id(name),
            label: name.into(),
            category: "mug".into(),
            size_m: DVec3::splat(0.1),
            color: None,
            material: None,
            seed: 1,
            stands_on,
            seen_px: None,
            seen_as: None,
            seen_like: None,
            mass_kg: None,
            stand_in: None,
            tipped: None,
        };
        let checked = |objects: Vec<RecognizedObject>, side_px: u32| {
            let recognition = Recognition {
                camera: Camera::orbit(64, 48, 0.7, DVec3::ZERO, 0.0, 0.8, 1.6),
                camera_is: CameraKnowledge::Known,
                table: table(TableShape::Round, None),
                objects,
                left_out_px: Vec::new(),
                depth: None,
            };
            let image = Image::filled(side_px, 48, [0; 4]);
            check(&recognition, &image).and_then(|()| support_tree(&recognition)).map_err(|error| error.code)
        };
        let (on_plate, on_mug) = (StandsOn::On(id("plate_1")), StandsOn::On(id("mug_1")));
        let mug = || object("mug_1", on_plate.clone());
        let sound = checked(vec![mug(), object("plate_1", StandsOn::Table)], 64).expect("sound");
        assert_eq!(sound.order(), [1, 0]);
        for objects in [
            vec![mug(), object("plate_1", on_mug)],
            vec![mug()],
            vec![object("mug_1", StandsOn::Table), object("mug_1", StandsOn::Table)],
            vec![RecognizedObject { size_m: DVec3::ZERO, ..object("mug_1", StandsOn::Table) }],
        ] {
            assert_eq!(checked(objects, 64), Err("recognition_inconsistent"));
        }
        assert_eq!(checked(vec![object("mug_1", StandsOn::Table)], 60), Err("recognition_inconsistent"));
        assert_eq!(checked(Vec::new(), 64), Err("nothing_on_the_table"));
    }

    fn id(name: &str) -> InstanceId {
        InstanceId::new(name).expect("a name")
    }

    fn table(shape: TableShape, outline_m: Option<Outline>) -> RecognizedTable {
        RecognizedTable {
            label: "table".into(),
            shape,
            model: "any".into(),
            outline_m,
            size_m: DVec3::new(1.2, 0.8, 0.7),
            color: None,
            material: None,
            seed: 1,
        }
    }

    #[test]
    fn the_edge_of_a_round_top_is_round_and_an_outline_is_itself() {
        let oval = top_edge(&table(TableShape::Oval, None));
        assert!(oval.iter().all(|p| ((p.x / 0.6).hypot(p.y / 0.4) - 1.0).abs() < 1e-9));
        assert_eq!(top_edge(&table(TableShape::Rectangular, None))[2], DVec2::new(0.6, 0.4));
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y)).to_vec();
        let outline = Outline::new(corners).expect("a triangle");
        assert_eq!(top_edge(&table(TableShape::Triangular, Some(outline.clone()))), outline.corners());
    }
}
