//! Playing cards, dice and puzzle cubes.

use rand::RngExt;

use super::PrintOrder;
use super::strokes::{covered, fill_rounded, smoothed};
use crate::texture::{draw_text, draw_texture, fill_rectangle, frame_rectangle};
use geometry::Rgb;
use imaging::{Image, Texture};

/// Width and height of a card, millimeters.
const CARD_MM: [f32; 2] = [63.0, 88.0];
const WHITE: Rgb = Rgb([1.0; 3]);

/// A lattice of diamonds around a rosette, with a white margin; 256 px.
pub(super) fn card_back(order: &mut PrintOrder) -> Texture {
    let ground = order.ground;
    let light = ground.mix(WHITE, 0.7);
    draw_texture(256, 256, |u, v| {
        smoothed(u, v, [1.0 / 256.0; 2], |u, v| {
            let (x, y) = ((u - 0.5) * CARD_MM[0], (v - 0.5) * CARD_MM[1]);
            let margin = (0.5 * CARD_MM[0] - x.abs()).min(0.5 * CARD_MM[1] - y.abs());
            let radius = x.hypot(y);
            let petals = 11.0 + 2.0 * (8.0 * y.atan2(x)).cos();
            let (a, b) = (((x + y) / 5.0).rem_euclid(1.0), ((x - y) / 5.0).rem_euclid(1.0));
            if margin < 3.0 || radius < 1.6 {
                Rgb::hex(0xfa_f8_f4)
            } else if (4.0..4.6).contains(&margin) || (petals - 1.2..petals).contains(&radius) {
                light
            } else if radius < petals {
                if (4.0..5.0).contains(&radius) { light } else { ground }
            } else if margin > 5.0 && (a < 0.16 || b < 0.16 || (a - 0.58).hypot(b - 0.58) < 0.13) {
                light
            } else {
                ground
            }
        })
    })
}

/// Suit of a playing card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Suit {
    Hearts,
    Diamonds,
    Clubs,
    Spades,
}

impl Suit {
    const ALL: [Self; 4] = [Self::Hearts, Self::Diamonds, Self::Clubs, Self::Spades];

    fn ink(self) -> Rgb {
        match self {
            Self::Hearts | Self::Diamonds => Rgb::hex(0xc8_20_2c),
            Self::Clubs | Self::Spades => Rgb::hex(0x18_18_1c),
        }
    }

    /// Whether the point is in the symbol, which reaches from -1 to 1.
    fn contains(self, x: f32, y: f32) -> bool {
        let is_in_foot = y < 0.0 && y > -1.0 && x.abs() < 0.08 + 0.32 * (-0.25 - y).max(0.0).powi(2) / 0.56;
        match self {
            Self::Hearts => is_in_heart(x, y),
            Self::Diamonds => x.abs() / 0.72 + y.abs() < 1.0,
            Self::Clubs => {
                let lobes = [(0.0, 0.5), (-0.47, -0.16), (0.47, -0.16)];
                is_in_foot || lobes.iter().any(|(cx, cy)| (x - cx).hypot(y - cy) < 0.44)
            }
            Self::Spades => is_in_foot || is_in_heart(x, 0.12 - y * 1.05),
        }
    }
}

fn is_in_heart(x: f32, y: f32) -> bool {
    let (x, y) = (x * 1.25, y * 1.1 + 0.12);
    let r = x * x + y * y - 1.0;
    r * r * r - x * x * y * y * y < 0.0
}

/// A symbol on a card: its center from that of the card, and its half height, millimeters; upside down or
/// not.
struct Symbol {
    x: f32,
    y: f32,
    half: f32,
    is_inverted: bool,
}

/// Symbols of the ranks from ace to ten, with two large ones for the court cards.
fn symbols(rank: &str) -> Vec<Symbol> {
    let (column, row) = (13.0, 27.0);
    let at = |x: f32, y: f32| Symbol { x, y, half: 5.4, is_inverted: y < -0.1 };
    let number: usize = match rank {
        "A" => return vec![Symbol { x: 0.0, y: 0.0, half: 13.0, is_inverted: false }],
        "J" | "Q" | "K" => {
            let large = |y: f32| Symbol { x: 0.0, y, half: 8.5, is_inverted: y < 0.0 };
            return vec![large(17.0), large(-17.0)];
        }
        _ => rank.parse().unwrap_or(7),
    };
    let rows: &[f32] = match number {
        2 | 3 => &[],
        4 | 5 => &[1.0, -1.0],
        6..=8 => &[1.0, 0.0, -1.0],
        _ => &[1.0, 1.0 / 3.0, -1.0 / 3.0, -1.0],
    };
    let central: &[f32] = match number {
        2 => &[1.0, -1.0],
        3 => &[1.0, 0.0, -1.0],
        5 | 9 => &[0.0],
        7 => &[0.5],
        8 => &[0.5, -0.5],
        10 => &[2.0 / 3.0, -2.0 / 3.0],
        _ => &[],
    };
    let pairs = rows.iter().flat_map(|y| [at(-column, row * y), at(column, row * y)]);
    pairs.chain(central.iter().map(|y| at(0.0, row * y))).collect()
}

/// The face of a playing card on nearly white paper; 256 px. The word may be its rank: A, 2 to 10, J, Q or K.
pub(super) fn card_face(order: &mut PrintOrder) -> Texture {
    const RANKS: [&str; 13] = ["A", "2", "3", "4", "5", "6", "7", "8", "9", "10", "J", "Q", "K"];
    let suit = Suit::ALL[order.rng.random_range(0..4)];
    let random = RANKS[order.rng.random_range(0..RANKS.len())];
    let rank = if RANKS.contains(&order.word) { order.word } else { random };
    let (paper, ink) = (order.ground.mix(Rgb::hex(0xfd_fc_f8), 0.93), suit.ink());
    let mut marks = symbols(rank);
    marks.push(Symbol { x: -26.5, y: 27.0, half: 3.0, is_inverted: false });
    let face = draw_texture(256, 256, |u, v| {
        smoothed(u, v, [1.0 / 256.0; 2], |u, v| {
            let (x, y) = ((u - 0.5) * CARD_MM[0], (v - 0.5) * CARD_MM[1]);
            let inked = marks.iter().any(|mark| {
                let sign = if mark.is_inverted { -1.0 } else { 1.0 };
                let (dx, dy) = ((x - mark.x) / mark.half, sign * (y - mark.y) / mark.half);
                dx.abs() < 1.1 && dy.abs() < 1.1 && suit.contains(dx, dy)
            });
            if inked { ink } else { paper }
        })
    });
    let mut image = (*face).clone();
    draw_text(
        &mut image,
        rank,
        if rank.len() > 1 { 5 } else { 10 },
        12,
        if rank.len() > 1 { 3 } else { 4 },
        ink,
    );
    if rank.parse::<u32>().is_err() && rank != "A" {
        court(&mut image, rank, ink);
    }
    // The corner again, upside down.
    for y in 0..70 {
        for x in 0..38 {
            image.set_pixel(255 - x, 255 - y, image.pixel(x, y));
        }
    }
    Texture::new(image)
}

/// Draws the frame, the band and the letter of a court card.
fn court(image: &mut Image, rank: &str, ink: Rgb) {
    let (blue, yellow) = (Rgb::hex(0x2a_4a_9a), Rgb::hex(0xf0_c0_3a));
    frame_rectangle(image, 42, 18, 172, 220, 3, blue);
    fill_rectangle(image, 45, 100, 166, 56, yellow);
    fill_rectangle(image, 45, 98, 166, 4, ink);
    fill_rectangle(image, 45, 154, 166, 4, ink);
    for x in [58, 78, 98, 158, 178, 198] {
        for step in 0..9 {
            fill_rectangle(image, x - step / 2 - 1, 104 + step, 2 * (step / 2) + 2, 1, blue);
            fill_rectangle(image, x - step / 2 - 1, 151 - step, 2 * (step / 2) + 2, 1, blue);
        }
    }
    draw_text(image, rank, 116, 111, 5, ink);
}

/// One face of a die; 128 px. `count` is the number of pips, random where it is not given.
pub(super) fn pips(order: &mut PrintOrder) -> Texture {
    let random = order.rng.random_range(1..7);
    let value = order.count.unwrap_or(random).clamp(1, 6);
    let spots: &[(f32, f32)] = match value {
        1 => &[(0.0, 0.0)],
        2 => &[(-1.0, -1.0), (1.0, 1.0)],
        3 => &[(-1.0, -1.0), (0.0, 0.0), (1.0, 1.0)],
        4 => &[(-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)],
        5 => &[(-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (0.0, 0.0)],
        _ => &[(-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, 0.0), (1.0, 0.0)],
    };
    let (ground, ink) = (order.ground, order.ink);
    draw_texture(128, 128, |u, v| {
        let (x, y) = ((u - 0.5) * 128.0, (v - 0.5) * 128.0);
        let distance = |(sx, sy): &(f32, f32)| (x - 32.0 * sx).hypot(y - 32.0 * sy) - 12.5;
        ground.mix(ink, covered(spots.iter().map(distance).fold(f32::INFINITY, f32::min)))
    })
}

/// One face of a puzzle cube: `count` by `count` cells of six colors, all in the ink where the word is
/// SOLVED; 128 px.
pub(super) fn stickers(order: &mut PrintOrder) -> Texture {
    const COLORS: [u32; 6] = [0xf4_f4_f2, 0xf2_d0_2c, 0xc4_2a_2c, 0xe8_7a_24, 0x24_9a_50, 0x24_5a_b8];
    let count = order.count.unwrap_or(3).clamp(1, 8) as i32;
    let is_solved = order.word.eq_ignore_ascii_case("solved");
    let mut image = Image::filled(128, 128, order.ground.to_rgba8());
    for k in 0..count * count {
        let random = Rgb::hex(COLORS[order.rng.random_range(0..COLORS.len())]);
        let [x, y] = [k % count, k / count].map(|cell| 4 + 120 * cell / count + 3);
        let side = 120 / count - 5;
        fill_rounded(&mut image, [x, y, side, side], 4, if is_solved { order.ink } else { random });
    }
    Texture::new(image)
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::seed::child_rng;

    #[test]
    fn faces_of_a_die_have_their_number_of_pips() {
        let dark = |value: u32| {
            let mut rng = child_rng(1, "die");
            let count = Some(value);
            let mut order = PrintOrder { ground: WHITE, ink: Rgb([0.0; 3]), word: "", count, rng: &mut rng };
            let image = pips(&mut order);
            (0..128 * 128).filter(|k| image.pixel(k % 128, k / 128)[0] == 0).count()
        };
        let one = dark(1) as f32;
        for value in 1..=6 {
            let share = dark(value) as f32 / one;
            assert!((share - value as f32).abs() < 0.1, "{value}: {share}");
        }
    }

    #[test]
    fn number_cards_have_as_many_symbols_as_their_rank() {
        for rank in 2..=10_usize {
            assert_eq!(symbols(&rank.to_string()).len(), rank);
        }
    }
}
