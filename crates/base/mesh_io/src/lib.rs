//! Readers and writers of mesh files: GLB, and OBJ in a ZIP archive.
//!
//! Readers are bounded: hostile bytes give an error, never a panic or an unbounded allocation. The crate knows meshes
//! and images. It must not depend on scenes, jobs or the network, and it opens no file.
//!
//! ```
//! use geometry::shapes::block;
//! use geometry::{DVec3, Material, Rgb, TexturedMesh};
//! use mesh_io::gltf::{read_mesh_glb, write_mesh_glb};
//!
//! let mut mesh = TexturedMesh::default();
//! mesh.add(block(DVec3::splat(0.5)), &Material::plain("oak", Rgb::hex(0xb0_8a_5a), 0.6));
//! assert_eq!(read_mesh_glb(&write_mesh_glb(&mesh))?, mesh);
//! # Ok::<(), mesh_io::gltf::GltfError>(())
//! ```

pub mod gltf;
pub mod obj_archive;
