// Value noise on the plane, noise.rs's.

fn hash(x: i32, y: i32, seed: u32) -> f32 {
    var h = (bitcast<u32>(x) * 0x8da6b343u) ^ (bitcast<u32>(y) * 0xd8163841u) ^ (seed * 0xcb1ab31fu);
    h ^= h >> 16u;
    h *= 0x7feb352du;
    h ^= h >> 15u;
    h *= 0x846ca68bu;
    h ^= h >> 16u;
    return f32(h >> 8u) * (1.0 / 16777216.0);
}

fn value_noise(p: vec2<f32>, seed: u32) -> f32 {
    let low = vec2<i32>(floor(p));
    let t = p - vec2<f32>(low);
    let s = t * t * (3.0 - 2.0 * t);
    let lower = mix(hash(low.x, low.y, seed), hash(low.x + 1, low.y, seed), s.x);
    let upper = mix(hash(low.x, low.y + 1, seed), hash(low.x + 1, low.y + 1, seed), s.x);
    return mix(lower, upper, s.y);
}
