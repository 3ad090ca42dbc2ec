//! Stage 2: what the image shows: camera, table, objects with their commonsense sizes, and what stands
//! on what.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec2;
use serde::Serialize;

use super::checkpoint::{ArtifactRef, Stage};
use super::error::StageError;
use super::{Context, artifact_io, reference};
use geometry::Pose;
use imaging::Image;
use ports::{Adapter, Ports};
use render::annotate::{draw_axes, draw_polyline};
use scene::request::RequestOptions;
use scene::{Recognition, RecognizedTable, SceneRequest, SupportTree, TableShape};

pub const STAGE: Stage = Stage { name: "recognize", version: 6 };

#[derive(Serialize)]
pub struct Inputs {
    image: ArtifactRef,
    known: Option<ArtifactRef>,
    seed: u64,
    options: RequestOptions,
    analyst: Adapter,
}

impl Inputs {
    pub fn new(request: &SceneRequest, reference: &reference::Output, ports: &Ports) -> Self {
        Self {
            image: reference.image.clone(),
            known: reference.known.clone(),
            seed: request.seed,
            options: reference::options_for_key(request),
            analyst: ports.analyst.adapter(),
        }
    }
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Recognition, StageError> {
    let (call, ports) = (context.call(), &context.services().ports);
    let seen = reference::seen(&context, &inputs.image, inputs.known.as_ref()).await?;
    let recognition =
        ports.analyst.recognize(&call, seen.clone(), inputs.seed, inputs.options.clone()).await?;
    check(&recognition, &seen.image)?;
    context.put_json("recognition.json", &recognition).await?;
    let message = recognition.clone();
    let drawn = context.cpu(move || drawn_on(&seen.image, &message)).await?;
    artifact_io::put_image(&context, "camera.png", drawn).await?;
    Ok(recognition)
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
            "no object was found on the table; send an image of a table with things on it",
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
            tipped: None,
        };
        let checked = |objects: Vec<RecognizedObject>, side_px: u32| {
            let recognition = Recognition {
                camera: Camera::orbit(64, 48, 0.7, DVec3::ZERO, 0.0, 0.8, 1.6),
                camera_is: CameraKnowledge::Known,
                table: table(TableShape::Round, None),
                objects,
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
