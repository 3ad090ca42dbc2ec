// What a ray that meets no object shows, backdrop.rs's.

struct BackdropPlace {
    color: vec3<f32>,
    receives: bool,
    point: vec3<f32>,
    normal: vec3<f32>,
    key: vec3<f32>,
    ambient: vec3<f32>,
}

fn smoothed(inside: f32) -> f32 {
    let t = clamp(inside / 0.05 + 0.5, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// Share of sunlight through a window at a point of the wall.
fn sunspot_share(point: vec3<f32>) -> f32 {
    let center = vec2(room_f32(44u), room_f32(45u));
    let p = abs(vec2(dot(point, room_vec3(36u)), dot(point, room_vec3(40u))) - center);
    let outer = smoothed(0.42 - p.x) * smoothed(0.54 - p.y);
    return outer * (1.0 - 0.55 * max(smoothed(0.035 - p.x), smoothed(0.035 - abs(p.y - 0.18))));
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
    let footprint = pixel_size_m(depth) / sqrt(max(facing, 0.06)) + 0.0015;
    let height = point.z - job.floor_z_m;
    var key = job.key_color * max(dot(job.toward_key, normal), 0.0);
    if normal.z > 0.5 {
        let to_wall = min(point.xy - low, high - point.xy);
        let ambient = floor_light(point.xy) * corner_shade(min(to_wall.x, to_wall.y));
        return BackdropPlace(floor_reflectance(point.xy, footprint), true, point, normal, key, ambient);
    }
    key *= WALL_SHARE * (0.3 + 0.7 * sunspot_share(point));
    let color = wall_reflectance(vec2(dot(point.xy, normal.yx), height), footprint);
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

fn backdrop_light(place: BackdropPlace, reaching: f32) -> vec3<f32> {
    if !place.receives {
        return place.color;
    }
    let limit = select(1.0, 3e38, job.has_room != 0u);
    return place.color * min((place.key * reaching + place.ambient) * job.per_light, vec3(limit));
}
