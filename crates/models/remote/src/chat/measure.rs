//! Commonsense sizes in meters, colors and materials of the objects in an image.

use bytes::Bytes;
use glam::DVec3;
use serde::Deserialize;
use serde_json::{Value, json};

use super::describe::{OBJECT_M, TABLE_M, check_extents, check_material, extents, materials};
use super::prompts::prompts;
use super::recognize::{Detections, named};
use super::repair_turn::Topic;
use super::response_values::{Complaints, Extents};
use super::{ChatAnalyst, schema};
use catalog::tables::TABLE_MATERIALS;
use geometry::Rgb;
use ports::{Call, ProviderError};
use scene::InstanceId;
use scene::request::RequestOptions;

#[derive(Deserialize)]
pub(super) struct Answer {
    table: AnswerSize,
    objects: Vec<AnswerObject>,
}

#[derive(Deserialize)]
struct AnswerObject {
    name: String,
    #[serde(flatten)]
    size: AnswerSize,
}

#[derive(Deserialize)]
struct AnswerSize {
    #[serde(flatten)]
    extents: Extents,
    color: Option<String>,
    material: Option<String>,
}

/// Size, color and material of one object.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Measurement {
    pub size_m: DVec3,
    pub color: Option<Rgb>,
    pub material: Option<String>,
}

/// The measurements of an image.
pub(super) struct Sizes {
    pub table: Measurement,
    /// In the order of the detections.
    pub objects: Vec<Measurement>,
}

pub(super) fn schema() -> Value {
    let appearance = |materials: Value| [("color", schema::text_or_null("#rrggbb")), ("material", materials)];
    let mut object = vec![("name", schema::text("as given"))];
    object.extend(extents([OBJECT_M; 3]));
    object.extend(appearance(schema::word_or_null(materials())));
    let mut table = Vec::from(extents(TABLE_M));
    table.extend(appearance(schema::word_or_null(TABLE_MATERIALS.iter().copied())));
    schema::object(&[("table", schema::object(&table)), ("objects", schema::list(&schema::object(&object)))])
}

/// Asks for the sizes. The table size of the request overrides the answer.
pub(super) async fn measure(
    analyst: &ChatAnalyst,
    call: &Call,
    image: &Bytes,
    detections: &Detections,
    seed: u64,
    options: &RequestOptions,
) -> Result<Sizes, ProviderError> {
    let table_size_m = options.table.as_ref().and_then(|table| table.size_m);
    let topic = Topic {
        prompt: &prompts().measure,
        schema: schema(),
        seed,
        data: json!({
            "table": detections.table.label, "objects": named(detections),
            "known": { "table_size_m": table_size_m, "width": options.metric_anchor },
        }),
        images: vec![image.clone()],
    };
    let ids: Vec<InstanceId> = detections.objects.iter().map(|object| object.id.clone()).collect();
    let mut sizes = analyst.ask(call, topic, |answer| accepted(answer, &ids)).await?;
    if let Some(size_m) = table_size_m {
        sizes.table.size_m = size_m;
    }
    Ok(sizes)
}

pub(super) fn accepted(answer: Answer, asked: &[InstanceId]) -> Result<Sizes, Vec<String>> {
    let mut complaints = Complaints::default();
    check_extents("table", answer.table.extents, TABLE_M, &mut complaints);
    if answer.table.material.as_deref().is_some_and(|name| !TABLE_MATERIALS.contains(&name)) {
        complaints.add("table.material must be one of the given words, or null");
    }
    let table = measurement("table", answer.table, &mut complaints);
    let order = complaints.answers(asked, answer.objects.iter().map(|object| object.name.as_str()));
    let all: Vec<Measurement> = answer
        .objects
        .into_iter()
        .map(|object| {
            let at = super::super::failure::one_line(&object.name);
            check_extents(&at, object.size.extents, [OBJECT_M; 3], &mut complaints);
            check_material(&at, object.size.material.as_deref(), &mut complaints);
            measurement(&at, object.size, &mut complaints)
        })
        .collect();
    let objects = order.into_iter().map(|place| all[place].clone()).collect();
    complaints.none_or(Sizes { table, objects })
}

fn measurement(at: &str, answer: AnswerSize, complaints: &mut Complaints) -> Measurement {
    let color = complaints.color(&format!("{at}.color"), answer.color.as_deref());
    Measurement { size_m: answer.extents.size_m(), color, material: answer.material }
}
