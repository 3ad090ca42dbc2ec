//! Domain types of the pipeline: requests, descriptions, recognitions, the finished scene.
//!
//! Deserialized requests, recognitions and scenes are valid: names are unique, sizes positive, and supports form a tree
//! rooted at the table. The crate depends on geometry and imaging only; it must not depend on transport, storage or
//! providers.
//!
//! ```
//! use scene::SceneRequest;
//!
//! let stored = r#"{"version": 1, "input": {"kind": "text", "text": "a mug"}, "seed": 7, "options": {}}"#;
//! let request: SceneRequest = serde_json::from_str(stored)?;
//! assert_eq!(request.seed, 7);
//!
//! let invalid = stored.replace("{}", r#"{"max_objects": 0}"#);
//! let error = serde_json::from_str::<SceneRequest>(&invalid).unwrap_err();
//! assert!(error.to_string().starts_with("/options/max_objects: must be from 1 to 64"));
//! # Ok::<(), serde_json::Error>(())
//! ```

mod validation;
pub mod json_schema;
pub mod id;
pub mod name;
pub mod labels;
pub mod request;
pub mod description;
pub mod edit;
pub mod program;
pub mod light;
pub mod variant;
pub mod text_account;
pub mod predicates;
pub mod table;
pub mod recognition;
pub mod stand_in;
pub mod grasps;
pub mod instance;
pub mod support_tree;
pub mod clutter;
pub mod money;
pub mod appraisal;
pub mod finished;

pub use description::{
    Arrangement, ArrangementKind, ObjectSpec, Relation, RelationKind, RequestedPose, SceneDescription,
};
pub use edit::{ArrangedAs, EditOperation, EditPlace, SortedBy};
pub use finished::{Metrics, Scene};
pub use geometry::{Friction, MassProperties};
pub use id::{BatchId, DatasetId, DeliveryId, JobId, KeyId, RecordingId, SceneId, TenantId, WebhookId};
pub use instance::{Instance, Provenance, ReconstructionMethod, Support, SupportRelation};
pub use light::Light;
pub use money::MicroUsd;
pub use name::InstanceId;
pub use program::{EditProgram, StatedGoal, TaskProgram};
pub use recognition::{
    CameraKnowledge, CategoryStance, DepthAccount, InstanceMask, MaskEdges, Recognition, RecognizedObject,
    RecognizedTable, StandsOn, TippedPose, TopBox, UNNAMED_CATEGORY,
};
pub use request::{Input, SceneRequest};
pub use stand_in::StandIn;
pub use support_tree::{SupportTree, Supporter};
pub use table::{Table, TableShape, TableSpec};
pub use text_account::{
    Goal, GoalPredicate, PredicateKind, TextMeaning, TextSpan, Understood, Unrecognized, UnrecognizedReason,
};
pub use validation::{InvalidValue, Violation};
pub use variant::Randomize;

#[cfg(test)]
mod tests;
