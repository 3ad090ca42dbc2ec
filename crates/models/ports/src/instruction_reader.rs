//! The reading of instructions about a finished scene, which belongs to the scene analyst: edits and robot tasks, each
//! as a program.
//!
//! It is a trait apart from [`SceneAnalyst`](super::SceneAnalyst), because it is no part of any stage: a program is
//! read once, when an order comes, and everything after it takes the program.

use std::sync::Arc;

use editing::EditableObject;
use scene::{EditProgram, TaskProgram};

use super::{Answer, Call};

/// An instruction and the objects that it is about.
#[derive(Clone, Debug)]
pub struct Instruction {
    pub text: String,
    /// The objects of the scene, in the order of `scene.json`.
    pub objects: Arc<[EditableObject]>,
}

/// The code of instructions that are not understood.
pub const NOT_UNDERSTOOD: &str = "instruction_not_understood";

/// Reads instructions as programs.
///
/// A program has at least one statement, and every word of the instruction that asks for something is part of one: what
/// no statement can express is an error ([`ProviderError::Rejected`](super::ProviderError::Rejected) with the code
/// [`NOT_UNDERSTOOD`] or that of a refused task), never left out.
pub trait InstructionReader: Send + Sync {
    /// The operations that an instruction asks for.
    fn read_edit<'a>(&'a self, call: &'a Call, instruction: Instruction) -> Answer<'a, EditProgram>;

    /// The goal that an instruction sets a robot.
    fn read_task<'a>(&'a self, call: &'a Call, instruction: Instruction) -> Answer<'a, TaskProgram>;
}
