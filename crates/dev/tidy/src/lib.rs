//! Checks of the source tree that Cargo cannot express: imports, file forms, comment widths, words and sentences.
//!
//! The crate reads every source file and document as text. It has no dependency, so a change of any other crate never
//! makes it compile again. `tests/checks` applies the rules to the whole tree; the binary lists findings file by file:
//!
//! ```text
//! cargo run -p tabletopgen-tidy -- words [PATH...]    banned words as path:line: word: text
//! cargo run -p tabletopgen-tidy -- widths [PATH...]   comment lines that are too wide
//! cargo run -p tabletopgen-tidy -- openings [PATH...] doc comments that do not begin with what the item is
//! cargo run -p tabletopgen-tidy -- signatures [PATH...] long functions, and errors that are texts
//! cargo run -p tabletopgen-tidy -- budget             rewrites budget.txt after findings are fixed
//! ```

// What the checks read.
pub mod lexer;
pub mod python_lexer;
pub mod test_code;
pub mod source;
pub mod paths;
pub mod manifest;
pub mod documents;

// What the checks require.
pub mod layers;
pub mod imports;
pub mod forms;
pub mod settings;
pub mod width;
pub mod doc_openings;
pub mod document_paths;
pub mod sentences;
pub mod words;
pub mod allowed;
pub mod signatures;
pub mod single_places;

// Findings that are still permitted, and how they are listed.
pub mod budget;
pub mod listing;

/// One violation of a rule that has a budget.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    pub rule: Rule,
    /// Relative to the repository.
    pub path: String,
    /// Counted from 1.
    pub line: usize,
    /// The banned word, or the measured width.
    pub subject: String,
    /// The source line without indentation.
    pub text: String,
}

/// Rules whose findings may be many today and may only become fewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rule {
    CommentWidth,
    CommentWord,
    DocOpening,
    DocumentWord,
    IdentifierWord,
    LiteralWord,
    LongFunction,
    TextError,
    TypeName,
}

impl Rule {
    pub const ALL: [Self; 9] = [
        Self::CommentWidth,
        Self::CommentWord,
        Self::DocOpening,
        Self::DocumentWord,
        Self::IdentifierWord,
        Self::LiteralWord,
        Self::LongFunction,
        Self::TextError,
        Self::TypeName,
    ];

    /// The name in `budget.txt`.
    pub fn name(self) -> &'static str {
        match self {
            Self::CommentWidth => "comment-width",
            Self::CommentWord => "comment-word",
            Self::DocOpening => "doc-opening",
            Self::DocumentWord => "document-word",
            Self::IdentifierWord => "identifier-word",
            Self::LiteralWord => "literal-word",
            Self::LongFunction => "long-function",
            Self::TextError => "text-error",
            Self::TypeName => "type-name",
        }
    }

    /// Whether the rule is about texts for users, not about code and its comments.
    pub fn is_of_texts(self) -> bool {
        matches!(self, Self::DocumentWord | Self::LiteralWord)
    }

    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|rule| rule.name() == name)
    }
}
