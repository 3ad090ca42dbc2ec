//! Objects that operations add: made by the ordinary stages from a text that lists only them, without a layout.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;

use super::error::EditError;
use super::{Additions, landmarks, refused, variation};
use crate::pipeline::checkpoint::{Checkpoints, Stage};
use crate::pipeline::composition::Composition;
use crate::pipeline::error::StageError;
use crate::pipeline::resources::StageResources;
use crate::pipeline::{
    Context, PreparedObjects, Settings, canonicalize, decompose, prepare_objects_alone, reconstruct, rotate,
};
use ports::Adapter;
use runtime::seed::child_seed;
use scene::request::{MAX_SEED, OnUnknown, RequestOptions};
use scene::text_account::TextMeaning;
use scene::{EditOperation, Input, InstanceId, RecognizedObject, SceneRequest};

/// One object that was made for an operation.
#[derive(Clone, Serialize)]
pub struct NewObject {
    pub recognized: RecognizedObject,
    pub raw: reconstruct::Output,
    pub canonical: canonicalize::Output,
    pub hulls: decompose::Output,
    pub yaw: rotate::Output,
}

/// A line of the text that lists new objects.
struct Line {
    /// Of the operation.
    index: usize,
    start: usize,
    end: usize,
    count: usize,
}

/// The objects that the operations add.
///
/// # Errors
///
/// `edit_refused` for a phrase of which no object can be made; the error of a stage that fails.
pub(super) async fn make(
    request: &SceneRequest,
    operations: &[EditOperation],
    parent: &Composition,
    stages: &Checkpoints<StageResources>,
    settings: &Arc<Settings>,
) -> Result<Additions, StageError> {
    let themes = themes(request, operations, parent, stages).await?;
    let (text, lines) = {
        let parents = Parents {
            same_kind: &|target| variation::phrase_of(parent, target),
            number: &|phrase| landmarks::count(parent, phrase),
        };
        listed(operations, &themes, &parents)
    };
    let mut additions = Additions::new();
    if !lines.is_empty() {
        let objects = prepare_objects_alone(asked(request, text), stages.clone(), settings.clone()).await?;
        for line in lines {
            let made = of_line(&objects, &line, &operations[line.index])?;
            additions.insert(line.index, made);
        }
    }
    Ok(additions)
}

/// Inputs of the request for objects of a theme, for an operation that adds clutter.
#[derive(Serialize)]
struct ThemeInputs {
    theme: String,
    count: usize,
    seed: u64,
    analyst: Adapter,
}

const THEME: Stage = Stage { name: "theme", version: 1 };

/// Labels of the objects that clutter adds, by index of the operation.
async fn themes(
    request: &SceneRequest,
    operations: &[EditOperation],
    parent: &Composition,
    stages: &Checkpoints<StageResources>,
) -> Result<BTreeMap<usize, Vec<String>>, StageError> {
    let (mut inputs, mut indices) = (Vec::new(), Vec::new());
    for (index, operation) in operations.iter().enumerate() {
        let EditOperation::Clutter { count, theme } = operation else { continue };
        let id = InstanceId::numbered("clutter", index + 1);
        let theme = theme.clone().unwrap_or_else(|| theme_of(parent));
        let seed = child_seed(request.seed, id.as_str()) & MAX_SEED;
        let analyst = stages.services().ports.analyst.adapter();
        inputs.push((id, ThemeInputs { theme, count: *count as usize, seed, analyst }));
        indices.push(index);
    }
    if inputs.is_empty() {
        return Ok(BTreeMap::new());
    }
    let found = stages.run_each(THEME, inputs, theme).await?;
    let mut themes = BTreeMap::new();
    for (index, labels) in indices.into_iter().zip(found) {
        let EditOperation::Clutter { count, .. } = &operations[index] else { continue };
        if labels.len() < *count as usize {
            let why = EditError::ThemeTooSmall { found: labels.len(), wanted: *count };
            return Err(refused(index, &operations[index], &why));
        }
        themes.insert(index, labels);
    }
    Ok(themes)
}

/// The smallest objects of a theme, which find room.
async fn theme(context: Context, inputs: Arc<ThemeInputs>) -> Result<Vec<String>, StageError> {
    let ports = &context.services().ports;
    let options = RequestOptions::default();
    let described =
        ports.analyst.describe(&context.call(), inputs.theme.clone(), inputs.seed, options).await?;
    let mut objects = described.objects;
    objects.sort_by(|a, b| (a.size_m.x * a.size_m.y).total_cmp(&(b.size_m.x * b.size_m.y)));
    Ok(objects.into_iter().take(inputs.count).map(|object| object.label).collect())
}

/// A request for objects alone.
fn asked(request: &SceneRequest, text: String) -> SceneRequest {
    let options = &request.options;
    let options = RequestOptions {
        on_unknown: Some(options.on_unknown.unwrap_or(OnUnknown::StandIn)),
        set: options.set.clone(),
        ..RequestOptions::default()
    };
    SceneRequest::new(Input::Text { text }, child_seed(request.seed, "add") & MAX_SEED, options)
}

/// Theme that the parent's text states; a default for other scenes.
fn theme_of(parent: &Composition) -> String {
    let themes = parent.account.iter().flat_map(|account| &account.understood);
    let theme = themes.clone().find_map(|understood| match &understood.meaning {
        TextMeaning::Theme { theme } => Some(theme.replace('_', " ")),
        _ => None,
    });
    theme.unwrap_or_else(|| "a cluttered office desk".to_owned())
}

/// Answers about the parent that a list of new objects needs.
struct Parents<'a> {
    /// The phrase of another object like one of the parent.
    same_kind: &'a dyn Fn(&str) -> Option<String>,
    /// The number of objects that a phrase means.
    number: &'a dyn Fn(&str) -> usize,
}

/// A text that lists the objects of every operation that adds some.
fn listed(
    operations: &[EditOperation],
    themes: &BTreeMap<usize, Vec<String>>,
    parents: &Parents,
) -> (String, Vec<Line>) {
    let (mut text, mut lines) = (String::new(), Vec::new());
    for (index, operation) in operations.iter().enumerate() {
        let (phrase, count) = match operation {
            EditOperation::Add { object, count, place } => {
                let landmark = place.as_ref().and_then(|place| place.target.as_deref());
                let count = *count as usize * landmark.map_or(1, parents.number);
                (counted(object, count), count)
            }
            EditOperation::Replace { target, object } => {
                let count = (parents.number)(target);
                (counted(object, count), count)
            }
            EditOperation::Remake { target } => match (parents.same_kind)(target) {
                Some(phrase) => (counted(&phrase, 1), 1),
                None => continue,
            },
            EditOperation::Clutter { .. } => {
                let labels = themes.get(&index).map_or(&[][..], Vec::as_slice);
                let phrases: Vec<String> = labels.iter().map(|label| counted(label, 1)).collect();
                (phrases.join(", "), labels.len())
            }
            _ => continue,
        };
        if !text.is_empty() {
            text.push_str(", ");
        }
        let start = text.len();
        text.push_str(&phrase);
        lines.push(Line { index, start, end: text.len(), count });
    }
    (text, lines)
}

/// "3 red mugs" is the parser's business; the phrase only loses its article.
fn counted(phrase: &str, count: usize) -> String {
    let phrase = phrase.trim().trim_end_matches('.');
    let bare = ["a ", "an ", "one ", "the ", "another "]
        .iter()
        .find_map(|article| {
            let (head, rest) = phrase.split_at_checked(article.len())?;
            head.eq_ignore_ascii_case(article).then_some(rest)
        })
        .unwrap_or(phrase);
    if count == 1 { format!("one {bare}") } else { format!("{count} {bare}") }
}

/// The objects of a line: those that the account of the text finds there; without an account, the next ones in order.
fn of_line(
    objects: &PreparedObjects,
    line: &Line,
    operation: &EditOperation,
) -> Result<Vec<NewObject>, StageError> {
    let understood = objects.account.iter().flat_map(|account| &account.understood);
    let ids: Vec<&InstanceId> = understood
        .filter(|part| part.span.start >= line.start && part.span.end <= line.end)
        .filter_map(|part| match &part.meaning {
            TextMeaning::Object { objects, .. } => Some(objects),
            _ => None,
        })
        .flatten()
        .collect();
    let recognized = &objects.recognition.objects;
    let made: Vec<NewObject> = (0..recognized.len())
        .filter(|index| ids.contains(&&recognized[*index].id))
        .map(|index| new(objects, index))
        .collect();
    if made.len() == line.count {
        return Ok(made);
    }
    let unrecognized = objects.account.iter().flat_map(|account| &account.unrecognized);
    let words: Vec<&str> = unrecognized
        .filter(|part| part.span.start >= line.start && part.span.end <= line.end)
        .map(|part| part.span.text.as_str())
        .collect();
    let why = match words.as_slice() {
        [] => EditError::OtherCount { made: made.len(), wanted: line.count },
        words => EditError::UnknownWords { words: words.join(" ") },
    };
    Err(refused(line.index, operation, &why))
}

fn new(objects: &PreparedObjects, index: usize) -> NewObject {
    NewObject {
        recognized: objects.recognition.objects[index].clone(),
        raw: objects.raw_meshes[index].clone(),
        canonical: objects.canonical_meshes[index].clone(),
        hulls: objects.hulls[index].clone(),
        yaw: objects.yaws[index].clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phrases_of_operations_are_listed_with_their_counts_and_places_in_the_text() {
        let read = |json: &str| serde_json::from_str::<EditOperation>(json).expect(json);
        let operations = [
            read(r#"{"op":"add","object":"a red mug"}"#),
            read(r#"{"op":"remove","target":"lamp"}"#),
            read(r#"{"op":"add","object":"fork","count":2}"#),
            read(r#"{"op":"replace","target":"mug_1","object":"An apple"}"#),
            read(r#"{"op":"clutter","count":2}"#),
            read(r#"{"op":"remake","target":"plate_1"}"#),
        ];
        let themes = BTreeMap::from([(4, vec!["pen".to_owned(), "stapler".to_owned()])]);
        let same_kind = |name: &str| (name == "plate_1").then(|| "blue plate".to_owned());
        let parents = Parents { same_kind: &same_kind, number: &|_| 1 };
        let (text, lines) = listed(&operations, &themes, &parents);
        assert_eq!(text, "one red mug, 2 fork, one apple, one pen, one stapler, one blue plate");
        let found: Vec<(usize, &str)> =
            lines.iter().map(|line| (line.index, &text[line.start..line.end])).collect();
        let expected = [
            (0, "one red mug"),
            (2, "2 fork"),
            (3, "one apple"),
            (4, "one pen, one stapler"),
            (5, "one blue plate"),
        ];
        assert_eq!(found, expected);
    }
}
