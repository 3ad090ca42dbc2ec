//! Contents of each split.
//!
//! The split of an image determines its categories, composites, finishes and backdrops. The lists are disjoint and
//! fixed: a category added to the catalog becomes training material unless a list here names it.

use serde::{Deserialize, Serialize};

use catalog::{Category, categories};

/// One of three disjoint sets of images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Split {
    /// For training.
    Training,
    /// For early stopping and for choosing thresholds.
    Validation,
    /// For the final evaluation only.
    Test,
}

/// Categories that occur only in validation images.
pub const VALIDATION_CATEGORIES: &[&str] = &[
    "book",
    "candle",
    "cheese_wedge",
    "croissant",
    "cutting_mat",
    "dice",
    "hammer",
    "headphones",
    "jar",
    "marker",
    "orange",
    "plate",
    "pliers",
    "scissors",
    "spatula",
    "tablet",
    "thread_spool",
    "toolbox",
    "wine_glass",
];

/// Categories that occur only in test images.
pub const TEST_CATEGORIES: &[&str] = &[
    "baguette",
    "banana",
    "bowl",
    "cactus",
    "carrot",
    "desk_clock",
    "desk_lamp",
    "eyeglasses",
    "flashlight",
    "fork",
    "frying_pan",
    "glue_stick",
    "hand_saw",
    "hourglass",
    "ladle",
    "laptop",
    "magnifying_glass",
    "milk_carton",
    "model_airplane",
    "mouse",
    "multimeter",
    "notebook",
    "paint_can",
    "paint_palette",
    "pear",
    "pen_holder",
    "pepper_mill",
    "playing_cards",
    "power_drill",
    "saucer",
    "smartphone",
    "soda_can",
    "stapler",
    "storage_bin",
    "storage_case",
    "teacup",
    "teapot",
    "teddy_bear",
    "toaster",
    "tray",
    "wrench",
];

impl Split {
    pub const ALL: [Split; 3] = [Split::Training, Split::Validation, Split::Test];

    /// `[a-z]+`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Training => "training",
            Self::Validation => "validation",
            Self::Test => "test",
        }
    }

    /// The split whose images contain objects of that category.
    pub fn of_category(name: &str) -> Self {
        if TEST_CATEGORIES.contains(&name) {
            Self::Test
        } else if VALIDATION_CATEGORIES.contains(&name) {
            Self::Validation
        } else {
            Self::Training
        }
    }

    /// Categories of the split's images, in catalog order.
    pub fn categories(self) -> Vec<&'static Category> {
        categories().iter().filter(|category| Self::of_category(&category.name) == self).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn held_out_categories_exist_and_occur_in_one_list() {
        let known: BTreeSet<&str> = categories().iter().map(|category| category.name.as_str()).collect();
        let held_out: Vec<&str> = [VALIDATION_CATEGORIES, TEST_CATEGORIES].concat();
        let once: BTreeSet<&str> = held_out.iter().copied().collect();
        assert_eq!(once.len(), held_out.len(), "a category is held out twice");
        let unknown: Vec<&&str> = once.difference(&known).collect();
        assert!(unknown.is_empty(), "not in the catalog: {unknown:?}");
        let counts = Split::ALL.map(|split| split.categories().len());
        assert_eq!(counts.iter().sum::<usize>(), known.len());
        assert!(counts[0] > 70 && counts[1] > 15 && counts[2] > 35, "{counts:?}");
    }
}
