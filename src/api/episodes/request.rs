//! Parameters of `/episodes`.

use serde::Deserialize;

use store::recordings::RecordingState;

/// State that a list is filtered by.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "String")]
pub(super) struct StateFilter(pub(super) RecordingState);

impl TryFrom<String> for StateFilter {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        RecordingState::parse(&text).map(Self).ok_or("must be queued, running, finished, failed or cancelled")
    }
}
