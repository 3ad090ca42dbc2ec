//! Text to scene description: the objects on the table, their sizes and their relations.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Deserialize;
use serde_json::{Value, json};

use super::object_kinds::{ObjectKind, object_kind};
use super::prompts::prompts;
use super::repair_turn::Topic;
use super::response_values::{Complaints, Extents, cyclic};
use super::{ChatAnalyst, rejected, schema};
use catalog::tables::TABLE_MATERIALS;
use catalog::{substance, table_models};
use ports::{Call, ProviderError};
use runtime::seed::child_seed;
use scene::request::{MAX_SEED, RequestOptions};
use scene::{
    InstanceId, ObjectSpec, Relation, RelationKind, RequestedPose, SceneDescription, TableShape, TableSpec,
    TextSpan, Unrecognized, UnrecognizedReason,
};

/// Maximum length of the request text, characters.
const MAX_TEXT_CHARS: usize = 4000;

/// Maximum objects of a scene whose request states none.
const DEFAULT_MAX_OBJECTS: u32 = 64;

const FAMILIES: [&str; 4] = ["office_living", "dining_kitchen", "workbench_utility", "crafting_hobby"];

/// Range of the extents of objects on a table, meters.
pub(super) const OBJECT_M: [f64; 2] = [0.001, 2.0];

/// Ranges of the width and depth of a table top and of its height, meters.
pub(super) const TABLE_M: [[f64; 2]; 3] = [[0.2, 5.0], [0.2, 5.0], [0.1, 2.0]];

/// The answer on the wire.
#[derive(Deserialize)]
pub(super) struct Answer {
    theme: String,
    family: String,
    table: AnswerTable,
    objects: Vec<AnswerObject>,
    unrecognized_terms: Vec<String>,
    prose: String,
}

#[derive(Deserialize)]
struct AnswerTable {
    model: String,
    material: Option<String>,
    color: Option<String>,
    #[serde(flatten)]
    extents: Extents,
}

#[derive(Deserialize)]
struct AnswerObject {
    name: String,
    label: String,
    category: String,
    #[serde(flatten)]
    extents: Extents,
    color: Option<String>,
    material: Option<String>,
    requested: bool,
    relations: Vec<AnswerRelation>,
}

#[derive(Deserialize)]
struct AnswerRelation {
    kind: RelationKind,
    target: Option<String>,
}

const RELATIONS: [&str; 14] = [
    "on",
    "in",
    "left_of",
    "right_of",
    "in_front_of",
    "behind",
    "next_to",
    "around",
    "stacked_on",
    "at_center",
    "at_back",
    "at_front",
    "at_left",
    "at_right",
];

/// Three extents, in their ranges.
pub(super) fn extents([x, y, z]: [[f64; 2]; 3]) -> [(&'static str, Value); 3] {
    [
        ("width_m", schema::number(x[0], x[1], "width, meters")),
        ("depth_m", schema::number(y[0], y[1], "depth, meters")),
        ("height_m", schema::number(z[0], z[1], "height, meters")),
    ]
}

/// Names of substances, sorted as in their file.
pub(super) fn materials() -> impl Iterator<Item = &'static str> {
    substance::substances().keys().map(String::as_str)
}

/// Schema of the description of a text.
pub(super) fn schema() -> Value {
    let relation = schema::object(&[
        ("kind", schema::word(RELATIONS)),
        ("target", schema::text_or_null("name of the other object, null for a part of the table")),
    ]);
    let mut object = vec![
        ("name", schema::text("such as mug_1")),
        ("label", schema::text("what a person would say")),
        ("category", schema::text("the common noun for it, singular, such as mug or desk lamp")),
    ];
    object.extend(extents([OBJECT_M; 3]));
    object.extend([
        ("color", schema::text_or_null("#rrggbb")),
        ("material", schema::word_or_null(materials())),
        ("requested", schema::yes_or_no()),
        ("relations", schema::list(&relation)),
    ]);
    let mut table = vec![
        ("model", schema::word(table_models().iter().map(|model| model.name))),
        ("material", schema::word_or_null(TABLE_MATERIALS.iter().copied())),
        ("color", schema::text_or_null("a color word of the wish")),
    ];
    table.extend(extents(TABLE_M));
    schema::object(&[
        ("theme", schema::text("such as breakfast_table")),
        ("family", schema::word(FAMILIES)),
        ("table", schema::object(&table)),
        ("objects", schema::list(&schema::object(&object))),
        ("unrecognized_terms", schema::list(&schema::text("a word of the wish"))),
        ("prose", schema::text("the scene in two or three sentences")),
    ])
}

/// Asks for a description.
pub(super) async fn describe(
    analyst: &ChatAnalyst,
    call: &Call,
    text: String,
    seed: u64,
    options: RequestOptions,
) -> Result<SceneDescription, ProviderError> {
    let chars = text.chars().count();
    if text.trim().is_empty() {
        return Err(rejected("text_empty", "the text is empty: name a table and what stands on it".into()));
    }
    if chars > MAX_TEXT_CHARS {
        let reason =
            format!("the text has {chars} characters, the most sent is {MAX_TEXT_CHARS}: shorten it");
        return Err(rejected("text_too_long", reason));
    }
    let wanted = options.table.unwrap_or_default();
    if let Some(model) = &wanted.model
        && table_models().iter().all(|known| known.name != model)
    {
        let known = table_models().iter().map(|model| model.name).collect::<Vec<_>>().join(", ");
        return Err(rejected(
            "unknown_table_model",
            format!("there is no table model {model}; choose of {known}"),
        ));
    }
    let max_objects = options.max_objects.unwrap_or(DEFAULT_MAX_OBJECTS) as usize;
    let topic = Topic {
        prompt: &prompts().describe,
        schema: schema(),
        seed,
        data: json!({ "wish": &text, "most_objects": max_objects, "table": wanted }),
        images: Vec::new(),
    };
    let description = analyst
        .ask(call, topic, |answer: Answer| accepted(answer, &text, seed, max_objects, &wanted))
        .await?;
    if description.objects.is_empty() {
        let terms: Vec<&str> = description.unrecognized.iter().map(|part| part.span.text.as_str()).collect();
        let terms = terms.join(", ");
        let reason =
            format!("nothing in the text is an object that can stand on a table ({terms}); name some");
        return Err(rejected("nothing_recognized", reason));
    }
    Ok(description)
}

/// The description of a valid answer, or its violations.
pub(super) fn accepted(
    answer: Answer,
    text: &str,
    seed: u64,
    max_objects: usize,
    wanted: &TableSpec,
) -> Result<SceneDescription, Vec<String>> {
    let mut complaints = Complaints::default();
    if answer.objects.len() > max_objects {
        // The objects stay unread: there may be a million.
        let message =
            format!("there are {} objects; at most {max_objects} are allowed", answer.objects.len());
        return Err(vec![message]);
    }
    complaints.plain("theme", &answer.theme, 60);
    complaints.plain("prose", &answer.prose.replace('\n', " "), 4000);
    if !FAMILIES.contains(&answer.family.as_str()) {
        complaints.add(format!("family must be one of {}", FAMILIES.join(", ")));
    }
    for term in &answer.unrecognized_terms {
        complaints.plain("an unrecognized term", term, 100);
    }
    let table = table_of(&answer.table, wanted, &mut complaints);
    let objects = objects_of(&answer.objects, seed, &mut complaints);
    complaints.none_or(SceneDescription {
        theme: answer.theme,
        family: answer.family,
        table,
        // A model states sizes that the text does not.
        table_size_is_stated: wanted.size_m.is_some(),
        objects,
        arrangements: Vec::new(),
        goal: None,
        excluded_categories: Vec::new(),
        understood: Vec::new(),
        unrecognized: unrecognized(&answer.unrecognized_terms, text),
        prose: answer.prose,
    })
}

/// The terms at their positions in the text. A term that the text does not have covers the whole text.
fn unrecognized(terms: &[String], text: &str) -> Vec<Unrecognized> {
    let lower = text.to_lowercase();
    // The positions are those of the text only if letters keep their length.
    let searchable = if lower.len() == text.len() { lower.as_str() } else { text };
    let mut parts: Vec<Unrecognized> = terms
        .iter()
        .map(|term| {
            let found =
                searchable.find(&term.to_lowercase()).map(|start| (start, start + term.to_lowercase().len()));
            let (start, end) =
                found.filter(|(start, end)| text.get(*start..*end).is_some()).unwrap_or((0, text.len()));
            let words = if found.is_some() { text[start..end].to_owned() } else { term.clone() };
            Unrecognized {
                span: TextSpan { start, end, text: words },
                reason: UnrecognizedReason::UnknownObject,
                nearest_by_spelling: None,
                nearest_by_meaning: None,
            }
        })
        .collect();
    parts.sort_by_key(|part| part.span.start);
    parts
}

/// The table: values of the request override those of the answer.
fn table_of(answer: &AnswerTable, wanted: &TableSpec, complaints: &mut Complaints) -> TableSpec {
    check_extents("table", answer.extents, TABLE_M, complaints);
    let fits = |shape: TableShape, name: &str| {
        table_models().iter().any(|model| model.name == name && shape_of(model.shape) == shape)
    };
    let model = wanted.model.clone().unwrap_or_else(|| answer.model.clone());
    let known = table_models().iter().find(|known| known.name == model);
    if known.is_none() {
        complaints.add("table.model must be one of the given words");
    }
    if let (Some(shape), None) = (wanted.shape, &wanted.model)
        && !fits(shape, &answer.model)
    {
        complaints.add(format!("table.model must be a {} one, as the request says", json!(shape)));
    }
    if answer.material.as_deref().is_some_and(|name| !TABLE_MATERIALS.contains(&name)) {
        complaints.add("table.material must be one of the given words, or null");
    }
    if let Some(color) = &answer.color {
        complaints.plain("table.color", color, 40);
    }
    TableSpec {
        shape: known.map(|model| shape_of(model.shape)).or(wanted.shape),
        size_m: wanted.size_m.or(Some(answer.extents.size_m())),
        model: Some(model),
        material: wanted.material.clone().or_else(|| answer.material.clone()),
        color: wanted.color.clone().or_else(|| answer.color.clone()),
    }
}

fn objects_of(answers: &[AnswerObject], seed: u64, complaints: &mut Complaints) -> Vec<ObjectSpec> {
    let places = complaints.names(answers.iter().map(|object| object.name.as_str()));
    let kinds: Vec<Option<ObjectKind>> = answers.iter().map(|answer| object_kind(&answer.category)).collect();
    let ids = numbered(kinds.iter().map(|kind| kind.as_ref().map_or("object", ObjectKind::stem)));
    let mut carried: Vec<Option<usize>> = vec![None; answers.len()];
    let mut objects = Vec::with_capacity(answers.len());
    for (index, (answer, kind)) in answers.iter().zip(kinds).enumerate() {
        let at = format!("objects[{index}]");
        complaints.label(&format!("{at}.label"), &answer.label);
        check_extents(&at, answer.extents, [OBJECT_M; 3], complaints);
        let Some(kind) = kind else {
            complaints.add(format!(
                "{at}.category is no known object for a table: say a commoner noun or leave it out"
            ));
            continue;
        };
        let (stand_in, substance) = kind.stand_in.unzip();
        check_material(&at, answer.material.as_deref(), complaints);
        let mut relations: Vec<Relation> = Vec::new();
        for AnswerRelation { kind, target } in &answer.relations {
            let place = target.as_deref().map(|name| places.get(name).copied());
            match place {
                Some(None) => {
                    complaints.add(format!("{at}.relations name a target that is no object's name"))
                }
                Some(Some(to)) if to == index => {
                    complaints.add(format!("{at} is related to itself"));
                }
                _ => {}
            }
            let place = place.flatten();
            let of_the_table = matches!(
                kind,
                RelationKind::AtCenter
                    | RelationKind::AtBack
                    | RelationKind::AtFront
                    | RelationKind::AtLeft
                    | RelationKind::AtRight
            );
            // A support without a target is the table, which is the default.
            if kind.is_support() && target.is_none() {
                continue;
            }
            if of_the_table != target.is_none() {
                complaints.add(format!("{at}.relations: {} has the wrong target", json!(kind)));
            }
            if kind.is_support() && carried[index].is_some() {
                complaints.add(format!("{at} stands on or in two objects"));
            }
            if kind.is_support() {
                carried[index] = place;
            }
            let relation = Relation::new(*kind, place.map(|to| ids[to].clone()));
            if !relations.contains(&relation) {
                relations.push(relation);
            }
        }
        objects.push(ObjectSpec {
            id: ids[index].clone(),
            label: answer.label.trim().to_owned(),
            category: kind.category.name.clone(),
            size_m: answer.extents.size_m(),
            color: complaints.color(&format!("{at}.color"), answer.color.as_deref()),
            material: answer.material.clone().or_else(|| substance.map(str::to_owned)),
            seed: child_seed(seed, ids[index].as_str()) & MAX_SEED,
            requested: answer.requested,
            stand_in,
            pose: RequestedPose::Upright,
            yaw_rad: None,
            position_m: None,
            state: None,
            mass_kg: None,
            relations,
        });
    }
    for index in cyclic(&carried) {
        complaints.add(format!("objects[{index}] stands, in the end, on itself"));
    }
    objects
}

/// A numbered id for each object of these kinds: `mug_1`, `mug_2`.
pub(super) fn numbered<'a>(kinds: impl Iterator<Item = &'a str>) -> Vec<InstanceId> {
    numbered_beside(&[], kinds)
}

/// Numbered ids of objects, none of which is one of `taken`.
pub(super) fn numbered_beside<'a>(
    taken: &[InstanceId],
    kinds: impl Iterator<Item = &'a str>,
) -> Vec<InstanceId> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    kinds
        .map(|kind| {
            // Different kinds can give the same stem.
            let stem = InstanceId::numbered(kind, 0);
            let count = counts.entry(stem.as_str().to_owned()).or_default();
            loop {
                *count += 1;
                let id = InstanceId::numbered(kind, *count);
                if !taken.contains(&id) {
                    break id;
                }
            }
        })
        .collect()
}

pub(super) fn check_extents(at: &str, extents: Extents, ranges: [[f64; 2]; 3], complaints: &mut Complaints) {
    let DVec3 { x, y, z } = extents.size_m();
    let names = ["width_m", "depth_m", "height_m"];
    for ((name, value), [low, high]) in names.into_iter().zip([x, y, z]).zip(ranges) {
        complaints.range(&format!("{at}.{name}"), value, low, high);
    }
}

pub(super) fn check_material(at: &str, material: Option<&str>, complaints: &mut Complaints) {
    if material.is_some_and(|name| substance(name).is_none()) {
        complaints.add(format!("{at}.material must be one of the given words, or null"));
    }
}

/// The shape of a catalog's shape name.
pub(super) fn shape_of(word: &str) -> TableShape {
    match word {
        "square" => TableShape::Square,
        "round" => TableShape::Round,
        "oval" => TableShape::Oval,
        "triangular" => TableShape::Triangular,
        "irregular" => TableShape::Irregular,
        _ => TableShape::Rectangular,
    }
}

#[cfg(test)]
mod tests;
