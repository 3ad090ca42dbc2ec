//! Where things stand: yaw from a silhouette, layout from a top view, how contained things lie, the upright pose of a raw mesh.
//!
//! Pure functions of meshes, masks, cameras and boxes; nothing here knows a job, a file or a model.
//! Angles are radians about world +z; lengths meters; pictures count pixels from the top-left corner.

mod appearance;
pub mod beside;
pub mod camera;
pub mod canonicalize;
pub mod contained;
pub mod dro;
pub mod tsa;
