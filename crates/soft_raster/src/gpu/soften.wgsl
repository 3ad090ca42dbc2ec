// Soft coverage with derivatives from the hard image and the outline, as band.rs: a workgroup per tile of 8 x 8
// pixels. Pieces within reach of the tile are found 64 at a time, one per thread. Each pixel then tests those in their
// order, so that ties are decided as on the CPU.

@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(1) var<storage, read> poses: array<Pose>;
// Of each piece: both ends; then of each parameter the slopes of both ends.
@group(0) @binding(2) var<storage, read> pieces: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> planes: array<f32>;

// A bit for each of the 64 pieces: whether it is within reach of the tile.
var<workgroup> near: array<atomic<u32>, 2>;

// From the nearest point of a piece, the part of its length before it; squared distance.
struct Foot {
    from_foot: vec2<f32>,
    share: f32,
    distance2: f32,
}

fn foot(p: vec2<f32>, piece: vec4<f32>) -> Foot {
    let along = piece.zw - piece.xy;
    let w = p - piece.xy;
    let share = clamp(dot(w, along) / max(dot(along, along), 1e-12), 0.0, 1.0);
    let from_foot = w - share * along;
    return Foot(from_foot, share, dot(from_foot, from_foot));
}

@compute @workgroup_size(THREADS)
fn soften(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let pose = poses[group.z];
    let corner = vec2<f32>(group.xy) * 8.0;
    // From the tile's center to its farthest pixel centers.
    let tile_reach = job.reach_px + 4.95;
    let pixel = group.xy * 8u + vec2(thread % 8u, thread / 8u);
    let center = vec2<f32>(pixel) + 0.5;
    var nearest2 = job.reach_px * job.reach_px;
    var nearest = NONE;
    for (var first = 0u; first < pose.pieces; first += THREADS) {
        if thread < 2u {
            atomicStore(&near[thread], 0u);
        }
        workgroupBarrier();
        let own = first + thread;
        if own < pose.pieces {
            let piece = pieces[(pose.first_piece + own) * PLANES];
            if foot(corner + 4.0, piece).distance2 < tile_reach * tile_reach {
                atomicOr(&near[thread / 32u], 1u << (thread % 32u));
            }
        }
        workgroupBarrier();
        for (var word = 0u; word < 2u; word++) {
            var bits = atomicLoad(&near[word]);
            while bits != 0u {
                let candidate = first + word * 32u + firstTrailingBit(bits);
                bits &= bits - 1u;
                let distance2 = foot(center, pieces[(pose.first_piece + candidate) * PLANES]).distance2;
                if distance2 < nearest2 {
                    nearest2 = distance2;
                    nearest = candidate;
                }
            }
        }
        workgroupBarrier();
    }
    if pixel.y >= job.height_px {
        return;
    }
    let plane = job.height_px * job.width_px;
    let at = group.z * PLANES * plane + pixel.y * job.width_px + pixel.x;
    if nearest == NONE {
        for (var k = 1u; k < PLANES; k++) {
            planes[at + k * plane] = 0.0;
        }
        return;
    }
    let piece = (pose.first_piece + nearest) * PLANES;
    let found = foot(center, pieces[piece]);
    let sign = 2.0 * planes[at] - 1.0;
    let soft = 1.0 / (1.0 + exp(-sign * found.distance2 / job.sigma_px2));
    planes[at] = soft;
    let gain = soft * (1.0 - soft) * sign / job.sigma_px2;
    for (var k = 1u; k < PLANES; k++) {
        let moving = pieces[piece + k];
        let velocity = moving.xy + found.share * (moving.zw - moving.xy);
        planes[at + k * plane] = -2.0 * dot(found.from_foot, velocity) * gain;
    }
}
