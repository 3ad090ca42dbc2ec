// Uniform of all passes: the view, the strip of the image, the light, and the offsets of the lists in the buffers.
// Affine maps are three rows, each with its shift last. The host writes the fields in this order.

struct Job {
    camera_from_world: array<vec4<f32>, 3>,
    world_from_camera: array<vec4<f32>, 3>,
    light_from_world: array<vec4<f32>, 3>,
    // Focal lengths in samples, or samples per meter; principal point.
    lens: vec4<f32>,
    toward_key: vec3<f32>,
    key_radius_rad: f32,
    key_color: vec3<f32>,
    exposure: f32,
    sky_color: vec3<f32>,
    floor_z_m: f32,
    ground_color: vec3<f32>,
    nodes_per_m: f32,
    side_box: vec3<f32>,
    texels_per_m: f32,
    rim_box: vec3<f32>,
    texel_m: f32,
    top_color: vec3<f32>,
    reach: f32,
    bottom_color: vec3<f32>,
    spread: f32,
    per_light: vec3<f32>,
    // 0: none.
    floor_nodes: u32,
    floor_low: vec2<f32>,
    perspective: u32,
    // Of a pixel. Known to the shaders too, but loops over a constant number would be unrolled, shading and all.
    all_samples: u32,
    width_px: u32,
    height_px: u32,
    first_row_px: u32,
    rows_px: u32,
    triangles: u32,
    // What is written, and which triangles are drawn.
    phase: u32,
    keep: u32,
    layer_capacity: u32,
    directions: u32,
    // First word of each list in `scene`.
    triangles_at: u32,
    materials_at: u32,
    directions_at: u32,
    disks_at: u32,
    linear_of_srgb_at: u32,
    // In `light`. The key light's map is 0 texels wide where there is none.
    map_width: u32,
    map_height: u32,
    coarse_width: u32,
    coarse_height: u32,
    coarse_at: u32,
    fine_at: u32,
    floor_at: u32,
    has_room: u32,
    room_at: u32,
    // 0: there is no glass.
    glass_at: u32,
}

const NOTHING = 0xffffffffu;

// Words at the beginning of `state`: large triangles to draw, large triangles to lay over, layers.
const COUNTERS = 4u;
// Then of each sample the key, of each sample the triangle, of each pixel its last layer, and what is read back.

fn keys_at() -> u32 {
    return COUNTERS;
}

fn strip_samples() -> u32 {
    return job.width_px * job.rows_px * SAMPLES * SAMPLES;
}

fn fronts_at() -> u32 {
    return COUNTERS + strip_samples();
}

fn heads_at() -> u32 {
    return COUNTERS + 2u * strip_samples();
}

fn results_at() -> u32 {
    return heads_at() + job.width_px * job.rows_px;
}

// Of a sample of the whole image, in its strip.
fn sample_index(sample: vec2<u32>) -> u32 {
    return (sample.y - job.first_row_px * SAMPLES) * (job.width_px * SAMPLES) + sample.x;
}

fn pixel_index(pixel: vec2<u32>) -> u32 {
    return (pixel.y - job.first_row_px) * job.width_px + pixel.x;
}

// Keys as unsigned numbers in the same order, none of them 0.
fn ordered(key: f32) -> u32 {
    let bits = bitcast<u32>(key);
    return select(bits | 0x80000000u, ~bits, (bits & 0x80000000u) != 0u);
}

fn key_of(ordered: u32) -> f32 {
    return bitcast<f32>(select(~ordered, ordered & 0x7fffffffu, (ordered & 0x80000000u) != 0u));
}

fn depth_of(key: f32) -> f32 {
    if job.perspective != 0u {
        return 1.0 / key;
    }
    return -key;
}

fn moved(rows: array<vec4<f32>, 3>, p: vec3<f32>) -> vec3<f32> {
    let point = vec4(p, 1.0);
    return vec3(dot(rows[0], point), dot(rows[1], point), dot(rows[2], point));
}

fn turned(rows: array<vec4<f32>, 3>, v: vec3<f32>) -> vec3<f32> {
    return vec3(dot(rows[0].xyz, v), dot(rows[1].xyz, v), dot(rows[2].xyz, v));
}
