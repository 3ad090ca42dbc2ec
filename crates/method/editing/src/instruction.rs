//! Operations read from an English instruction: "move the mug to the left of the laptop, put a spoon in it, and remove
//! the lamp".
//!
//! The text is split into clauses with a verb each; a clause without a verb repeats the one before it. Objects that
//! exist stay phrases as written, which [`crate::references`] resolves when the operation is carried out. New objects
//! are singular with an indefinite article and a count.
//!
//! - A definite phrase is an object of the scene, an indefinite one is new: "put the mug on the tray" moves, "put a
//!   mug on the tray" adds. "Some" and "a few" are 3, "several" is 4, a plural without a number is 2, clutter is 5
//!   objects.
//! - "It" and "them" are what the last command changed or made; in "a fork to the left of the plate and a knife to the
//!   right of it", the plate. A new object is named by its label ("the red mug"): who carries the operations out
//!   prefers the newest object that fits ([`crate::references::resolve_newest`]).
//! - After a change that makes a phrase unfit ("move the leftmost book ... and color it red"), an operation on "it"
//!   precedes the change, or the text is refused.
//! - Left and right are as seen from the front edge; forward is toward it. Clockwise is as seen from above and
//!   negative. "Bigger" is a factor of 1.25, "a bit bigger" 1.1, "much bigger" 1.5; "smaller" is the inverse.
//!
//! Nothing is dropped: a word without a meaning, a negation, a condition, a question, an open choice or an unclear
//! pronoun is an [`InstructionError`] with the words and what to say instead. Cost is linear in the operations and
//! quadratic in the words of a clause.
//!
//! ```
//! use editing::instruction;
//!
//! let operations = instruction::read("put two forks next to the plate")?;
//! let json = r#"[{"op":"add","object":"a fork","count":2,"where":{"relation":"next_to","target":"the plate"}}]"#;
//! assert_eq!(serde_json::to_string(&operations).expect("serializes"), json);
//! # Ok::<(), instruction::InstructionError>(())
//! ```

mod tokens;
mod cursor;
mod measures;
mod nouns;
mod discourse;
mod chunks;
mod targets;
mod place;
mod regions;
mod openings;
mod additions;
mod moves;
mod removals;
mod turns;
mod sizes;
mod appearance;
mod clauses;

use std::ops::Range;

use cursor::Cursor;
use discourse::Discourse;
use scene::EditOperation;
use scene::edit::violations;

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
    #[error(
        "to swap two objects is not supported; move one after the other, or replace by a new object (\"a wine \
         glass\")"
    )]
    Swap,
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

/// The operations that an instruction asks for, in the order in which they are carried out; at least one.
///
/// # Errors
///
/// [`InstructionError`] with the words that cannot be carried out, as described above.
pub fn read(text: &str) -> Result<Vec<EditOperation>, InstructionError> {
    if text.chars().count() > MAX_CHARACTERS {
        return Err(InstructionError { words: String::new(), span: 0..text.len(), reason: Reason::TooLong });
    }
    let (tokens, discourse) = (tokens::tokens(text), Discourse::default());
    let mut cursor = Cursor { tokens, at: 0, operations: Vec::new(), discourse };
    cursor.check_mood()?;
    cursor.clauses()?;
    let whole = |reason| InstructionError { words: text.trim().to_owned(), span: 0..text.len(), reason };
    if cursor.operations.is_empty() {
        return Err(whole(Reason::Empty));
    }
    match violations(&cursor.operations).into_iter().next() {
        Some(violation) => {
            Err(whole(Reason::OutOfRange(format!("{}: {}", violation.pointer, violation.detail))))
        }
        None => Ok(cursor.operations),
    }
}
