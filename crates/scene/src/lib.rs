//! What stages speak about: requests, descriptions, the table, instances, the finished scene.
//!
//! Types here know geometry and nothing of transport or rows. A value that exists is valid: names are
//! checked, sizes positive, supports form a tree rooted at the table.

pub mod name;
pub mod request;
pub mod description;
pub mod table;
pub mod recognition;
pub mod instance;
pub mod money;
pub mod certificate;
pub mod appraisal;
pub mod finished;
pub mod job;

pub use certificate::Certificate;
pub use description::{ObjectSpec, Relation, RelationKind, SceneDescription};
pub use finished::Scene;
pub use geometry::{Friction, MassProperties};
pub use instance::{Instance, Provenance, ReconstructionMethod, Support};
pub use money::MicroUsd;
pub use name::InstanceId;
pub use recognition::{
    CameraKnowledge, CategoryStance, InstanceMask, MaskEdges, Recognition, RecognizedObject, RecognizedTable,
    StandsOn, TopBox, UNNAMED_CATEGORY,
};
pub use request::{Input, SceneRequest};
pub use table::{Table, TableShape, TableSpec};
