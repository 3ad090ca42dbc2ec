//! Tabletops of glued boards: growth rings as a saw cuts them, pores, rays and knots; the grain runs along u.
//!
//! Method: a trunk is a wavy cone of rings about its pith, and a board is a plane through it. Where the plane passes
//! near the pith (plain-sawn), rings appear as nested arches; elsewhere as nearly straight lines. Of the boards of one
//! top, a few show arches. Lengths on the board are millimeters.
//!
//! Result: an image of [`super::super::grain::METERS_PER_REPEAT`], finer across the grain than along it, since wood has
//! its details across. It repeats without a seam.

use rand::RngExt;

use crate::tables::grain::METERS_PER_REPEAT;
use crate::texture::Noise;
use geometry::Rgb;
use imaging::{Image, Texture};
use runtime::seed::Rng;

/// Size of the image of a top, and of that of a frame, pixels along and across the grain.
const TOP_PX: [u32; 2] = [768, 1024];
const FRAME_PX: [u32; 2] = [256, 512];
/// Number of boards across a repeat, and the largest deviation of their joints, as a share of their width.
pub const BOARDS: usize = 10;
const JOINT_DEVIATION: f32 = 0.16;
/// Half the width of the dark line of a joint, millimeters.
const JOINT_MM: f32 = 0.6;

/// Marks of a kind of wood. Contrasts are shares of brightness.
struct Species {
    ring_mm: f32,
    /// Darkness of latewood, and of the open pores of earlywood.
    latewood: f32,
    earlywood: f32,
    /// Darkness of pores anywhere.
    pores: f32,
    /// Lightness of rays on boards whose rings stand upright.
    flecks: f32,
    /// Difference between boards.
    tones: f32,
    /// Knots in a hundred boards.
    knots: u32,
}

impl Species {
    fn of(name: &str) -> Self {
        let (ring_mm, latewood, earlywood, pores, flecks, tones, knots) = match name {
            "walnut" => (3.4, 0.09, 0.04, 0.17, 0.0, 0.1, 0),
            "pine" => (2.9, 0.1, 0.0, 0.03, 0.0, 0.05, 8),
            "birch" => (2.8, 0.045, 0.0, 0.04, 0.02, 0.04, 0),
            _ => (2.8, 0.04, 0.1, 0.11, 0.04, 0.07, 0),
        };
        Self { ring_mm, latewood, earlywood, pores, flecks, tones, knots }
    }
}

/// A knot: where a branch left the trunk.
struct Knot {
    x_mm: f32,
    y_mm: f32,
    radius_mm: f32,
}

/// A board between two joints.
struct Board {
    /// Along v, 0..1.
    low: f32,
    high: f32,
    /// Distance of its center from the place nearest the pith, and of its plane from the pith.
    aside_mm: f32,
    depth_mm: f32,
    /// Number of its rings, so that no two boards show the same.
    first_ring: f32,
    /// Factor on its color, by channel.
    tone: [f32; 3],
    knot: Option<Knot>,
}

/// The noises of a top.
struct Log {
    swell: Noise,
    ripple: Noise,
    rings: Noise,
    tone: Noise,
    rays: Noise,
    fibers: Fibers,
}

/// Random numbers that vary along each row of pixels and are independent from row to row.
struct Fibers {
    columns: usize,
    values: Vec<f32>,
}

/// A top of boards of the wood `name` in about that color.
pub fn tabletop(name: &str, color: Rgb, rng: &mut Rng) -> Texture {
    let species = Species::of(name);
    let boards = boards(&species, rng);
    board_texture(TOP_PX, &species, &boards, color, rng)
}

/// Straight grain for the parts of a frame.
pub fn straight(name: &str, color: Rgb, rng: &mut Rng) -> Texture {
    let species = Species::of(name);
    // A repeat holds many rings, so that the image may begin again at its edge: no joint is drawn.
    let across_mm = 1000.0 * METERS_PER_REPEAT.y as f32;
    let whole = Species { ring_mm: across_mm / (across_mm / (2.0 * species.ring_mm)).round(), ..species };
    let board = Board {
        low: 0.0,
        high: 1.0,
        aside_mm: 1e5,
        depth_mm: 0.0,
        first_ring: 0.0,
        tone: [1.0; 3],
        knot: None,
    };
    board_texture(FRAME_PX, &whole, &[board], color, rng)
}

fn boards(species: &Species, rng: &mut Rng) -> Vec<Board> {
    let deviation = |rng: &mut Rng| rng.random_range(-JOINT_DEVIATION..JOINT_DEVIATION);
    let joints: Vec<f32> = (0..BOARDS)
        .map(|k| (k as f32 + if k == 0 { 0.0 } else { deviation(rng) }) / BOARDS as f32)
        .chain([1.0])
        .collect();
    let [length_mm, across_mm] = METERS_PER_REPEAT.to_array().map(|m| 1000.0 * m as f32);
    joints
        .windows(2)
        .map(|joints| {
            let half_mm = 0.5 * across_mm * (joints[1] - joints[0]);
            // Three in ten are cut near the pith.
            let shows_arches = rng.random_range(0..10) < 3;
            let side = if rng.random_range(0..2) == 0 { 1.0 } else { -1.0 };
            let aside_mm = if shows_arches {
                0.3 * half_mm * rng.random_range(-1.0_f32..1.0)
            } else {
                side * rng.random_range(1.3..4.0) * half_mm
            };
            let depth_mm = rng.random_range(16.0..34.0);
            let brightness = 1.0 + species.tones * rng.random_range(-0.5_f32..0.5);
            let warmth = 0.2 * species.tones * rng.random_range(-1.0_f32..1.0);
            let knot = (rng.random_range(0..100) < species.knots).then(|| Knot {
                x_mm: length_mm * rng.random_range(0.0_f32..1.0),
                y_mm: half_mm * rng.random_range(-0.7_f32..0.7),
                radius_mm: rng.random_range(3.0..7.0),
            });
            Board {
                low: joints[0],
                high: joints[1],
                aside_mm,
                depth_mm,
                first_ring: rng.random_range(0..500) as f32,
                tone: [1.0 + warmth, 1.0, 1.0 - warmth].map(|channel| channel * brightness),
                knot,
            }
        })
        .collect()
}

fn board_texture(
    [width, height]: [u32; 2],
    species: &Species,
    boards: &[Board],
    color: Rgb,
    rng: &mut Rng,
) -> Texture {
    let log = Log {
        swell: Noise::new(4, 2 * BOARDS, rng),
        ripple: Noise::new(18, 60, rng),
        rings: Noise::new(509, 1, rng),
        tone: Noise::new(5, 48, rng),
        rays: Noise::new(48, 300, rng),
        fibers: Fibers::new(width as usize / 2, height as usize, rng),
    };
    let [length_mm, across_mm] = METERS_PER_REPEAT.to_array().map(|m| 1000.0 * m as f32);
    let mut image = Image::filled(width, height, [255; 4]);
    let row_bytes = 4 * width as usize;
    for (y, row) in image.as_rgba_mut().chunks_exact_mut(row_bytes).enumerate() {
        let v = 1.0 - (y as f32 + 0.5) / height as f32;
        let board = boards.iter().find(|board| v < board.high).unwrap_or(&boards[0]);
        let line = Line {
            log: &log,
            species,
            board,
            v,
            row: y,
            across_mm: across_mm * (v - 0.5 * (board.low + board.high)),
            row_mm: across_mm / height as f32,
            length_mm,
        };
        let edge_mm = across_mm * (v - board.low).min(board.high - v);
        let joint = if boards.len() > 1 { (1.2 - edge_mm / (2.0 * JOINT_MM)).clamp(0.0, 1.0) } else { 0.0 };
        let base = Rgb(std::array::from_fn(|k| color.0[k] * board.tone[k] * (1.0 - 0.14 * joint)));
        for (x, pixel) in row.chunks_exact_mut(4).enumerate() {
            let u = (x as f32 + 0.5) / width as f32;
            let (shade, knot) = line.shade(u, x as f32 / width as f32);
            let shaded = base.scaled(shade);
            let shaded = if knot > 0.0 { shaded.mix(base.scaled(0.42), knot) } else { shaded };
            pixel.copy_from_slice(&shaded.to_rgba8());
        }
    }
    Texture::new(image)
}

/// A row of pixels of a board.
struct Line<'a> {
    log: &'a Log,
    species: &'a Species,
    board: &'a Board,
    v: f32,
    row: usize,
    /// From the center of the board.
    across_mm: f32,
    row_mm: f32,
    length_mm: f32,
}

impl Line<'_> {
    /// Brightness at a place along the grain, and the share of a knot there.
    #[inline]
    fn shade(&self, u: f32, at: f32) -> (f32, f32) {
        let Self { log, species, board, v, .. } = self;
        let aside = self.across_mm - board.aside_mm;
        // The trunk's radius varies along the board: what makes arches of lines.
        let depth = board.depth_mm + 26.0 * (log.swell.at(u, board.low + 0.013) - 0.5);
        let ripple = log.ripple.at(u, *v) - 0.5;
        let mut radius = (aside * aside + depth * depth).sqrt() + 2.6 * ripple;
        let mut in_knot = 0.0;
        if let Some(knot) = &board.knot {
            let (bulge, inside) = knot.at(self.length_mm * u, self.across_mm, self.length_mm);
            radius += bulge;
            in_knot = inside;
        }
        let ring = radius / species.ring_mm + board.first_ring;
        let number = ring.floor();
        let strength = log.rings.at((number + 0.5) * (1.0 / 509.0), 0.0);
        // Rings of different widths: the boundary moves by a part of a ring.
        let part = ring - number;
        // Rings too close for the image would become moiré.
        let per_row = aside.abs() / radius.max(1.0) * self.row_mm / species.ring_mm;
        let visible = (1.35 - 2.0 * per_row).clamp(0.0, 1.0) * (0.35 + 1.3 * strength);
        // The end of a ring is sharper than the image can show: over less than a pixel, it would become a staircase.
        let end = (self.row_mm / species.ring_mm).clamp(0.14, 0.5);
        let late = if part < 1.0 - end { (part / (1.0 - end)).powi(2) } else { (1.0 - part) / end };
        let early = (1.0 - part / 0.34).max(0.0);
        let fiber = log.fibers.at(self.row, at);
        let pore = ((fiber - 0.62) * 2.6).max(0.0);
        let tone = log.tone.at(u, *v) - 0.5;
        let mut shade = 1.02 + 0.07 * tone + 0.03 * ripple + 0.05 * (fiber - 0.5)
            - visible * species.latewood * late
            - visible * species.earlywood * early * (0.4 + pore)
            - species.pores * pore * (0.35 + 0.65 * late);
        if species.flecks > 0.0 && board.aside_mm.abs() > 2.0 * board.depth_mm {
            shade += species.flecks * ((log.rays.at(u, *v) - 0.7) * 3.3).max(0.0);
        }
        (shade, in_knot)
    }
}

impl Knot {
    /// Displacement of the rings around the knot, millimeters, and the share of its wood.
    fn at(&self, x_mm: f32, y_mm: f32, length_mm: f32) -> (f32, f32) {
        let mut dx = (x_mm - self.x_mm).abs();
        dx = dx.min(length_mm - dx);
        let dy = y_mm - self.y_mm;
        if dx > 120.0 {
            return (0.0, 0.0);
        }
        let far = (dx / (4.2 * self.radius_mm)).powi(2) + (dy / (2.0 * self.radius_mm)).powi(2);
        let distance = (dx * dx / 2.2 + dy * dy).sqrt() / self.radius_mm;
        let inside = ((1.15 - distance) * 3.0).clamp(0.0, 1.0);
        let ringed = 0.65 + 0.25 * (distance * 14.0).sin();
        (2.2 * self.radius_mm * (-far).exp(), inside * ringed)
    }
}

impl Fibers {
    fn new(columns: usize, rows: usize, rng: &mut Rng) -> Self {
        Self { columns, values: (0..columns * rows).map(|_| rng.random_range(0.0..1.0)).collect() }
    }

    /// The number at a place of a row, 0..1, interpolated between its neighbors.
    #[inline]
    fn at(&self, row: usize, u: f32) -> f32 {
        let values = &self.values[row * self.columns..][..self.columns];
        let x = u * self.columns as f32;
        let first = x as usize;
        let next = if first + 1 < self.columns { first + 1 } else { 0 };
        values[first] + (values[next] - values[first]) * (x - first as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use imaging::srgb::LINEAR_OF_SRGB;
    use runtime::seed::child_rng;

    const WOODS: [(&str, u32); 4] =
        [("oak", 0xb8_8a_56), ("walnut", 0x6e_49_30), ("pine", 0xd9_b2_78), ("birch", 0xe0_c8_9c)];

    fn mean(texture: &Texture) -> [f32; 3] {
        let pixels = texture.as_rgba().chunks_exact(4);
        let mut sum = [0.0_f64; 3];
        for pixel in pixels.clone() {
            (0..3).for_each(|k| sum[k] += f64::from(LINEAR_OF_SRGB[usize::from(pixel[k])]));
        }
        sum.map(|channel| (channel / pixels.len() as f64) as f32)
    }

    #[test]
    fn tops_and_frames_keep_their_color_on_average() {
        for (name, hex) in WOODS {
            let asked = Rgb::hex(hex).to_linear();
            for seed in 0..3 {
                let rng = &mut child_rng(seed, name);
                for texture in [tabletop(name, Rgb::hex(hex), rng), straight(name, Rgb::hex(hex), rng)] {
                    for (found, asked) in mean(&texture).into_iter().zip(asked) {
                        assert!((found / asked - 1.0).abs() < 0.09, "{name}: {found} for {asked}");
                    }
                }
            }
        }
    }

    #[test]
    fn images_of_wood_repeat_without_a_seam() {
        for (name, hex) in WOODS {
            let rng = &mut child_rng(5, name);
            for texture in [tabletop(name, Rgb::hex(hex), rng), straight(name, Rgb::hex(hex), rng)] {
                let (width, height) = (texture.width_px(), texture.height_px());
                let step = |from: u32, to: u32| -> f32 {
                    let apart =
                        |y: u32| f32::from(texture.pixel(from, y)[1].abs_diff(texture.pixel(to, y)[1]));
                    (0..height).map(apart).sum::<f32>() / height as f32
                };
                let inside = step(width / 2, width / 2 + 1);
                assert!(
                    step(width - 1, 0) < 1.6 * inside + 0.5,
                    "{name}: {} beside {inside}",
                    step(width - 1, 0)
                );
            }
        }
    }

    #[test]
    fn rings_of_a_top_are_fine_and_of_low_contrast() {
        for (name, hex) in WOODS {
            let texture = tabletop(name, Rgb::hex(hex), &mut child_rng(2, name));
            let line: Vec<f32> =
                (0..texture.height_px()).map(|y| f32::from(texture.pixel(100, y)[1])).collect();
            let mean = line.iter().sum::<f32>() / line.len() as f32;
            let deviation = (line.iter().map(|c| (c - mean).powi(2)).sum::<f32>() / line.len() as f32).sqrt();
            assert!((0.01..0.11).contains(&(deviation / mean)), "{name}: {deviation} of {mean}");
            let crossings = line.windows(2).filter(|w| (w[0] < mean) != (w[1] < mean)).count();
            assert!(crossings > 120, "{name}: only {crossings} changes across 1.2 m");
        }
    }

    #[test]
    fn knots_are_rare_and_in_pine_only() {
        let knots = |name: &str| {
            let boards = (0..40).flat_map(|seed| boards(&Species::of(name), &mut child_rng(seed, name)));
            boards.filter(|board| board.knot.is_some()).count()
        };
        let in_pine = knots("pine");
        assert!((20..120).contains(&in_pine), "{in_pine} in 400 boards");
        assert_eq!(["oak", "walnut", "birch"].map(knots), [0; 3]);
    }
}
