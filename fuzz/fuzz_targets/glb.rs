//! GLB files, as mesh generators send them.
#![no_main]

use libfuzzer_sys::fuzz_target;
use mesh_io::gltf::read_mesh_glb;

fuzz_target!(|file: &[u8]| {
    if let Ok(mesh) = read_mesh_glb(file) {
        // What is taken can be measured: every index leads to a vertex.
        let _ = (mesh.size_m(), mesh.triangle_count(), mesh.bounds());
    }
});
