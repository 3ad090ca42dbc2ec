// The color of a surface point: Lambert and GGX under key light, sky and surroundings, shade.rs's.

struct Material {
    base_color: vec3<f32>,
    roughness: f32,
    metalness: f32,
    opacity: f32,
    // Where it lies; 0: none.
    texture: u32,
    // Height of white over black in the texture, as a share of the texture's repeat.
    relief: f32,
}

struct Surface {
    point: vec3<f32>,
    // Unit, smooth, turned toward the eye.
    normal: vec3<f32>,
    // Unit, of the flat triangle, turned toward the eye.
    flat_normal: vec3<f32>,
    toward_eye: vec3<f32>,
    uv: vec2<f32>,
    // Unit directions in which u and v grow.
    u_axis: vec3<f32>,
    v_axis: vec3<f32>,
    // Texture repeats squared per square meter.
    uv_density: f32,
    material: u32,
}

struct Reflected {
    diffuse: vec3<f32>,
    specular: vec3<f32>,
}

// Linear light: what is added, and the factor on what lies behind.
struct Shaded {
    added: vec3<f32>,
    passed: vec3<f32>,
}

fn material_at(index: u32) -> Material {
    let at = job.materials_at + index * MATERIAL_WORDS;
    return Material(
        scene_vec3(at), scene_f32(at + 3u), scene_f32(at + 4u), scene_f32(at + 5u), scene[at + 6u],
        scene_f32(at + 20u),
    );
}

fn uv_of(vertex: u32) -> vec2<f32> {
    let at = vertex * VERTEX_WORDS + 6u;
    return vec2(scene_f32(at), scene_f32(at + 1u));
}

fn surface_at(index: u32, p: vec2<f32>) -> Surface {
    let triangle = triangle_at(index);
    let found = hit(triangle, p);
    let eye = toward_eye(found.in_camera);
    let flat_normal = turned_toward(triangle.facing, eye);
    let a = uv_of(triangle.vertices.x);
    let b = uv_of(triangle.vertices.y);
    let c = uv_of(triangle.vertices.z);
    let uv_area = abs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
    let area = length(cross(found.sides[0], found.sides[1]));
    let axes = texture_axes(found.sides, b - a, c - a);
    return Surface(
        moved(job.world_from_camera, found.in_camera),
        smooth_normal(triangle, found.weights, flat_normal),
        flat_normal,
        eye,
        found.weights.x * a + found.weights.y * b + found.weights.z * c,
        turned(job.world_from_camera, axes[0]),
        turned(job.world_from_camera, axes[1]),
        uv_area / max(area, 1e-20),
        triangle.material,
    );
}

// Whether two triangles belong to one smooth piece of one material.
fn continues(a: u32, b: u32) -> bool {
    let p = triangle_at(a);
    let q = triangle_at(b);
    return p.material == q.material && dot(p.facing, q.facing) > 0.965;
}

// Level of the mipmap for a pixel of that size.
fn texture_level(s: Surface, material: Material, pixel_size_m: f32) -> f32 {
    let facing = max(dot(s.flat_normal, s.toward_eye), 0.05);
    let texels = s.uv_density * scene_f32(material.texture) * pixel_size_m * pixel_size_m / facing;
    return 0.5 * log2(max(texels, 1.0)) - 0.25;
}

fn albedo_of(s: Surface, material: Material, pixel_size_m: f32) -> vec3<f32> {
    if material.texture == 0u {
        return material.base_color;
    }
    return material.base_color * texture_color(material.texture, s.uv, texture_level(s, material, pixel_size_m));
}

// Unit normal with the relief of the material, relief.rs's, which images outside of rooms do not show.
fn normal_in_relief(s: Surface, material: Material, pixel_size_m: f32) -> vec3<f32> {
    if job.has_room == 0u || material.relief <= 0.0 || material.texture == 0u {
        return s.normal;
    }
    let level = max(texture_level(s, material, pixel_size_m), 1.0);
    let full = level_at(material.texture, 0u);
    let step = 0.5 * exp2(level) / vec2(f32(full.width), f32(full.height));
    var heights = vec4(0.0);
    for (var k = 0u; k < 4u; k++) {
        let toward = select(-1.0, 1.0, (k & 1u) == 0u);
        let offset = select(vec2(0.0, toward * step.y), vec2(toward * step.x, 0.0), k < 2u);
        heights[k] = dot(texture_color(material.texture, s.uv + offset, level), vec3(0.2126, 0.7152, 0.0722));
    }
    let slope = 0.5 * material.relief * vec2(heights.x - heights.y, heights.z - heights.w) / step;
    let rise = slope.x * s.u_axis + slope.y * s.v_axis;
    return unit_or(s.normal - (rise - dot(rise, s.normal) * s.normal), s.normal);
}

fn fifth(x: f32) -> f32 {
    return x * x * x * x * x;
}

// Factors on color and roughness of a surface point in a room, shade/wear.rs's.
fn wear_at(s: Surface, pixel_size_m: f32) -> vec2<f32> {
    if job.has_room == 0u {
        return vec2(1.0);
    }
    let p = moved(scene_rows(job.materials_at + s.material * MATERIAL_WORDS + 8u), s.point);
    let along = vec2(p.x + 0.62 * p.z, p.y + 0.37 * p.z);
    let across = vec2(p.x - 0.47 * p.z, p.y + 0.71 * p.z);
    let clouds = value_noise(28.0 * along, s.material) - 0.5;
    let smudges = value_noise(75.0 * across, s.material ^ 0x51u) - 0.5;
    let kept = clamp(WEAR_FINE_M / (pixel_size_m + 1e-6) - 0.5, 0.0, 1.0);
    let fine = kept * (value_noise(along / WEAR_FINE_M, s.material ^ 0xa2u) - 0.5);
    return vec2(1.0 + 0.05 * clouds + 0.03 * fine, 1.0 + 0.12 * clouds + 0.18 * smudges + 0.1 * fine);
}

// Share of the surroundings a surface mirrors (Karis 2014).
fn mirror_share(f0: vec3<f32>, roughness: f32, nv: f32) -> vec3<f32> {
    let r = vec4(
        1.0 - roughness,
        0.0425 - 0.0275 * roughness,
        1.04 - 0.572 * roughness,
        0.022 * roughness - 0.04,
    );
    let a004 = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
    return f0 * (-1.04 * a004 + r.z) + max(1.04 * a004 + r.w, 0.0);
}

// Cosine to the key light; a smooth normal does not carry it far beyond the flat face's.
fn key_cosine(s: Surface) -> f32 {
    return max(min(dot(s.normal, job.toward_key), 2.0 * dot(s.flat_normal, job.toward_key)), 0.0);
}

// `nl` is the cosine to the key light, `reaching` the share of it that reaches the point.
fn reflected(s: Surface, material: Material, albedo: vec3<f32>, nl: f32, reaching: vec3<f32>, around: Ambient) -> Reflected {
    let n = s.normal;
    let v = s.toward_eye;
    let l = job.toward_key;
    let nv = clamp(dot(n, v), 0.02, 1.0);
    let f0 = mix(vec3(0.04), albedo, material.metalness);
    let matte = albedo * (1.0 - material.metalness);
    var light = Reflected(vec3(0.0), vec3(0.0));
    if nl > 0.0 && any(reaching > vec3(0.0)) {
        let key = job.key_color * nl * reaching;
        let h = unit_or(l + v, vec3(0.0));
        // A light of finite size blurs the highlight (Karis 2013).
        let alpha = min(material.roughness * material.roughness + 0.4 * job.key_radius_rad, 1.0);
        let a2 = alpha * alpha;
        let nh = clamp(dot(n, h), 0.0, 1.0);
        let d = nh * nh * (a2 - 1.0) + 1.0;
        let smith = nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2);
        let shine = 0.5 * a2 / (d * d * max(smith, 1e-4));
        let fresnel = f0 + (vec3(1.0) - f0) * fifth(1.0 - clamp(dot(v, h), 0.0, 1.0));
        light.diffuse += matte * key;
        light.specular += fresnel * key * min(shine, 12.0);
    }
    let mirror = 2.0 * dot(n, v) * n - v;
    let share = mirror_share(f0, material.roughness, nv);
    let seen = around.seen;
    if job.has_room != 0u {
        light.diffuse += matte * between(room_diffuse(n, around), albedo);
        let reflection = room_mirrored(s.point, mirror, material.roughness, around);
        light.specular += between(reflection, f0) * share;
        return light;
    }
    let up = 0.5 + 0.5 * n.z;
    let up_flat = 0.5 + 0.5 * s.flat_normal.z;
    // Occlusion is evaluated for the flat face and rescaled to the smooth normal.
    let smooth_over_flat = (job.sky_color * up + job.ground_color * (1.0 - up))
        / max(job.sky_color * up_flat + job.ground_color * (1.0 - up_flat), vec3(1e-3));
    light.diffuse += matte * diffuse_light(s.flat_normal, seen) * smooth_over_flat;
    let surroundings = mirrored(mirror, material.roughness);
    let occlusion = min(0.25 + 0.75 * seen.open, 1.0);
    light.specular += surroundings * share * occlusion;
    return light;
}

// A transparent surface: the light it adds, and the factor on the light from behind.
fn glass(s: Surface, material: Material, albedo: vec3<f32>, light: Reflected, around: Ambient) -> Shaded {
    let facing = 1.0 - clamp(dot(s.normal, s.toward_eye), 0.0, 1.0);
    let grazing = facing * facing * facing;
    let opacity = material.opacity;
    let tint = mix(vec3(1.0), albedo, 0.35 + 0.3 * opacity);
    if job.has_room == 0u {
        let solid = opacity + (1.0 - opacity) * 0.35 * grazing;
        return Shaded((light.diffuse * solid * 0.8 + light.specular) * job.exposure, tint * (1.0 - solid));
    }
    // Clean glass is seen by what it mirrors, and by its outline, where it shows another part of the room.
    let solid = opacity * opacity * (0.2 + 0.8 * opacity);
    let bending = RIM * grazing * (1.0 - opacity);
    let beyond = unit_or(-s.toward_eye - BEND * s.normal, -s.normal);
    let rim = between(room_mirrored(s.point, beyond, RIM_BLUR, around), vec3(1.0));
    let added = light.diffuse * solid * 0.5 + light.specular + rim * tint * tint * bending;
    return Shaded(added * job.exposure, tint * ((1.0 - solid) * (1.0 - bending)));
}
