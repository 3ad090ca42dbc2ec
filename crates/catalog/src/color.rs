//! Color words, from `[colors]` of `config/catalog/words.toml`.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

use geometry::Rgb;

#[derive(Deserialize)]
struct Words {
    /// `#rrggbb`.
    colors: BTreeMap<String, String>,
}

static COLORS: LazyLock<BTreeMap<String, Rgb>> = LazyLock::new(|| {
    let words: Words =
        toml::from_str(include_str!("../../../config/catalog/words.toml")).expect("a compiled-in file");
    let read = |(name, hex): (String, String)| {
        let color = u32::from_str_radix(hex.trim_start_matches('#'), 16).ok()?;
        Some((name, Rgb::hex(color)))
    };
    words.colors.into_iter().filter_map(read).collect()
});

/// The color with an English name (`red`, `sky blue`).
pub fn named_color(name: &str) -> Option<Rgb> {
    COLORS.get(name).copied()
}

/// All color words with their colors, sorted by word.
pub fn color_names() -> impl Iterator<Item = (&'static str, Rgb)> {
    COLORS.iter().map(|(name, color)| (name.as_str(), *color))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_color_word_has_a_color() {
        assert!(color_names().count() >= 40);
        let red = named_color("red").expect("a color").0;
        assert!(red[0] > 0.6 && red[1] < 0.4, "{red:?}");
        assert_eq!(named_color("sky blue"), color_names().find(|(name, _)| *name == "sky blue").map(|c| c.1));
        assert_eq!(named_color("reddish nonsense"), None);
    }
}
