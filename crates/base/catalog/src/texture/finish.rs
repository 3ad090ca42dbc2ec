//! Surface finishes of named materials.

use super::{brushed_metal, ceramic_speckle, fabric_weave, granite, marble, wicker, wood_grain};
use geometry::{Material, Rgb};
use imaging::Texture;
use runtime::seed::Rng;

/// Names that [`material_finish`] knows.
const NAMES: &[&str] = &[
    "oak",
    "walnut",
    "pine",
    "birch",
    "beech",
    "maple",
    "cherry",
    "mahogany",
    "bamboo",
    "wood",
    "wooden",
    "steel",
    "stainless_steel",
    "metal",
    "iron",
    "cast_iron",
    "aluminum",
    "chrome",
    "silver",
    "copper",
    "brass",
    "gold",
    "glass",
    "ceramic",
    "porcelain",
    "stoneware",
    "clay",
    "terracotta",
    "plastic",
    "rubber",
    "leather",
    "fabric",
    "cloth",
    "wool",
    "felt",
    "cork",
    "paper",
    "cardboard",
    "stone",
    "granite",
    "marble",
    "wicker",
    "concrete",
];

/// Whether [`material_finish`] has a finish of its own for `name`.
pub fn is_finish(name: &str) -> bool {
    NAMES.contains(&name)
}

/// The finish of the material `name`. Woods, metals and cork have their own color; the others
/// (plastic, ceramic, glass, leather, cloth, unknown names) take `fallback_color`.
pub fn material_finish(name: &str, fallback_color: Rgb, rng: &mut Rng) -> Material {
    let wood = |color: u32, rng: &mut Rng| Material {
        relief: 0.008,
        ..Material::textured(name, wood_grain(Rgb::hex(color), rng), 0.55)
    };
    let rough = |texture: Texture, roughness: f32, relief: f32| Material {
        relief,
        ..Material::textured(name, texture, roughness)
    };
    let metal = |color: u32, roughness: f32, rng: &mut Rng| Material {
        metalness: 1.0,
        ..Material::textured(name, brushed_metal(Rgb::hex(color), rng), roughness)
    };
    let color = fallback_color;
    match name {
        "oak" | "wood" | "wooden" => wood(0xb9_8a_55, rng),
        "walnut" => wood(0x6a_45_2c, rng),
        "pine" => wood(0xdd_b5_78, rng),
        "birch" | "maple" => wood(0xe2_c7_98, rng),
        "beech" => wood(0xcf_a4_70, rng),
        "cherry" => wood(0xa3_5f_38, rng),
        "mahogany" => wood(0x7a_38_26, rng),
        "bamboo" => wood(0xd8_b8_70, rng),
        "steel" | "stainless_steel" | "metal" => metal(0xc9_cb_cd, 0.3, rng),
        "chrome" | "silver" => metal(0xdd_de_e0, 0.14, rng),
        "aluminum" => metal(0xb8_bb_c0, 0.42, rng),
        "iron" | "cast_iron" => metal(0x3a_3b_3d, 0.6, rng),
        "copper" => metal(0xc9_7a_52, 0.28, rng),
        "brass" => metal(0xc9_a2_4c, 0.28, rng),
        "gold" => metal(0xe0_b9_4e, 0.2, rng),
        "glass" => Material { opacity: 0.35, ..Material::plain(name, color, 0.06) },
        "ceramic" | "porcelain" => Material::plain(name, color, 0.2),
        "stoneware" => rough(ceramic_speckle(color, rng), 0.45, 0.003),
        "clay" | "terracotta" => rough(ceramic_speckle(Rgb::hex(0xb8_66_42), rng), 0.8, 0.008),
        "plastic" => Material::plain(name, color, 0.35),
        "rubber" => Material::plain(name, color, 0.8),
        "leather" => rough(granite(color.scaled(1.05), rng), 0.6, 0.02),
        "fabric" | "cloth" | "wool" | "felt" => rough(fabric_weave(color, rng), 0.95, 0.012),
        "cork" => rough(granite(Rgb::hex(0xb8_8c_5c), rng), 0.9, 0.012),
        "paper" => Material::plain(name, color, 0.9),
        "cardboard" => Material::plain(name, Rgb::hex(0xb8_92_62), 0.9),
        "stone" | "granite" | "concrete" => Material::textured(name, granite(Rgb::hex(0x8a_8a_88), rng), 0.6),
        "marble" => {
            let texture = marble(Rgb::hex(0xee_ec_e8), Rgb::hex(0x84_84_8a), rng);
            Material::textured(name, texture, 0.2)
        }
        "wicker" => rough(wicker(Rgb::hex(0xb0_7c_44), 16, rng), 0.85, 0.02),
        _ => Material::plain("main", color, 0.45),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::seed::child_rng;

    #[test]
    fn every_listed_material_has_its_own_finish() {
        let mut rng = child_rng(1, "look");
        for name in NAMES {
            assert_eq!(material_finish(name, Rgb([0.5; 3]), &mut rng).name, *name);
        }
        assert_eq!(material_finish("unobtainium", Rgb([0.5; 3]), &mut rng).name, "main");
    }
}
