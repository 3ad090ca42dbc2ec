//! Comparison of measured colors with color words.
//!
//! Distances are Euclidean in Oklab (Ottosson, 2020), where 0.02 is just noticeable. A basic word ("red") means the
//! colors that are nearer to it than to any other basic word. Other words ("crimson", "dark blue") mean their
//! surroundings.

use catalog::color::oklab;
use geometry::Rgb;
use language::vocabulary::color_of;

/// Largest distance of a color to its nearest basic word.
const MAX_BASIC_DISTANCE: f64 = 0.22;

/// Largest distance of a color to a word that is not basic.
const MAX_DISTANCE: f64 = 0.09;

const BASIC: &[&str] = &[
    "red",
    "orange",
    "yellow",
    "green",
    "blue",
    "purple",
    "pink",
    "brown",
    "beige",
    "turquoise",
    "white",
    "black",
    "gray",
];

/// Basic words that several references stand for, because hues spread widely in lightness.
const FURTHER_REFERENCES: &[(&str, &str)] = &[
    ("red", "crimson"),
    ("red", "maroon"),
    ("yellow", "mustard"),
    ("green", "lime"),
    ("green", "olive"),
    ("green", "emerald"),
    ("blue", "navy"),
    ("blue", "sky blue"),
    ("purple", "lavender"),
    ("beige", "cream"),
    ("gray", "silver"),
    ("white", "off white"),
    ("gray", "graphite"),
];

pub(super) fn is_color(color: Rgb, words: &str) -> bool {
    let Some(reference) = color_of(words) else { return false };
    let words = if words == "grey" { "gray" } else { words };
    if !BASIC.contains(&words) {
        return distance(color, reference) <= MAX_DISTANCE;
    }
    let references = BASIC.iter().map(|word| (*word, *word)).chain(FURTHER_REFERENCES.iter().copied());
    references
        .filter_map(|(name, word)| Some((name, distance(color, color_of(word)?))))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .is_some_and(|(name, nearest)| name == words && nearest <= MAX_BASIC_DISTANCE)
}

fn distance(a: Rgb, b: Rgb) -> f64 {
    let (a, b) = (oklab(a), oklab(b));
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn basic_words_mean_the_colors_nearest_to_them() {
        let cases = [
            (0xb5_43_2f, "red"),
            (0x2f_5b_96, "blue"),
            (0x3f_6b_52, "green"),
            (0xd9_a4_41, "yellow"),
            (0xe8_e4_da, "white"),
            (0x30_34_3a, "black"),
        ];
        for (hex, word) in cases {
            let matching: Vec<&&str> = BASIC.iter().filter(|name| is_color(Rgb::hex(hex), name)).collect();
            assert_eq!(matching, [&word], "{hex:06x}");
        }
    }

    #[test]
    fn shades_differ_from_the_plain_color() {
        let blue = color_of("blue").expect("a color");
        assert!(is_color(blue, "blue") && !is_color(blue, "dark blue") && !is_color(blue, "light blue"));
        assert!(is_color(color_of("dark blue").expect("a shade"), "dark blue"));
    }
}
