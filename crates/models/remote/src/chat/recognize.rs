//! Image to recognition, in three questions: objects and camera, sizes, supports. What a text says is in the image
//! goes with the first question, under a prompt of its own; the answer uses the text's names.

use std::sync::Arc;

use serde::Deserialize;
use serde_json::{Value, json};

use super::camera_estimate::{CameraEstimate, fit_camera};
use super::describe::{numbered_beside, shape_of};
use super::prompts::prompts;
use super::repair_turn::Topic;
use super::response_values::{Complaints, ImageBox};
use super::schema::PER_MILLE;
use super::{ChatAnalyst, measure, rejected, schema, stacking};
use crate::image;
use crate::prompt::Prompt;
use catalog::{category_called, table_models};
use ports::BAD_ANSWER;
use ports::{Call, NamedObject, Port, ProviderError, RecognitionHints, ReferenceImage};
use runtime::seed::child_seed;
use scene::UNNAMED_CATEGORY;
use scene::request::RequestOptions;
use scene::{CameraKnowledge, InstanceId, Recognition, RecognizedObject, RecognizedTable};

/// Maximum objects of an answer.
const MAX_OBJECTS: usize = 64;

/// Range of a table box, which may extend beyond the image, thousandths.
const TABLE_BOX_RANGE: [f64; 2] = [-500.0, 1500.0];

/// Ranges of the camera angles, degrees.
const ELEVATION_DEG: [f64; 2] = [5.0, 90.0];
const AZIMUTH_DEG: [f64; 2] = [-90.0, 90.0];
const FOV_DEG: [f64; 2] = [10.0, 110.0];

/// The answer to the first question on the wire.
#[derive(Deserialize)]
pub(super) struct Answer {
    table: AnswerTable,
    camera: AnswerCamera,
    objects: Vec<AnswerObject>,
}

#[derive(Deserialize)]
struct AnswerTable {
    label: String,
    model: String,
    #[serde(rename = "box")]
    place: ImageBox,
}

#[derive(Deserialize)]
struct AnswerCamera {
    elevation_deg: f64,
    azimuth_deg: f64,
    horizontal_fov_deg: f64,
}

#[derive(Deserialize)]
struct AnswerObject {
    name: String,
    label: String,
    category: String,
    #[serde(rename = "box")]
    place: ImageBox,
}

/// The result of the first question.
pub(super) struct Detections {
    pub table: DetectedTable,
    pub camera: CameraEstimate,
    pub objects: Vec<DetectedObject>,
}

pub(super) struct DetectedTable {
    pub label: String,
    pub model: String,
}

/// One object in the image.
pub(super) struct DetectedObject {
    pub id: InstanceId,
    pub label: String,
    pub category: String,
    /// Thousandths of the image size.
    pub place: ImageBox,
}

/// Schema of the recognition of an image.
pub(super) fn schema() -> Value {
    let object = schema::object(&[
        ("name", schema::text("such as mug_1")),
        ("label", schema::text("what it is, in a few words")),
        (
            "category",
            schema::text(
                "the common noun for it, singular, such as mug or desk lamp; object where none is known",
            ),
        ),
        ("box", schema::image_box(0.0, PER_MILLE)),
    ]);
    let table = schema::object(&[
        ("label", schema::text("what kind of table it is")),
        ("model", schema::word(table_models().iter().map(|model| model.name))),
        ("box", schema::image_box(TABLE_BOX_RANGE[0], TABLE_BOX_RANGE[1])),
    ]);
    let angle = |[low, high]: [f64; 2]| schema::number(low, high, "degrees");
    let camera = schema::object(&[
        ("elevation_deg", angle(ELEVATION_DEG)),
        ("azimuth_deg", angle(AZIMUTH_DEG)),
        ("horizontal_fov_deg", angle(FOV_DEG)),
    ]);
    schema::object(&[("table", table), ("camera", camera), ("objects", schema::list(&object))])
}

/// Asks for the recognition of an image.
pub(super) async fn recognize(
    analyst: &ChatAnalyst,
    call: &Call,
    reference: ReferenceImage,
    seed: u64,
    options: RequestOptions,
    hints: Option<Arc<RecognitionHints>>,
) -> Result<Recognition, ProviderError> {
    let (image, longest_px) = (reference.image.clone(), analyst.settings.image_px);
    let (width_px, height_px) = (image.width_px(), image.height_px());
    let encoded = call.compute(Port::Analyst, move |_| {
        image::sent(&image, longest_px)
            .map_err(|error| rejected("image_unreadable", format!("the image cannot be sent: {error}")))
    });
    let png = encoded.await?;

    let (prompt, data) = question(hints.as_deref());
    let of_text = hints.as_deref().map_or(&[][..], RecognitionHints::named);
    let topic = Topic { prompt, schema: schema(), seed, data, images: vec![png.clone()] };
    let detections = analyst.ask(call, topic, |answer| accepted(answer, of_text)).await?;
    let limit = options.max_objects.map_or(MAX_OBJECTS, |limit| limit as usize);
    if detections.objects.len() > limit {
        let found = detections.objects.len();
        return Err(rejected(
            "too_many_objects",
            format!(
                "the image shows {found} objects, the request allows {limit}; raise max_objects or send an image \
                 with fewer"
            ),
        ));
    }
    if detections.objects.is_empty() {
        return Err(rejected(
            "nothing_on_the_table",
            "no object was found on the table; send an image of a table with objects on it".into(),
        ));
    }

    let sizes = measure::measure(analyst, call, &png, &detections, seed, &options).await?;
    let carried = stacking::stacking(analyst, call, &png, &detections, seed).await?;

    let wanted = options.table.as_ref();
    let model = wanted.and_then(|table| table.model.clone()).unwrap_or(detections.table.model);
    let model = table_models().iter().find(|known| known.name == model).ok_or_else(|| {
        rejected(
            "unknown_table_model",
            format!("there is no table model {model}; leave it out of the request"),
        )
    })?;
    let shape = shape_of(model.shape);
    let camera =
        fit_camera(&detections.camera, width_px, height_px, sizes.table.size_m, shape).ok_or_else(|| {
            ProviderError::Transient {
                port: Port::Analyst,
                code: BAD_ANSWER,
                reason: "no camera sees a table of that size where the model says it is".into(),
            }
        })?;
    let objects = detections.objects.into_iter().zip(sizes.objects).zip(carried);
    let mut recognition = Recognition {
        camera,
        camera_is: CameraKnowledge::Judged,
        table: RecognizedTable {
            label: detections.table.label,
            shape,
            model: model.name.to_owned(),
            outline_m: None,
            size_m: sizes.table.size_m,
            color: sizes.table.color,
            material: wanted.and_then(|table| table.material.clone()).or(sizes.table.material),
            seed: child_seed(seed, "table"),
        },
        objects: objects
            .map(|((object, size), stands_on)| RecognizedObject {
                seed: child_seed(seed, object.id.as_str()),
                id: object.id,
                label: object.label,
                category: object.category,
                size_m: size.size_m,
                tipped: None,
                color: size.color,
                material: size.material,
                stands_on,
                seen_px: Some(object.place.in_pixels(width_px, height_px)),
                seen_as: None,
                seen_like: None,
                mass_kg: None,
                stand_in: None,
            })
            .collect(),
        left_out_px: Vec::new(),
        depth: None,
    };
    if let Some(hints) = hints {
        hints.apply(&mut recognition);
    }
    Ok(recognition)
}

/// The prompt of the first question, and its data.
fn question(hints: Option<&RecognitionHints>) -> (&'static Prompt, Value) {
    let asked = "What stands on the table?";
    let Some(hints) = hints else { return (&prompts().recognize, json!({ "question": asked })) };
    let object = |named: &NamedObject| {
        // Names of the hidden categories of stand-ins are no nouns.
        let category = named.stand_in.as_ref().map_or(&named.category, |mark| &mark.stands_for);
        let mut object = json!({ "name": named.id, "label": named.label, "category": category });
        if let Some(color) = named.color {
            object["color"] = json!(color.to_hex());
        }
        if let Some(material) = &named.material {
            object["material"] = json!(material);
        }
        if named.size_is_stated {
            object["size_m"] = json!(named.size_m);
        }
        if let Some((relation, supporter)) = &named.supporter {
            object["stands"] = json!({ "relation": relation, "of": supporter });
        }
        object
    };
    let named: Vec<Value> = hints.named().iter().map(object).collect();
    (&prompts().recognize_named, json!({ "question": asked, "named": named, "absent": hints.absent() }))
}

/// The detections of a valid answer, or its violations. Objects that `of_text` names keep their names; all others are
/// numbered.
pub(super) fn accepted(answer: Answer, of_text: &[NamedObject]) -> Result<Detections, Vec<String>> {
    let mut complaints = Complaints::default();
    complaints.label("table.label", &answer.table.label);
    if table_models().iter().all(|model| model.name != answer.table.model) {
        complaints.add("table.model must be one of the given words");
    }
    answer.table.place.check("table.box", TABLE_BOX_RANGE[0], TABLE_BOX_RANGE[1], &mut complaints);
    let AnswerCamera { elevation_deg, azimuth_deg, horizontal_fov_deg } = answer.camera;
    for (name, angle, [low, high]) in [
        ("elevation_deg", elevation_deg, ELEVATION_DEG),
        ("azimuth_deg", azimuth_deg, AZIMUTH_DEG),
        ("horizontal_fov_deg", horizontal_fov_deg, FOV_DEG),
    ] {
        complaints.range(&format!("camera.{name}"), angle, low, high);
    }
    complaints.names(answer.objects.iter().map(|object| object.name.as_str()));
    for (index, object) in answer.objects.iter().enumerate() {
        let at = format!("objects[{index}]");
        complaints.label(&format!("{at}.label"), &object.label);
        object.place.check(&format!("{at}.box"), 0.0, PER_MILLE, &mut complaints);
        complaints.label(&format!("{at}.category"), &object.category);
    }
    let named = |object: &AnswerObject| of_text.iter().find(|named| named.id.as_str() == object.name);
    let categories: Vec<&str> = answer
        .objects
        .iter()
        .map(|object| category_called(&object.category).map_or(UNNAMED_CATEGORY, |found| &found.name))
        .collect();
    // An object without a category is named by its label.
    let kinds = answer.objects.iter().zip(&categories).map(|(object, category)| match *category {
        UNNAMED_CATEGORY => object.label.as_str(),
        category => category,
    });
    // The names of the text come first, so that no number is used twice.
    let taken: Vec<InstanceId> = of_text.iter().map(|named| named.id.clone()).collect();
    let ids: Vec<InstanceId> = answer
        .objects
        .iter()
        .zip(numbered_beside(&taken, kinds))
        .map(|(object, other)| named(object).map_or(other, |named| named.id.clone()))
        .collect();
    let objects =
        answer.objects.into_iter().zip(categories).zip(ids).map(|((object, category), id)| DetectedObject {
            id,
            label: object.label.trim().to_owned(),
            category: category.to_owned(),
            place: object.place,
        });
    let ImageBox { x0, y0, x1, y1 } = answer.table.place;
    complaints.none_or(Detections {
        camera: CameraEstimate {
            elevation_rad: elevation_deg.to_radians(),
            azimuth_rad: azimuth_deg.to_radians(),
            fov_x_rad: horizontal_fov_deg.to_radians(),
            table_box: [x0, y0, x1, y1].map(|side| side / PER_MILLE),
        },
        table: DetectedTable { label: answer.table.label.trim().to_owned(), model: answer.table.model },
        objects: objects.collect(),
    })
}

/// The objects that the further questions name, each with its label and box.
pub(super) fn named(detections: &Detections) -> Value {
    let object = |object: &DetectedObject| {
        let ImageBox { x0, y0, x1, y1 } = object.place;
        json!({ "name": object.id, "label": object.label, "box": { "x0": x0, "y0": y0, "x1": x1, "y1": y1 } })
    };
    json!(detections.objects.iter().map(object).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests;
