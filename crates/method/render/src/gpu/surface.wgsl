// The point of a triangle that a ray meets, shade.rs's.

@group(0) @binding(2) var<storage, read_write> state: array<u32>;

struct Hit {
    weights: vec3<f32>,
    in_camera: vec3<f32>,
    // From the first corner, camera's frame.
    sides: array<vec3<f32>, 2>,
}

struct Ray {
    origin: vec3<f32>,
    // Not unit; z = 1.
    direction: vec3<f32>,
}

// Through a sample position, camera's frame.
fn ray_through(p: vec2<f32>) -> Ray {
    let uv = (p - job.lens.zw) / job.lens.xy;
    if job.perspective != 0u {
        return Ray(vec3(0.0), vec3(uv, 1.0));
    }
    return Ray(vec3(uv, 0.0), vec3(0.0, 0.0, 1.0));
}

fn hit(triangle: Triangle, p: vec2<f32>) -> Hit {
    let ray = ray_through(p);
    let a = corner_in_camera(triangle.vertices.x);
    let e1 = corner_in_camera(triangle.vertices.y) - a;
    let e2 = corner_in_camera(triangle.vertices.z) - a;
    let across = cross(ray.direction, e2);
    let determinant = dot(e1, across);
    var inverse = 0.0;
    if abs(determinant) > 1e-30 {
        inverse = 1.0 / determinant;
    }
    let from_a = ray.origin - a;
    let u = clamp(dot(from_a, across) * inverse, 0.0, 1.0);
    let v = clamp(dot(ray.direction, cross(from_a, e1)) * inverse, 0.0, 1.0 - u);
    return Hit(vec3(1.0 - u - v, u, v), a + u * e1 + v * e2, array(e1, e2));
}

fn unit_or(v: vec3<f32>, otherwise: vec3<f32>) -> vec3<f32> {
    let length2 = dot(v, v);
    if length2 > 1e-30 {
        return v * inverseSqrt(length2);
    }
    return otherwise;
}

// Unit directions in which texture coordinates grow on a triangle, zero where the texture has no area.
fn texture_axes(sides: array<vec3<f32>, 2>, along: vec2<f32>, across: vec2<f32>) -> array<vec3<f32>, 2> {
    let normal = cross(sides[0], sides[1]);
    let first = cross(sides[1], normal);
    let second = cross(normal, sides[0]);
    return array(
        unit_or(along.x * first + across.x * second, vec3(0.0)),
        unit_or(along.y * first + across.y * second, vec3(0.0)),
    );
}

fn turned_toward(v: vec3<f32>, side: vec3<f32>) -> vec3<f32> {
    return select(v, -v, dot(v, side) < 0.0);
}

// Unit, smooth, turned to the side of `flat_normal`.
fn smooth_normal(triangle: Triangle, weights: vec3<f32>, flat_normal: vec3<f32>) -> vec3<f32> {
    let vertices = triangle.vertices * VERTEX_WORDS + 3u;
    let smoothed = weights.x * scene_vec3(vertices.x)
        + weights.y * scene_vec3(vertices.y)
        + weights.z * scene_vec3(vertices.z);
    return turned_toward(unit_or(smoothed, flat_normal), flat_normal);
}

// Unit, from the surface point back along the ray.
fn toward_eye(in_camera: vec3<f32>) -> vec3<f32> {
    let away = select(vec3(0.0, 0.0, 1.0), in_camera, job.perspective != 0u);
    return -unit_or(turned(job.world_from_camera, away), vec3(0.0));
}

fn pixel_size_m(depth: f32) -> f32 {
    if job.perspective != 0u {
        return depth / job.lens.x;
    }
    return 1.0 / job.lens.x;
}

// Index of the triangle in front.
fn front_at(sample: u32) -> u32 {
    return ~state[fronts_at() + sample];
}
