//! Reasons why an instruction is refused.

use std::ops::Range;

/// Longest instruction, characters.
pub const MAX_CHARACTERS: usize = 4000;

/// Words of an instruction that cannot be carried out, and the reason.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{words:?} (at character {}): {reason}", .span.start)]
pub struct InstructionError {
    /// The words, as written.
    pub words: String,
    /// Range of these words in the instruction, bytes.
    pub span: Range<usize>,
    pub reason: Reason,
}

/// Reason why words of an instruction cannot be carried out.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Reason {
    #[error("the instruction asks for no change; say what to add, remove, replace, move or change")]
    Empty,
    #[error("the instruction is longer than {MAX_CHARACTERS} characters; split it")]
    TooLong,
    #[error("this is not understood; {0}")]
    NotUnderstood(&'static str),
    #[error("this says what not to do; objects that are not named stay as they are, so leave it out")]
    Negated,
    #[error("objects that are not named stay as they are; leave it out, or use \"everything except\"")]
    Unchanged,
    #[error("conditions such as \"if\" are not supported; say what to do")]
    Conditional,
    #[error("\"or\" leaves a choice open; say which")]
    Alternative,
    #[error("this is a question; say what to change")]
    Question,
    #[error("it is not clear what this stands for; name the object")]
    UnclearPronoun,
    #[error("nothing before this says what it stands for; name the object")]
    NoAntecedent,
    #[error("this stands for an object that was removed; name another one")]
    Removed,
    #[error(
        "after the change before it, {0:?} may fit another object; give its name, or make two instructions of \
         it"
    )]
    Changed(String),
    #[error(
        "it is not said how far; give a distance (10 cm to the left) or a place (to the left of the laptop, on \
         the left side)"
    )]
    HowFar,
    #[error("it is not said how far it turns; give an angle (by 90 degrees) or what it faces")]
    HowFarTurned,
    #[error("{0} is not a factor from 0.5 to 2, which sizes may change by")]
    Factor(f64),
    #[error("two places at once are not supported; give one of them")]
    TwoPlaces,
    #[error("a place is relative to one object; \"each\" or several objects need one instruction per object")]
    SeveralLandmarks,
    #[error("a place is relative to an object of the scene; add the other object first")]
    NewLandmark,
    #[error("a displacement needs an object that exists; give the place of a new one")]
    OffsetOfNew,
    #[error("clutter is spread over the whole table; leave the place out")]
    ClutterPlace,
    #[error(
        "it is not clear which part says the place and which part says the object; write \"move X to ...\""
    )]
    Attachment,
    #[error(
        "removal from the table or from the other object? say \"remove the spoon\" or \"take the spoon out of \
         the mug\""
    )]
    RemoveFrom,
    #[error("two objects change places; name two")]
    Swap,
    #[error(
        "objects are not laid down, turned over or stood up by an edit; ask for it in the text of a new scene (\"a vase \
         lying on its side\")"
    )]
    Posture,
    #[error("in, on or next to it? say which")]
    Destination,
    #[error("one object replaces one; name one new object, singular")]
    OneForOne,
    #[error("the table cannot be moved, removed or replaced; \"make the table oak\" changes its appearance")]
    Table,
    #[error("tables have no such finish; use oak, walnut, pine, birch, glass, steel, marble or a color")]
    TableMaterial,
    #[error("it {0}")]
    NotPlaceable(&'static str),
    #[error("no object of this name is known; use another word for it")]
    UnknownObject,
    #[error("no theme of this name is known; use one such as kitchen, office, breakfast, workshop, sewing")]
    UnknownTheme,
    #[error("{0}")]
    OutOfRange(String),
}
