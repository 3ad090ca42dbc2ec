//! SimReady's non-visual materials: the substance of a surface for sensors other than cameras (lidar, radar).

use geometry::Material;

use super::layer::Prim;
use super::value::Value;

/// Writes the substance of a visual material, if SimReady's fixed list of bases contains it.
pub fn write(prim: &mut Prim, substance: &str, material: &Material) {
    let Some(base) = base(substance, material) else { return };
    let attribute = if material.opacity < 1.0 { "visually_transparent" } else { "none" };
    prim.set("omni:simready:nonvisual:attributes", Value::tokens(&[attribute]));
    prim.set("omni:simready:nonvisual:base", Value::token(base));
    prim.set("omni:simready:nonvisual:coating", Value::token("none"));
}

/// The base for a body's main substance (a name of `config/materials.toml`). A part with a metallic material is metal,
/// whatever the main substance is.
fn base(substance: &str, material: &Material) -> Option<&'static str> {
    let main = match substance {
        "wood" | "plywood" => "wood",
        "ceramic" | "porcelain" => "ceramic_glass",
        "glass" => "clear_glass",
        "steel" => "steel",
        "aluminum" => "aluminum",
        "brass" => "brass",
        "cast_iron" => "iron",
        "plastic" | "hard_plastic" | "electronics" => "plastic",
        "rubber" => "rubber",
        "paper" => "paper",
        "cardboard" => "cardboard",
        "fabric" => "fabric",
        "leather" => "leather",
        "stone" => "stone",
        "soil" => "dirt",
        "water" => "water",
        _ => return None,
    };
    let is_metal = ["steel", "aluminum", "brass", "iron"].contains(&main);
    Some(if material.metalness >= 0.5 && !is_metal { "steel" } else { main })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Rgb;

    #[test]
    fn base_maps_known_substances_and_metallic_parts() {
        let plain = Material::plain("glaze", Rgb::hex(0xffffff), 0.4);
        let metal = Material::metal("blade", Rgb::hex(0xc0c0c0), 0.2);
        assert_eq!(base("porcelain", &plain), Some("ceramic_glass"));
        assert_eq!(base("wood", &metal), Some("steel"));
        assert_eq!(base("brass", &metal), Some("brass"));
        // The list has no base for fruit.
        assert_eq!(base("fruit", &plain), None);
    }
}
