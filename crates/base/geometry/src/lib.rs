//! Rigid geometry: poses, cameras, meshes, convex hulls, convex decomposition, collision and contact queries, mass.
//!
//! Lengths are meters, angles radians, numbers `f64`. The world frame is right-handed with +z up; its origin is the
//! center of the table top (see `ARCHITECTURE.md`, "Frames"). Functions read no file, no clock and no global random
//! number, and their results do not depend on the number of threads. The crate must not depend on scenes, models,
//! rendering or file formats; below it are `imaging` (textures) and `runtime` (cancellation).
//!
//! ```
//! use geometry::convex_hull::convex_hull;
//! use geometry::shapes::block;
//! use geometry::{DVec3, Pose};
//!
//! let cube = block(DVec3::splat(0.05));
//! let hull = convex_hull(&cube.positions, 64, 0.0005).expect("a cube has a volume");
//! assert!((hull.volume_m3() - 0.05_f64.powi(3)).abs() < 1e-9);
//! let world_from_cube = Pose::upright(DVec3::new(0.2, 0.0, 0.0), 0.0);
//! assert_eq!(world_from_cube.transform_point(DVec3::ZERO).x, 0.2);
//! ```

pub mod camera;
pub mod collide;
pub mod collision_shape;
pub mod contact_hull;
pub mod contact_patch;
pub mod convex_hull;
pub mod decimate;
pub mod optimize;
pub mod decompose;
pub mod drop_cast;
pub mod hull;
pub mod mass_and_friction;
pub mod mass_properties;
pub mod material;
pub mod outline;
pub mod parallel_grasp;
pub mod polygon;
pub mod json_numbers;
pub mod pose;
pub mod posed_primitive;
pub mod repair;
pub mod rotational_symmetry;
pub mod shapes;
pub mod shells;
pub mod simple_solid;
pub mod solid_query;
pub mod textured_mesh;
pub mod triangle_shell;

pub use camera::Camera;
pub use hull::ConvexHull;
pub use mass_and_friction::{Friction, MassProperties};
pub use material::{Material, Rgb};
pub use outline::Outline;
pub use pose::Pose;
pub use posed_primitive::{PosedPrimitive, Posture, PrimitiveKind};
pub use simple_solid::{SimpleSolid, SimpleSolidKind};
pub use textured_mesh::{FaceGroup, TexturedMesh};
pub use triangle_shell::Solid;

pub use glam::{DMat3, DQuat, DVec2, DVec3, Vec2, Vec3};
