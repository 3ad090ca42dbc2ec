//! Readers and writers of mesh files: GLB, and OBJ in a ZIP archive. Readers are bounded: hostile bytes are an error.
//!
//! The crate knows meshes and images. It must not depend on scenes, jobs or the network, and it opens no file.

pub mod gltf;
pub mod wavefront_archive;
