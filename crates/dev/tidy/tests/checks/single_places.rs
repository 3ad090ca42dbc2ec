//! Mechanisms that have one place.

use tidy::single_places::{MECHANISMS, findings, uses};
use tidy::source::Source;

use crate::{report, shipped};

#[test]
fn mechanisms_are_used_in_their_places_alone() {
    report("mechanisms", shipped().flat_map(findings).collect());
}

/// A place that uses nothing permits more than the code needs.
#[test]
fn every_place_of_a_mechanism_uses_it() {
    let mut unused = Vec::new();
    for mechanism in MECHANISMS {
        let places = mechanism.places.iter().map(|(place, _)| place);
        let idle = places.filter(|place| {
            !shipped().any(|source| source.path.starts_with(**place) && !uses(source, mechanism).is_empty())
        });
        unused.extend(idle.map(|place| format!("{place} has no {}", mechanism.what)));
    }
    report("single_places.rs", unused);
}

#[test]
fn uses_in_code_and_in_statements_are_found_and_those_of_tests_are_not() {
    let source = Source::new(
        "crates/base/scene/src/job.rs",
        "use std::thread;\nfn a() { thread::spawn(|| {}); sql(\"SET lease_until = 1\"); }\n\
         #[cfg(test)]\nmod tests { fn b() { std::thread::spawn(|| {}); } }",
    );
    assert_eq!(
        findings(&source),
        [
            "crates/base/scene/src/job.rs:2: leases of jobs have one place, crates/server/store/src/queue",
            "crates/base/scene/src/job.rs:2: threads beside the pool have one place, crates/server/store/src/",
        ]
    );
}
