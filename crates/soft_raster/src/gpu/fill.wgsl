// The hard silhouette, fill.rs's: a workgroup a row of an image. Layers begin where lines cross the row; a
// pixel with a layer is inside.

struct Line {
    upper: vec2<f32>,
    // x gained per row downward.
    slope: f32,
    lower_y: f32,
    // Layers that begin to its right.
    layers: i32,
    padding: i32,
}

@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(1) var<storage, read> poses: array<Pose>;
@group(0) @binding(2) var<storage, read> lines: array<Line>;
@group(0) @binding(3) var<storage, read_write> planes: array<f32>;

// Of each pixel of the row: layers that begin there, less those that end.
var<workgroup> begins: array<atomic<i32>, MAX_SIDE_PX>;
// Layers that begin in the columns of each thread.
var<workgroup> shares: array<i32, THREADS>;

@compute @workgroup_size(THREADS)
fn fill(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    for (var x = thread; x < job.width_px; x += THREADS) {
        atomicStore(&begins[x], 0);
    }
    workgroupBarrier();
    let row = f32(group.x);
    let pose = poses[group.y];
    for (var k = thread; k < pose.lines; k += THREADS) {
        let line = lines[pose.first_line + k];
        if line.upper.y - 0.5 <= row && line.lower_y - 0.5 > row {
            let x = line.upper.x + (row + 0.5 - line.upper.y) * line.slope;
            let column = u32(clamp(ceil(x - 0.5), 0.0, f32(job.width_px)));
            if column < job.width_px {
                atomicAdd(&begins[column], line.layers);
            }
        }
    }
    workgroupBarrier();
    let columns = (job.width_px + THREADS - 1u) / THREADS;
    let first = min(thread * columns, job.width_px);
    let end = min(first + columns, job.width_px);
    var share = 0;
    for (var x = first; x < end; x++) {
        share += atomicLoad(&begins[x]);
    }
    shares[thread] = share;
    workgroupBarrier();
    var layers = 0;
    for (var k = 0u; k < thread; k++) {
        layers += shares[k];
    }
    let at = (group.y * PLANES * job.height_px + group.x) * job.width_px;
    for (var x = first; x < end; x++) {
        layers += atomicLoad(&begins[x]);
        planes[at + x] = select(0.0, 1.0, layers != 0);
    }
}
