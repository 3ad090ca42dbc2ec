//! Pose estimation: camera refinement, upright pose of a raw mesh, yaw from a silhouette, layout from a top view, and
//! poses in containers.
//!
//! Pure functions of meshes, masks, cameras and boxes. The crate must not depend on jobs, files, ports or models.
//! Angles are radians about world +z; lengths are meters; image positions count pixels from the top-left corner.
//!
//! ```
//! use geometry::{DVec2, DVec3, Material, Rgb, TexturedMesh, shapes};
//! use pose_estimation::top_view_layout::footprint;
//!
//! let mut mesh = TexturedMesh::default();
//! mesh.add(shapes::block(DVec3::new(0.2, 0.1, 0.05)), &Material::plain("gray", Rgb::hex(0x808080), 0.5));
//! // A quarter turn exchanges width and depth.
//! let turned = footprint(&mesh, std::f64::consts::FRAC_PI_2);
//! assert!((turned.high_m - turned.low_m - DVec2::new(0.1, 0.2)).length() < 1e-9);
//! ```

mod appearance;
pub mod beside;
pub mod camera;
pub mod upright;
pub mod contained;
pub mod yaw;
pub mod top_view_layout;
