//! Finishes of table tops.

use super::sampling::{any_color, chance, of_split, pale, pick, uniform, weighted, wood_color};
use super::{Split, pattern};
use catalog::texture::{
    brushed_metal, checker, fabric_weave, granite, marble, stripes, wicker, wood_grain, wood_planks,
};
use geometry::{Material, Rgb};
use imaging::Texture;
use rand::RngExt;
use runtime::seed::Rng;

/// Finishes. Each belongs to one split.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Finish {
    White,
    SolidColor,
    DarkGloss,
    Planks,
    Grain,
    Staves,
    Marble,
    Granite,
    Cloth,
    Checks,
    Metal,
    Slats,
    Glass,
    Terrazzo,
    Stripes,
    Wicker,
    SatinWhite,
    BasketParquet,
    Laminate,
    Tiles,
    Inlay,
    Cement,
    Plaid,
    Burl,
    Lacquer,
    /// Tables of the catalog.
    CatalogWood,
    CatalogStone,
    CatalogMetal,
}

/// A sampled finish.
pub(super) struct Top {
    pub material: Material,
    pub mapping: Mapping,
    /// Average color, for matching legs and edges.
    pub color: Rgb,
}

/// Texture mapping of a top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mapping {
    /// One repetition per `meters`.
    Repeated { meters: f64 },
    /// One copy over the whole top.
    Once,
}

/// All finishes with their weight within their split.
pub(super) const FINISHES: &[(Finish, Split, f64)] = &[
    (Finish::White, Split::Training, 3.0),
    (Finish::SolidColor, Split::Training, 1.2),
    (Finish::DarkGloss, Split::Training, 1.0),
    (Finish::Planks, Split::Training, 2.5),
    (Finish::Grain, Split::Training, 3.0),
    (Finish::Staves, Split::Training, 1.5),
    (Finish::Marble, Split::Training, 0.8),
    (Finish::Granite, Split::Training, 0.6),
    (Finish::Cloth, Split::Training, 0.8),
    (Finish::Checks, Split::Training, 0.4),
    (Finish::Metal, Split::Training, 0.5),
    (Finish::Slats, Split::Training, 0.9),
    (Finish::Glass, Split::Training, 0.4),
    (Finish::CatalogWood, Split::Training, 10.0),
    (Finish::SatinWhite, Split::Validation, 1.5),
    (Finish::Terrazzo, Split::Validation, 1.0),
    (Finish::Stripes, Split::Validation, 1.0),
    (Finish::Wicker, Split::Validation, 1.0),
    (Finish::CatalogMetal, Split::Validation, 2.0),
    (Finish::Laminate, Split::Test, 3.0),
    (Finish::BasketParquet, Split::Test, 1.5),
    (Finish::Tiles, Split::Test, 0.8),
    (Finish::Inlay, Split::Test, 1.2),
    (Finish::Cement, Split::Test, 1.0),
    (Finish::Plaid, Split::Test, 0.8),
    (Finish::Burl, Split::Test, 2.0),
    (Finish::Lacquer, Split::Test, 1.2),
    (Finish::CatalogStone, Split::Test, 3.0),
];

#[cfg(test)]
impl Finish {
    /// The split whose images use it.
    pub fn split(self) -> Split {
        FINISHES.iter().find(|(finish, _, _)| *finish == self).expect("every finish is in the list").1
    }
}

impl Finish {
    /// `[a-z_]+`.
    pub fn name(self) -> &'static str {
        match self {
            Self::White => "white",
            Self::SolidColor => "paint",
            Self::DarkGloss => "dark_gloss",
            Self::Planks => "planks",
            Self::Grain => "grain",
            Self::Staves => "staves",
            Self::Marble => "marble",
            Self::Granite => "granite",
            Self::Cloth => "cloth",
            Self::Checks => "checks",
            Self::Metal => "metal",
            Self::Slats => "slats",
            Self::Glass => "glass",
            Self::Terrazzo => "terrazzo",
            Self::Stripes => "stripes",
            Self::Wicker => "wicker",
            Self::SatinWhite => "satin_white",
            Self::BasketParquet => "basket_parquet",
            Self::Laminate => "laminate",
            Self::Tiles => "tiles",
            Self::Inlay => "inlay",
            Self::Cement => "cement",
            Self::Plaid => "plaid",
            Self::Burl => "burl",
            Self::Lacquer => "lacquer",
            Self::CatalogWood => "catalog_wood",
            Self::CatalogStone => "catalog_stone",
            Self::CatalogMetal => "catalog_metal",
        }
    }

    /// Materials of tables of the catalog with this finish; none where the top is made here.
    pub(super) fn of_catalog(self) -> &'static [&'static str] {
        match self {
            Self::CatalogWood => &["oak", "walnut", "pine", "birch", "white", "black"],
            Self::CatalogStone => &["marble"],
            Self::CatalogMetal => &["steel", "glass"],
            _ => &[],
        }
    }

    /// Samples a finish of the split.
    pub(super) fn draw(split: Split, rng: &mut Rng) -> Self {
        of_split(rng, split, FINISHES)
    }

    /// Whether the top may reflect the objects on it.
    pub(super) fn is_glossy(self) -> bool {
        matches!(self, Self::DarkGloss | Self::Lacquer | Self::Glass | Self::Marble | Self::SatinWhite)
    }
}

impl Top {
    /// Samples a top with that finish.
    pub(super) fn new(finish: Finish, rng: &mut Rng) -> Self {
        let rough = uniform(rng, 0.3, 0.85) as f32;
        let repeated = |meters: f64| Mapping::Repeated { meters };
        let textured = |texture: Texture, roughness: f32| Material::textured("top", texture, roughness);
        let dark = |rng: &mut Rng| any_color(rng).scaled(0.3);
        let (material, mapping) = match finish {
            Finish::White => (Material::plain("top", pale(rng), rough), repeated(1.0)),
            Finish::SolidColor => (Material::plain("top", any_color(rng), rough), repeated(1.0)),
            Finish::DarkGloss => {
                let color = dark(rng);
                (Material::plain("top", color, uniform(rng, 0.05, 0.25) as f32), repeated(1.0))
            }
            Finish::Planks => {
                let (color, boards) = (wood_color(rng), rng.random_range(3..8));
                (textured(wood_planks(color, boards, rng), rough), repeated(uniform(rng, 0.4, 1.2)))
            }
            Finish::Grain => {
                (textured(wood_grain(wood_color(rng), rng), rough), repeated(uniform(rng, 0.4, 1.6)))
            }
            Finish::Staves => {
                let (rows, across) = (rng.random_range(6..16), rng.random_range(2..5));
                (textured(pattern::staves(rng, rows, across), rough), repeated(uniform(rng, 0.4, 0.9)))
            }
            Finish::Marble => {
                let (base, vein) = if chance(rng, 0.7) {
                    (pale(rng), dark(rng).mix(Rgb([0.6; 3]), 0.6))
                } else {
                    (dark(rng), pale(rng))
                };
                (
                    textured(marble(base, vein, rng), uniform(rng, 0.08, 0.4) as f32),
                    repeated(uniform(rng, 0.6, 1.5)),
                )
            }
            Finish::Granite => {
                let color = any_color(rng);
                (
                    textured(granite(color, rng), uniform(rng, 0.15, 0.6) as f32),
                    repeated(uniform(rng, 0.3, 0.8)),
                )
            }
            Finish::Cloth => {
                let color = if chance(rng, 0.5) { pale(rng) } else { any_color(rng) };
                (textured(fabric_weave(color, rng), 0.95), repeated(uniform(rng, 0.05, 0.25)))
            }
            Finish::Checks => {
                let count = 2 * rng.random_range(2..6);
                let first = if chance(rng, 0.6) { pale(rng) } else { any_color(rng) };
                (
                    textured(checker(first, any_color(rng), count, count), 0.9),
                    repeated(uniform(rng, 0.3, 1.0)),
                )
            }
            Finish::Metal => {
                let color = Rgb([uniform(rng, 0.55, 0.85) as f32; 3]);
                let material = textured(brushed_metal(color, rng), uniform(rng, 0.25, 0.5) as f32);
                (Material { metalness: 1.0, ..material }, repeated(uniform(rng, 0.3, 1.0)))
            }
            Finish::Slats => (textured(pattern::slats(rng), rough), repeated(uniform(rng, 0.4, 0.8))),
            Finish::Glass => {
                let tint = any_color(rng).mix(Rgb([0.8, 0.9, 0.88]), 0.7);
                let opacity = uniform(rng, 0.35, 0.7) as f32;
                (Material { opacity, ..Material::plain("top", tint, 0.05) }, repeated(1.0))
            }
            Finish::Terrazzo => (textured(pattern::terrazzo(rng), 0.4), repeated(uniform(rng, 0.4, 1.0))),
            Finish::Stripes => {
                let count = 2 * rng.random_range(2..7);
                let first = if chance(rng, 0.5) { pale(rng) } else { any_color(rng) };
                (textured(stripes(first, any_color(rng), count), 0.9), repeated(uniform(rng, 0.4, 1.2)))
            }
            Finish::Wicker => {
                let color = wood_color(rng);
                (textured(wicker(color, 16, rng), 0.85), repeated(uniform(rng, 0.2, 0.5)))
            }
            Finish::SatinWhite => {
                (Material::plain("top", pale(rng), uniform(rng, 0.12, 0.4) as f32), repeated(1.0))
            }
            Finish::BasketParquet => {
                (textured(pattern::basket_parquet(rng), rough), repeated(uniform(rng, 0.4, 1.0)))
            }
            Finish::Laminate => (textured(pattern::laminate(rng), rough), repeated(uniform(rng, 0.3, 1.2))),
            Finish::Tiles => (textured(pattern::tiles(rng), 0.3), repeated(uniform(rng, 0.4, 1.0))),
            Finish::Inlay => (textured(pattern::inlay(rng), rough), Mapping::Once),
            Finish::Cement => (textured(pattern::cement(rng), 0.8), repeated(uniform(rng, 0.6, 1.5))),
            Finish::Plaid => (textured(pattern::plaid(rng), 0.95), repeated(uniform(rng, 0.2, 0.7))),
            Finish::Burl => (textured(pattern::burl(rng), rough), repeated(uniform(rng, 0.4, 1.4))),
            // Seen where the catalog has no table of that outline.
            Finish::CatalogWood | Finish::CatalogStone | Finish::CatalogMetal => {
                (Material::plain("top", any_color(rng), rough), repeated(1.0))
            }
            Finish::Lacquer => {
                let color = if chance(rng, 0.6) { dark(rng) } else { any_color(rng) };
                (Material::plain("top", color, uniform(rng, 0.06, 0.22) as f32), repeated(1.0))
            }
        };
        let color = material.base_color_texture.as_ref().map_or(material.base_color, mean_color);
        Self { material, mapping, color }
    }
}

/// Mean color: the coarsest mip level of the texture.
fn mean_color(texture: &Texture) -> Rgb {
    let [r, g, b, _] = texture.halved().last().map_or([128; 4], |texel| texel.pixel(0, 0));
    Rgb([r, g, b].map(|c| f32::from(c) / 255.0))
}

/// Material of legs and frames: the color of the top, a solid color, or metal.
pub(super) fn frame_finish(top: &Top, rng: &mut Rng) -> Material {
    match weighted(rng, &[(0, 5.0), (1, 1.5), (2, 1.5), (3, 1.0), (4, 1.0)]) {
        0 => Material::plain(
            "frame",
            top.color.scaled(uniform(rng, 0.75, 1.05) as f32),
            uniform(rng, 0.35, 0.8) as f32,
        ),
        1 => Material::plain("frame", Rgb([uniform(rng, 0.04, 0.2) as f32; 3]), 0.5),
        2 => {
            Material::metal("frame", Rgb([uniform(rng, 0.5, 0.8) as f32; 3]), uniform(rng, 0.25, 0.5) as f32)
        }
        3 => Material::plain("frame", pale(rng), 0.5),
        _ => Material::plain("frame", pick(rng, &[wood_color, any_color])(rng), 0.55),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::seed::child_rng;

    #[test]
    fn splits_draw_only_their_finishes_and_each_builds_a_top() {
        for split in Split::ALL {
            for seed in 0..60 {
                let mut rng = child_rng(seed, split.name());
                let finish = Finish::draw(split, &mut rng);
                assert_eq!(finish.split(), split);
                let top = Top::new(finish, &mut rng);
                assert!(top.color.0.iter().all(|c| (0.0..=1.0).contains(c)), "{finish:?} {:?}", top.color);
            }
        }
    }
}
