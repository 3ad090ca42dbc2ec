//! Operations of an edit, read from an English instruction: "move the mug to the left of the laptop, put a spoon in it,
//! and remove the lamp".
//!
//! - A definite phrase is an object of the scene, an indefinite one is new: "put the mug on the tray" moves, "put a
//!   mug on the tray" adds. "Some" and "a few" are 3, "several" is 4, a plural without a number is 2, clutter is 5
//!   objects. Objects that exist stay phrases as written, which are resolved when the operation is carried out. New
//!   ones are singular with an indefinite article and a count.
//! - "It" and "them" are what the last command changed or made; in "a fork to the left of the plate and a knife to the
//!   right of it", the plate. After a change that makes a phrase unfit ("move the leftmost book ... and color it red"),
//!   the operation says "it", which means the objects of the operation before.
//! - Left and right are as seen from the front edge; forward is toward it. Clockwise is as seen from above and
//!   negative. "Bigger" is a factor of 1.25, "a bit bigger" 1.1, "much bigger" 1.5; "smaller" is the inverse.
//! - Light is brighter or darker than the usual one; "from the left" is as seen by the viewer. The camera turns about
//!   the table, from where it is: "from the left" by a quarter.
//!
//! Nothing is dropped: a word without a meaning, a condition, a question, an open choice or an unclear pronoun is an
//! [`InstructionError`] with the words and what to say instead.

mod additions;
mod changes;
mod discourse;
mod error;
pub(crate) mod fold;
mod new_objects;
mod places;
mod placing;
mod surroundings;
mod targets;

pub use error::{InstructionError, MAX_CHARACTERS, Reason};

use scene::EditProgram;
use scene::edit::violations;

use crate::chart::Referents;
use crate::reading::edits_of;

/// The operations that an instruction asks for, in the order in which they are carried out; at least one, each with the
/// words of its clause.
///
/// # Errors
///
/// [`InstructionError`] with the words that cannot be carried out, as described above.
pub fn read(text: &str, referents: &dyn Referents) -> Result<EditProgram, InstructionError> {
    if text.chars().count() > MAX_CHARACTERS {
        return Err(InstructionError { words: String::new(), span: 0..text.len(), reason: Reason::TooLong });
    }
    let (chart, reading) = edits_of(text, referents);
    let whole = |reason| InstructionError { words: text.trim().to_owned(), span: 0..text.len(), reason };
    if chart.tokens.iter().all(|token| token.word == "." || token.word == ",") {
        return Err(whole(Reason::Empty));
    }
    let program = fold::program(&chart, &reading)?;
    let operations: Vec<_> = program.meanings().cloned().collect();
    match violations(&operations).into_iter().next() {
        Some(violation) => {
            Err(whole(Reason::OutOfRange(format!("{}: {}", violation.pointer, violation.detail))))
        }
        None => Ok(program),
    }
}
