//! Reasons why a layer could not be read.

use lz4_flex::block::DecompressError;

/// Reason why a layer could not be read.
#[derive(Debug, thiserror::Error)]
pub enum LayerError {
    #[error("is not UTF-8")]
    NotUtf8,
    #[error("does not begin like a crate file")]
    NotCrate,
    #[error("is of version {major}.{minor}")]
    Version { major: u8, minor: u8 },
    #[error("ends before byte {0}")]
    EndsBefore(usize),
    #[error("ends too early")]
    EndsEarly,
    #[error("{0} ends behind the file")]
    SectionEndsBehind(String),
    #[error("has no section {0}")]
    NoSection(&'static str),
    #[error("tells of {0} bytes")]
    Length(u64),
    #[error("tells of too many {0}")]
    TooMany(&'static str),
    #[error("a block is empty")]
    EmptyBlock,
    #[error("a table is in {0} blocks instead of one")]
    BlockCount(u8),
    #[error("a block cannot be unpacked: {0}")]
    Block(#[from] DecompressError),
    #[error("has {found} tokens instead of {wanted}")]
    TokenCount { found: usize, wanted: usize },
    #[error("a token is not UTF-8")]
    TokenNotUtf8,
    #[error("there is no token {0}")]
    NoToken(u32),
    #[error("there is no string {0}")]
    NoString(u32),
    #[error("fields have no values")]
    NoValues,
    #[error("a field is missing")]
    NoField,
    #[error("a spec stands at no path")]
    SpecWithoutPath,
    #[error("a spec has no fields")]
    SpecWithoutFields,
    #[error("{path} is a spec of kind {kind}")]
    SpecKind { path: String, kind: u32 },
    #[error("a spec stands twice at one path")]
    SpecTwice,
    #[error("row {0} of the paths has no parent")]
    NoParent(usize),
    #[error("something stands beside the root")]
    BesideRoot,
    #[error("a path is followed by {0}")]
    PathJump(i32),
    #[error("a value of type {0} is no token")]
    ValueNotToken(u64),
    #[error("a value of type {0} is no numbers")]
    ValueNotNumbers(u64),
    #[error("an array of tokens is empty")]
    EmptyTokens,
    #[error("{0} are not prepended")]
    NotPrepended(&'static str),
    #[error("a list of paths is empty or replaces nothing")]
    NoExplicitPath,
    #[error("numbers with a point are compressed")]
    CompressedNumbers,
}
