// Uniform of all passes.

struct Job {
    width_px: u32,
    height_px: u32,
    // Distance from the outline to which it is felt.
    reach_px: f32,
    sigma_px2: f32,
}

struct Pose {
    first_line: u32,
    lines: u32,
    first_piece: u32,
    pieces: u32,
}

const NONE = 0xffffffffu;
