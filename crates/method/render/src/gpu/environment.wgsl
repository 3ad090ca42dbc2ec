// Light of sky and surroundings, environment.rs's, and on the backdrop's floor, floor_light.rs's.

// Light that a white matte surface of that normal reflects from sky and ground.
fn diffuse_light(normal: vec3<f32>, seen: SkyShare) -> vec3<f32> {
    let up = 0.5 + 0.5 * normal.z;
    return job.sky_color * (up * (0.12 + 0.88 * seen.arriving))
        + job.ground_color * ((1.0 - up) * (0.35 + 0.65 * seen.open));
}

fn lamp(direction: vec3<f32>, toward: vec3<f32>, sharp: f32, size: f32) -> f32 {
    let near = (dot(direction, toward) - 1.0) * sharp / size;
    return min(0.4 * sqrt(sharp) * exp(near), 1.0);
}

// What a mirror sees in that direction, blurred by `roughness`.
fn mirrored(direction: vec3<f32>, roughness: f32) -> vec3<f32> {
    let wall = 0.55 * job.sky_color + 0.25 * job.ground_color;
    let width = 0.25 + 0.75 * roughness;
    let above = mix(wall, 1.35 * job.sky_color, max(direction.z, 0.0));
    let below = mix(0.7 * wall, job.ground_color, clamp(-2.0 * direction.z, 0.0, 1.0));
    let base = mix(below, above, clamp((direction.z + width) / (2.0 * width), 0.0, 1.0));
    let sharp = 1.0 / (0.06 + 0.9 * roughness * roughness);
    let lamps = 0.9 * lamp(direction, job.side_box, sharp, 1.5) + 0.7 * lamp(direction, job.rim_box, sharp, 1.0);
    return base + job.key_color * lamps;
}

fn floor_node(x: u32, y: u32) -> vec3<f32> {
    let at = job.floor_at + 3u * (y * job.floor_nodes + x);
    return vec3(light_f32(at), light_f32(at + 1u), light_f32(at + 2u));
}

// Bilinear sample; positions beyond the grid take its edge value.
fn floor_light(point: vec2<f32>) -> vec3<f32> {
    let last = f32(job.floor_nodes - 1u);
    let p = clamp((point - job.floor_low) * job.nodes_per_m, vec2(0.0), vec2(last));
    let node = min(vec2<u32>(p), vec2(job.floor_nodes - 2u));
    let t = p - vec2<f32>(node);
    let upper = mix(floor_node(node.x, node.y), floor_node(node.x + 1u, node.y), t.x);
    let lower = mix(floor_node(node.x, node.y + 1u), floor_node(node.x + 1u, node.y + 1u), t.x);
    return mix(upper, lower, t.y);
}
