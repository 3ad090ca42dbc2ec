//! Answers of the embedded ports in the precision of a model: angles to half a degree, boxes to a thousandth of the
//! image, sizes to a millimeter.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use serde_json::{Value, json};

use super::{Question, ratings, rotations};
use crate::mock_vendors::error_response::VendorError;
use crate::mock_vendors::image_sessions::{DescribedScene, ImageSessions};
use crate::mock_vendors::recognized_image::RecognizedImage;
use geometry::Rgb;
use scene::request::RequestOptions;
use scene::{InstanceId, StandsOn, TableShape, TableSpec};

pub(super) async fn answered(sessions: &ImageSessions, question: &Question) -> Result<Value, VendorError> {
    match question.schema.as_str() {
        "describe" => return described(sessions, question).await,
        "check_top" => return top_checked(sessions, question).await,
        "upright" => return rotations::answer(sessions, question).await,
        "judge_picture" => return ratings::after_image(question),
        "judge_text" => return ratings::after_text(sessions, question).await,
        "propose_tasks" => return ratings::tasks(question),
        _ => {}
    }
    let image = question.images.first().ok_or_else(|| VendorError::Invalid("there is no image".into()))?;
    let known = sessions.recognize(image.clone()).await?;
    match question.schema.as_str() {
        "recognize" | "recognize_named" => Ok(recognized(&known.recognized)),
        "measure" => measured(&known.recognized, &question.data),
        "stacking" => stacked(&known.recognized, &question.data),
        other => Err(VendorError::Invalid(format!("there is no answer to {other}"))),
    }
}

async fn described(sessions: &ImageSessions, question: &Question) -> Result<Value, VendorError> {
    let request =
        question.data["wish"].as_str().ok_or_else(|| VendorError::Invalid("the text is missing".into()))?;
    let table: Option<TableSpec> = serde_json::from_value(question.data["table"].clone()).ok();
    let table = table.filter(|table| *table != TableSpec::default());
    let max_objects = question.data["most_objects"].as_u64().and_then(|highest| u32::try_from(highest).ok());
    let options = RequestOptions { table, max_objects, ..RequestOptions::default() };
    let known = sessions.described(request, question.seed, options).await?;
    Ok(description(&known))
}

fn description(known: &DescribedScene) -> Value {
    let DescribedScene { description, reference } = known;
    let table = &reference.recognized.recognition.table;
    let objects: Vec<Value> = description
        .objects
        .iter()
        .map(|object| {
            let relations: Vec<Value> = object
                .relations
                .iter()
                .map(|relation| json!({ "kind": relation.kind, "target": relation.target }))
                .collect();
            let mut answer = json!({ "name": object.id, "label": object.label, "category": object.category });
            put_size(&mut answer, object.size_m);
            answer["color"] = json!(object.color.map(hexadecimal));
            answer["material"] = json!(object.material);
            answer["requested"] = json!(object.requested);
            answer["relations"] = json!(relations);
            answer
        })
        .collect();
    let mut top = json!({
        "model": table.model, "material": description.table.material, "color": description.table.color,
    });
    put_size(&mut top, table.size_m);
    let terms: Vec<&str> = description.unrecognized.iter().map(|part| part.span.text.as_str()).collect();
    json!({
        "theme": description.theme, "family": description.family, "table": top, "objects": objects,
        "unrecognized_terms": terms, "prose": description.prose,
    })
}

fn recognized(recognized: &RecognizedImage) -> Value {
    let (recognition, camera) = (&recognized.recognition, &recognized.recognition.camera);
    let width = f64::from(camera.width_px);
    let shown = recognition
        .objects
        .iter()
        .zip(recognized.boxes())
        .filter_map(|(object, place)| Some((object, place?)));
    let objects: Vec<Value> = shown
        .map(|(object, place)| {
            json!({
                "name": object.id, "label": object.label, "category": object.category, "box": in_thousandths(place),
            })
        })
        .collect();
    let half_degrees = |angle: f64| (2.0 * angle.to_degrees()).round() / 2.0;
    json!({
        "table": {
            "label": recognition.table.label, "model": recognition.table.model, "box": in_thousandths(top_box(recognized)),
        },
        "camera": {
            "elevation_deg": half_degrees(camera.elevation_rad()),
            "azimuth_deg": half_degrees(camera.azimuth_rad()),
            "horizontal_fov_deg": half_degrees(2.0 * (0.5 * width / camera.fx).atan()),
        },
        "objects": objects,
    })
}

/// Answers whether the second image is the top view of the first.
async fn top_checked(sessions: &ImageSessions, question: &Question) -> Result<Value, VendorError> {
    let [image, top] = &question.images[..] else {
        return Err(VendorError::Invalid("two images are wanted".into()));
    };
    let shown = sessions.recognize(image.clone()).await?;
    let known = sessions.known_top_view(top).await;
    let holds = known.is_some_and(|known| Arc::ptr_eq(&known.of, &shown));
    let message = if holds { "it holds" } else { "draw the table from straight above" };
    Ok(json!({
        "straight_down": holds, "no_perspective": holds, "front_below": holds, "all_there": true, "none_added": true,
        "told": message,
    }))
}

/// Box around the table top, shares of the image.
fn top_box(recognized: &RecognizedImage) -> [f64; 4] {
    let (table, camera) = (&recognized.recognition.table, &recognized.recognition.camera);
    let size_px = DVec2::new(f64::from(camera.width_px), f64::from(camera.height_px));
    let edge: Vec<DVec2> = (0..64)
        .map(|k| DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / 64.0))
        .map(|direction| match table.shape {
            TableShape::Round | TableShape::Oval => 0.5 * direction,
            // On the edge of the square, corners included.
            _ => 0.5 * direction / direction.abs().max_element(),
        })
        .map(|point| point * table.size_m.truncate())
        .filter_map(|point| camera.project(point.extend(0.0)).map(|(pixel, _)| pixel / size_px))
        .collect();
    let low = edge.iter().fold(DVec2::INFINITY, |low, point| low.min(*point));
    let high = edge.iter().fold(DVec2::NEG_INFINITY, |high, point| high.max(*point));
    [low.x, low.y, high.x, high.y]
}

/// The objects of the question, each with its index in the image.
fn asked_about<'a>(
    recognized: &RecognizedImage,
    data: &'a Value,
) -> Result<Vec<(&'a str, usize)>, VendorError> {
    let asked =
        data["objects"].as_array().ok_or_else(|| VendorError::Invalid("there are no objects".into()))?;
    let found = asked.iter().map(|object| {
        let side = |name: &str| object["box"][name].as_f64().map(|side| side / 1000.0);
        let place = [side("x0")?, side("y0")?, side("x1")?, side("y1")?];
        Some((object["name"].as_str()?, recognized.object_at(place)?))
    });
    found.collect::<Option<_>>().ok_or_else(|| VendorError::Invalid("objects have names and boxes".into()))
}

fn measured(recognized: &RecognizedImage, data: &Value) -> Result<Value, VendorError> {
    let put_appearance = |answer: &mut Value, color: Option<Rgb>, material: &Option<String>| {
        answer["color"] = json!(color.map(hexadecimal));
        answer["material"] = json!(material);
    };
    let objects = asked_about(recognized, data)?.into_iter().map(|(name, index)| {
        let object = &recognized.recognition.objects[index];
        let mut answer = json!({ "name": name });
        put_size(&mut answer, object.size_m);
        put_appearance(&mut answer, object.color, &object.material);
        answer
    });
    let objects: Vec<Value> = objects.collect();
    let known = &recognized.recognition.table;
    let mut table = json!({});
    put_size(&mut table, known.size_m);
    put_appearance(&mut table, known.color, &known.material);
    Ok(json!({ "table": table, "objects": objects }))
}

fn stacked(recognized: &RecognizedImage, data: &Value) -> Result<Value, VendorError> {
    let asked = asked_about(recognized, data)?;
    let name_of = |id: &InstanceId| {
        let index = recognized.recognition.objects.iter().position(|object| object.id == *id);
        asked.iter().find(|(_, other)| Some(*other) == index).map_or("table", |(name, _)| *name)
    };
    let objects: Vec<Value> = asked
        .iter()
        .map(|(name, index)| {
            let (relation, carrier) = match &recognized.recognition.objects[*index].stands_on {
                StandsOn::Table => ("on", "table"),
                StandsOn::On(id) => ("on", name_of(id)),
                StandsOn::In(id) => ("in", name_of(id)),
            };
            json!({ "name": name, "relation": relation, "carried_by": carrier })
        })
        .collect();
    Ok(json!({ "objects": objects }))
}

fn in_thousandths(place: [f64; 4]) -> Value {
    let [x0, y0, x1, y1] = place.map(|side| (1000.0 * side).round());
    json!({ "x0": x0, "y0": y0, "x1": x1, "y1": y1 })
}

fn put_size(answer: &mut Value, size_m: DVec3) {
    let names = ["width_m", "depth_m", "height_m"];
    for (name, extent) in names.into_iter().zip(size_m.to_array()) {
        // Sizes are at least one millimeter.
        answer[name] = json!(((1000.0 * extent).round() / 1000.0).max(0.001));
    }
}

fn hexadecimal(color: Rgb) -> String {
    let [r, g, b, _] = color.to_rgba8();
    format!("#{r:02x}{g:02x}{b:02x}")
}
