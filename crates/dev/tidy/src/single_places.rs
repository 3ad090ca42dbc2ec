//! Mechanisms that have one place. A second place would answer the same question, and the two would disagree one day.

use crate::source::Source;

/// A mechanism, the names that show its use, and the places that may use them.
pub struct Mechanism {
    pub what: &'static str,
    /// Sequences of names in code, or parts of string literals.
    pub signs: &'static [&'static str],
    /// Paths, or starts of paths, with the reason where one is not the mechanism itself.
    pub places: &'static [(&'static str, &'static str)],
}

/// All of them.
pub const MECHANISMS: &[Mechanism] = &[
    Mechanism {
        what: "leases of jobs",
        signs: &["lease_until"],
        places: &[
            ("crates/server/store/src/queue", ""),
            ("crates/server/store/src/readiness.rs", "takes and gives back a lease, as the queue does"),
        ],
    },
    Mechanism {
        what: "threads that compute",
        signs: &["ThreadPoolBuilder"],
        places: &[
            ("crates/base/runtime/src/cpu.rs", ""),
            ("crates/dev/lab/src/cli/", "as many as the command line says, for all of a measurement"),
        ],
    },
    Mechanism {
        what: "threads beside the pool",
        signs: &["spawn_blocking", "thread::Builder", "thread::spawn", "thread::scope"],
        places: &[
            ("crates/server/store/src/", "waits for files and for SQLite, and digests what it reads"),
            ("crates/data/episodes/src/part_folder.rs", "writes files of several formats at a time"),
            ("src/api/", "parses and checks bodies, which must not wait for scenes"),
            ("src/app/episodes/recorder.rs", "the workers of the command line, as many as it is given"),
            ("src/cli/foreground.rs", "the one computation of a command"),
            ("src/pipeline/resources.rs", "waits for the driver of the GPU"),
            ("src/service/feeding.rs", "reads recipes, which must not wait for scenes"),
            ("src/worker/heartbeat.rs", "keeps leases while the runtime is busy"),
        ],
    },
];

/// Uses of a mechanism outside its places, in shipped code.
pub fn findings(source: &Source) -> Vec<String> {
    if source.is_test || !source.is_rust() || source.package() == "tidy" {
        return Vec::new();
    }
    let mut findings = Vec::new();
    for mechanism in MECHANISMS {
        if mechanism.places.iter().any(|(place, _)| source.path.starts_with(place)) {
            continue;
        }
        findings.extend(uses(source, mechanism).into_iter().map(|line| {
            let first = mechanism.places[0].0;
            format!("{}:{line}: {} have one place, {first}", source.path, mechanism.what)
        }));
    }
    findings
}

/// Lines that use the mechanism.
pub fn uses(source: &Source, mechanism: &Mechanism) -> Vec<usize> {
    let tokens = &source.shipped;
    let mut lines = Vec::new();
    for sign in mechanism.signs {
        let names: Vec<&str> = sign.split("::").collect();
        let starts_here = |index: usize| {
            names.iter().enumerate().all(|(k, name)| {
                // Names and the signs between them take turns.
                tokens.get(index + 2 * k).is_some_and(|token| token.text == *name)
                    && (k == 0 || tokens[index + 2 * k - 1].text == "::")
            })
        };
        let in_code = (0..tokens.len()).filter(|&index| starts_here(index)).map(|index| tokens[index].line);
        let in_literals = tokens.iter().filter(|token| token.literal.contains(sign)).map(|token| token.line);
        lines.extend(in_code.chain(in_literals));
    }
    lines.sort_unstable();
    lines
}
