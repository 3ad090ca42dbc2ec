// The objects, as scene_words.rs lays them out.

@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(1) var<storage, read> scene: array<u32>;

const VERTEX_WORDS = 8u;
const TRIANGLE_WORDS = 8u;
const MATERIAL_WORDS = 21u;

const ONE_SIDED = 1u;
const TRANSPARENT = 2u;

struct Triangle {
    vertices: vec3<u32>,
    flags: u32,
    // Unit, in the world, by its winding.
    facing: vec3<f32>,
    material: u32,
}

fn scene_f32(at: u32) -> f32 {
    return bitcast<f32>(scene[at]);
}

fn scene_vec3(at: u32) -> vec3<f32> {
    return vec3(scene_f32(at), scene_f32(at + 1u), scene_f32(at + 2u));
}

fn triangle_at(index: u32) -> Triangle {
    let at = job.triangles_at + index * TRIANGLE_WORDS;
    return Triangle(
        vec3(scene[at], scene[at + 1u], scene[at + 2u]),
        scene[at + 3u],
        scene_vec3(at + 4u),
        scene[at + 7u],
    );
}

// In the camera's frame.
fn corner_in_camera(vertex: u32) -> vec3<f32> {
    return moved(job.camera_from_world, scene_vec3(vertex * VERTEX_WORDS));
}
