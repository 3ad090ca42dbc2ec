// Which triangle is in front at each sample, and which see-through ones lie before it: prepare.rs's and
// raster.rs's. `scatter` draws small triangles, one a thread, and lists the large ones; `sweep` draws those, a
// workgroup a tile of 16 x 16 pixels, 64 of them at a time. Three phases, each both passes: the nearest key, the
// first triangle that has it, the layers of glass before it. Keys are the same in every phase, because it is the
// same code that computes them.

@group(0) @binding(2) var<storage, read_write> state: array<atomic<u32>>;
@group(0) @binding(3) var<storage, read_write> large: array<u32>;
// Next layer of the pixel (0: none), triangle, samples that it covers, sum of the corners' keys.
@group(0) @binding(4) var<storage, read_write> layers: array<vec4<u32>>;

const KEYS = 0u;
const FRONTS = 1u;
const LAYERS = 2u;

const KEEP_OPAQUE = 1u;
const KEEP_TRANSPARENT = 2u;

// More samples than this in its box make a triangle large.
const SMALL_SAMPLES = 256u;

// Pixel positions and keys of the corners.
struct Screen {
    x: vec3<f32>,
    y: vec3<f32>,
    key: vec3<f32>,
    drawn: bool,
}

struct Edges {
    start_x: vec3<f32>,
    start_y: vec3<f32>,
    extent_x: vec3<f32>,
    extent_y: vec3<f32>,
    // Whether a sample on the edge is inside.
    closed: vec3<bool>,
    first: vec3<f32>,
    key_slope: vec2<f32>,
    key_low: f32,
    key_high: f32,
    key_sum: f32,
    triangle: u32,
    // Samples that may be inside: first and, one beyond, last.
    low: vec2<u32>,
    end: vec2<u32>,
}

fn projected(p: vec3<f32>) -> vec3<f32> {
    if job.perspective != 0u {
        let key = 1.0 / p.z;
        return vec3(job.lens.xy * p.xy * key + job.lens.zw, key);
    }
    return vec3(job.lens.xy * p.xy + job.lens.zw, -p.z);
}

// The part before the near plane has up to four corners: piece 0 and, if there is a fourth, piece 1.
fn screen_of(triangle: Triangle, piece: u32) -> Screen {
    let near = select(0.0, NEAR_M, job.perspective != 0u);
    var corners: array<vec3<f32>, 3>;
    corners[0] = corner_in_camera(triangle.vertices.x);
    corners[1] = corner_in_camera(triangle.vertices.y);
    corners[2] = corner_in_camera(triangle.vertices.z);
    var kept: array<vec3<f32>, 5>;
    var count = 0u;
    for (var k = 0u; k < 3u; k++) {
        let p = corners[k];
        let q = corners[(k + 1u) % 3u];
        if p.z >= near {
            kept[count] = projected(p);
            count++;
        }
        if (p.z < near) != (q.z < near) {
            let cut = p + (near - p.z) / (q.z - p.z) * (q - p);
            kept[count] = projected(vec3(cut.xy, near));
            count++;
        }
    }
    let a = kept[0];
    let b = kept[1u + piece];
    let c = kept[2u + piece];
    var screen = Screen(vec3(a.x, b.x, c.x), vec3(a.y, b.y, c.y), vec3(a.z, b.z, c.z), count >= 3u + piece);
    let seen_from_behind = doubled_area(screen) > 0.0;
    screen.drawn = screen.drawn && !((triangle.flags & ONE_SIDED) != 0u && seen_from_behind);
    return screen;
}

fn doubled_area(s: Screen) -> f32 {
    return (s.x.y - s.x.x) * (s.y.z - s.y.x) - (s.y.y - s.y.x) * (s.x.z - s.x.x);
}

// First sample, and one beyond the last, whose center lies within the span of the coordinates; equal if none.
fn covered(c: vec3<f32>, begin: u32, end: u32) -> vec2<u32> {
    let low = max(min(c.x, min(c.y, c.z)) - 0.5, f32(begin));
    let high = min(max(c.x, max(c.y, c.z)) - 0.5, f32(end) - 1.0);
    if !(low <= high) {
        return vec2(begin, begin);
    }
    return vec2(u32(ceil(low)), u32(floor(high)) + 1u);
}

fn is_kept(triangle: Triangle) -> bool {
    let transparent = (triangle.flags & TRANSPARENT) != 0u;
    return !(job.keep == KEEP_OPAQUE && transparent) && !(job.keep == KEEP_TRANSPARENT && !transparent);
}

// Edge functions for the row loop; the box is empty if there is nothing to draw.
fn edges_of(s: Screen, triangle: u32) -> Edges {
    var edges: Edges;
    edges.triangle = triangle;
    let columns = covered(s.x, 0u, job.width_px * SAMPLES);
    let rows = covered(s.y, job.first_row_px * SAMPLES, (job.first_row_px + job.rows_px) * SAMPLES);
    let area = doubled_area(s);
    if !s.drawn || columns.x >= columns.y || rows.x >= rows.y || !(abs(area) > 0.0 && abs(area) < 1e30) {
        return edges;
    }
    edges.low = vec2(columns.x, rows.x);
    edges.end = vec2(columns.y, rows.y);
    for (var k = 0u; k < 3u; k++) {
        let j = (k + 1u) % 3u;
        let a = vec2(s.x[k], s.y[k]);
        let b = vec2(s.x[j], s.y[j]);
        // From the lexicographically smaller end, so that both triangles of an edge compute the same number.
        let forward = a.x < b.x || (a.x == b.x && a.y < b.y);
        let start = select(b, a, forward);
        let extent = select(a, b, forward) - start;
        let turned = forward == (area > 0.0);
        let sign = select(-1.0, 1.0, turned);
        edges.start_x[k] = start.x;
        edges.start_y[k] = start.y;
        edges.extent_x[k] = sign * extent.x;
        edges.extent_y[k] = sign * extent.y;
        edges.closed[k] = turned;
    }
    let gain = s.key.yz - s.key.x;
    let side_x = s.x.yz - s.x.x;
    let side_y = s.y.yz - s.y.x;
    edges.first = vec3(s.x.x, s.y.x, s.key.x);
    edges.key_slope =
        vec2(gain.x * side_y.y - gain.y * side_y.x, gain.y * side_x.x - gain.x * side_x.y) / area;
    edges.key_low = min(s.key.x, min(s.key.y, s.key.z));
    edges.key_high = max(s.key.x, max(s.key.y, s.key.z));
    edges.key_sum = s.key.x + s.key.y + s.key.z;
    return edges;
}

// The key at a sample as an ordered number, 0 outside of the triangle.
fn key_at(edges: Edges, sample: vec2<u32>) -> u32 {
    let p = vec2<f32>(sample) + 0.5;
    let value = (vec3(p.y) - edges.start_y) * edges.extent_x - (vec3(p.x) - edges.start_x) * edges.extent_y;
    if !all((value > vec3(0.0)) | ((value == vec3(0.0)) & edges.closed)) {
        return 0u;
    }
    let offset = p - edges.first.xy;
    let key = offset.x * edges.key_slope.x + (edges.first.z + offset.y * edges.key_slope.y);
    return ordered(clamp(key, edges.key_low, edges.key_high));
}

fn draw_sample(edges: Edges, sample: vec2<u32>) {
    let key = key_at(edges, sample);
    if key == 0u {
        return;
    }
    let at = sample_index(sample);
    if job.phase == KEYS {
        atomicMax(&state[keys_at() + at], key);
    } else if key == atomicLoad(&state[keys_at() + at]) {
        // The first of the list has the largest complement; 0 is nothing.
        atomicMax(&state[fronts_at() + at], ~edges.triangle);
    }
}

// Notes the layer if the triangle is before what is in front at any sample of the pixel.
fn draw_layer(edges: Edges, pixel: vec2<u32>) {
    var mask = 0u;
    for (var k = 0u; k < SAMPLES * SAMPLES; k++) {
        let sample = pixel * SAMPLES + vec2(k % SAMPLES, k / SAMPLES);
        if all(sample >= edges.low) && all(sample < edges.end) {
            let key = key_at(edges, sample);
            if key > atomicLoad(&state[keys_at() + sample_index(sample)]) {
                mask |= 1u << k;
            }
        }
    }
    if mask == 0u {
        return;
    }
    // The count continues without room, so that it reports the required capacity.
    let layer = atomicAdd(&state[2], 1u);
    if layer < job.layer_capacity {
        let next = atomicExchange(&state[heads_at() + pixel_index(pixel)], layer + 1u);
        layers[layer] = vec4(next, edges.triangle, mask, bitcast<u32>(edges.key_sum));
    }
}

fn list_counter() -> u32 {
    return select(0u, 1u, job.phase == LAYERS);
}

@compute @workgroup_size(THREADS)
fn scatter(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let index = (group.y * groups.x + group.x) * THREADS + thread;
    if index >= job.triangles {
        return;
    }
    let triangle = triangle_at(index);
    if !is_kept(triangle) {
        return;
    }
    for (var piece = 0u; piece < 2u; piece++) {
        let edges = edges_of(screen_of(triangle, piece), index);
        let size = edges.end - edges.low;
        if size.x > SMALL_SAMPLES || size.y > SMALL_SAMPLES || size.x * size.y > SMALL_SAMPLES {
            // The second phase draws what the first listed.
            if job.phase != FRONTS {
                large[atomicAdd(&state[list_counter()], 1u)] = 2u * index + piece;
            }
        } else if size.x > 0u && job.phase == LAYERS {
            let low = edges.low / SAMPLES;
            let end = (edges.end + SAMPLES - 1u) / SAMPLES;
            for (var y = low.y; y < end.y; y++) {
                for (var x = low.x; x < end.x; x++) {
                    draw_layer(edges, vec2(x, y));
                }
            }
        } else {
            for (var y = edges.low.y; y < edges.end.y; y++) {
                for (var x = edges.low.x; x < edges.end.x; x++) {
                    draw_sample(edges, vec2(x, y));
                }
            }
        }
    }
}

var<workgroup> near: array<Edges, THREADS>;
// A bit for each of the 64 triangles: whether its box touches the tile.
var<workgroup> touched: array<atomic<u32>, 2>;
var<workgroup> listed: u32;

@compute @workgroup_size(THREADS)
fn sweep(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let tile_low = vec2(group.x * TILE_PX, job.first_row_px + group.y * TILE_PX);
    let tile_end =
        min(tile_low + TILE_PX, vec2(job.width_px, job.first_row_px + job.rows_px));
    if thread == 0u {
        listed = atomicLoad(&state[list_counter()]);
    }
    let count = workgroupUniformLoad(&listed);
    for (var first = 0u; first < count; first += THREADS) {
        if thread < 2u {
            atomicStore(&touched[thread], 0u);
        }
        workgroupBarrier();
        if first + thread < count {
            let entry = large[first + thread];
            let edges = edges_of(screen_of(triangle_at(entry / 2u), entry % 2u), entry / 2u);
            near[thread] = edges;
            if all(edges.low < tile_end * SAMPLES) && all(edges.end > tile_low * SAMPLES) {
                atomicOr(&touched[thread / 32u], 1u << (thread % 32u));
            }
        }
        workgroupBarrier();
        for (var word = 0u; word < 2u; word++) {
            var bits = atomicLoad(&touched[word]);
            while bits != 0u {
                let edges = near[word * 32u + firstTrailingBit(bits)];
                bits &= bits - 1u;
                for (var k = thread; k < TILE_PX * TILE_PX; k += THREADS) {
                    let pixel = tile_low + vec2(k % TILE_PX, k / TILE_PX);
                    if any(pixel >= tile_end) {
                        continue;
                    }
                    if job.phase == LAYERS {
                        draw_layer(edges, pixel);
                        continue;
                    }
                    for (var s = 0u; s < SAMPLES * SAMPLES; s++) {
                        let sample = pixel * SAMPLES + vec2(s % SAMPLES, s / SAMPLES);
                        if all(sample >= edges.low) && all(sample < edges.end) {
                            draw_sample(edges, sample);
                        }
                    }
                }
            }
        }
        workgroupBarrier();
    }
}
