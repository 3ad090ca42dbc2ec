//! Edits of finished scenes: which objects a phrase means, where an object has room, how it comes to rest there.
//!
//! [`references`] finds the objects that a phrase means, [`place`]
//! searches free places in a [`Workspace`], and [`rest`] lets objects come to rest there while all others stay. The
//! crate depends on geometry, physics, the catalog and the domain types; it must not depend on the pipeline, storage
//! or providers.

pub mod object;
pub mod references;
pub mod workspace;
pub mod place;
pub mod rest;
#[cfg(test)]
mod tests;

pub use object::EditableObject;
pub use place::{Candidate, NoPlace, PlaceQuery};
pub use rest::{RestFault, RestSettings};
pub use workspace::{Workspace, WorkspaceObject};
