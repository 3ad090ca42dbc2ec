//! Printed pages: a heading, lines of words, sometimes an image.

use rand::RngExt;

use super::fill_rectangle;
use geometry::Rgb;
use imaging::{Image, Texture};
use runtime::seed::Rng;

/// One page, 256 x 256 px, the top of the text toward v = 1.
pub fn printed_page(paper: Rgb, rng: &mut Rng) -> Texture {
    let mut image = Image::filled(256, 256, paper.to_rgba8());
    page(&mut image, 0, paper, rng);
    Texture::new(image)
}

/// Two facing pages with a gutter shadow, 512 x 256 px.
pub fn book_spread(paper: Rgb, rng: &mut Rng) -> Texture {
    let mut image = Image::filled(512, 256, paper.to_rgba8());
    page(&mut image, 0, paper, rng);
    page(&mut image, 256, paper, rng);
    for step in 0..14 {
        let shade = paper.scaled(0.72 + 0.02 * step as f32);
        fill_rectangle(&mut image, 255 - step, 0, 1, 256, shade);
        fill_rectangle(&mut image, 256 + step, 0, 1, 256, shade);
    }
    Texture::new(image)
}

fn page(image: &mut Image, left: i32, paper: Rgb, rng: &mut Rng) {
    let ink = Rgb([0.16, 0.16, 0.18]).mix(paper, 0.15);
    let (low, high) = (left + 28, left + 228);
    let heading = rng.random_range(70..150);
    fill_rectangle(image, low, 22, heading, 10, ink);
    let illustration = (rng.random_range(0..3) == 0).then(|| rng.random_range(70..150));
    if let Some(top) = illustration {
        let tint = Rgb([0.45, 0.6, 0.72]).mix(paper, rng.random_range(0.0..0.3));
        fill_rectangle(image, low, top, 200, 60, tint);
        fill_rectangle(image, low, top + 38, 200, 22, Rgb([0.4, 0.52, 0.32]));
    }
    let mut y = 46;
    while y < 234 {
        let inside = illustration.is_some_and(|top| y + 6 > top && y < top + 64);
        let last = rng.random_range(0..6) == 0;
        let end = if last { low + rng.random_range(40..150) } else { high };
        let mut x = low;
        while x < end && !inside {
            let word = rng.random_range(9..30).min(end - x);
            fill_rectangle(image, x, y, word, 4, ink.mix(paper, 0.2));
            x += word + 5;
        }
        y += 9;
    }
}
