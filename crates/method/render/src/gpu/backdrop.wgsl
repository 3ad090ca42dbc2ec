// What a ray that meets no object shows, backdrop.rs's.

struct BackdropPlace {
    color: vec3<f32>,
    receives: bool,
    point: vec3<f32>,
    normal: vec3<f32>,
    key: vec3<f32>,
    ambient: vec3<f32>,
}

// Soft step over a penumbra of the sun.
fn smoothed(inside: f32) -> f32 {
    let t = clamp(inside / room_f32(71u) + 0.5, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// Distance to the nearest bar between panes; large where there is none.
fn to_bar(p: f32, half_m: f32, pane: f32) -> f32 {
    let bar = floor((p + half_m) / pane + 0.5);
    if bar * pane < 0.5 * pane || bar * pane > 2.0 * half_m - 0.5 * pane {
        return 1e3;
    }
    return abs(p + half_m - bar * pane);
}

// Share of sunlight through a window at a point of the wall, backdrop/sunspot.rs's.
fn sunspot_share(point: vec3<f32>) -> f32 {
    let strength = room_f32(76u);
    let center = vec2(room_f32(44u), room_f32(45u));
    let half_m = vec2(room_f32(66u), room_f32(67u));
    let p = vec2(dot(point, room_vec3(36u)), dot(point, room_vec3(40u))) - center;
    let outer = smoothed(half_m.x - abs(p.x)) * smoothed(half_m.y - abs(p.y));
    if strength <= 0.0 || outer <= 0.0 {
        return 0.0;
    }
    let pane = 2.0 * half_m / vec2(room_f32(68u), room_f32(69u));
    let bar_m = room_f32(70u);
    let bar = max(
        smoothed(bar_m - to_bar(p.x, half_m.x, pane.x)),
        smoothed(bar_m - to_bar(p.y, half_m.y, pane.y)),
    );
    var sun = outer * (1.0 - SUN_PAST_BARS_LESS * bar);
    let slats_m = room_f32(72u);
    if slats_m > 0.0 {
        let wave = 0.5 + 0.5 * cos(p.y * (6.2831855 / slats_m));
        sun *= 1.0 - SUN_PAST_SLATS_LESS * (1.0 - wave);
    }
    let beyond = room_f32(74u) * p.x - room_f32(73u) + 0.02 * sin(7.0 * p.y);
    sun *= 1.0 - SUN_PAST_CURTAIN_LESS * smoothed(beyond);
    let leaves = room_f32(75u);
    if leaves > 0.0 {
        let seed = light[job.room_at + 77u];
        let cover = 0.55 * value_noise(3.1 * p, seed) + 0.45 * value_noise(14.0 * p, seed ^ 0x51u);
        sun *= 1.0 - leaves * clamp(3.0 * (cover - 0.36), 0.0, 1.0);
    }
    return strength * sun;
}

// What is on a wall over its bare reflectance, backdrop/furnishing.rs's.
fn furnished(normal: vec3<f32>, at: vec2<f32>, footprint: f32, bare: vec3<f32>) -> vec3<f32> {
    var wall = select(3u, 2u, normal.y < -0.5);
    wall = select(wall, 1u, normal.x > 0.5);
    wall = select(wall, 0u, normal.x < -0.5);
    let first = light[job.room_at + 78u + 2u * wall];
    let count = light[job.room_at + 79u + 2u * wall];
    var color = bare;
    for (var k = 0u; k < count; k++) {
        let patch_at = first + 9u * k;
        let center = vec2(light_f32(patch_at), light_f32(patch_at + 1u));
        let half_m = vec2(light_f32(patch_at + 2u), light_f32(patch_at + 3u));
        let over = vec3(light_f32(patch_at + 4u), light_f32(patch_at + 5u), light_f32(patch_at + 6u));
        let blur = light_f32(patch_at + 8u) + 0.5 * footprint;
        let inside = clamp(0.5 + (half_m - abs(at - center)) / (2.0 * blur), vec2(0.0), vec2(1.0));
        let soft = inside * inside * (3.0 - 2.0 * inside);
        color = mix(color, over, light_f32(patch_at + 7u) * soft.x * soft.y);
    }
    return color;
}

fn corner_shade(distance: f32) -> f32 {
    return 1.0 - 0.3 / (1.0 + 9.0 * max(distance, 0.0));
}

fn wall_reflectance(at: vec2<f32>, footprint: f32) -> vec3<f32> {
    let above = at.y - 0.085;
    let blur = 0.5 * footprint;
    let skirting = clamp(0.5 - above / (2.0 * blur), 0.0, 1.0);
    let joint = max(1.0 - abs(above - 0.002) / (0.002 + blur), 0.0) * (0.004 / (0.004 + 2.0 * blur));
    let plaster = 0.97 + 0.06 * value_noise(1.7 * at, light[job.room_at + 46u]);
    return mix(plaster * room_vec3(28u), room_vec3(32u), skirting) * (1.0 - 0.5 * joint);
}

fn depth_along(target_at: f32, start: f32, direction: f32) -> f32 {
    if abs(direction) < 1e-30 {
        return 1e30;
    }
    let t = (target_at - start) / direction;
    return select(1e30, t, t > 0.0);
}

fn in_room(origin: vec3<f32>, direction: vec3<f32>) -> BackdropPlace {
    let low = vec2(room_f32(35u), room_f32(39u));
    let high = vec2(room_f32(43u), room_f32(48u));
    let x = depth_along(select(low.x, high.x, direction.x > 0.0), origin.x, direction.x);
    let y = depth_along(select(low.y, high.y, direction.y > 0.0), origin.y, direction.y);
    var z = 1e30;
    if direction.z < 0.0 {
        z = depth_along(job.floor_z_m, origin.z, direction.z);
    }
    var normal = vec3(0.0, 0.0, 1.0);
    var depth = z;
    if !(z <= x && z <= y) {
        if x <= y {
            normal = vec3(select(1.0, -1.0, direction.x > 0.0), 0.0, 0.0);
            depth = x;
        } else {
            normal = vec3(0.0, select(1.0, -1.0, direction.y > 0.0), 0.0);
            depth = y;
        }
    }
    let point = origin + depth * direction;
    let facing = -dot(direction, normal) / length(direction);
    let footprint = pixel_size_m(depth) / sqrt(max(facing, 0.06)) + DEFOCUS_M;
    let height = point.z - job.floor_z_m;
    var key = job.key_color * max(dot(job.toward_key, normal), 0.0);
    if normal.z > 0.5 {
        let to_wall = min(point.xy - low, high - point.xy);
        let ambient = floor_light(point.xy) * corner_shade(min(to_wall.x, to_wall.y));
        return BackdropPlace(floor_reflectance(point.xy, footprint), true, point, normal, key, ambient);
    }
    key *= WALL_SHARE * (0.3 + 0.7 * sunspot_share(point));
    let at = vec2(dot(point.xy, normal.yx), height);
    let color = furnished(normal, at, footprint, wall_reflectance(at, footprint));
    let shares = diffuse_shares(normal);
    let open = WALL_SHARE * (from_above(shares) + shares.w * room_vec3(12u));
    let ambient = open * corner_shade(height) * (0.92 + 0.08 * min(height / 1.2, 1.0));
    return BackdropPlace(color, true, point, normal, key, ambient);
}

// `fraction` is the height in the image (0 = top).
fn backdrop_place(p: vec2<f32>, fraction: f32) -> BackdropPlace {
    let ray = ray_through(p);
    let origin = moved(job.world_from_camera, ray.origin);
    let direction = turned(job.world_from_camera, ray.direction);
    if job.has_room != 0u {
        return in_room(origin, direction);
    }
    let up = vec3(0.0, 0.0, 1.0);
    let color = mix(job.top_color, job.bottom_color, fraction);
    let nowhere = BackdropPlace(color, false, vec3(0.0), up, vec3(0.0), vec3(0.0));
    // A level ray meets no floor.
    if job.floor_nodes == 0u || abs(direction.z) < 1e-30 {
        return nowhere;
    }
    let t = (job.floor_z_m - origin.z) / direction.z;
    if !(t > 0.0 && t < 1e30) {
        return nowhere;
    }
    let point = origin + t * direction;
    let key = job.key_color * max(job.toward_key.z, 0.0);
    return BackdropPlace(color, true, point, up, key, floor_light(point.xy));
}

fn backdrop_light(place: BackdropPlace, reaching: vec3<f32>) -> vec3<f32> {
    if !place.receives {
        return place.color;
    }
    let limit = select(1.0, 3e38, job.has_room != 0u);
    return place.color * min((place.key * reaching + place.ambient) * job.per_light, vec3(limit));
}
