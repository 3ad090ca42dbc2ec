//! A picture becomes a recognition, in three turns: what is there and from where it is seen, how large it is, what
//! carries what.

use serde::Deserialize;
use serde_json::{Value, json};

use super::conversation::Topic;
use super::describe::{numbered, shape_of};
use super::prompts::prompts;
use super::schema::PER_MILLE;
use super::seen_camera::{SeenCamera, placed};
use super::words::{Complaints, PictureBox};
use super::{ChatAnalyst, measure, rejected, schema, stacking};
use crate::picture;
use catalog::{categories, category, table_models};
use ports::BAD_ANSWER;
use ports::{Call, Port, ProviderError, Reference};
use runtime::seed::child_seed;
use scene::UNNAMED_CATEGORY;
use scene::request::RequestOptions;
use scene::{CameraKnowledge, InstanceId, Recognition, RecognizedObject, RecognizedTable};

/// Most objects that are believed.
const MAX_OBJECTS: usize = 64;

/// How far beyond the picture a table may be guessed to go on, thousandths.
const BEYOND: [f64; 2] = [-500.0, 1500.0];

/// Ranges of the camera's angles, degrees.
const ELEVATION_DEG: [f64; 2] = [5.0, 90.0];
const AZIMUTH_DEG: [f64; 2] = [-90.0, 90.0];
const FOV_DEG: [f64; 2] = [10.0, 110.0];

/// The first turn's answer as it comes.
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
    place: PictureBox,
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
    place: PictureBox,
}

/// What the first turn finds.
pub(super) struct Seen {
    pub table: SeenTable,
    pub camera: SeenCamera,
    pub objects: Vec<SeenObject>,
}

pub(super) struct SeenTable {
    pub label: String,
    pub model: String,
}

/// One thing on the picture.
pub(super) struct SeenObject {
    pub id: InstanceId,
    pub label: String,
    pub category: String,
    /// Thousandths of the picture.
    pub place: PictureBox,
}

pub(super) fn schema() -> Value {
    let kinds = categories().iter().map(|category| category.name.as_str()).chain([UNNAMED_CATEGORY]);
    let object = schema::object(&[
        ("name", schema::text("such as mug_1")),
        ("label", schema::text("what it is, in a few words")),
        ("category", schema::word(kinds)),
        ("box", schema::picture_box(0.0, PER_MILLE)),
    ]);
    let table = schema::object(&[
        ("label", schema::text("what kind of table it is")),
        ("model", schema::word(table_models().iter().map(|model| model.name))),
        ("box", schema::picture_box(BEYOND[0], BEYOND[1])),
    ]);
    let angle = |[low, high]: [f64; 2]| schema::number(low, high, "degrees");
    let camera = schema::object(&[
        ("elevation_deg", angle(ELEVATION_DEG)),
        ("azimuth_deg", angle(AZIMUTH_DEG)),
        ("horizontal_fov_deg", angle(FOV_DEG)),
    ]);
    schema::object(&[("table", table), ("camera", camera), ("objects", schema::list(&object))])
}

/// Asks what the picture shows.
pub(super) async fn recognize(
    analyst: &ChatAnalyst,
    call: &Call,
    reference: Reference,
    seed: u64,
    options: RequestOptions,
) -> Result<Recognition, ProviderError> {
    let (image, longest_px) = (reference.picture.clone(), analyst.settings.picture_px);
    let (width_px, height_px) = (image.width_px(), image.height_px());
    let encoded = call.compute(Port::Analyst, move |_| {
        picture::sent(&image, longest_px)
            .map_err(|error| rejected("image_unreadable", format!("the picture cannot be sent: {error}")))
    });
    let png = encoded.await?;

    let topic = Topic {
        prompt: &prompts().recognize,
        schema: schema(),
        seed,
        data: json!({ "question": "What stands on the table?" }),
        pictures: vec![png.clone()],
    };
    let seen = analyst.ask(call, topic, accepted).await?;
    let limit = options.max_objects.map_or(MAX_OBJECTS, |most| most as usize);
    if seen.objects.len() > limit {
        let found = seen.objects.len();
        return Err(rejected(
            "too_many_objects",
            format!(
                "the picture shows {found} things, the request allows {limit}; raise max_objects or send a picture \
                 with fewer"
            ),
        ));
    }
    if seen.objects.is_empty() {
        return Err(rejected(
            "nothing_on_the_table",
            "no object was found on the table; send a picture of a table with things on it".into(),
        ));
    }

    let sizes = measure::measure(analyst, call, &png, &seen, seed, &options).await?;
    let carried = stacking::stacking(analyst, call, &png, &seen, seed).await?;

    let wanted = options.table.as_ref();
    let model = wanted.and_then(|table| table.model.clone()).unwrap_or(seen.table.model);
    let model = table_models().iter().find(|known| known.name == model).ok_or_else(|| {
        rejected(
            "unknown_table_model",
            format!("there is no table model {model}; leave it out of the request"),
        )
    })?;
    let shape = shape_of(model.shape);
    let camera = placed(&seen.camera, width_px, height_px, sizes.table.size_m, shape).ok_or_else(|| {
        ProviderError::Transient {
            port: Port::Analyst,
            code: BAD_ANSWER,
            reason: "no camera sees a table of that size where the model says it is".into(),
        }
    })?;
    let objects = seen.objects.into_iter().zip(sizes.objects).zip(carried);
    Ok(Recognition {
        camera,
        camera_is: CameraKnowledge::Judged,
        table: RecognizedTable {
            label: seen.table.label,
            shape,
            model: model.name.to_owned(),
            outline_m: None,
            size_m: sizes.table.size_m,
            color: sizes.table.color,
            material: wanted.and_then(|table| table.material.clone()).or(sizes.table.material),
            seed: child_seed(seed, "table"),
        },
        objects: objects
            .map(|((seen, size), stands_on)| RecognizedObject {
                seed: child_seed(seed, seen.id.as_str()),
                id: seen.id,
                label: seen.label,
                category: seen.category,
                size_m: size.size_m,
                color: size.color,
                material: size.material,
                stands_on,
                seen_px: Some(seen.place.in_pixels(width_px, height_px)),
                seen_as: None,
                seen_like: None,
            })
            .collect(),
    })
}

/// The answer as it is used, or what is wrong with it.
pub(super) fn accepted(answer: Answer) -> Result<Seen, Vec<String>> {
    let mut complaints = Complaints::default();
    complaints.label("table.label", &answer.table.label);
    if table_models().iter().all(|model| model.name != answer.table.model) {
        complaints.add("table.model must be one of the given words");
    }
    answer.table.place.check("table.box", BEYOND[0], BEYOND[1], &mut complaints);
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
        if object.category != UNNAMED_CATEGORY && category(&object.category).is_none() {
            complaints.add(format!("{at}.category must be one of the given words"));
        }
    }
    // What has no category is called by what it is.
    let ids = numbered(answer.objects.iter().map(|object| match object.category.as_str() {
        UNNAMED_CATEGORY => object.label.as_str(),
        category => category,
    }));
    let objects = answer.objects.into_iter().zip(ids).map(|(object, id)| SeenObject {
        id,
        label: object.label.trim().to_owned(),
        category: object.category,
        place: object.place,
    });
    let PictureBox { x0, y0, x1, y1 } = answer.table.place;
    complaints.none_or(Seen {
        camera: SeenCamera {
            elevation_rad: elevation_deg.to_radians(),
            azimuth_rad: azimuth_deg.to_radians(),
            fov_x_rad: horizontal_fov_deg.to_radians(),
            table_box: [x0, y0, x1, y1].map(|side| side / PER_MILLE),
        },
        table: SeenTable { label: answer.table.label.trim().to_owned(), model: answer.table.model },
        objects: objects.collect(),
    })
}

/// The names that the other turns are asked about, each with what tells it from the others.
pub(super) fn named(seen: &Seen) -> Value {
    let object = |object: &SeenObject| {
        let PictureBox { x0, y0, x1, y1 } = object.place;
        json!({ "name": object.id, "label": object.label, "box": { "x0": x0, "y0": y0, "x1": x1, "y1": y1 } })
    };
    json!(seen.objects.iter().map(object).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests;
