//! Files in which a banned word is the standard term of the domain.

/// An exception: in files whose path starts with `path`, `words` are allowed in identifiers and comments.
#[derive(Debug)]
pub struct Allowed {
    pub path: &'static str,
    pub words: &'static [&'static str],
    pub reason: &'static str,
}

pub const ALLOWED: &[Allowed] = &[
    Allowed {
        path: "crates/catalog/src/crafting.rs",
        words: &["paint", "painting"],
        reason: "the paint bottle and the paint palette are objects, painting is the craft they belong to",
    },
    Allowed {
        path: "crates/catalog/src/crafting/models.rs",
        words: &["paint"],
        reason: "the paint of a model car or plane",
    },
    Allowed {
        path: "crates/catalog/src/crafting/painting.rs",
        words: &["paint", "painter", "painting", "paints"],
        reason: "the file builds paint bottles, brushes, a painter's palette and a canvas with a painting",
    },
    Allowed {
        path: "crates/catalog/src/workbench",
        words: &["paint"],
        reason: "the paint can is an object, with drips of paint",
    },
    Allowed {
        path: "crates/catalog/",
        words: &["knob"],
        reason: "the knob is a part of lids, planes, toasters and meters",
    },
    Allowed {
        path: "crates/catalog/src/office.rs",
        words: &["picture"],
        reason: "the picture frame is an object",
    },
    Allowed {
        path: "crates/catalog/src/office/decor.rs",
        words: &["picture"],
        reason: "the picture frame is an object",
    },
];

pub fn is_allowed(path: &str, word: &str) -> bool {
    ALLOWED.iter().any(|allowed| path.starts_with(allowed.path) && allowed.words.contains(&word))
}
