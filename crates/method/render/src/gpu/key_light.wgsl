// Soft shadows of the key light, light_map.rs's: percentage-closer, with coarse blocks that answer most points.

// The map's keys, its dilated coarse blocks, its fine blocks, what glass lets pass; then the floor's nodes.
@group(0) @binding(3) var<storage, read> light: array<u32>;

const DISK_WORDS = 16u * (1u + TAP_GROUPS);

fn light_f32(at: u32) -> f32 {
    return bitcast<f32>(light[at]);
}

fn block_of(c: f32, size: u32) -> u32 {
    return min(u32(max(c, 0.0)), size - 1u) / FINE;
}

// At least the highest key within `radius` texels.
fn highest_within(p: vec2<f32>, radius: f32) -> f32 {
    let columns = (job.map_width + FINE - 1u) / FINE;
    let left = block_of(p.x - radius, job.map_width);
    let right = block_of(p.x + radius, job.map_width);
    let bottom = block_of(p.y + radius, job.map_height);
    var highest = LOWEST_F32;
    for (var row = block_of(p.y - radius, job.map_height); row <= bottom; row++) {
        for (var column = left; column <= right; column++) {
            highest = max(highest, light_f32(job.fine_at + row * columns + column));
        }
    }
    return highest;
}

// Outside the map keys are those of the empty border.
fn map_key(p: vec2<f32>) -> f32 {
    let last = vec2(f32(job.map_width), f32(job.map_height)) - 1.0;
    let texel = vec2<u32>(clamp(p, vec2(0.0), last));
    return light_f32(texel.y * job.map_width + texel.x);
}

fn is_lit(x: i32, y: i32, key: f32) -> f32 {
    if x < 0 || y < 0 || u32(x) >= job.map_width || u32(y) >= job.map_height {
        return 1.0;
    }
    return select(0.0, 1.0, light_f32(u32(y) * job.map_width + u32(x)) <= key);
}

// Share of the four texels around a position that let light through to `key`, bilinearly.
fn lit_share(p: vec2<f32>, key: f32) -> f32 {
    let low = vec2<i32>(floor(p - 0.5));
    let t = p - 0.5 - vec2<f32>(low);
    let upper = mix(is_lit(low.x, low.y, key), is_lit(low.x + 1, low.y, key), t.x);
    let lower = mix(is_lit(low.x, low.y + 1, key), is_lit(low.x + 1, low.y + 1, key), t.x);
    return mix(upper, lower, t.y);
}

// Change of the key of a surface with this normal per texel sideways; and per meter away from it.
fn key_slope(normal: vec3<f32>) -> vec3<f32> {
    let in_light = turned(job.light_from_world, normal);
    let facing = min(in_light.z, STEEPEST);
    return vec3(in_light.xy / facing * job.texel_m, -1.0 / facing);
}

// Up to which key a texel off the point is below the plane of the surface, which rises to one side of a steep one.
fn plane_key(lit_up_to: f32, slope: vec2<f32>, offset: vec2<f32>) -> f32 {
    return lit_up_to + max(dot(slope, offset), 0.0);
}

fn disk_point(disk: u32, k: u32) -> vec2<f32> {
    return vec2(scene_f32(disk + 2u * k), scene_f32(disk + 2u * k + 1u));
}

// Share of the round light that reaches the point; `turn` (0..1) rotates the sampling pattern.
fn key_visibility(point: vec3<f32>, normal: vec3<f32>, turn: f32) -> f32 {
    if job.map_width == 0u {
        return 1.0;
    }
    let in_light = moved(job.light_from_world, point + normal * (1.2 * job.texel_m));
    let p = in_light.xy * job.texels_per_m + BORDER;
    let key = -in_light.z;
    let size = vec2(f32(job.map_width), f32(job.map_height));
    if any(p < vec2(-job.reach)) || any(p >= size + job.reach) {
        return 1.0;
    }
    let block = min(
        vec2<u32>(max(p, vec2(0.0))) / COARSE,
        vec2(job.coarse_width - 1u, job.coarse_height - 1u),
    );
    let lit_up_to = key + 0.6 * job.texel_m;
    var highest = light_f32(job.coarse_at + block.y * job.coarse_width + block.x);
    if highest <= lit_up_to {
        return 1.0;
    }
    var search = clamp((highest - key) * job.spread, 1.0, job.reach);
    if search <= FEW_BLOCKS {
        highest = highest_within(p, search + 1.0);
        if highest <= lit_up_to {
            return 1.0;
        }
        search = clamp((highest - key) * job.spread, 1.0, job.reach);
    }
    // The points of a narrow penumbra are the first eight.
    let disk = job.disks_at + (u32(turn * f32(TURNS)) % TURNS) * DISK_WORDS;
    let wide = disk + 16u;
    let slope = key_slope(normal).xy;
    var sum = 0.0;
    var count = 0u;
    for (var k = 0u; k < 8u * SEARCH_GROUPS; k++) {
        let offset = search * disk_point(wide, k);
        let found = map_key(p + offset);
        if found > plane_key(lit_up_to, slope, offset) {
            sum += found;
            count++;
        }
    }
    if count == 0u {
        return 1.0;
    }
    if count == 8u * SEARCH_GROUPS {
        return 0.0;
    }
    let width = clamp((sum / f32(count) - key) * job.spread, 0.8, job.reach);
    if width < NARROW {
        var lit = 0.0;
        for (var k = 0u; k < 8u; k++) {
            let offset = width * disk_point(disk, k);
            lit += lit_share(p + offset, plane_key(lit_up_to, slope, offset));
        }
        return lit / 8.0;
    }
    // Where all of the first half agree, the second would.
    let few = 4u * TAP_GROUPS;
    var lit = 0u;
    for (var k = 0u; k < 2u * few; k++) {
        if k == few && (lit == 0u || lit == few) {
            return f32(lit) / f32(few);
        }
        let offset = width * disk_point(wide, k);
        lit += select(0u, 1u, map_key(p + offset) <= plane_key(lit_up_to, slope, offset));
    }
    return f32(lit) / f32(2u * few);
}

// A resolution of what glass lets pass, light_map/glass.rs's.
struct GlassLevel {
    at: u32,
    width: u32,
    height: u32,
    scale: f32,
}

fn glass_level(number: u32) -> GlassLevel {
    let at = job.glass_at + 3u + 3u * number;
    return GlassLevel(light[at], light[at + 1u], light[at + 2u], 1.0 / f32(1u << number));
}

// Share of light that passes, by color; and the nearest key.
fn glass_texel(level: GlassLevel, p: vec2<i32>) -> vec4<f32> {
    if any(p < vec2(0)) || u32(p.x) >= level.width || u32(p.y) >= level.height {
        return vec4(1.0, 1.0, 1.0, LOWEST_F32);
    }
    let at = level.at + 4u * (u32(p.y) * level.width + u32(p.x));
    return vec4(light_f32(at), light_f32(at + 1u), light_f32(at + 2u), light_f32(at + 3u));
}

// The key above which glass at a texel is in the way of a point at `p`: it is above the plane of the surface.
fn glass_limit(level: GlassLevel, texel: vec2<i32>, p: vec2<f32>, lit_up_to: f32, slope: vec2<f32>) -> f32 {
    let width = GLASS_WIDER / level.scale;
    let rises = slope * ((vec2<f32>(texel) + 0.5) * width - p * GLASS_WIDER) + 0.5 * width * abs(slope);
    return lit_up_to + max(rises.x + rises.y, 0.0);
}

// What passes about a position of the finest level; and the mean key of what is in the way there, if anything is.
fn glass_about(number: u32, p: vec2<f32>, lit_up_to: f32, slope: vec2<f32>, highest: f32) -> vec4<f32> {
    let level = glass_level(number);
    let at = p * level.scale - 0.5;
    let low = vec2<i32>(floor(at));
    let t = at - vec2<f32>(low);
    var passing = vec3(0.0);
    var keys = 0.0;
    var weights = 0.0;
    for (var k = 0; k < 4; k++) {
        let corner = vec2(k & 1, k >> 1u);
        let weight = select(1.0 - t.x, t.x, corner.x == 1) * select(1.0 - t.y, t.y, corner.y == 1);
        let texel = glass_texel(level, low + corner);
        if texel.w > glass_limit(level, low + corner, p, lit_up_to, slope) {
            passing += weight * texel.xyz;
            keys += weight * texel.w;
            weights += weight;
        } else {
            passing += vec3(weight);
        }
    }
    if weights > 1e-3 {
        return vec4(passing, keys / weights);
    }
    return vec4(passing, highest);
}

fn glass_blur(above: f32, key: f32) -> f32 {
    let radius = max((above - key) * job.spread / GLASS_WIDER, 1.0);
    return min(log2(radius), f32(GLASS_LEVELS - 1u));
}

// Share of the key light that transparent objects let pass to the point, by color.
fn through_glass(point: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    if job.glass_at == 0u {
        return vec3(1.0);
    }
    let in_light = moved(job.light_from_world, point + normal * (1.2 * job.texel_m));
    let p = (in_light.xy * job.texels_per_m + BORDER) / GLASS_WIDER;
    let key = -in_light.z;
    let slope = key_slope(normal);
    let lit_up_to = key + 0.6 * job.texel_m + GLASS_CLOSE_M * slope.z;
    let coarse = vec2(light[job.glass_at + 1u], light[job.glass_at + 2u]);
    let block = min(vec2<u32>(max(p, vec2(0.0))) >> vec2(GLASS_NEAR_LEVEL), coarse - 1u);
    let highest = light_f32(light[job.glass_at] + block.y * coarse.x + block.x);
    if highest <= lit_up_to {
        return vec3(1.0);
    }
    // The highest glass of the neighborhood need not be what is in the way: sought first, then the two levels.
    var blur = glass_blur(highest, key);
    var passing = vec3(0.0);
    for (var k = 0u; k < 3u; k++) {
        let number = min(u32(blur) + select(0u, 1u, k == 2u), GLASS_LEVELS - 1u);
        let found = glass_about(number, p, lit_up_to, slope.xy, highest);
        if k == 0u {
            blur = glass_blur(found.w, key);
        } else if k == 1u {
            passing = found.xyz;
        } else {
            passing = mix(passing, found.xyz, blur - floor(blur));
        }
    }
    return passing;
}
