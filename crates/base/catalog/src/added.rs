//! Categories of the user, beside those that are compiled in.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use glam::DVec3;

use super::category::{Category, CategoryFile, built_in};
use super::kit::ShapeError;
use super::{category, stand_in, substance};

/// Categories that were added when the program started.
struct Added {
    categories: Vec<Category>,
    digest: String,
}

static ADDED: OnceLock<Added> = OnceLock::new();

/// Categories that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CategoryError {
    #[error("{0}")]
    NotReadable(String),
    #[error("category `{name}`: {fault}")]
    Faulty { name: String, fault: CategoryFault },
    #[error("categories can be added only when the program starts")]
    TooLate,
}

/// Fault of a category.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CategoryFault {
    #[error("a name has lower-case letters, digits and underscores")]
    BadName,
    #[error("{other} has the name `{word}` already; choose another")]
    NameTaken { word: String, other: String },
    #[error("the word `{0}` has upper-case letters or blanks at its ends")]
    BadWord(String),
    #[error("it has no `[category.shape]`; list its parts, or name a category that it is like")]
    NoShape,
    #[error("{0}")]
    Shape(ShapeError),
    #[error("no substance `{0}`; `config/materials.toml` lists them")]
    UnknownSubstance(String),
    #[error("each of `size.low_m` must be above 0, and at most that of `size.high_m`")]
    BadSize,
    #[error("`{0}` is no color; write #rrggbb")]
    BadColor(String),
    #[error("`palette` and `families` must not be empty")]
    Empty,
}

/// The categories of a file, as in `config/catalog/*.toml`, not yet checked against others.
///
/// # Errors
///
/// [`CategoryError::NotReadable`], with the line and the key.
pub fn read_categories(text: &str) -> Result<Vec<Category>, CategoryError> {
    let file: Result<CategoryFile, _> = toml::from_str(text);
    file.map(|file| file.category).map_err(|error| CategoryError::NotReadable(error.to_string()))
}

/// Adds the categories to the catalog of this process. `digest` stands for the content of their files: results that
/// were made without them, or with others, are not taken for results with these.
///
/// # Errors
///
/// A [`CategoryError`] for the first category that cannot be used; [`CategoryError::TooLate`] where the catalog was
/// read before.
pub fn add_categories(categories: Vec<Category>, digest: String) -> Result<(), CategoryError> {
    if categories.is_empty() {
        return Ok(());
    }
    check_words(&categories)?;
    each(&categories, check_values)?;
    if super::category::is_read() || ADDED.set(Added { categories, digest }).is_err() {
        return Err(CategoryError::TooLate);
    }
    each(added(), check_shape)
}

fn each(
    categories: &[Category],
    check: fn(&Category) -> Result<(), CategoryFault>,
) -> Result<(), CategoryError> {
    categories.iter().try_for_each(|category| {
        check(category).map_err(|fault| CategoryError::Faulty { name: category.name.clone(), fault })
    })
}

/// The categories that were added.
pub(crate) fn added() -> &'static [Category] {
    ADDED.get().map_or(&[], |added| &added.categories)
}

/// Digest of the files of categories that were added; `None` where there are none.
pub fn added_digest() -> Option<&'static str> {
    ADDED.get().map(|added| added.digest.as_str())
}

/// Lower case, hyphens and underscores as blanks: how words are compared.
pub(crate) fn normalized(words: &str) -> String {
    words.to_lowercase().replace(['-', '_'], " ").split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Names and words that two categories share.
fn check_words(categories: &[Category]) -> Result<(), CategoryError> {
    let known = built_in();
    let mut owners: BTreeMap<String, &Category> = BTreeMap::new();
    for known in known.iter().chain(stand_in::hidden_categories()) {
        owners.extend(known.words().map(|word| (normalized(word), known)));
    }
    for category in categories {
        let faulty = |fault| Err(CategoryError::Faulty { name: category.name.clone(), fault });
        let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        if category.name.is_empty() || !category.name.chars().all(is_plain) {
            return faulty(CategoryFault::BadName);
        }
        for word in category.words() {
            if word.trim() != word || word.is_empty() || *word != word.to_lowercase() {
                return faulty(CategoryFault::BadWord(word.to_owned()));
            }
            let other = owners.insert(normalized(word), category);
            if let Some(other) = other.filter(|other| !std::ptr::eq(*other, category)) {
                let (word, other) = (word.to_owned(), other.name.clone());
                return faulty(CategoryFault::NameTaken { word, other });
            }
        }
    }
    Ok(())
}

/// Sizes, colors and substance.
pub(crate) fn check_values(category: &Category) -> Result<(), CategoryFault> {
    if substance(&category.substance).is_none() {
        return Err(CategoryFault::UnknownSubstance(category.substance.clone()));
    }
    if category.palette.is_empty() || category.families.is_empty() {
        return Err(CategoryFault::Empty);
    }
    let (low_m, high_m) = (category.size.low_m, category.size.high_m);
    if !(low_m.cmpgt(DVec3::ZERO).all() && low_m.cmple(high_m).all() && high_m.is_finite()) {
        return Err(CategoryFault::BadSize);
    }
    let is_color = |color: &str| {
        let digits = color.strip_prefix('#').filter(|digits| digits.len() == 6);
        digits.is_some_and(|digits| u32::from_str_radix(digits, 16).is_ok())
    };
    match category.palette.iter().find(|color| !is_color(color)) {
        Some(color) => Err(CategoryFault::BadColor(color.clone())),
        None => Ok(()),
    }
}

/// A shape of its own that can be built.
fn check_shape(given: &Category) -> Result<(), CategoryFault> {
    // By its name the shape finds those that it is like.
    let shape = category(&given.name).and_then(|known| known.shape.as_ref()).ok_or(CategoryFault::NoShape)?;
    shape.get().check().map_err(CategoryFault::Shape)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = r##"
        [[category]]
        name = "sundial"
        label = "sundial"
        synonyms = ["sun dial"]
        families = ["crafting_hobby"]
        group = "decor"
        size = { low_m = [0.12, 0.12, 0.18], high_m = [0.16, 0.16, 0.24] }
        palette = ["#8a6a3c"]
        substance = "wood"
        facing = "viewer"
        symmetry_order = 1
        zone = "any"
        [category.shape]
        part = [{ box = { size = [0.14, 0.14, 0.2], edge = 0.004 } }]
    "##;

    fn changed(from: &str, to: &str) -> Result<(), CategoryError> {
        assert!(FILE.contains(from), "{from}");
        let read = read_categories(&FILE.replace(from, to))?;
        check_words(&read)?;
        each(&read, check_values)
    }

    #[test]
    fn what_is_wrong_with_a_category_is_named() {
        changed("sundial", "sundial").expect("a sound category");
        let refused = |from, to| changed(from, to).expect_err(to).to_string();
        assert!(refused("zone = \"any\"", "zone = \"roof\"").contains("roof"));
        assert!(refused("\"sundial\"", "\"Sun Dial\"").contains("lower-case"));
        assert!(refused("\"sundial\"", "\"mug\"").contains("mug has the name `mug`"));
        assert!(refused("sun dial", "coffee mug").contains("mug has the name `coffee mug`"));
        assert!(refused("sun dial", "Sun dial").contains("upper-case"));
        assert!(refused("\"wood\"", "\"kryptonite\"").contains("no substance `kryptonite`"));
        assert!(refused("0.12, 0.12, 0.18", "0.12, 0, 0.18").contains("above 0"));
        assert!(refused("#8a6a3c", "brown").contains("#rrggbb"));
        assert!(refused("[\"#8a6a3c\"]", "[]").contains("not be empty"));
    }
}
