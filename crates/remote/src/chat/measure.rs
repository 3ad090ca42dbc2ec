//! How large the things of a picture are, and what they are made of: commonsense sizes in meters.

use bytes::Bytes;
use glam::DVec3;
use serde::Deserialize;
use serde_json::{Value, json};

use super::conversation::Topic;
use super::describe::{OBJECT_M, TABLE_M, check_extents, check_material, extents, materials};
use super::prompts::prompts;
use super::recognize::{Seen, named};
use super::words::{Complaints, Extents};
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

/// Size and look of one thing.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Measured {
    pub size_m: DVec3,
    pub color: Option<Rgb>,
    pub material: Option<String>,
}

/// Of everything on the picture.
pub(super) struct Sizes {
    pub table: Measured,
    /// In the order in which they were seen.
    pub objects: Vec<Measured>,
}

pub(super) fn schema() -> Value {
    let look = |materials: Value| [("color", schema::text_or_null("#rrggbb")), ("material", materials)];
    let mut object = vec![("name", schema::text("as given"))];
    object.extend(extents([OBJECT_M; 3]));
    object.extend(look(schema::word_or_null(materials())));
    let mut table = Vec::from(extents(TABLE_M));
    table.extend(look(schema::word_or_null(TABLE_MATERIALS.iter().copied())));
    schema::object(&[("table", schema::object(&table)), ("objects", schema::list(&schema::object(&object)))])
}

/// Asks how large everything is. What the request knows of the table stays as it says.
pub(super) async fn measure(
    analyst: &ChatAnalyst,
    call: &Call,
    picture: &Bytes,
    seen: &Seen,
    seed: u64,
    options: &RequestOptions,
) -> Result<Sizes, ProviderError> {
    let table_size_m = options.table.as_ref().and_then(|table| table.size_m);
    let topic = Topic {
        prompt: &prompts().measure,
        schema: schema(),
        seed,
        data: json!({
            "table": seen.table.label, "objects": named(seen),
            "known": { "table_size_m": table_size_m, "width": options.metric_anchor },
        }),
        pictures: vec![picture.clone()],
    };
    let ids: Vec<InstanceId> = seen.objects.iter().map(|object| object.id.clone()).collect();
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
    let table = measured("table", answer.table, &mut complaints);
    let order = complaints.answers(asked, answer.objects.iter().map(|object| object.name.as_str()));
    let all: Vec<Measured> = answer
        .objects
        .into_iter()
        .map(|object| {
            let at = super::super::failure::one_line(&object.name);
            check_extents(&at, object.size.extents, [OBJECT_M; 3], &mut complaints);
            check_material(&at, object.size.material.as_deref(), &mut complaints);
            measured(&at, object.size, &mut complaints)
        })
        .collect();
    let objects = order.into_iter().map(|place| all[place].clone()).collect();
    complaints.none_or(Sizes { table, objects })
}

fn measured(at: &str, answer: AnswerSize, complaints: &mut Complaints) -> Measured {
    let color = complaints.color(&format!("{at}.color"), answer.color.as_deref());
    Measured { size_m: answer.extents.size_m(), color, material: answer.material }
}
