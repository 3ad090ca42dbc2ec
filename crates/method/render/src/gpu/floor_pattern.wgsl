// Procedural floors, floor_pattern.rs's; lengths in meters.

const BOARDS = 0u;
const TILES = 1u;
const CONCRETE = 2u;
const CARPET = 3u;

// Share of a detail of that size that remains visible after averaging over the footprint.
fn kept(size: f32, footprint: f32) -> f32 {
    return clamp(size / (footprint + 1e-6) - 0.5, 0.0, 1.0);
}

// Darkness of a gap at a distance.
fn gap(distance: f32, half_width: f32, footprint: f32) -> f32 {
    let blur = half_width + 0.75 * footprint;
    let near = clamp(1.0 - distance / (2.0 * blur), 0.0, 1.0);
    return near * near * (3.0 - 2.0 * near) * (half_width / blur);
}

fn boards(p: vec2<f32>, footprint: f32, seed: u32, dark: vec3<f32>, light: vec3<f32>) -> vec3<f32> {
    let across = p.y / 0.13;
    let row = i32(floor(across));
    let along = p.x / 1.35 + hash(row, 17, seed);
    let plank = i32(floor(along));
    let tone = hash(row, plank, seed);
    let cut = vec2(61.0 * tone, 37.0 * hash(plank, row, seed ^ 0x9e37u));
    let bend = value_noise(vec2(2.2 * p.x, 6.0 * p.y) + cut, seed) - 0.5;
    let grain = value_noise(vec2(3.0 * p.x, 95.0 * p.y + 7.0 * bend) + cut, seed) - 0.5;
    let share = 0.5 + 0.62 * (tone - 0.5) + 0.35 * bend + 0.5 * kept(0.011, footprint) * grain;
    let in_row = across - f32(row);
    let in_plank = along - f32(plank);
    let side = 0.13 * min(in_row, 1.0 - in_row);
    let end = 1.35 * min(in_plank, 1.0 - in_plank);
    return mix(dark, light, share) * (1.0 - 0.55 * gap(min(side, end), 0.0016, footprint));
}

fn tiles(p: vec2<f32>, footprint: f32, seed: u32, dark: vec3<f32>, light: vec3<f32>) -> vec3<f32> {
    let q = p / 0.3;
    let cell = vec2<i32>(floor(q));
    let inside = q - vec2<f32>(cell);
    let nearest = min(inside, vec2(1.0) - inside);
    let edge = min(nearest.x, nearest.y) * 0.3;
    let cloud = value_noise(4.5 * p, seed) - 0.5;
    let share = 0.5 + 0.7 * (hash(cell.x, cell.y, seed) - 0.5) + 0.6 * cloud;
    return mix(dark, light, share) * (1.0 - 0.42 * gap(edge, 0.0028, footprint));
}

fn concrete(p: vec2<f32>, footprint: f32, seed: u32) -> f32 {
    let large = value_noise(1.3 * p, seed);
    let medium = value_noise(6.1 * p, seed ^ 0x51u);
    let fine = value_noise(90.0 * p, seed ^ 0xa2u) - 0.5;
    return 0.55 * large + 0.4 * medium + 0.35 * kept(0.011, footprint) * fine;
}

fn carpet(p: vec2<f32>, footprint: f32, seed: u32) -> f32 {
    let tufts = value_noise(180.0 * p, seed) - 0.5;
    let flecks = value_noise(55.0 * p, seed ^ 0x51u) - 0.5;
    let tracks = value_noise(vec2(2.4 * p.x, 5.0 * p.y), seed ^ 0xa2u) - 0.5;
    return 0.5 + 0.9 * kept(0.006, footprint) * tufts + 0.8 * kept(0.018, footprint) * flecks + 0.3 * tracks;
}

fn terrazzo(p: vec2<f32>, footprint: f32, seed: u32, dark: vec3<f32>, light: vec3<f32>) -> vec3<f32> {
    let base = mix(dark, light, 0.25 + 0.5 * value_noise(2.0 * p, seed));
    let q = p / 0.034;
    let cell = vec2<i32>(floor(q));
    let inside = q - vec2<f32>(cell);
    let center = vec2(0.3 + 0.4 * hash(cell.x, cell.y, seed), 0.3 + 0.4 * hash(cell.x, cell.y, seed ^ 0x51u));
    let radius = 0.1 + 0.2 * hash(cell.x, cell.y, seed ^ 0xa2u);
    let turn = 3.0 * hash(cell.x, cell.y, seed ^ 0xf3u);
    let off = inside - center;
    let stretched = off + 0.5 * dot(off, vec2(1.0 - turn, turn - 0.5)) * vec2(1.0, -0.6);
    let blur = 0.06 + footprint / 0.034;
    let share = clamp((radius - length(stretched)) / blur + 0.5, 0.0, 1.0) * kept(0.012, footprint);
    let kind = hash(cell.y, cell.x, seed);
    var chip = vec3(0.75, 0.52, 0.4) * light;
    if kind < 0.35 {
        chip = 0.45 * dark;
    } else if kind < 0.7 {
        chip = min(1.2 * light, vec3(1.0));
    }
    return mix(base, chip, share);
}

fn floor_reflectance(p: vec2<f32>, footprint: f32) -> vec3<f32> {
    let seed = light[job.room_at + 46u];
    let dark = room_vec3(20u);
    let bright = room_vec3(24u);
    switch light[job.room_at + 47u] {
        case BOARDS: {
            return boards(p, footprint, seed, dark, bright);
        }
        case TILES: {
            return tiles(p, footprint, seed, dark, bright);
        }
        case CONCRETE: {
            return mix(dark, bright, concrete(p, footprint, seed));
        }
        case CARPET: {
            return mix(dark, bright, carpet(p, footprint, seed));
        }
        default: {
            return terrazzo(p, footprint, seed, dark, bright);
        }
    }
}
