//! The HTTP API as clients see it.

mod submissions;
mod edits;
mod variants;
mod executions;
mod tasks;
mod batches;
mod datasets;
mod episodes;
mod recording_events;
mod listing;
mod documents;
mod downloads;
mod events;
mod slow_clients;
mod rejected_images;
mod damage;
mod retention;
mod limits;
mod deletion;
mod labels;
mod bodies;
mod event_streams;
mod hosts;
mod access;
mod sessions;
