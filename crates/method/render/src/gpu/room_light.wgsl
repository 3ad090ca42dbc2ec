// Light in a room, room_light.rs's, from prefiltered octahedral maps, environment_map.rs's. Shares are those of
// windows, walls, ceiling and ground.

fn room_f32(k: u32) -> f32 {
    return light_f32(job.room_at + k);
}

fn room_vec3(k: u32) -> vec3<f32> {
    return vec3(room_f32(k), room_f32(k + 1u), room_f32(k + 2u));
}

fn tabletop_low() -> vec2<f32> {
    return vec2(room_f32(19u), room_f32(23u));
}

fn tabletop_high() -> vec2<f32> {
    return vec2(room_f32(27u), room_f32(31u));
}

fn sign_of(p: vec2<f32>) -> vec2<f32> {
    return select(vec2(1.0), vec2(-1.0), p < vec2(0.0));
}

// Position of a direction in the octahedral square.
fn octahedral(d: vec3<f32>) -> vec2<f32> {
    let p = d.xy / (abs(d.x) + abs(d.y) + abs(d.z));
    return 0.5 * select(p, (1.0 - abs(p.yx)) * sign_of(p), d.z < 0.0) + 0.5;
}

fn environment_texel(at: u32) -> vec4<f32> {
    return vec4(light_f32(at), light_f32(at + 1u), light_f32(at + 2u), light_f32(at + 3u));
}

fn environment_bilinear(number: u32, at: vec2<f32>) -> vec4<f32> {
    let side = light[job.room_at + 49u + 2u * number];
    let p = at * f32(side) + 0.5;
    let low = min(vec2<u32>(max(p, vec2(0.0))), vec2(side));
    let t = p - vec2<f32>(low);
    let stride = side + 2u;
    let first = light[job.room_at + 50u + 2u * number] + 4u * (low.y * stride + low.x);
    let lower = mix(environment_texel(first), environment_texel(first + 4u), t.x);
    let next = first + 4u * stride;
    return mix(lower, mix(environment_texel(next), environment_texel(next + 4u), t.x), t.y);
}

// A direction of the world in the frame of the map.
fn in_map(d: vec3<f32>) -> vec3<f32> {
    let w = vec2(room_f32(3u), room_f32(7u));
    return vec3(d.x * w.x + d.y * w.y, d.y * w.x - d.x * w.y, d.z);
}

fn diffuse_shares(normal: vec3<f32>) -> vec4<f32> {
    return environment_bilinear(DIFFUSE_MAP, octahedral(in_map(normal)));
}

// Radiance of what is above the horizon.
fn from_above(shares: vec4<f32>) -> vec3<f32> {
    return room_vec3(0u) * shares.x + room_vec3(4u) * shares.y + room_vec3(8u) * shares.z;
}

// Light on a surface by what can hide it, partly_open.rs's.
struct PartlyOpen {
    far: vec3<f32>,
    arriving: f32,
    near: vec3<f32>,
    near_open: f32,
}

fn with_reflections(open: f32, albedo: vec3<f32>) -> vec3<f32> {
    let a = 2.0404 * albedo - 0.3324;
    let b = -4.7951 * albedo + 0.6417;
    let c = 2.7552 * albedo + 0.6903;
    return clamp(((a * open + b) * open + c) * open, vec3(open), vec3(1.0));
}

// Light that arrives between surfaces of that albedo.
fn between(light: PartlyOpen, albedo: vec3<f32>) -> vec3<f32> {
    let lit = SHADED + (1.0 - SHADED) * with_reflections(light.near_open, albedo);
    return light.far * with_reflections(light.arriving, albedo) + light.near * lit;
}

// Share of light from above that arrives without reflections.
fn arriving_share(seen: SkyShare) -> f32 {
    return seen.arriving * (0.6 + 0.4 * seen.arriving);
}

// Light in these shares where what lies below has this radiance if nothing shades it.
fn partly_open(shares: vec4<f32>, below: vec3<f32>, around: Ambient) -> PartlyOpen {
    let enclosed = (1.0 - around.below_open) * (1.0 - around.seen.arriving);
    let open_sky = from_above(diffuse_shares(vec3(0.0, 0.0, 1.0)));
    return PartlyOpen(
        from_above(shares) + shares.w * enclosed * open_sky,
        arriving_share(around.seen),
        shares.w * (1.0 - enclosed) * below,
        around.below_open,
    );
}

fn room_diffuse(normal: vec3<f32>, around: Ambient) -> PartlyOpen {
    return partly_open(diffuse_shares(normal), around.below_light, around);
}

fn share_on_tabletop(point: vec3<f32>, direction: vec3<f32>, roughness: f32) -> f32 {
    let height = point.z - room_f32(11u);
    if height < -0.01 {
        return 0.0;
    }
    let reach = max(height, 0.0) / max(-direction.z, 0.1);
    let at = point.xy + reach * direction.xy;
    let outside = max(tabletop_low() - at, at - tabletop_high());
    return clamp(0.5 - max(outside.x, outside.y) / (0.02 + roughness * reach), 0.0, 1.0);
}

fn room_mirrored(point: vec3<f32>, direction: vec3<f32>, roughness: f32, around: Ambient) -> PartlyOpen {
    let level = clamp(roughness * ROUGHNESS_STEPS, 0.0, ROUGHNESS_STEPS);
    let sharp = min(u32(level), DIFFUSE_MAP - 2u);
    let at = octahedral(in_map(direction));
    let shares =
        mix(environment_bilinear(sharp, at), environment_bilinear(sharp + 1u, at), level - f32(sharp));
    if shares.w <= 0.0 {
        return partly_open(shares, vec3(0.0), around);
    }
    let below = mix(around.below_light, room_vec3(63u), share_on_tabletop(point, direction, roughness));
    return partly_open(shares, below, around);
}

// Where a ray that descends meets a height; at its start if that lies below.
fn met_below(point: vec3<f32>, toward: vec3<f32>, z: f32) -> vec3<f32> {
    let reach = max(point.z - z, 0.0) / max(-toward.z, 0.05);
    return vec3((point + reach * toward).xy, z);
}

// What lies below a surface point: where, whether on the tabletop, and whether it counts.
struct Below {
    point: vec3<f32>,
    on_tabletop: bool,
    counts: bool,
}

fn below(point: vec3<f32>, normal: vec3<f32>) -> Below {
    if job.has_room == 0u || normal.z > 0.98 {
        return Below(vec3(0.0), false, false);
    }
    let toward = unit_or(vec3(normal.xy, normal.z - 1.0), vec3(0.0, 0.0, -1.0));
    let tabletop_z = room_f32(11u);
    let at = met_below(point, toward, tabletop_z);
    if point.z > tabletop_z - 0.002 && all(at.xy >= tabletop_low()) && all(at.xy <= tabletop_high()) {
        return Below(at, true, true);
    }
    return Below(met_below(point, toward, job.floor_z_m), false, true);
}

// Radiance of a place where nothing shades it.
fn open_light(below: Below) -> vec3<f32> {
    return select(room_vec3(12u), room_vec3(16u), below.on_tabletop);
}
