//! Robot tasks in finished tabletop scenes.
//!
//! A [`Task`] is an instruction with a [`Goal`]: a conjunction of predicates over the objects of a scene, for a named
//! robot and within limits. [`evaluate`] decides every predicate from poses, contacts and convex hulls, never with a
//! model: the same poses give the same verdict, wherever they were simulated.
//!
//! World frame: origin at the center of the table top, z up, x to the right and y to the back as seen from the front
//! edge. Meters, radians, kilograms, seconds.

pub mod bddl;
pub mod contact;
mod convex_width;
pub mod disturbance;
pub mod evaluation;
pub mod goal;
pub mod opening;
pub mod posed_object;
pub mod proposals;
pub mod refusal;
pub mod robot_limits;
pub mod scene_state;
mod stacks;
pub mod task;
pub mod task_scene;
pub mod text;
pub mod validation;
#[cfg(test)]
mod test_scenes;

pub use contact::{Contact, ContactBody};
pub use disturbance::{Disturbance, disturbed_others};
pub use evaluation::{PredicateOutcome, Reason, Situation, evaluate};
pub use goal::{Goal, GoalError};
pub use opening::Opening;
pub use posed_object::{ObjectShape, PosedObject};
pub use proposals::{ProposalKind, ProposedTask, propose};
pub use refusal::Refusal;
pub use robot_limits::RobotLimits;
pub use scene::text_account::{GoalPredicate, PredicateKind};
pub use task::{Limits, Task};
pub use task_scene::{ObjectAppearance, TaskScene};
pub use validation::validate;
