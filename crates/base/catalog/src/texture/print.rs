//! Images that surfaces may have, by name.
//!
//! A print is drawn from two colors, a word, a count and a seeded generator; the same order draws the same
//! image. Images have 64 to 512 pixels along a side.

mod strokes;
mod screens;
mod scales;
mod paper;
mod marks;
mod games;
mod patterns;
mod food;
mod crafts;
mod artwork;
mod continents;
mod world;

use serde::Deserialize;

use geometry::Rgb;
use imaging::Texture;
use runtime::seed::Rng;

/// Colors, letters and chance that a print is drawn from.
pub(crate) struct PrintOrder<'a> {
    /// Color of the ground.
    pub ground: Rgb,
    /// Color of what is drawn on it.
    pub ink: Rgb,
    pub word: &'a str,
    /// Number of stripes, squares, divisions; `None` for the usual one.
    pub count: Option<u32>,
    pub rng: &'a mut Rng,
}

/// Projection of an image onto a solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Mapping {
    /// As seen from -y.
    Front,
    /// As seen from above.
    Top,
    /// As seen from +x.
    Side,
    /// Once around a body of revolution, the image's center in front.
    Around,
    /// Once on each face of a box.
    Box,
    /// Repeated at a fixed distance.
    Tiled,
    /// The form's own coordinates: u around, v along.
    Own,
}

/// A named image.
#[derive(Debug)]
pub(crate) struct Print {
    pub name: &'static str,
    /// The usual mapping.
    pub mapping: Mapping,
    pub roughness: f32,
    pub draw: fn(&mut PrintOrder) -> Texture,
}

impl PartialEq for Print {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// The print with this name.
pub(crate) fn print(name: &str) -> Option<&'static Print> {
    PRINTS.iter().find(|print| print.name == name)
}

const fn row(
    name: &'static str,
    mapping: Mapping,
    roughness: f32,
    draw: fn(&mut PrintOrder) -> Texture,
) -> Print {
    Print { name, mapping, roughness, draw }
}

/// All prints.
pub(crate) const PRINTS: &[Print] = &[
    row("skin", Mapping::Own, 0.4, food::skin),
    row("peel", Mapping::Own, 0.5, food::peel),
    row("banana_skin", Mapping::Own, 0.5, food::banana_skin),
    row("ringed_skin", Mapping::Own, 0.55, food::ringed_skin),
    row("bumpy_skin", Mapping::Own, 0.4, food::bumpy_skin),
    row("diamonds", Mapping::Own, 0.6, food::diamonds),
    row("rind", Mapping::Own, 0.45, food::rind),
    row("crust", Mapping::Own, 0.85, food::crust),
    row("croissant_crust", Mapping::Own, 0.5, food::croissant_crust),
    row("scored_crust", Mapping::Top, 0.75, food::scored_crust),
    row("crumb", Mapping::Tiled, 0.9, food::crumb),
    row("sponge", Mapping::Tiled, 0.95, food::sponge),
    row("cheese", Mapping::Box, 0.5, food::cheese),
    row("sprinkles", Mapping::Top, 0.4, food::sprinkles),
    row("stripes", Mapping::Front, 0.6, patterns::stripes),
    row("checker", Mapping::Tiled, 0.6, patterns::squares),
    row("bands", Mapping::Around, 0.3, patterns::bands),
    row("dipped", Mapping::Around, 0.25, patterns::dipped),
    row("speckle", Mapping::Tiled, 0.45, patterns::speckle),
    row("brushed", Mapping::Tiled, 0.3, patterns::brushed),
    row("woven", Mapping::Around, 0.85, patterns::woven),
    row("lattice", Mapping::Tiled, 0.5, patterns::lattice),
    row("grille", Mapping::Tiled, 0.8, patterns::grille),
    row("blossoms", Mapping::Tiled, 0.6, patterns::blossoms),
    row("flowers", Mapping::Around, 0.2, patterns::flowers),
    row("heart", Mapping::Around, 0.25, marks::heart),
    row("box_label", Mapping::Box, 0.5, marks::plain_label),
    row("front_label", Mapping::Front, 0.5, marks::plain_label),
    row("top_label", Mapping::Top, 0.5, marks::plain_label),
    row("wrap_label", Mapping::Around, 0.45, marks::round_label),
    row("lettering", Mapping::Front, 0.5, marks::lettering),
    row("emblem", Mapping::Front, 0.5, marks::emblem),
    row("round_emblem", Mapping::Around, 0.25, marks::round_emblem),
    row("cereal", Mapping::Front, 0.45, marks::cereal),
    row("nutrition_facts", Mapping::Box, 0.5, paper::nutrition_facts),
    row("book_cover", Mapping::Top, 0.55, paper::book_cover),
    row("page_edges", Mapping::Box, 0.9, paper::page_edges),
    row("printed_page", Mapping::Top, 0.9, paper::printed_page),
    row("staves", Mapping::Top, 0.9, paper::staves),
    row("note", Mapping::Top, 0.9, paper::note),
    row("stitches", Mapping::Front, 0.5, paper::stitches),
    row("desktop_screen", Mapping::Front, 0.18, screens::desktop),
    row("home_screen", Mapping::Top, 0.12, screens::home_screen),
    row("lcd", Mapping::Front, 0.25, screens::lcd),
    row("clock_dial", Mapping::Front, 0.4, scales::clock_dial),
    row("selector_dial", Mapping::Top, 0.5, scales::selector_dial),
    row("scale", Mapping::Top, 0.5, scales::scale),
    row("upright_scale", Mapping::Front, 0.4, scales::upright_scale),
    row("grid", Mapping::Top, 0.75, scales::grid),
    row("card_back", Mapping::Top, 0.5, games::card_back),
    row("card_face", Mapping::Top, 0.5, games::card_face),
    row("pips", Mapping::Box, 0.25, games::pips),
    row("stickers", Mapping::Box, 0.3, games::stickers),
    row("windings", Mapping::Own, 0.95, crafts::windings),
    row("plush", Mapping::Tiled, 1.0, crafts::plush),
    row("embroidery", Mapping::Top, 0.95, crafts::embroidery),
    row("paint_wells", Mapping::Top, 0.4, crafts::color_wells),
    row("palette_spots", Mapping::Top, 0.3, crafts::palette_spots),
    row("beads", Mapping::Top, 0.3, crafts::beads),
    row("painting", Mapping::Top, 0.6, artwork::artwork),
    row("landscape", Mapping::Front, 0.25, world::landscape),
    row("world_map", Mapping::Own, 0.4, world::world_map),
    row("leaf", Mapping::Own, 0.5, world::leaf),
    row("soil", Mapping::Tiled, 1.0, world::soil),
    row("grain", Mapping::Own, 0.5, world::grain),
    row("planks", Mapping::Top, 0.55, world::planks),
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use runtime::seed::child_rng;

    fn drawn(print: &Print, seed: u64) -> Texture {
        let (ground, ink) = (Rgb::hex(0x3f_6f_9a), Rgb::hex(0xf4_ee_e0));
        let mut rng = child_rng(seed, print.name);
        (print.draw)(&mut PrintOrder { ground, ink, word: "", count: None, rng: &mut rng })
    }

    #[test]
    fn every_print_draws_an_image_that_its_seed_determines() {
        for print in PRINTS {
            let texture = drawn(print, 1);
            let pixels: BTreeSet<&[u8]> = texture.as_rgba().chunks(4).collect();
            assert!(pixels.len() > 1, "{} is blank", print.name);
            assert!(texture == drawn(print, 1), "{} differs", print.name);
        }
    }

    #[test]
    fn every_print_accepts_any_count_and_word() {
        for print in PRINTS {
            for count in [0, 1, 60] {
                let (ground, ink, word) = (Rgb([0.2; 3]), Rgb([0.9; 3]), "A long word, and more: 12.5");
                let mut rng = child_rng(2, print.name);
                (print.draw)(&mut PrintOrder { ground, ink, word, count: Some(count), rng: &mut rng });
            }
        }
    }

    #[test]
    fn names_of_prints_are_unique() {
        let names: BTreeSet<&str> = PRINTS.iter().map(|print| print.name).collect();
        assert_eq!(names.len(), PRINTS.len());
        assert!(PRINTS.iter().all(|known| print(known.name) == Some(known)));
    }
}
