// Textures sampled trilinearly with repetition, texture_map.rs's.

struct Level {
    at: u32,
    width: u32,
    height: u32,
}

fn level_at(texture: u32, number: u32) -> Level {
    let at = texture + 2u + 3u * number;
    return Level(scene[at], scene[at + 1u], scene[at + 2u]);
}

// Linear light.
fn texel(level: Level, x: u32, y: u32) -> vec3<f32> {
    let rgba = scene[level.at + y * level.width + x];
    let bytes = job.linear_of_srgb_at + vec3(rgba & 255u, (rgba >> 8u) & 255u, (rgba >> 16u) & 255u);
    return vec3(scene_f32(bytes.x), scene_f32(bytes.y), scene_f32(bytes.z));
}

fn wrapped(c: i32, size: u32) -> u32 {
    if c < 0 {
        return size - 1u;
    }
    return select(u32(c), 0u, u32(c) >= size);
}

fn bilinear(level: Level, uv: vec2<f32>) -> vec3<f32> {
    let x = (uv.x - floor(uv.x)) * f32(level.width) - 0.5;
    let y = (1.0 - (uv.y - floor(uv.y))) * f32(level.height) - 0.5;
    let low = vec2<i32>(vec2(floor(x), floor(y)));
    let t = vec2(x, y) - vec2<f32>(low);
    let x0 = wrapped(low.x, level.width);
    let x1 = wrapped(low.x + 1, level.width);
    let y0 = wrapped(low.y, level.height);
    let y1 = wrapped(low.y + 1, level.height);
    let upper = mix(texel(level, x0, y0), texel(level, x1, y0), t.x);
    let lower = mix(texel(level, x0, y1), texel(level, x1, y1), t.x);
    return mix(upper, lower, t.y);
}

// v = 0 at the bottom; level 0 = full size, 1 = halved, ...
fn texture_color(texture: u32, uv: vec2<f32>, wanted: f32) -> vec3<f32> {
    let last = scene[texture + 1u] - 1u;
    let level = clamp(wanted, 0.0, f32(last));
    let fine = u32(level);
    let blend = level - f32(fine);
    let color = bilinear(level_at(texture, fine), uv);
    if blend < 0.02 || fine == last {
        return color;
    }
    return mix(color, bilinear(level_at(texture, fine + 1u), uv), blend);
}
