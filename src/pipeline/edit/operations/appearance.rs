//! Operations on colors, materials and labels.

use std::sync::Arc;

use super::{Done, NewTable, OperationInputs, ids, names, one, several};
use crate::pipeline::certify::plausibility::uncovered_m;
use crate::pipeline::edit::draft::{Draft, load};
use crate::pipeline::edit::error::EditError;
use crate::pipeline::edit::recolor::recolored;
use catalog::{physical, substance};
use editing::references;
use geometry::Rgb;

/// A table in another material may stick out of the hulls of the one before by this, meters.
const MAX_UNCOVERED_M: f64 = 0.01;

pub(super) fn recolor(draft: &mut Draft, phrase: &str, color: Option<&str>, material: Option<&str>) -> Done {
    let color = color.map(color_named).transpose()?;
    let material = material.map(|words| material_named(words, false)).transpose()?;
    let material = material.as_deref();
    let targets = several(draft, phrase)?;
    for &target in &targets {
        let appearance = color.or_else(|| material.and_then(material_color));
        let geometry = &draft.loaded[target + 1];
        let mesh = match appearance {
            Some(appearance) => recolored(&geometry.mesh, appearance),
            None => (*geometry.mesh).clone(),
        };
        let loaded = load(mesh, geometry.hulls.clone())?;
        draft.repaint(target, loaded, material)?;
        let recognition = Arc::make_mut(&mut draft.composition.recognition);
        let recognized = &mut recognition.objects[target];
        recognized.color = color.or(recognized.color);
        if let Some(material) = material {
            recognized.material = Some(material.to_owned());
        }
    }
    let appearance: Vec<String> = [color.map(|_| "color"), material.map(|_| "material")]
        .into_iter()
        .flatten()
        .map(str::to_owned)
        .collect();
    Ok((
        ids(draft, &targets),
        format!("changed the {} of {}", appearance.join(" and "), names(draft, &targets)),
    ))
}

/// The color of words such as "red" and "dark blue".
pub(in crate::pipeline::edit) fn color_named(words: &str) -> Result<Rgb, EditError> {
    references::color_of(words.trim()).ok_or_else(|| EditError::UnknownColor { words: words.to_owned() })
}

/// The name of a material in the catalog; of a table, its finish where the material has one.
pub(in crate::pipeline::edit) fn material_named(words: &str, of_table: bool) -> Result<String, EditError> {
    let lower = words.trim().to_ascii_lowercase();
    if let Some(word) = references::material_of(&lower) {
        let finish = word.table.as_ref().filter(|_| of_table);
        return Ok(finish.unwrap_or(&word.substance).clone());
    }
    let is_known = substance(&lower).is_some() || physical::is_finish(&lower);
    is_known.then_some(lower).ok_or_else(|| EditError::UnknownMaterial { words: words.to_owned() })
}

/// The usual color of a material, where it has one.
fn material_color(material: &str) -> Option<Rgb> {
    let hex = match material {
        "steel" | "stainless_steel" | "metal" => 0xb8_bc_c0,
        "aluminum" | "aluminium" => 0xc8_cb_ce,
        "wood" | "oak" => 0xb0_84_55,
        "walnut" => 0x5e_42_2d,
        "pine" | "birch" | "bamboo" => 0xd8_b9_86,
        "plastic" => 0xd8_d8_d4,
        "ceramic" | "porcelain" => 0xee_eb_e4,
        "stone" | "marble" => 0xcf_cc_c6,
        "copper" => 0xb4_70_3f,
        "brass" => 0xc2_9b_4a,
        "leather" => 0x7a_4d_2e,
        "cardboard" | "paper" => 0xc9_a9_7c,
        "rubber" => 0x33_34_36,
        _ => return None,
    };
    Some(Rgb::hex(hex))
}

pub(super) fn relabel(draft: &mut Draft, phrase: &str, label: &str) -> Done {
    let target = one(draft, phrase)?;
    let recognition = Arc::make_mut(&mut draft.composition.recognition);
    label.trim().clone_into(&mut recognition.objects[target].label);
    Ok((ids(draft, &[target]), format!("labeled {} as {label:?}", draft.name(target))))
}

pub(super) fn restyle_table(draft: &mut Draft, given: OperationInputs) -> Done {
    let NewTable { loaded, material, color } = given.table.ok_or(EditError::NoTable)?;
    // It keeps the hulls of the table before.
    if uncovered_m(&loaded.mesh, &loaded.hulls) > MAX_UNCOVERED_M {
        return Err(EditError::OtherTableShape);
    }
    draft.replace_table(loaded, material.as_deref())?;
    let recognition = Arc::make_mut(&mut draft.composition.recognition);
    if color.is_some() {
        recognition.table.color = color;
    }
    if material.is_some() {
        recognition.table.material = material;
    }
    Ok((Vec::new(), "changed the appearance of the table".to_owned()))
}
