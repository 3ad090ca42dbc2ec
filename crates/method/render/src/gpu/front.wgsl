// Depth, id and normal of what is in front at the pixel centers, a thread a pixel: five words each.

const FRONT_WORDS = 5u;

@compute @workgroup_size(THREADS)
fn front(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let at = (group.y * groups.x + group.x) * THREADS + thread;
    if at >= job.width_px * job.rows_px {
        return;
    }
    let result = results_at() + at * FRONT_WORDS;
    let index = front_at(at);
    if index == NOTHING {
        for (var k = 0u; k < FRONT_WORDS; k++) {
            state[result + k] = 0u;
        }
        return;
    }
    let triangle = triangle_at(index);
    let pixel = vec2(at % job.width_px, job.first_row_px + at / job.width_px);
    let found = hit(triangle, vec2<f32>(pixel) + 0.5);
    let flat_normal = turned_toward(triangle.facing, toward_eye(found.in_camera));
    let normal = smooth_normal(triangle, found.weights, flat_normal);
    state[result] = bitcast<u32>(depth_of(key_of(state[keys_at() + at])));
    state[result + 1u] = scene[job.materials_at + triangle.material * MATERIAL_WORDS + 7u];
    state[result + 2u] = bitcast<u32>(normal.x);
    state[result + 3u] = bitcast<u32>(normal.y);
    state[result + 4u] = bitcast<u32>(normal.z);
}
