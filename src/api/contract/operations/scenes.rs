//! Operations of the tag `scenes`: scenes, their bundles and their artifacts.

use super::super::operation::Operation;
use crate::api::artifacts::ArtifactList;
use crate::api::edits::ValidatedEdit;
use crate::api::extract::JsonRequest;
use crate::api::files::BundleFileList;
use crate::api::lineage::Lineage;
use crate::api::scene_body::SceneBody;
use crate::api::scene_body::SceneForm;
use crate::api::scene_body::SceneSubmission;
use crate::api::scenes::SceneFacets;
use crate::api::scenes::ScenePage;
use crate::api::scenes::Validated;
use crate::api::variants::ValidatedVariants;
use crate::api::variants::VariantsView;
use crate::api::views::JobView;
use crate::api::views::SceneView;
use crate::app::tasks::SceneTasks;
use crate::schemas::executions::ExecutedTask;
use crate::schemas::values::Id;
use crate::schemas::values::PathText;

/// `GET /scenes`.
pub fn list_scenes(operation: &mut Operation<'_>) {
    operation.is(
        "scenes",
        "listScenes",
        "Scenes, newest first unless `sort` says otherwise, each with its newest job.",
    );
    operation.answers::<ScenePage>(200, "A page.");
}

/// `GET /scenes/facets`.
pub fn count_scenes(operation: &mut Operation<'_>) {
    operation.is(
        "scenes",
        "countScenes",
        "How many scenes a filter leaves, by what they can be filtered by.",
    );
    operation.answers::<SceneFacets>(200, "The numbers.");
}

/// `POST /scenes`.
pub fn submit_scene(operation: &mut Operation<'_>) {
    operation.is("scenes", "submitScene", "Submit a text or an image; a job makes the scene.");
    operation.reads::<SceneSubmission>("application/json");
    operation.shows("application/json", SceneBody::EXAMPLE);
    operation.reads::<SceneForm>("multipart/form-data");
    let parts = [("image", "image/png, image/jpeg, image/webp"), ("request", "application/json")];
    operation.encodes("multipart/form-data", &parts);
    operation.answers::<SceneView>(202, "Accepted; not finished yet, or no wait was asked for.");
    operation.locates();
    operation.applies_preference();
    operation.links("scene", "getScene", &[("scene_id", "$response.body#/id")]);
    operation.links("bundle", "getBundle", &[("scene_id", "$response.body#/id")]);
    operation.links("artifacts", "listArtifacts", &[("scene_id", "$response.body#/id")]);
    operation.links("edit", "editScene", &[("scene_id", "$response.body#/id")]);
    operation.links("lineage", "getLineage", &[("scene_id", "$response.body#/id")]);
    operation.links("deletion", "deleteScene", &[("scene_id", "$response.body#/id")]);
    operation.links("job", "getJob", &[("job_id", "$response.body#/job/id")]);
    operation.links("stages", "listStages", &[("job_id", "$response.body#/job/id")]);
    operation.links("events", "listEvents", &[("job_id", "$response.body#/job/id")]);
    operation.links("cancellation", "cancelJob", &[("job_id", "$response.body#/job/id")]);
    operation.links("retry", "retryJob", &[("job_id", "$response.body#/job/id")]);
    operation.links("jobs", "listJobs", &[("scene", "$response.body#/id")]);
    operation.answers::<SceneView>(200, "With `Prefer wait`, the scene whose job has ended.");
    operation.locates();
    operation.applies_preference();
    operation.refuses(&[410, 507]);
}

/// `POST /scenes/validate`.
pub fn validate_scene(operation: &mut Operation<'_>) {
    let summary = "Check a request for a scene as if it were submitted; nothing is enqueued.";
    operation.is("scenes", "validateScene", summary);
    operation.answers::<Validated>(200, "The request as understood.");
}

/// `GET /scenes/{scene_id}`.
pub fn get_scene(operation: &mut Operation<'_>) {
    operation.is(
        "scenes",
        "getScene",
        "The scene with its newest job, that job's stages, and the artifacts.",
    );
    operation.answers::<SceneView>(200, "The scene.");
    operation.tags();
    operation.refuses(&[410]);
}

/// `PATCH /scenes/{scene_id}`.
pub fn change_scene(operation: &mut Operation<'_>) {
    operation.is("scenes", "changeScene", "Change labels of the scene by a JSON merge patch (RFC 7396).");
    operation.explain(
        "A label that the patch names gets its value, or goes where that is null; the others stay. Lists and \
         datasets find the scene by its new labels. Labels are those of a submission: at most 32.",
    );
    operation.answers::<SceneView>(200, "The scene after the change.");
    operation.tags();
    operation.refuses(&[410]);
}

/// `DELETE /scenes/{scene_id}`.
pub fn delete_scene(operation: &mut Operation<'_>) {
    operation.is(
        "scenes",
        "deleteScene",
        "Delete the scene and cancel what is being done to it; deleting twice is fine.",
    );
    operation.answers_nothing(204, "Deleted.");
}

/// `GET /scenes/{scene_id}/bundle`.
pub fn get_bundle(operation: &mut Operation<'_>) {
    operation.is("scenes", "getBundle", "The finished scene as a zip; bytes never change under this URL.");
    operation.explain("In it, `report.html` tells people and `report.json` programs (by `report.schema.json`) \
         what was measured, against which thresholds, and why the scene may be used or not; `README.md` has a \
         few lines for each simulator.");
    operation.downloads(
        "The archive; as `application/octet-stream` for clients that accept only that.",
        &["application/zip"],
    );
    operation.refuses(&[409, 410]);
}

/// `GET /scenes/{scene_id}/files`.
pub fn list_files(operation: &mut Operation<'_>) {
    operation.is("scenes", "listFiles", "The files of the bundle.");
    operation.answers::<BundleFileList>(200, "The files by name.");
    operation.links(
        "first",
        "getFile",
        &[("scene_id", "$request.path.scene_id"), ("name", "$response.body#/files/0/name")],
    );
    operation.refuses(&[409, 410]);
}

/// `GET /scenes/{scene_id}/files/{name}`.
pub fn get_file(operation: &mut Operation<'_>) {
    operation.is("scenes", "getFile", "One file of the bundle.");
    let description = "The file's name, slashes included; they may be percent-encoded.";
    operation.path_parameter::<PathText>("name", description, "scene.json");
    operation.downloads(
        "Bytes of the file, in its media type; as `application/octet-stream` for clients that accept only that.",
        &["application/json", "*/*"],
    );
    operation.refuses(&[409, 410]);
}

/// `GET /scenes/{scene_id}/preview`.
pub fn get_preview(operation: &mut Operation<'_>) {
    operation.is("scenes", "getPreview", "A small image of the finished scene, also of one in quarantine.");
    operation.explain("404 where the scene has no render, or none yet.");
    operation.downloads("The image.", &["image/jpeg"]);
    operation.refuses(&[410]);
}

/// `POST /scenes/{scene_id}/edits`.
pub fn edit_scene(operation: &mut Operation<'_>) {
    let summary = "A new scene, made from this one by operations or by an instruction in words; this one stays as it is.";
    operation.is("scenes", "editScene", summary);
    operation.explain(
        "Operations are carried out in order; a later one sees the result of the earlier ones. \
         Objects that they do not name keep their exact poses unless they must move, and the report of the \
         new scene states why one moved. What cannot be done without a collision fails the job with the \
         reason.",
    );
    operation.answers::<SceneView>(202, "Accepted; not finished yet, or no wait was asked for.");
    operation.locates();
    operation.applies_preference();
    operation.links("scene", "getScene", &[("scene_id", "$response.body#/id")]);
    operation.links("lineage", "getLineage", &[("scene_id", "$response.body#/id")]);
    operation.links("job", "getJob", &[("job_id", "$response.body#/job/id")]);
    operation.answers::<SceneView>(200, "With `Prefer wait`, the scene whose job has ended.");
    operation.locates();
    operation.applies_preference();
    operation.refuses(&[409, 410, 507]);
}

/// `POST /scenes/{scene_id}/edits/validate`.
pub fn validate_edit(operation: &mut Operation<'_>) {
    let summary = "Check an edit as if it were submitted, and predict its result; nothing is enqueued.";
    operation.is("scenes", "validateEdit", summary);
    operation.answers::<ValidatedEdit>(200, "The request as understood.");
    operation.refuses(&[409, 410]);
}

/// `POST /scenes/{scene_id}/variants`.
pub fn make_variants(operation: &mut Operation<'_>) {
    operation.is(
        "scenes",
        "makeVariants",
        "Several new scenes, made from this one by operations that seeds draw; this one stays as it is.",
    );
    operation.explain(
        "Every variant is a scene with its own job, certified like any other. What a text \
         states of an object holds in every variant. An operation that a scene has no room for is left out, \
         and the account of the scene says so.",
    );
    operation.answers::<VariantsView>(
        202,
        "Accepted. Where the queue has room for some only, `remaining` counts the others.",
    );
    operation.refuses(&[409, 410, 507]);
}

/// `POST /scenes/{scene_id}/variants/validate`.
pub fn validate_variants(operation: &mut Operation<'_>) {
    let summary = "Check a request for variants as if it were submitted; nothing is enqueued.";
    operation.is("scenes", "validateVariants", summary);
    operation.answers::<ValidatedVariants>(200, "The requests as understood.");
    operation.refuses(&[409, 410]);
}

/// `GET /scenes/{scene_id}/lineage`.
pub fn get_lineage(operation: &mut Operation<'_>) {
    operation.is(
        "scenes",
        "getLineage",
        "Parent and edits of the scene, and the scenes that were made from it.",
    );
    operation.answers::<Lineage>(200, "The lineage.");
    operation.refuses(&[410]);
}

/// `GET /scenes/{scene_id}/tasks`.
pub fn list_tasks(operation: &mut Operation<'_>) {
    operation.is(
        "scenes",
        "listTasks",
        "Tasks that a robot could do in the finished scene, or the task of an instruction.",
    );
    operation.answers::<SceneTasks>(200, "The tasks.");
    operation.refuses(&[409, 410, 422]);
}

/// `POST /scenes/{scene_id}/executions`.
pub fn execute_task(operation: &mut Operation<'_>) {
    operation.is(
        "scenes",
        "executeTask",
        "A simulated robot does a task in the finished scene, and the goal's predicates decide.",
    );
    operation.explain(
        "An execution is a job of the kind `execute_task`, with its events, cancellation and \
         retries, and takes seconds to a minute. The answer is 202 with the job, whose id is that of the \
         execution; with `Prefer: wait=N`, 200 with the execution if it ends in time. The same scene, task, \
         robot and seed give the same bytes again.",
    );
    operation.answers::<ExecutedTask>(200, "The execution, done or failed; only with `Prefer`.");
    operation.answers_file(200, "The execution, done or failed; only with `Prefer`.", &["application/zip"]);
    operation.applies_preference();
    operation.answers::<JobView>(202, "Accepted; the job waits or runs.");
    operation.locates();
    operation.links("job", "getJob", &[("job_id", "$response.body#/id")]);
    operation.links("execution", "getExecution", &[("execution_id", "$response.body#/id")]);
    operation.refuses(&[409, 410, 507]);
}

/// `GET /scenes/{scene_id}/artifacts`.
pub fn list_artifacts(operation: &mut Operation<'_>) {
    operation.is(
        "scenes",
        "listArtifacts",
        "Artifacts of every finished stage, also while the job is running.",
    );
    operation.answers::<ArtifactList>(200, "The artifacts by name.");
    operation.links(
        "first",
        "getArtifact",
        &[("scene_id", "$request.path.scene_id"), ("name", "$response.body#/artifacts/0/name")],
    );
    operation.refuses(&[410]);
}

/// `GET /scenes/{scene_id}/artifacts/{name}`.
pub fn get_artifact(operation: &mut Operation<'_>) {
    operation.is("scenes", "getArtifact", "One artifact.");
    operation.path_parameter::<PathText>(
        "name",
        "The artifact's name, slashes included; they may be percent-encoded.",
        "reference/known.json",
    );
    operation.downloads(
        "Bytes of the artifact, in its media type; as `application/octet-stream` for clients \
         that accept only that.",
        &["application/json", "*/*"],
    );
    operation.refuses(&[410]);
}

/// `GET /executions/{execution_id}`.
pub fn get_execution(operation: &mut Operation<'_>) {
    operation.is("scenes", "getExecution", "The answer of an execution that has ended.");
    operation.explain("The document or the files that were asked for, with a strong `ETag`. An execution that \
         was not attempted is answered with the problem of its task, one that has not ended with 409. Answers \
         stay for `store.retention.intermediate_hours`.");
    operation.path_parameter::<Id>("execution_id", "The id of the execution, which is that of its job.", "");
    operation.answers::<ExecutedTask>(200, "The execution, done or failed.");
    operation.downloads("The execution, done or failed.", &["application/json", "application/zip"]);
    operation.refuses(&[409, 410, 422]);
}
