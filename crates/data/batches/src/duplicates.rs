//! Names that occur twice, and requests that ask for the same scene, found before anything is computed.
//!
//! Memory: some 150 bytes per request, whatever the length of its text.

use std::collections::HashMap;

use super::counts::RequestState;
use super::output::{OutputError, OutputLine};
use super::request::{BatchRequest, RequestDigest};

/// The requests of a batch so far.
#[derive(Debug, Default)]
pub struct Registry {
    /// Names with the line of each.
    names: HashMap<Box<str>, u64>,
    /// The first request for each scene: its line and its name.
    scenes: HashMap<RequestDigest, (u64, Box<str>)>,
}

/// Admission of a request to the computation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Admission {
    /// First request of its name and of its content.
    New,
    /// An earlier request has the name; this one is an error.
    NameTaken {
        /// Line of the earlier request.
        first_place: u64,
    },
    /// An earlier request asks for the same scene.
    Duplicate {
        /// Name of the earlier request.
        first: String,
        /// Line of the earlier request.
        first_place: u64,
    },
}

impl Registry {
    /// Takes the next request, which stands on the line `place`.
    pub fn admit(&mut self, place: u64, request: &BatchRequest) -> Admission {
        if let Some(first_place) = self.names.get(request.custom_id.as_str()) {
            return Admission::NameTaken { first_place: *first_place };
        }
        self.names.insert(request.custom_id.as_str().into(), place);
        let digest = request.body.digest();
        if let Some((first_place, first)) = self.scenes.get(&digest) {
            return Admission::Duplicate { first: first.to_string(), first_place: *first_place };
        }
        self.scenes.insert(digest, (place, request.custom_id.as_str().into()));
        Admission::New
    }

    /// Takes the next request as [`Self::admit`]; the result is its line if it is not computed.
    pub fn refusal(&mut self, place: u64, request: &BatchRequest) -> Option<OutputLine> {
        match self.admit(place, request) {
            Admission::New => None,
            Admission::NameTaken { first_place } => {
                let message = format!(
                    "the custom_id {:?} is used on line {first_place} too; change one",
                    request.custom_id
                );
                let error = OutputError::new("duplicate_custom_id", message).at("/custom_id").on_line(place);
                let custom_id = Some(request.custom_id.clone());
                Some(OutputLine::not_computed(custom_id, RequestState::Invalid, error))
            }
            Admission::Duplicate { first, first_place } => {
                Some(OutputLine::duplicate(request.custom_id.clone(), &first, first_place, place))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::request::RequestBody;

    fn request(custom_id: &str, text: &str, seed: u64) -> BatchRequest {
        let body = RequestBody { text: Some(text.into()), seed: Some(seed), ..RequestBody::default() };
        BatchRequest { custom_id: custom_id.into(), body }
    }

    #[test]
    fn names_and_scenes_are_admitted_once() {
        let mut registry = Registry::default();
        let duplicate = |first: &str, first_place| Admission::Duplicate { first: first.into(), first_place };
        for (place, request, expected) in [
            (1, request("a", "a mug", 7), Admission::New),
            (2, request("b", "a mug", 8), Admission::New),
            (4, request("c", " a  mug\n", 7), duplicate("a", 1)),
            (5, request("a", "a cup", 7), Admission::NameTaken { first_place: 1 }),
            (6, request("d", "a cup", 7), Admission::New),
            (7, request("c", "a jug", 7), Admission::NameTaken { first_place: 4 }),
            (8, request("e", "a mug", 8), duplicate("b", 2)),
        ] {
            assert_eq!(registry.admit(place, &request), expected, "line {place}");
        }
        for (place, request, state, says) in [
            (9, request("a", "a pen", 7), RequestState::Invalid, "\"a\" is used on line 1"),
            (10, request("f", "a cup", 7), RequestState::Duplicate, "as \"d\" on line 6"),
        ] {
            let line = registry.refusal(place, &request).expect("is refused");
            let error = line.error.expect("says why");
            assert_eq!((line.state, error.line), (state, Some(place)));
            assert!(error.message.contains(says), "{}", error.message);
        }
        assert_eq!(registry.refusal(11, &request("g", "a pan", 7)), None);
    }
}
