//! Texts of requests: each is described or rejected, and the account of a description is about its text.
//!
//! The limit on the length is far above the server's, so that a text whose time is not linear in its length takes too
//! long.
#![no_main]

use std::collections::HashSet;
use std::sync::LazyLock;

use embedded::text_parser::{DescribeOptions, TextParserSettings, describe};
use libfuzzer_sys::fuzz_target;
use scene::request::OnUnknown;
use scene::text_account::TextSpan;
use tabletopgen::config::{Sources, layers};

const MAX_OBJECTS: usize = 64;

static SETTINGS: LazyLock<TextParserSettings> = LazyLock::new(|| TextParserSettings {
    max_text_chars: 100_000,
    ..layers::load(Sources::default()).expect("the defaults are valid").config.analyst
});

fuzz_target!(|text: &str| {
    for on_unknown in [OnUnknown::StandIn, OnUnknown::Drop, OnUnknown::Fail] {
        let options = DescribeOptions { max_objects: MAX_OBJECTS, table: None, on_unknown };
        let Ok(description) = describe(text, 1, &options, &SETTINGS) else { continue };
        assert!(description.objects.len() <= MAX_OBJECTS);
        let ids: HashSet<_> = description.objects.iter().map(|object| &object.id).collect();
        assert_eq!(ids.len(), description.objects.len(), "an id stands twice");
        for predicate in description.goal.iter().flat_map(|goal| &goal.predicates) {
            assert!(ids.contains(&predicate.object), "the goal is about an object that is not there");
        }
        let understood = description.understood.iter().map(|part| &part.span);
        for span in understood.chain(description.unrecognized.iter().map(|part| &part.span)) {
            assert!(is_of(span, text), "{span:?} is no part of the text");
        }
    }
});

fn is_of(span: &TextSpan, text: &str) -> bool {
    text.get(span.start..span.end).is_some_and(|words| words == span.text)
}
