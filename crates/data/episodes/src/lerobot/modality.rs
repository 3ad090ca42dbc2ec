//! `meta/modality.json`, from which GR00T knows the parts of states and actions.

use serde_json::{Map, Value, json};

use crate::dataset_statistics::image_key;
use crate::description::DatasetDescription;
use crate::vector_layout::VectorLayout;

/// The file's content: groups as half-open ranges, cameras, and where the instruction is.
pub(crate) fn modality(description: &DatasetDescription) -> Value {
    let groups = |layout: &VectorLayout| -> Map<String, Value> {
        let part = |range: std::ops::Range<usize>| json!({"start": range.start, "end": range.end});
        layout.groups().into_iter().map(|(group, range)| (group.to_owned(), part(range))).collect()
    };
    let video = |name: &str| (name.to_owned(), json!({"original_key": image_key(name)}));
    json!({
        "state": groups(description.state()),
        "action": groups(description.action()),
        "video": description.cameras().iter().map(|camera| video(&camera.name)).collect::<Map<_, _>>(),
        "annotation": {"human.action.task_description": {"original_key": "task_index"}},
    })
}
