//! Colors as eyes compare them, and whether a mesh shows one.

use geometry::{DVec2, Material, Rgb, TexturedMesh};
use imaging::Image;

/// Colors of less chroma have no hue: grays, white and black.
const MIN_CHROMA: f64 = 0.03;
/// Largest difference of the hue of a surface to that of its color, radians.
const HUE_RAD: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// Largest difference of the lightness, 0..1.
const LIGHTNESS: f64 = 0.2;

/// Lightness (0..1), and the two axes green to red and blue to yellow, of Oklab (Ottosson, 2020). Differences of 0.02
/// are just noticeable.
pub fn oklab(color: Rgb) -> [f64; 3] {
    let [r, g, b] = color.to_linear().map(f64::from);
    let l = (0.412_221_47 * r + 0.536_332_54 * g + 0.051_445_99 * b).cbrt();
    let m = (0.211_903_5 * r + 0.680_699_55 * g + 0.107_396_96 * b).cbrt();
    let s = (0.088_302_46 * r + 0.281_718_84 * g + 0.629_978_7 * b).cbrt();
    [
        0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_05 * s,
        1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
        0.025_904_04 * l + 0.782_771_77 * m - 0.808_675_77 * s,
    ]
}

/// The color with these coordinates in Oklab, as near as a screen shows it.
fn from_oklab([lightness, a, b]: [f64; 3]) -> Rgb {
    let l = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
    let m = (lightness - 0.105_561_35 * a - 0.063_854_17 * b).powi(3);
    let s = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
    let linear = [
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_93 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_4 * s,
        -0.004_196_09 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    ];
    Rgb(linear.map(|channel| {
        let channel = channel.clamp(0.0, 1.0);
        let encoded =
            if channel <= 0.003_130_8 { 12.92 * channel } else { 1.055 * channel.powf(1.0 / 2.4) - 0.055 };
        encoded as f32
    }))
}

/// Least share of the surface, or of the material that takes the color, that shows a color which was asked for.
const SHOWN: f64 = 0.5;
/// A material that covers less than this share of the surface is a detail.
const DETAIL_SHARE: f64 = 0.12;
/// Smallest share of the surface that takes a color.
const MIN_COLORED_SHARE: f64 = 0.05;
/// Share of the variation within a texture that stays when it is colored.
const KEPT_LIGHTNESS: f64 = 0.6;
const KEPT_CHROMA: f64 = 0.3;
/// Maximum metalness of coated metal.
const COATED_METALNESS: f32 = 0.4;
/// Materials that are images; a color that is asked for is not that of their paper.
const IMAGES: [&str; 6] = ["picture", "photo", "screen", "map", "dial", "keys"];

/// The mesh with the asked color where its design shows too little of it: metals, woods and skins of fruit have colors
/// of their own. `usual` is the same object without an asked color. Metal is coated, unless metal is asked for. The
/// material that takes the color is the largest of those that depend on it, if that is more than a detail, else the
/// largest of all; where most of it shows the color by design, nothing changes.
pub(crate) fn with_color(
    mesh: TexturedMesh,
    asked: Rgb,
    is_coated: bool,
    usual: impl FnOnce() -> Option<TexturedMesh>,
) -> TexturedMesh {
    if shown_share(&mesh, asked) >= SHOWN {
        return mesh;
    }
    let Some(usual) = usual() else { return mesh };
    let depends = |index: usize| usual.materials.get(index) != Some(&mesh.materials[index]);
    let by_design = largest(&mesh, DETAIL_SHARE, depends);
    let Some(index) = by_design.or_else(|| largest(&mesh, MIN_COLORED_SHARE, |_| true)) else { return mesh };
    if share_within(&mesh, asked, |material| material == index) >= SHOWN {
        return mesh;
    }
    let mut mesh = mesh;
    let material = &mut mesh.materials[index];
    colored(material, asked);
    if is_coated {
        material.metalness = material.metalness.min(COATED_METALNESS);
    }
    mesh
}

/// Index of the opaque material with the largest area among those that are meant; none that covers less than this
/// share of the surface.
fn largest(mesh: &TexturedMesh, min_share: f64, is_meant: impl Fn(usize) -> bool) -> Option<usize> {
    let mut areas_m2 = vec![0.0; mesh.materials.len()];
    for group in &mesh.groups {
        for triangle in &group.triangles {
            let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
            areas_m2[group.material] += 0.5 * (b - a).cross(c - a).length();
        }
    }
    let whole_m2: f64 = areas_m2.iter().sum();
    let can_be = |index: &usize| {
        let material = &mesh.materials[*index];
        is_meant(*index)
            && material.opacity >= 0.5
            && !IMAGES.contains(&material.name.as_str())
            && areas_m2[*index] >= min_share * whole_m2
    };
    (0..areas_m2.len()).filter(can_be).max_by(|a, b| areas_m2[*a].total_cmp(&areas_m2[*b]))
}

/// Gives a material the color; its texture keeps a part of its variation.
fn colored(material: &mut Material, asked: Rgb) {
    let Some(texture) = &material.base_color_texture else {
        material.base_color = asked;
        return;
    };
    let (width, height) = (texture.width_px(), texture.height_px());
    let texel = |k: u32| {
        let [red, green, blue, _] = texture.pixel(k % width, k / width);
        oklab(Rgb([red, green, blue].map(|channel| f32::from(channel) / 255.0)))
    };
    let texels: Vec<[f64; 3]> = (0..width * height).map(texel).collect();
    let mean: [f64; 3] = std::array::from_fn(|axis| {
        texels.iter().map(|texel| texel[axis]).sum::<f64>() / texels.len().max(1) as f64
    });
    let asked = oklab(asked);
    let kept = [KEPT_LIGHTNESS, KEPT_CHROMA, KEPT_CHROMA];
    let mut image = Image::filled(width, height, [0, 0, 0, 255]);
    for (k, texel) in texels.iter().enumerate() {
        let moved = std::array::from_fn(|axis| asked[axis] + kept[axis] * (texel[axis] - mean[axis]));
        image.set_pixel(k as u32 % width, k as u32 / width, from_oklab(moved).to_rgba8());
    }
    material.base_color_texture = Some(image.into());
}

/// Share of the surface whose own color, without light, has the hue of the asked one (to 15 degrees) and about its
/// lightness; a gray has any hue and little chroma. 0..1.
pub fn shown_share(mesh: &TexturedMesh, asked: Rgb) -> f64 {
    share_within(mesh, asked, |_| true)
}

/// As [`shown_share`], of the surface of the meant materials.
fn share_within(mesh: &TexturedMesh, asked: Rgb, is_meant: impl Fn(usize) -> bool) -> f64 {
    let (mut shown_m2, mut whole_m2) = (0.0, 0.0);
    for group in mesh.groups.iter().filter(|group| is_meant(group.material)) {
        let material = &mesh.materials[group.material];
        for triangle in &group.triangles {
            let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
            let area_m2 = 0.5 * (b - a).cross(c - a).length();
            let uvs = triangle.map(|v| mesh.uvs[v as usize]);
            whole_m2 += area_m2;
            for weights in [[0.6, 0.2, 0.2], [0.2, 0.6, 0.2], [0.2, 0.2, 0.6], [1.0 / 3.0; 3]] {
                let [u, v]: [f64; 2] = std::array::from_fn(|axis| {
                    uvs.iter().zip(weights).map(|(uv, weight)| f64::from(uv[axis]) * weight).sum()
                });
                let color = match &material.base_color_texture {
                    Some(texture) => texel(texture, DVec2::new(u, v)),
                    None => material.base_color,
                };
                shown_m2 += if is_alike(color, asked) { 0.25 * area_m2 } else { 0.0 };
            }
        }
    }
    if whole_m2 > 0.0 { shown_m2 / whole_m2 } else { 0.0 }
}

fn is_alike(color: Rgb, asked: Rgb) -> bool {
    let ([l, a, b], [asked_l, asked_a, asked_b]) = (oklab(color), oklab(asked));
    let (chroma, asked_chroma) = (a.hypot(b), asked_a.hypot(asked_b));
    if (l - asked_l).abs() > LIGHTNESS {
        return false;
    }
    if asked_chroma < MIN_CHROMA {
        return chroma < 1.5 * MIN_CHROMA;
    }
    let turn = b.atan2(a) - asked_b.atan2(asked_a);
    let hue_rad = (turn + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
    chroma > 0.4 * asked_chroma && hue_rad.abs() <= HUE_RAD
}

fn texel(texture: &imaging::Texture, uv: DVec2) -> Rgb {
    let at = |share: f64, side: u32| (share.rem_euclid(1.0) * f64::from(side)) as u32 % side;
    let [red, green, blue, _] = texture.pixel(at(uv.x, texture.width_px()), at(uv.y, texture.height_px()));
    Rgb([red, green, blue].map(|channel| f32::from(channel) / 255.0))
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use super::*;
    use crate::{Category, Recipe, build, categories};

    const ASKED: [(&str, u32); 12] = [
        ("red", 0xc0_39_2b),
        ("orange", 0xe6_7e_22),
        ("yellow", 0xf0_c3_30),
        ("green", 0x3f_8f_4f),
        ("teal", 0x1f_7f_82),
        ("blue", 0x2f_63_b5),
        ("purple", 0x71_40_9a),
        ("pink", 0xe7_9a_b0),
        ("brown", 0x7a_52_30),
        ("white", 0xf2_f0_ea),
        ("black", 0x25_26_2a),
        ("gray", 0x85_88_8c),
    ];

    /// Share of an object of a category that shows a color.
    fn share(category: &Category, asked: Rgb, seed: u64) -> f64 {
        let typical = Recipe::typical(&category.name, Some(asked), None).expect("a category");
        shown_share(&build(&Recipe { seed, ..typical }).expect("a mesh"), asked)
    }

    #[test]
    fn every_category_shows_every_color_word() {
        let pairs: Vec<(&Category, &str, f64)> = categories()
            .par_iter()
            .enumerate()
            .flat_map_iter(|(index, category)| {
                // Two of the colors for each, in turn: all would take minutes.
                let asked = ASKED.into_iter().skip(index % 6).step_by(6);
                asked.map(move |(word, hex)| (category, word, share(category, Rgb::hex(hex), index as u64)))
            })
            .collect();
        let hidden: Vec<String> = pairs
            .iter()
            .filter(|(_, _, share)| *share < 0.08)
            .map(|(category, word, share)| format!("{word} {}: {share:.3}", category.name))
            .collect();
        assert!(hidden.is_empty(), "{hidden:?}");
        let plain = pairs.iter().filter(|(_, _, share)| *share >= 0.25).count();
        assert!(plain as f64 >= 0.95 * pairs.len() as f64, "{plain} of {}", pairs.len());
    }

    #[test]
    fn oklab_and_back_is_the_same_color() {
        for (_, hex) in ASKED {
            let color = Rgb::hex(hex);
            assert_eq!(from_oklab(oklab(color)).to_rgba8(), color.to_rgba8());
        }
    }
}
