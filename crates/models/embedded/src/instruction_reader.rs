//! The embedded reader of instructions: English by the constructions of [`language`], beside the objects of the scene.

use editing::references::SceneReferents;
use language::{edit, task};
use ports::instruction_reader::NOT_UNDERSTOOD;
use ports::{Answer, Call, Instruction, InstructionReader, Port, ProviderError};
use scene::{EditProgram, TaskProgram};
use tasks::Refusal;

/// Reads English without a language model.
#[derive(Clone, Copy, Debug)]
pub struct EnglishReader;

impl InstructionReader for EnglishReader {
    fn read_edit<'a>(&'a self, call: &'a Call, instruction: Instruction) -> Answer<'a, EditProgram> {
        Box::pin(call.compute(Port::Analyst, move |_| {
            let Instruction { text, objects } = &instruction;
            edit::read(text, &SceneReferents(objects))
                .map_err(|error| rejected(NOT_UNDERSTOOD, error.to_string()))
        }))
    }

    fn read_task<'a>(&'a self, call: &'a Call, instruction: Instruction) -> Answer<'a, TaskProgram> {
        Box::pin(call.compute(Port::Analyst, move |_| {
            let Instruction { text, objects } = &instruction;
            task::read(text, &SceneReferents(objects)).map_err(|error| {
                let refusal = Refusal::from(error);
                rejected(refusal.code(), refusal.to_string())
            })
        }))
    }
}

fn rejected(code: &'static str, reason: String) -> ProviderError {
    ProviderError::Rejected { port: Port::Analyst, code, reason }
}
