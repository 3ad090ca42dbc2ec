//! Programs of instructions: statements in their order, each with the words that it comes from.
//!
//! An edit is a program of [`EditOperation`]s, a task for a robot one of [`StatedGoal`]s. Objects stay phrases or
//! names, which are resolved against the scene when the program is carried out, so that readers of words and language
//! models give the same programs. Both have a JSON form and a JSON schema.
//!
//! ```
//! use scene::EditOperation;
//! use scene::program::Program;
//!
//! let stated = r#"{"statements": [{"words": "lose the lamp", "op": "remove", "target": "the lamp"}]}"#;
//! let program: Program<EditOperation> = serde_json::from_str(stated)?;
//! assert_eq!(program.statements[0].words, "lose the lamp");
//! assert_eq!(program.meanings().count(), 1);
//! # Ok::<(), serde_json::Error>(())
//! ```

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::EditOperation;
use crate::text_account::PredicateKind;

/// A program: statements in the order in which they are carried out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Program<S> {
    pub statements: Vec<Statement<S>>,
    /// Words that ask for nothing, such as reasons and remarks that an object stays as it is.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub asides: Vec<String>,
}

/// Program of an edit.
pub type EditProgram = Program<EditOperation>;

/// Program of a task: conditions on the state at its end.
pub type TaskProgram = Program<StatedGoal>;

/// A statement and the words of the instruction that it comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Statement<S> {
    /// As the instruction has them.
    pub words: String,
    #[serde(flatten)]
    pub meaning: S,
}

/// A condition on the state at the end of a task, about all objects that its phrases mean.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct StatedGoal {
    pub predicate: PredicateKind,
    pub object: String,
    /// The other object of a relation. Without one, a swap or a stack is one of the objects among themselves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<String>,
    /// The second object of `between`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_target: Option<String>,
}

impl<S> Program<S> {
    /// The statements without their words, in order.
    pub fn meanings(&self) -> impl Iterator<Item = &S> {
        self.statements.iter().map(|statement| &statement.meaning)
    }
}
