//! Names of objects in an instruction ("put mug_1 on tray_1").
//!
//! The analyst knows no names. Each named object is called by a color and its noun instead ("the red mug"), one color
//! for each object, so that two mugs are not taken for one.

use std::ops::Range;

use editing::EditableObject;

use super::words::words;

/// Colors that tell named objects apart.
const COLORS: [&str; 8] = ["red", "blue", "green", "yellow", "purple", "orange", "black", "white"];

/// The text without names, and the bytes of what stands for them with the index of the object. Names beyond the number
/// of colors stay.
pub(super) fn replaced(text: &str, objects: &[EditableObject]) -> (String, Vec<(Range<usize>, usize)>) {
    let (mut replaced, mut named, mut at) = (String::new(), Vec::new(), 0);
    let mut known: Vec<usize> = Vec::new();
    let mut is_preceded_by_the = false;
    for word in words(text) {
        let index = objects.iter().position(|object| object.name.as_str() == word.text);
        let the = matches!(word.text.as_str(), "the" | "a" | "an");
        let Some(index) = index.filter(|_| word.text.contains('_')) else {
            is_preceded_by_the = the;
            continue;
        };
        let position = known.iter().position(|other| *other == index).unwrap_or_else(|| {
            known.push(index);
            known.len() - 1
        });
        let Some(color) = COLORS.get(position) else { continue };
        replaced.push_str(&text[at..word.bytes.start]);
        if !is_preceded_by_the {
            replaced.push_str("the ");
        }
        let start = replaced.len();
        replaced.push_str(color);
        replaced.push(' ');
        replaced.push_str(noun(&objects[index]));
        named.push((start..replaced.len(), index));
        at = word.bytes.end;
        is_preceded_by_the = false;
    }
    replaced.push_str(&text[at..]);
    (replaced, named)
}

/// A noun that the analyst knows: that of the category, or "block" where the object has none.
fn noun(object: &EditableObject) -> &str {
    catalog::category(&object.category).map_or("block", |category| &category.label)
}
