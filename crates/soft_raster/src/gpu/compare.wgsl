// The sums of the silhouette and edge terms with their derivatives, loss.rs's: a workgroup a strip of rows.

@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(1) var<storage, read> planes: array<f32>;
// Mask, known, distance: one plane after another.
@group(0) @binding(2) var<storage, read> goal: array<f32>;
// Of each pose and strip: common, covered, far, edges, each a value and its derivatives.
@group(0) @binding(3) var<storage, read_write> sums: array<f32>;

const SUMS = 4u * PLANES;

var<workgroup> shares: array<f32, THREADS * SUMS>;

fn sobel(first: u32, left: u32, here: u32, right: u32, above: u32, center: u32, below: u32) -> vec2<f32> {
    let a = first + above;
    let m = first + center;
    let b = first + below;
    let upper = vec3(planes[a + left], planes[a + here], planes[a + right]);
    let lower = vec3(planes[b + left], planes[b + here], planes[b + right]);
    let dx = (upper.z - upper.x) + 2.0 * (planes[m + right] - planes[m + left]) + (lower.z - lower.x);
    let dy = (lower.x - upper.x) + 2.0 * (lower.y - upper.y) + (lower.z - upper.z);
    return vec2(dx, dy);
}

@compute @workgroup_size(THREADS)
fn compare(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let plane = job.height_px * job.width_px;
    let pose = group.y * PLANES * plane;
    var own: array<f32, SUMS>;
    for (var k = 0u; k < SUMS; k++) {
        own[k] = 0.0;
    }
    let end = min((group.x + 1u) * STRIP_ROWS, job.height_px);
    for (var y = group.x * STRIP_ROWS; y < end; y++) {
        let row = y * job.width_px;
        let above = select(row - job.width_px, row, y == 0u);
        let below = select(row + job.width_px, row, y + 1u == job.height_px);
        for (var x = thread; x < job.width_px; x += THREADS) {
            let at = row + x;
            let mask = goal[at];
            let known = goal[plane + at];
            for (var k = 0u; k < PLANES; k++) {
                let coverage = planes[pose + k * plane + at];
                own[k] += coverage * mask;
                own[PLANES + k] += coverage * known;
            }
            // The first and last column have no neighbor on one side.
            if known == 0.0 || x == 0u || x + 1u == job.width_px {
                continue;
            }
            let g = sobel(pose, x - 1u, x, x + 1u, above, row, below);
            if g.x == 0.0 && g.y == 0.0 {
                continue;
            }
            let distance = goal[2u * plane + at];
            let length = sqrt(dot(g, g) + EDGE_EPSILON);
            let edge = (length - sqrt(EDGE_EPSILON)) * known;
            own[2u * PLANES] += edge * distance;
            own[3u * PLANES] += edge;
            for (var k = 1u; k < PLANES; k++) {
                let moving = sobel(pose + k * plane, x - 1u, x, x + 1u, above, row, below);
                let slope = dot(g, moving) * known / length;
                own[2u * PLANES + k] += slope * distance;
                own[3u * PLANES + k] += slope;
            }
        }
    }
    for (var k = 0u; k < SUMS; k++) {
        shares[thread * SUMS + k] = own[k];
    }
    for (var half = THREADS / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if thread < half {
            for (var k = 0u; k < SUMS; k++) {
                shares[thread * SUMS + k] += shares[(thread + half) * SUMS + k];
            }
        }
    }
    workgroupBarrier();
    if thread < SUMS {
        sums[(group.y * groups.x + group.x) * SUMS + thread] = shares[thread];
    }
}
