//! Shapes and numbers every other module shares: poses, pictures, meshes, cameras, outlines, seeds.
//!
//! Geometry never reads a file, a clock or a global random number, so it needs no mocks: the same
//! arguments give the same answer on any day and with any number of threads. Lengths are meters,
//! angles radians, numbers `f64`; the world frame is right-handed with +z up, its origin at the
//! center of the table top (see `ARCHITECTURE.md`, "Frames").

pub mod pose;
pub mod camera;
pub mod material;
pub mod textured_mesh;
pub mod solid;
pub mod shapes;
pub mod outline;
pub mod standing_solid;
pub mod hull;
pub mod physical;
pub mod shells;
pub mod mass_properties;
pub mod mesh_solid;
pub mod convex_hull;
pub mod decimate;
pub mod repair;
pub mod decompose;
pub mod collision_shape;
pub mod cast;
pub mod collide;
pub mod contact_hull;
pub mod contact_patch;
pub mod rotational_symmetry;
pub mod parallel_grasp;

pub use camera::Camera;
pub use hull::ConvexHull;
pub use material::{Material, Rgb};
pub use outline::Outline;
pub use physical::{Friction, MassProperties};
pub use pose::Pose;
pub use solid::Solid;
pub use standing_solid::{Posture, SolidFit, SolidKind};
pub use textured_mesh::{FaceGroup, TexturedMesh};

pub use glam::{DMat3, DQuat, DVec2, DVec3, Vec2, Vec3};
