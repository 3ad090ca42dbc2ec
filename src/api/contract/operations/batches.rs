//! Operations of the tag `batches`: many requests for scenes that are submitted together.

use super::super::operation::Operation;
use crate::api::batches::BatchPage;
use crate::api::batches::views::BatchView;
use crate::schemas::batches::BatchRecipe;
use crate::schemas::batches::BatchRequestLine;
use crate::schemas::batches::BatchResult;
use crate::schemas::values::Bytes;

/// `GET /batches`.
pub fn list_batches(operation: &mut Operation<'_>) {
    operation.is("batches", "listBatches", "Batches, newest first.");
    operation.answers::<BatchPage>(200, "A page.");
}

/// `POST /batches`.
pub fn submit_batch(operation: &mut Operation<'_>) {
    operation.is("batches", "submitBatch", "Submit many requests for scenes, as JSON lines or as a recipe.");
    operation.reads::<BatchRecipe>("application/json");
    let recipe = r#"{"templates": ["A desk with a {color} mug and two {item}"],
        "slots": {"color": ["red", "blue"], "item": ["spoons", "forks"]}, "seeds": {"first": 0, "count": 10}}"#;
    operation.shows("application/json", recipe);
    operation.reads::<Bytes>("application/jsonl");
    operation.reads::<Bytes>("application/x-ndjson");
    operation.mentions::<BatchRequestLine, BatchResult>();
    operation.explain(
        "A body of lines has one `BatchRequestLine` per line. A line that will not do is listed \
         with its number among the errors, and the others are made. Requests for the same scene are found \
         before anything is computed; the scene is made once. Requests enter the queue a few at a time.",
    );
    operation.answers::<BatchView>(202, "Accepted; requests wait or are worked on.");
    operation.locates();
    operation.links("batch", "getBatch", &[("batch_id", "$response.body#/id")]);
    operation.links("output", "getBatchOutput", &[("batch_id", "$response.body#/id")]);
    operation.links("errors", "getBatchErrors", &[("batch_id", "$response.body#/id")]);
    operation.links("cancellation", "cancelBatch", &[("batch_id", "$response.body#/id")]);
    operation.links("retry", "retryBatch", &[("batch_id", "$response.body#/id")]);
    operation.links("jobs", "listJobs", &[("batch", "$response.body#/id")]);
    operation.links("deletion", "deleteBatch", &[("batch_id", "$response.body#/id")]);
    operation.refuses(&[410, 507]);
}

/// `GET /batches/{batch_id}`.
pub fn get_batch(operation: &mut Operation<'_>) {
    operation.is(
        "batches",
        "getBatch",
        "The batch, how far it is, when it is likely to end, and what it has cost.",
    );
    operation.answers::<BatchView>(200, "The batch.");
    operation.refuses(&[410]);
}

/// `DELETE /batches/{batch_id}`.
pub fn delete_batch(operation: &mut Operation<'_>) {
    operation.is(
        "batches",
        "deleteBatch",
        "Delete the batch with its requests and results, and cancel what has not ended; deleting twice is fine.",
    );
    operation.explain(
        "Its scenes stay unless `scenes` says `delete`; then they are deleted a few at a time, before the answer.",
    );
    operation.answers_nothing(204, "Deleted.");
}

/// `GET /batches/{batch_id}/output`.
pub fn get_batch_output(operation: &mut Operation<'_>) {
    operation.is(
        "batches",
        "getBatchOutput",
        "Results of requests with a scene, one JSON object per line, in the order of the requests.",
    );
    operation.explain(
        "Also while the batch runs; then those that have ended so far. Duplicates name the \
         request that has their scene.",
    );
    operation.answers_file(
        200,
        "Lines of `BatchResult`; as `application/octet-stream` for clients that accept only that.",
        &["application/jsonl", "application/octet-stream"],
    );
    operation.refuses(&[410]);
}

/// `GET /batches/{batch_id}/errors`.
pub fn get_batch_errors(operation: &mut Operation<'_>) {
    operation.is(
        "batches",
        "getBatchErrors",
        "Results of requests without a scene, one JSON object per line, in the order of the requests.",
    );
    operation.explain(
        "Also while the batch runs. Lines that could not be read have their number, column and pointer.",
    );
    operation.answers_file(
        200,
        "Lines of `BatchResult`; as `application/octet-stream` for clients that accept only that.",
        &["application/jsonl", "application/octet-stream"],
    );
    operation.refuses(&[410]);
}

/// `POST /batches/{batch_id}/cancel`.
pub fn cancel_batch(operation: &mut Operation<'_>) {
    operation.is("batches", "cancelBatch", "Cancel what has not ended; results so far stay.");
    operation.answers::<BatchView>(202, "Cancelling; requests that run stop at their next step.");
    operation.locates();
    operation.refuses(&[409, 410]);
}

/// `POST /batches/{batch_id}/retry`.
pub fn retry_batch(operation: &mut Operation<'_>) {
    operation.is(
        "batches",
        "retryBatch",
        "Make the scenes of requests that failed or were cancelled; finished stages are reused.",
    );
    operation.answers::<BatchView>(202, "These requests wait again.");
    operation.locates();
    operation.refuses(&[409, 410, 507]);
}
