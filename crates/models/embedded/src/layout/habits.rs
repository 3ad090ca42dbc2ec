//! Habits of people who use a table, from `config/catalog/co_occurrence.toml`: objects that are used together, and
//! usual positions of one beside another.

use std::sync::LazyLock;

use serde::Deserialize;

use super::spatial_constraints::{BEHIND, FRONT, LEFT, RIGHT, RelativePosition};
use catalog::Category;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Habits {
    /// Functional groups of categories by what they are used for. A group can have several uses.
    uses: Vec<Vec<String>>,
    prior: Vec<Prior>,
}

/// Usual position of objects relative to the first target that is present.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Prior {
    /// Names as [`names`] reads them.
    pub objects: Vec<String>,
    pub position: Position,
    /// Targets, the preferred one first; names as [`names`] reads them.
    pub of: Vec<String>,
    #[serde(default)]
    pub frame: Frame,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Position {
    Left,
    Right,
    Front,
    Behind,
    UpperLeft,
    UpperRight,
    Beside,
}

/// Frame of a direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Frame {
    /// The frame of the viewer at the front edge.
    #[default]
    Table,
    /// The frame of the target: a place setting on the far side is turned.
    Target,
}

static HABITS: LazyLock<Habits> = LazyLock::new(|| {
    toml::from_str(include_str!("../../../../../config/catalog/co_occurrence.toml"))
        .expect("the built-in habits parse (a test loads them)")
});

/// Usual positions in the order of the file.
pub(super) static PRIORS: LazyLock<&[Prior]> = LazyLock::new(|| &HABITS.prior);

impl Position {
    pub fn relative(self) -> RelativePosition {
        match self {
            Self::Left => LEFT,
            Self::Right => RIGHT,
            Self::Front => FRONT,
            Self::Behind => BEHIND,
            // Where glasses and bowls stand at a plate.
            Self::UpperRight => RelativePosition::Toward(0.9),
            Self::UpperLeft => RelativePosition::Toward(2.25),
            Self::Beside => RelativePosition::Beside,
        }
    }
}

/// Whether a name of the file is that of the category, or with "@" that of its functional group.
pub(super) fn names(name: &str, category: &Category) -> bool {
    name.strip_prefix('@').map_or(category.name == name, |group| category.group == group)
}

/// Whether both are of a kind, or have a use in common.
pub(super) fn share_a_use(a: &Category, b: &Category) -> bool {
    let has = |uses: &Vec<String>| uses.contains(&a.group) && uses.contains(&b.group);
    a.name == b.name || HABITS.uses.iter().any(has)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use catalog::{categories, category};

    #[test]
    fn groups_of_the_catalog_share_uses() {
        let share = |a: &str, b: &str| {
            let [a, b] = [a, b].map(|name| category(name).expect(name));
            share_a_use(a, b)
        };
        assert!(share("plate", "fork") && share("hammer", "bolt") && share("keyboard", "monitor"));
        assert!(share("apple", "banana") && share("notebook", "pen"));
        assert!(!share("hammer", "fork") && !share("mug", "keyboard"));
        let known: BTreeSet<&str> = categories().iter().map(|category| category.group.as_str()).collect();
        let unknown: Vec<_> = HABITS.uses.iter().flatten().filter(|g| !known.contains(g.as_str())).collect();
        assert!(unknown.is_empty(), "{unknown:?}");
    }

    #[test]
    fn priors_name_categories_and_groups_of_the_catalog() {
        let is_known = |name: &&String| categories().iter().any(|category| names(name, category));
        let named = PRIORS.iter().flat_map(|prior| prior.objects.iter().chain(&prior.of));
        let unknown: Vec<&String> = named.filter(|name| !is_known(name)).collect();
        assert!(unknown.is_empty() && PRIORS.len() > 50, "{unknown:?} of {}", PRIORS.len());
    }
}
