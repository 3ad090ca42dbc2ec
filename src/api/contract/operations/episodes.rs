//! Operations of the tag `episodes`: demonstrations of robots in a finished scene, recorded as datasets for policies.

use super::super::operation::Operation;
use crate::api::episodes::RecordingPage;
use crate::api::episodes::download::RecordingFilePage;
use crate::api::episodes::views::RecordingView;
use crate::api::events::content::RecordingEventPage;
use crate::schemas::values::PathText;
use crate::schemas::words::EpisodeFormat;

/// `POST /scenes/{scene_id}/episodes`.
pub fn submit_episodes(operation: &mut Operation<'_>) {
    operation.is(
        "episodes",
        "submitEpisodes",
        "Record demonstrations of tasks in the finished scene as a dataset, in the background.",
    );
    operation.explain(
        "Attempts are made until so many have succeeded, by all processes that work. The same \
         scene and order give the same dataset, to the byte. What the robot cannot do is found when the work \
         begins, and fails the recording.",
    );
    operation.answers::<RecordingView>(202, "Accepted; it waits or is being recorded.");
    operation.locates();
    operation.links("recording", "getEpisodes", &[("recording_id", "$response.body#/id")]);
    operation.links("events", "listEpisodeEvents", &[("recording_id", "$response.body#/id")]);
    operation.links("files", "listEpisodeFiles", &[("recording_id", "$response.body#/id")]);
    operation.links(
        "archive",
        "getEpisodeArchive",
        &[("recording_id", "$response.body#/id"), ("format", "$response.body#/order/formats/0")],
    );
    operation.links("cancellation", "cancelEpisodes", &[("recording_id", "$response.body#/id")]);
    operation.links("deletion", "deleteEpisodes", &[("recording_id", "$response.body#/id")]);
    operation.refuses(&[409, 410, 507]);
}

/// `GET /episodes`.
pub fn list_episodes(operation: &mut Operation<'_>) {
    operation.is("episodes", "listEpisodes", "Recordings of episodes, newest first.");
    operation.answers::<RecordingPage>(200, "A page.");
}

/// `GET /episodes/{recording_id}`.
pub fn get_episodes(operation: &mut Operation<'_>) {
    operation.is(
        "episodes",
        "getEpisodes",
        "The recording, how far it is, how attempts ended, and its dataset.",
    );
    operation.answers::<RecordingView>(200, "The recording.");
    operation.refuses(&[410]);
}

/// `DELETE /episodes/{recording_id}`.
pub fn delete_episodes(operation: &mut Operation<'_>) {
    operation.is(
        "episodes",
        "deleteEpisodes",
        "Delete the recording with its dataset and its events, and cancel it if it has not ended; deleting twice is fine.",
    );
    operation.answers_nothing(204, "Deleted.");
}

/// `GET /episodes/{recording_id}/events`.
pub fn list_episode_events(operation: &mut Operation<'_>) {
    operation.is(
        "episodes",
        "listEpisodeEvents",
        "Events of the recording, as a page or (with `Accept text/event-stream`) as they happen.",
    );
    operation.resumes();
    operation
        .answers::<RecordingEventPage>(200, "Events in order. A stream ends when the recording has ended.");
    operation.streams("Events in order. A stream ends when the recording has ended.", "a RecordingEvent");
    operation
        .answers_nothing(204, "Streams only: the recording has ended and the client has seen everything.");
    operation.refuses(&[410]);
}

/// `POST /episodes/{recording_id}/cancel`.
pub fn cancel_episodes(operation: &mut Operation<'_>) {
    operation.is(
        "episodes",
        "cancelEpisodes",
        "Cancel a recording that has not ended; its episodes so far are dropped.",
    );
    operation.answers::<RecordingView>(202, "Cancelled; attempts that have begun are finished and dropped.");
    operation.locates();
    operation.refuses(&[409, 410]);
}

/// `GET /episodes/{recording_id}/files`.
pub fn list_episode_files(operation: &mut Operation<'_>) {
    operation.is("episodes", "listEpisodeFiles", "The files of a recorded dataset.");
    operation.answers::<RecordingFilePage>(200, "A page, by format and path.");
    operation.refuses(&[409, 410]);
}

/// `GET /episodes/{recording_id}/files/{name}`.
pub fn get_episode_file(operation: &mut Operation<'_>) {
    operation.is("episodes", "getEpisodeFile", "A file of a recorded dataset; its bytes never change.");
    operation.path_parameter::<PathText>(
        "name",
        "The path of the file, which begins with its format.",
        "robomimic/dataset.hdf5",
    );
    operation.downloads(
        "The bytes; as `application/octet-stream` for clients that accept only that.",
        &["application/json", "application/jsonl", "text/markdown", "image/png", "video/mp4"],
    );
    operation.refuses(&[409, 410]);
}

/// `GET /episodes/{recording_id}/archives/{format}`.
pub fn get_episode_archive(operation: &mut Operation<'_>) {
    operation.is(
        "episodes",
        "getEpisodeArchive",
        "All files of a format as one tar archive; its bytes never change.",
    );
    operation.path_parameter::<EpisodeFormat>("format", "", "");
    operation.downloads(
        "The bytes; as `application/octet-stream` for clients that accept only that.",
        &["application/x-tar"],
    );
    operation.refuses(&[409, 410]);
}
