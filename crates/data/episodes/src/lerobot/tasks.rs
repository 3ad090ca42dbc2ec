//! The tasks of a dataset: `meta/tasks.parquet` of v3.0 and `meta/tasks.jsonl` of v2.1.

use std::path::Path;

use serde_json::json;

use crate::EpisodeError;
use crate::parquet_table::{Column, Table, write_table};

/// Writes the table of v3.0. Readers take the instruction from the index of a pandas frame, which the metadata
/// declares.
pub(crate) fn write_tasks_parquet(path: &Path, tasks: &[String]) -> Result<(), EpisodeError> {
    let mut table = Table::default();
    table.push("task_index", Column::Int64((0..tasks.len() as i64).collect()));
    table.push("task", Column::Text(tasks.to_vec()));
    let column = |name: &str, [pandas, numpy]: [&str; 2]| {
        json!({
            "name": name,
            "field_name": name,
            "pandas_type": pandas,
            "numpy_type": numpy,
            "metadata": null,
        })
    };
    let pandas = json!({
        "index_columns": ["task"],
        "column_indexes": [{
            "name": null,
            "field_name": null,
            "pandas_type": "unicode",
            "numpy_type": "object",
            "metadata": {"encoding": "UTF-8"},
        }],
        "columns": [column("task_index", ["int64"; 2]), column("task", ["unicode", "object"])],
        "attributes": {},
        "creator": {"library": "tabletopgen", "version": env!("CARGO_PKG_VERSION")},
        "pandas_version": "2.2.0",
    });
    write_table(path, &table, &[("pandas", pandas.to_string())])
}

/// The lines of v2.1.
pub(crate) fn tasks_jsonl(tasks: &[String]) -> String {
    let line = |(index, task): (usize, &String)| format!("{}\n", json!({"task_index": index, "task": task}));
    tasks.iter().enumerate().map(line).collect()
}
