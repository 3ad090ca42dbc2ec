//! Edits of finished scenes: which objects a phrase means, where an object has room, how it comes to rest there.
//!
//! [`instruction`] reads operations from a sentence, [`references`] finds the objects that a phrase means. The crate
//! depends on geometry, physics, the catalog and the domain types; it must not depend on the pipeline, storage or
//! providers.

pub mod object;
pub mod references;
pub mod instruction;

pub use object::EditableObject;
