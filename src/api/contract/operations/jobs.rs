//! Operations of the tag `jobs`: operations on scenes, their stages and their events.

use super::super::operation::Operation;
use crate::api::events::content::{EventPage, TenantEventPage};
use crate::api::jobs::JobPage;
use crate::api::jobs::StageList;
use crate::api::views::JobView;

/// `GET /jobs`.
pub fn list_jobs(operation: &mut Operation<'_>) {
    operation.is("jobs", "listJobs", "Jobs, newest first.");
    operation.answers::<JobPage>(200, "A page.");
    operation.links("first", "getJob", &[("job_id", "$response.body#/jobs/0/id")]);
}

/// `GET /jobs/{job_id}`.
pub fn get_job(operation: &mut Operation<'_>) {
    operation.is("jobs", "getJob", "Activity of the machine.");
    operation.answers::<JobView>(200, "The job.");
}

/// `GET /jobs/{job_id}/stages`.
pub fn list_stages(operation: &mut Operation<'_>) {
    operation.is("jobs", "listStages", "The job's stages in the order it came to them.");
    operation.answers::<StageList>(200, "The stages.");
}

/// `GET /jobs/{job_id}/events`.
pub fn list_events(operation: &mut Operation<'_>) {
    operation.is(
        "jobs",
        "listEvents",
        "Events of the job, as a page or (with `Accept text/event-stream`) as they happen.",
    );
    operation.resumes();
    operation.answers::<EventPage>(200, "Events in order. A stream ends when the job has ended.");
    operation.streams("Events in order. A stream ends when the job has ended.", "an Event");
    operation.answers_nothing(204, "Streams only: the job has ended and the client has seen everything.");
}

/// `GET /events`.
pub fn list_all_events(operation: &mut Operation<'_>) {
    operation.is(
        "jobs",
        "listAllEvents",
        "Events of all jobs and recordings, as a page or (with `Accept text/event-stream`) as they happen.",
    );
    operation.explain(
        "One stream tells a client of everything: a browser opens few connections to a server. It goes on until the \
         client leaves or it is too old; its first message has an `id` and no event, so that a client that was cut off \
         comes back where it left.",
    );
    operation.resumes();
    operation.answers::<TenantEventPage>(200, "Events in order.");
    operation.streams("Events in order.", "a TenantEvent");
}

/// `POST /jobs/{job_id}/cancel`.
pub fn cancel_job(operation: &mut Operation<'_>) {
    operation.is("jobs", "cancelJob", "Ask the job to stop; asking twice is fine.");
    operation.answers::<JobView>(202, "The job is cancelled, or its worker is letting go of it.");
    operation.links("job", "getJob", &[("job_id", "$response.body#/id")]);
    operation.links("retry", "retryJob", &[("job_id", "$response.body#/id")]);
    operation.refuses(&[409]);
}

/// `POST /jobs/{job_id}/retry`.
pub fn retry_job(operation: &mut Operation<'_>) {
    operation.is(
        "jobs",
        "retryJob",
        "A new job for the scene of an ended one; finished stages are not repeated.",
    );
    operation.answers::<JobView>(202, "The new job.");
    operation.locates();
    operation.links("job", "getJob", &[("job_id", "$response.body#/id")]);
    operation.links("cancellation", "cancelJob", &[("job_id", "$response.body#/id")]);
    operation.refuses(&[409, 507]);
}
