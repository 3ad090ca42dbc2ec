//! Files in which a banned word is the standard term of the domain.

use crate::Finding;

/// An exception: in files whose path starts with `path`, `words` are allowed.
#[derive(Debug)]
pub struct Allowed {
    pub path: &'static str,
    pub words: &'static [&'static str],
    pub reason: &'static str,
}

/// Exceptions for identifiers and comments.
pub const ALLOWED: &[Allowed] = &[
    Allowed {
        path: "python/tabletopgen_checks/bars/references.py",
        words: &["pictures"],
        reason: "the name of a command line option",
    },
    Allowed {
        path: "python/tabletopgen_checks/golden/dinov2.py",
        words: &["picture"],
        reason: "part of the names of tensors in the golden file",
    },
    Allowed {
        path: "python/tabletopgen_checks/service/postgres.py",
        words: &["nobody"],
        reason: "a user of Unix systems",
    },
];

/// Exceptions for string literals and documents.
pub const ALLOWED_IN_TEXTS: &[Allowed] = &[
    Allowed {
        path: "crates/models/embedded/src/text_parser/grammar/distances.rs",
        words: &["middle"],
        reason: "a phrase that texts use",
    },
    Allowed {
        path: "crates/models/embedded/src/text_parser/prepositions.rs",
        words: &["middle"],
        reason: "phrases that texts use",
    },
    Allowed {
        path: "crates/dev/lab/src/benchmark/scenes.rs",
        words: &["painting"],
        reason: "a text of the benchmark: a table for the craft",
    },
    Allowed {
        path: "crates/dev/lab/src/synthetic_images/synthesis.rs",
        words: &["picture"],
        reason: "the name of a stream of random numbers; another name gives other images",
    },
    Allowed {
        path: "crates/models/remote/src/chat/check_top.rs",
        words: &["painter"],
        reason: "part of the prompt, which recorded exchanges hold",
    },
    Allowed {
        path: "crates/models/remote/src/chat/describe.rs",
        words: &["wish"],
        reason: "part of the prompt, which recorded exchanges hold",
    },
    Allowed {
        path: "crates/models/remote/src/chat/judge.rs",
        words: &["picture"],
        reason: "part of the prompt, which recorded exchanges hold",
    },
    Allowed {
        path: "crates/models/remote/src/chat/schema.rs",
        words: &["picture"],
        reason: "part of the prompt, which recorded exchanges hold",
    },
    Allowed {
        path: "crates/models/remote/src/images/inpaint.rs",
        words: &["thing"],
        reason: "part of the prompt, which recorded exchanges hold",
    },
    Allowed {
        path: "crates/models/remote/src/images/reference.rs",
        words: &["middle"],
        reason: "part of the prompt, which recorded exchanges hold",
    },
    Allowed {
        path: "crates/dev/tidy/src/allowed.rs",
        words: &["picture"],
        reason: "the reasons above name these objects",
    },
    Allowed {
        path: "python/tabletopgen_checks/bars/batches/__main__.py",
        words: &["picture"],
        reason: "a text of the batch: the picture frame is an object",
    },
    Allowed {
        path: "python/tabletopgen_checks/bars/references.py",
        words: &["pictures"],
        reason: "the name of a command line option",
    },
    Allowed {
        path: "python/tabletopgen_checks/bars/reliability/plot.py",
        words: &["middle"],
        reason: "a value of the SVG attribute `text-anchor`",
    },
    Allowed {
        path: "python/tabletopgen_checks/service/postgres.py",
        words: &["nobody"],
        reason: "a user of Unix systems",
    },
];

pub fn is_allowed(finding: &Finding) -> bool {
    let entries = if finding.rule.is_of_texts() { ALLOWED_IN_TEXTS } else { ALLOWED };
    let is_of = |allowed: &&Allowed| finding.path.starts_with(allowed.path);
    entries.iter().filter(is_of).any(|allowed| allowed.words.contains(&finding.subject.as_str()))
}
