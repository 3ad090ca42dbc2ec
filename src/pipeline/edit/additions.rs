//! Objects that operations add: made by the ordinary stages from a text that lists only them, without a layout.

use std::sync::Arc;

use serde::Serialize;

use super::{Additions, refused};
use crate::pipeline::checkpoint::Checkpoints;
use crate::pipeline::composition::Composition;
use crate::pipeline::error::StageError;
use crate::pipeline::resources::StageResources;
use crate::pipeline::{
    PreparedObjects, Settings, canonicalize, decompose, prepare_objects_with, reconstruct, rotate,
};
use runtime::seed::child_seed;
use scene::request::{OnUnknown, RequestOptions};
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
    let mut additions = Additions::new();
    let (text, lines) = listed(operations);
    if !lines.is_empty() {
        let objects = prepare_objects_with(asked(request, "add", text), stages.clone(), settings.clone()).await?;
        for line in lines {
            let made = of_line(&objects, &line, &operations[line.index])?;
            additions.insert(line.index, made);
        }
    }
    for (index, operation) in operations.iter().enumerate() {
        let EditOperation::Clutter { count, theme } = operation else { continue };
        let theme = theme.clone().unwrap_or_else(|| theme_of(parent));
        let mut cluttered = asked(request, &format!("clutter {index}"), theme);
        cluttered.options.max_objects = Some(64);
        let objects = prepare_objects_with(cluttered, stages.clone(), settings.clone()).await?;
        let count = *count as usize;
        let mut made: Vec<NewObject> = (0..objects.recognition.objects.len()).map(|k| new(&objects, k)).collect();
        if made.len() < count {
            let have = made.len();
            return Err(refused(index, operation, format!("the theme has {have} objects, not {count}")));
        }
        // Small ones, which find room.
        made.sort_by(|a, b| footprint_m2(a).total_cmp(&footprint_m2(b)));
        made.truncate(count);
        additions.insert(index, made);
    }
    Ok(additions)
}

fn footprint_m2(object: &NewObject) -> f64 {
    object.canonical.size_m.x * object.canonical.size_m.y
}

/// A request for objects alone.
fn asked(request: &SceneRequest, purpose: &str, text: String) -> SceneRequest {
    let options = &request.options;
    SceneRequest {
        version: SceneRequest::VERSION,
        input: Input::Text { text },
        seed: child_seed(request.seed, purpose) & scene::request::MAX_SEED,
        options: RequestOptions {
            on_unknown: Some(options.on_unknown.unwrap_or(OnUnknown::StandIn)),
            set: options.set.clone(),
            ..RequestOptions::default()
        },
    }
}

/// What the parent's text says the table is for; of an image, its table.
fn theme_of(parent: &Composition) -> String {
    let themes = parent.account.iter().flat_map(|account| &account.understood);
    let theme = themes.clone().find_map(|understood| match &understood.meaning {
        TextMeaning::Theme { theme } => Some(theme.replace('_', " ")),
        _ => None,
    });
    theme.unwrap_or_else(|| "a cluttered office desk".to_owned())
}

/// A text with one line per operation that adds objects.
fn listed(operations: &[EditOperation]) -> (String, Vec<Line>) {
    let (mut text, mut lines) = (String::new(), Vec::new());
    for (index, operation) in operations.iter().enumerate() {
        let (phrase, count) = match operation {
            EditOperation::Add { object, count, .. } => (object, *count as usize),
            EditOperation::Replace { object, .. } => (object, 1),
            _ => continue,
        };
        if !text.is_empty() {
            text.push_str(", ");
        }
        let start = text.len();
        text.push_str(&counted(phrase, count));
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
        [] => format!("its phrase gives {} objects, not {}; name one kind of object", made.len(), line.count),
        words => format!("{:?} is not understood; name another object", words.join(" ")),
    };
    Err(refused(line.index, operation, why))
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
        ];
        let (text, lines) = listed(&operations);
        assert_eq!(text, "one red mug, 2 fork, one apple");
        let found: Vec<(usize, &str)> =
            lines.iter().map(|line| (line.index, &text[line.start..line.end])).collect();
        assert_eq!(found, [(0, "one red mug"), (2, "2 fork"), (3, "one apple")]);
    }
}
