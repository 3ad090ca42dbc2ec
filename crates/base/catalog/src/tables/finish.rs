//! Finishes of a table's top, frame and metal parts.

mod boards;
mod slab;

use rand::RngExt;

use geometry::{Material, Rgb, TexturedMesh};
use runtime::seed::Rng;

/// Names of materials of tops and of frames, as [`Finish::choose`] gives them.
pub(crate) const TOPS: [&str; 12] = [
    "oak", "walnut", "pine", "birch", "paint", "marble", "glass", "steel", "granite", "terrazzo", "concrete",
    "tile",
];
const FRAMES: [&str; 5] = ["oak_frame", "walnut_frame", "pine_frame", "birch_frame", "frame_paint"];

/// The mesh of a table of this catalog with the finish of another material: one of [`super::TABLE_MATERIALS`]. Its
/// materials keep their names. `None` for a mesh whose materials are not those of a table of the catalog.
pub fn refinished(mesh: &TexturedMesh, material: &str, rng: &mut Rng) -> Option<TexturedMesh> {
    mesh.materials.iter().find(|known| TOPS.contains(&known.name.as_str()))?;
    let finish = Finish::choose("table", None, Some(material), rng);
    let mut refinished = mesh.clone();
    for known in &mut refinished.materials {
        let other = match known.name.as_str() {
            name if TOPS.contains(&name) => &finish.top,
            name if FRAMES.contains(&name) => &finish.frame,
            _ => continue,
        };
        *known = Material { name: std::mem::take(&mut known.name), ..other.clone() };
    }
    Some(refinished)
}

/// Materials of one table.
pub struct Finish {
    pub top: Material,
    pub frame: Material,
    /// Handles, feet, screws.
    pub metal: Material,
    pub thickness_m: f64,
}

impl Finish {
    /// The requested material, or a usual one for the model; `color` is the color of the top.
    pub fn choose(model: &str, color: Option<Rgb>, material: Option<&str>, rng: &mut Rng) -> Self {
        let usual: &[&str] = match model {
            "workbench" => &["pine", "birch", "oak"],
            "desk" => &["oak", "walnut", "birch", "white"],
            "coffee_table" | "kidney_table" => &["walnut", "oak", "birch"],
            _ => &["oak", "walnut", "pine", "birch"],
        };
        let drawn = usual[rng.random_range(0..usual.len())];
        let name = match material {
            Some(name) if super::TABLE_MATERIALS.contains(&name) => name,
            _ if color.is_some() => "painted",
            _ => drawn,
        };
        let steel = Material::metal("brushed_metal", Rgb::hex(0x9a_9d_a1), 0.35);
        let dark = Material::metal("blackened_steel", Rgb::hex(0x3a_3b_3e), 0.5);
        let thickness_m = match (model, name) {
            ("workbench", _) => 0.045,
            (_, "glass") => 0.02,
            (_, "steel") => 0.022,
            ("coffee_table" | "kidney_table" | "square_table", _) => 0.025,
            _ => 0.032,
        };
        let (top, frame) = match name {
            "glass" => {
                let glass =
                    Material { opacity: 0.45, ..Material::plain("glass", Rgb::hex(0xbf_d8_d2), 0.05) };
                (glass, steel.clone())
            }
            "marble" => (stone(color, rng), dark.clone()),
            "granite" | "terrazzo" | "concrete" | "tile" => (mineral(name, color, rng), dark.clone()),
            "steel" => {
                let sheet = Material::metal("steel", color.unwrap_or(Rgb::hex(0xb4_b8_bc)), 0.38);
                (sheet, dark.clone())
            }
            "white" | "painted" => rendered(color.unwrap_or(Rgb::hex(0xee_ed_e8))),
            "black" => rendered(color.unwrap_or(Rgb::hex(0x2a_2a_2c))),
            wood => timber(wood, color, rng),
        };
        Self { top, frame, metal: steel, thickness_m }
    }
}

fn stone(color: Option<Rgb>, rng: &mut Rng) -> Material {
    let base = color.unwrap_or(Rgb::hex(0xee_ec_e8));
    let dark = base.0.iter().sum::<f32>() < 1.2;
    let vein = if dark { Rgb::hex(0xd8_d4_cc) } else { Rgb::hex(0x84_84_8a) };
    Material::textured("marble", slab::marble_slab(base, vein, rng), 0.22)
}

/// A top of grained stone, cast stone or tiles, whose color varies where none is asked for.
fn mineral(name: &str, color: Option<Rgb>, rng: &mut Rng) -> Material {
    let (usual, roughness): ([u32; 3], f32) = match name {
        "granite" => ([0x8d_89_86, 0x5f_5d_5e, 0x9a_84_78], 0.24),
        "terrazzo" => ([0xe2_dc_d0, 0xd3_d2_cc, 0xcf_bf_b0], 0.3),
        "concrete" => ([0xa9_a6_a0, 0x94_92_8e, 0xb4_ad_a2], 0.62),
        _ => ([0xe8_e5_dd, 0xc9_d6_d2, 0xdc_cf_b8], 0.16),
    };
    let color = color.unwrap_or(Rgb::hex(usual[rng.random_range(0..usual.len())]));
    let texture = match name {
        "granite" => slab::granite_slab(color, rng),
        "terrazzo" => slab::terrazzo_slab(color, rng),
        "concrete" => slab::concrete_slab(color, rng),
        _ => slab::tiles(color, rng),
    };
    Material::textured(name, texture, roughness)
}

fn rendered(color: Rgb) -> (Material, Material) {
    (Material::plain("paint", color, 0.45), Material::plain("frame_paint", color.scaled(0.92), 0.5))
}

/// A top of glued boards, and plain grain for the frame.
fn timber(name: &str, color: Option<Rgb>, rng: &mut Rng) -> (Material, Material) {
    let usual = match name {
        "walnut" => Rgb::hex(0x6e_49_30),
        "pine" => Rgb::hex(0xd9_b2_78),
        "birch" => Rgb::hex(0xe0_c8_9c),
        _ => Rgb::hex(0xb8_8a_56),
    };
    let color = color.unwrap_or(usual);
    let top = Material::textured(name, boards::tabletop(name, color, rng), 0.5);
    let frame = boards::straight(name, color.scaled(0.93), rng);
    let frame = Material::textured(&format!("{name}_frame"), frame, 0.55);
    (top, frame)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::{TABLE_MATERIALS, build_table, table_models};
    use runtime::seed::child_rng;

    #[test]
    fn every_table_takes_every_finish_and_keeps_its_shape() {
        let top = |mesh: &TexturedMesh| {
            let is_top = |known: &&Material| TOPS.contains(&known.name.as_str());
            let top = mesh.materials.iter().find(is_top).expect("a top").clone();
            (top.base_color, top.base_color_texture.is_some(), top.metalness.to_bits())
        };
        for model in table_models() {
            let build = |material: &&'static str| {
                let built = build_table(model.name, model.high_m, None, Some(material), 3);
                (*material, built.expect("a model").mesh)
            };
            let built: Vec<(&str, TexturedMesh)> = TABLE_MATERIALS.iter().map(build).collect();
            for (index, (before, mesh)) in built.iter().enumerate() {
                // Two of the others: all pairs take a minute.
                for step in [1, 5] {
                    let (material, expected) = &built[(index + step) % built.len()];
                    let other = refinished(mesh, material, &mut child_rng(1, material)).expect("a table");
                    assert_eq!(top(&other), top(expected), "{} of {before} in {material}", model.name);
                    assert_eq!((&other.positions, &other.groups), (&mesh.positions, &mesh.groups));
                }
            }
        }
    }

    #[test]
    fn what_is_no_table_of_the_catalog_has_no_other_finish() {
        let mut mesh = TexturedMesh::default();
        let solid = geometry::shapes::block(glam::DVec3::ONE);
        mesh.add(solid, &Material::plain("photographed", Rgb::hex(0x80_80_80), 0.5));
        assert_eq!(refinished(&mesh, "oak", &mut child_rng(1, "oak")), None);
    }
}
