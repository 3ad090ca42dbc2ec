//! Names of the requests of a recipe: template, values, options and seed, as `t0_red_three-spoons_o1_s7`.
//!
//! Values are shortened to letters and digits. Within one slot no two values have the same short form, and no short
//! form has a `_`, so that different combinations have different names.

use std::collections::BTreeSet;

use crate::request::MAX_CUSTOM_ID_CHARS;

/// Lengths that values are cut to, until every name is short enough. At 0 a value is its number.
const LENGTHS: [usize; 8] = [32, 24, 16, 12, 8, 5, 3, 0];

/// Names of values by slot; `None` where even numbers of values are too long, so that names count combinations.
#[derive(Clone, Debug)]
pub(super) struct Names(Option<Vec<Vec<String>>>);

/// Quantities that determine the length of names.
pub(super) struct Extent<'a> {
    /// Slots of each template.
    pub(super) templates: Vec<&'a [usize]>,
    pub(super) option_count: usize,
    pub(super) largest_seed: Option<u64>,
}

impl Names {
    /// Names for values by slot, as long as they may be.
    pub(super) fn new(slots: &[(String, Vec<String>)], extent: &Extent<'_>) -> Self {
        let fits = |names: &Vec<Vec<String>>| {
            let largest = |slot: &usize| names[*slot].iter().map(String::len).max().unwrap_or(0);
            let options = (extent.option_count > 1).then_some(extent.option_count - 1);
            let rest = tail(options, extent.largest_seed).len();
            extent.templates.iter().enumerate().all(|(k, slots)| {
                let values: usize = slots.iter().map(|slot| 1 + largest(slot)).sum();
                format!("t{k}").len() + values + rest <= MAX_CUSTOM_ID_CHARS
            })
        };
        let candidates =
            LENGTHS.map(|length| slots.iter().map(|(_, values)| short_forms(values, length)).collect());
        Self(candidates.into_iter().find(fits))
    }

    /// The name of a combination: `choices` are numbers of values of the slots; `number` counts combinations.
    pub(super) fn name(
        &self,
        template: usize,
        slots: &[usize],
        choices: &[usize],
        option: Option<usize>,
        seed: Option<u64>,
        number: u64,
    ) -> String {
        let mut name = format!("t{template}");
        match &self.0 {
            Some(names) => {
                for (slot, choice) in slots.iter().zip(choices) {
                    name.push('_');
                    name.push_str(&names[*slot][*choice]);
                }
            }
            None => name.push_str(&format!("_n{number}")),
        }
        name + &tail(option, seed)
    }
}

fn tail(option: Option<usize>, seed: Option<u64>) -> String {
    let option = option.map(|option| format!("_o{option}")).unwrap_or_default();
    let seed = seed.map(|seed| format!("_s{seed}")).unwrap_or_default();
    option + &seed
}

/// Short forms of the values of one slot, all different, of at most `length` characters and a number.
fn short_forms(values: &[String], length: usize) -> Vec<String> {
    let mut used = BTreeSet::new();
    let forms = values.iter().enumerate().map(|(index, value)| {
        let mut form = short_form(value, length);
        if form.is_empty() {
            form = index.to_string();
        }
        while !used.insert(form.clone()) {
            form = format!("{form}-{index}");
        }
        form
    });
    forms.collect()
}

/// Lower-case letters and digits, with `-` for what is between them.
fn short_form(value: &str, length: usize) -> String {
    let mut form = String::new();
    for c in value.chars() {
        if c.is_ascii_alphanumeric() {
            form.push(c.to_ascii_lowercase());
        } else if !form.is_empty() && !form.ends_with('-') {
            form.push('-');
        }
        if form.len() >= length {
            break;
        }
    }
    form.truncate(length);
    form.trim_matches('-').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_forms_are_readable_and_differ() {
        let forms = |values: &[&str], length| {
            short_forms(&values.iter().map(|value| (*value).to_owned()).collect::<Vec<_>>(), length)
        };
        assert_eq!(forms(&["Red", "dark  blue", "12 cm"], 32), ["red", "dark-blue", "12-cm"]);
        assert_eq!(forms(&["red", "red!", "red?"], 32), ["red", "red-1", "red-2"]);
        assert_eq!(forms(&["red-1", "red", "red!"], 32), ["red-1", "red", "red-2"]);
        assert_eq!(forms(&["été", "咖啡", "1"], 32), ["t", "1", "1-2"]);
        assert_eq!(forms(&["banana", "bandana", "b"], 3), ["ban", "ban-1", "b"]);
        assert_eq!(forms(&["red", "blue"], 0), ["0", "1"]);
    }
}
