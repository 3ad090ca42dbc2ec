// How much of the sky a surface point sees, sky.rs's and sky_group.rs's.

struct SkyShare {
    arriving: f32,
    open: f32,
}

const DIRECTION_WORDS = 20u;

fn scene_rows(at: u32) -> array<vec4<f32>, 3> {
    return array(
        vec4(scene_vec3(at), scene_f32(at + 3u)),
        vec4(scene_vec3(at + 4u), scene_f32(at + 7u)),
        vec4(scene_vec3(at + 8u), scene_f32(at + 11u)),
    );
}

fn sky_seen_from(point: vec3<f32>, normal: vec3<f32>) -> SkyShare {
    let min_cosine = select(0.0, MIN_SKY_COSINE, job.has_room != 0u);
    if job.directions == 0u {
        return SkyShare(1.0, 1.0);
    }
    var lit = 0.0;
    var all = 1e-4;
    var open = 0.0;
    for (var k = 0u; k < job.directions; k++) {
        let at = job.directions_at + k * DIRECTION_WORDS;
        let texel_m = scene_f32(at + 3u);
        // Offset by a texel from the surface, against self-shadowing.
        let texel = moved(scene_rows(at + 4u), point + normal * texel_m);
        let width = scene[at + 16u];
        // A map is empty around its content, so positions beyond it may be moved to its border.
        let last = vec2(f32(width), f32(scene[at + 17u])) - 2.0;
        let place = clamp(texel.xy - 0.5, vec2(0.0), last);
        let lit_up_to = 0.5 * texel_m - texel.z;
        let corner = vec2<u32>(place);
        let t = place - vec2<f32>(corner);
        let upper = scene[at + 18u] + corner.y * width + corner.x;
        let lower = upper + width;
        let lit_upper = select(0.0, 1.0 - t.x, scene_f32(upper) <= lit_up_to)
            + select(0.0, t.x, scene_f32(upper + 1u) <= lit_up_to);
        let lit_lower = select(0.0, 1.0 - t.x, scene_f32(lower) <= lit_up_to)
            + select(0.0, t.x, scene_f32(lower + 1u) <= lit_up_to);
        let share = lit_upper * (1.0 - t.y) + lit_lower * t.y;
        let cosine = max(dot(normal, scene_vec3(at)) - min_cosine, 0.0);
        lit += cosine * share;
        all += cosine;
        open += share;
    }
    return SkyShare(lit / all, open / f32(job.directions));
}

// Ambient light of a point: its sky share, and in a room the radiance in full light and the sky share of what lies
// below.
struct Ambient {
    seen: SkyShare,
    below_light: vec3<f32>,
    below_open: f32,
}

// The sky is sought in one place of the code, at the point and then below it: drivers inline every call.
fn ambient_at(point: vec3<f32>, flat_normal: vec3<f32>, normal: vec3<f32>) -> Ambient {
    let lower = below(point, normal);
    let above = select(flat_normal, normal, job.has_room != 0u);
    let places = select(1u, 2u, lower.counts);
    var ambient: Ambient;
    ambient.below_open = 1.0;
    for (var k = 0u; k < places; k++) {
        let seen =
            sky_seen_from(select(lower.point, point, k == 0u), select(vec3(0.0, 0.0, 1.0), above, k == 0u));
        if k == 0u {
            ambient.seen = seen;
        } else {
            ambient.below_light = open_light(lower);
            ambient.below_open = seen.arriving;
        }
    }
    return ambient;
}

// Ambient light of one point, reused in its neighborhood on the same smooth surface.
struct Nearby {
    known: bool,
    point: vec3<f32>,
    normal: vec3<f32>,
    ambient: Ambient,
}

fn ambient_nearby(
    nearby: ptr<function, Nearby>,
    point: vec3<f32>,
    flat_normal: vec3<f32>,
    normal: vec3<f32>,
    pixel_size_m: f32,
) -> Ambient {
    if (*nearby).known {
        let offset = point - (*nearby).point;
        let near_m = SKY_NEAR_PX * pixel_size_m;
        if dot(flat_normal, (*nearby).normal) > SKY_SAME_DIRECTION
            && dot(offset, offset) < near_m * near_m
            && abs(dot(offset, (*nearby).normal)) < SKY_SAME_PLANE_PX * pixel_size_m {
            return (*nearby).ambient;
        }
    }
    let ambient = ambient_at(point, flat_normal, normal);
    *nearby = Nearby(true, point, flat_normal, ambient);
    return ambient;
}
