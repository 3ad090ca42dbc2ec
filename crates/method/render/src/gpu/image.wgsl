// From what is in front to bytes, bands.rs's: a thread a block of pixels that share light from the sky. Each surface
// in a pixel is shaded once.

@group(0) @binding(4) var<storage, read> layers: array<vec4<u32>>;

const ALL_SAMPLES = SAMPLES * SAMPLES;

// A pixel's own turn of the sampling pattern, 0..1.
fn grain(p: vec2<u32>) -> f32 {
    let mixed = 0.06711056 * f32(p.x & 1023u) + 0.00583715 * f32(p.y & 1023u);
    return fract(52.982918 * fract(mixed));
}

// What a triangle, or the backdrop, shows at a sample position. The one place where anything is shaded: drivers
// inline every call.
fn shown(
    index: u32,
    p: vec2<f32>,
    seen_px_m: f32,
    turn: f32,
    layered: bool,
    nearby: ptr<function, Nearby>,
) -> Shaded {
    var s: Surface;
    var place: BackdropPlace;
    var receives = false;
    var lit_point: vec3<f32>;
    var lit_normal = vec3(0.0, 0.0, 1.0);
    // Without the relief.
    var smoothed: vec3<f32>;
    var nl = 0.0;
    var reaching = vec3(0.0);
    if index == NOTHING {
        place = backdrop_place(p, p.y / f32(job.height_px * SAMPLES));
        lit_point = place.point;
        lit_normal = place.normal;
        receives = place.receives;
    } else {
        s = surface_at(index, p);
        smoothed = s.normal;
        if !layered {
            s.normal = normal_in_relief(s, material_at(s.material), seen_px_m);
        }
        lit_point = s.point;
        lit_normal = s.flat_normal;
        nl = key_cosine(s);
    }
    if receives || nl > 0.0 {
        reaching = vec3(key_visibility(lit_point, lit_normal, turn));
        if reaching.x > 0.0 {
            reaching *= through_glass(lit_point, lit_normal);
        }
    }
    if index == NOTHING {
        return Shaded(backdrop_light(place, reaching), vec3(0.0));
    }
    var material = material_at(s.material);
    var albedo = albedo_of(s, material, seen_px_m);
    if !layered {
        let wear = wear_at(s, seen_px_m);
        material.roughness = min(material.roughness * wear.y, 1.0);
        if material.texture == 0u {
            albedo *= wear.x;
        }
    }
    var neighborhood = *nearby;
    // Light on glass is not carried over.
    neighborhood.known = neighborhood.known && !layered;
    let around = ambient_nearby(&neighborhood, s.point, s.flat_normal, smoothed, seen_px_m);
    let light = reflected(s, material, albedo, nl, reaching, around);
    if layered {
        return glass(s, material, albedo, light, around);
    }
    *nearby = neighborhood;
    return Shaded((light.diffuse + light.specular) * job.exposure, vec3(0.0));
}

fn is_one_surface(a: u32, b: u32) -> bool {
    if a == b {
        return true;
    }
    if a == NOTHING || b == NOTHING {
        return false;
    }
    return continues(a, b);
}

// Whether the layer is laid over the other one: nearer, or later in the list of triangles.
fn is_over(a: vec4<u32>, b: vec4<u32>) -> bool {
    let near_a = bitcast<f32>(a.w);
    let near_b = bitcast<f32>(b.w);
    if near_a != near_b {
        return near_a > near_b;
    }
    return a.y > b.y || (a.y == b.y && a.z > b.z);
}

// Leaves darks and centers as they are and bends highlights softly below 1.
fn bent(c: vec3<f32>) -> vec3<f32> {
    let knee = vec3(0.72);
    return select(knee + (1.0 - knee) * (1.0 - exp(-(c - knee) / (1.0 - knee))), c, c <= knee);
}

// Khronos "PBR Neutral".
fn photographic(c: vec3<f32>) -> vec3<f32> {
    let low = min(c.x, min(c.y, c.z));
    let color = c - select(0.02, low - 12.5 * low * low, low < 0.04);
    let peak = max(color.x, max(color.y, color.z));
    if peak < 0.76 {
        return color;
    }
    let compressed = 1.0 - 0.24 * 0.24 / (peak + 0.24 - 0.76);
    let white = 1.0 - 1.0 / (0.15 * (peak - compressed) + 1.0);
    return mix(color * (compressed / peak), vec3(compressed), white);
}

// From light to image light, tone_curve.rs's.
fn developed(c: vec3<f32>) -> vec3<f32> {
    if job.has_room != 0u {
        return photographic(c);
    }
    return bent(c);
}

// The table of the CPU: sRGB bytes by the square root of light, in steps.
fn srgb_byte(linear: f32) -> u32 {
    let root = floor(sqrt(clamp(linear, 0.0, 1.0)) * 4096.0 + 0.5) / 4096.0;
    let c = root * root;
    let s = select(1.055 * pow(max(c, 1e-6), 1.0 / 2.4) - 0.055, 12.92 * c, c <= 0.0031308);
    return u32(s * 255.0 + 0.5);
}

// The farthest of the pixel's layers that lie over `last` (0: all of them); 0 where there is none.
fn next_layer(head: u32, last: u32) -> u32 {
    var next = 0u;
    for (var layer = head; layer != 0u; layer = layers[layer - 1u].x) {
        let is_after = last == 0u || is_over(layers[layer - 1u], layers[last - 1u]);
        if is_after && (next == 0u || is_over(layers[next - 1u], layers[layer - 1u])) {
            next = layer;
        }
    }
    return next;
}

fn sample_of(pixel: vec2<u32>, k: u32) -> vec2<u32> {
    return pixel * SAMPLES + vec2(k % SAMPLES, k / SAMPLES);
}

fn pixel_color(pixel: vec2<u32>, nearby: ptr<function, Nearby>) -> u32 {
    var linear: array<vec3<f32>, ALL_SAMPLES>;
    var fronts: array<u32, ALL_SAMPLES>;
    var alike = true;
    for (var k = 0u; k < job.all_samples; k++) {
        fronts[k] = front_at(sample_index(sample_of(pixel, k)));
        alike = alike && is_one_surface(fronts[0], fronts[k]);
    }
    // For each sample the visible surface, then the layers over it.
    let head = state[heads_at() + pixel_index(pixel)];
    var step = 0u;
    var layer = 0u;
    loop {
        let layered = step >= job.all_samples;
        var index = NOTHING;
        var sample: vec2<u32>;
        var across = SAMPLES;
        var depth = 1.0;
        var turn_at = pixel;
        if layered {
            layer = next_layer(head, layer);
            if layer == 0u {
                break;
            }
            index = layers[layer - 1u].y;
            sample = sample_of(pixel, firstTrailingBit(layers[layer - 1u].z));
            depth = hit(triangle_at(index), vec2<f32>(sample) + 0.5).in_camera.z;
        } else {
            var known = 0u;
            while !is_one_surface(fronts[known], fronts[step]) {
                known++;
            }
            if known < step {
                linear[step] = linear[known];
                step++;
                continue;
            }
            // A whole pixel is shaded at the sample nearest its center, which its triangle certainly covers.
            sample = sample_of(pixel, step);
            if alike {
                sample += SAMPLES / 2u;
            } else {
                across = 1u;
                turn_at = sample;
            }
            let at = sample_index(sample);
            index = front_at(at);
            depth = depth_of(key_of(state[keys_at() + at]));
        }
        let p = vec2<f32>(sample) + 0.5;
        let seen_px_m = f32(across) * pixel_size_m(depth);
        let found = shown(index, p, seen_px_m, grain(turn_at), layered, nearby);
        if layered {
            let mask = layers[layer - 1u].z;
            for (var k = 0u; k < job.all_samples; k++) {
                if (mask & (1u << k)) != 0u {
                    linear[k] = linear[k] * found.passed + found.added;
                }
            }
        } else {
            linear[step] = found.added;
            step++;
        }
    }
    var mean = vec3(0.0);
    for (var k = 0u; k < job.all_samples; k++) {
        mean += developed(linear[k]);
    }
    mean /= f32(job.all_samples);
    return srgb_byte(mean.x) | (srgb_byte(mean.y) << 8u) | (srgb_byte(mean.z) << 16u) | 0xff000000u;
}

@compute @workgroup_size(THREADS)
fn shade(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let block = (group.y * groups.x + group.x) * THREADS + thread;
    let across = (job.width_px + BLOCK_PX - 1u) / BLOCK_PX;
    let low = vec2(block % across * BLOCK_PX, job.first_row_px + block / across * BLOCK_PX);
    let end = min(low + BLOCK_PX, vec2(job.width_px, job.first_row_px + job.rows_px));
    var nearby: Nearby;
    for (var y = low.y; y < end.y; y++) {
        for (var x = low.x; x < end.x; x++) {
            let pixel = vec2(x, y);
            state[results_at() + pixel_index(pixel)] = pixel_color(pixel, &nearby);
        }
    }
}
