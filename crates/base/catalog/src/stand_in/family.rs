//! Shape families of stand-ins.

use serde::Deserialize;

/// The plain shape that stands in for an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// A block with rounded edges: devices, packages, books.
    Box,
    /// An upright cylinder: cans, spools, drums.
    Cylinder,
    /// A body of revolution with a neck and a cap.
    Bottle,
    /// An open hollow body of revolution: bowls, pots, cups, hats.
    Bowl,
    /// An ellipsoid with a small flat base: fruit, buns, balls, stones.
    Produce,
    /// A flat body, round if it is as wide as deep: coins, cards, boards.
    Plate,
    /// A long body that lies: tools, utensils, sticks.
    Rod,
    /// A soft rounded body: folded clothes, cushions, bags.
    Pillow,
    /// A body with a head on a base: toy animals, statues.
    Figure,
    /// A pot with foliage.
    Plant,
    /// A torus: rings, bracelets, coils.
    Ring,
}

impl Family {
    /// Every family.
    pub const ALL: [Self; 11] = [
        Self::Box,
        Self::Cylinder,
        Self::Bottle,
        Self::Bowl,
        Self::Produce,
        Self::Plate,
        Self::Rod,
        Self::Pillow,
        Self::Figure,
        Self::Plant,
        Self::Ring,
    ];

    /// Name of the family in the configuration ("box").
    pub fn name(self) -> &'static str {
        self.category_name().trim_start_matches("stand_in_")
    }

    /// The hidden category that builds it ("stand_in_box").
    pub fn category_name(self) -> &'static str {
        match self {
            Self::Box => "stand_in_box",
            Self::Cylinder => "stand_in_cylinder",
            Self::Bottle => "stand_in_bottle",
            Self::Bowl => "stand_in_bowl",
            Self::Produce => "stand_in_produce",
            Self::Plate => "stand_in_plate",
            Self::Rod => "stand_in_rod",
            Self::Pillow => "stand_in_pillow",
            Self::Figure => "stand_in_figure",
            Self::Plant => "stand_in_plant",
            Self::Ring => "stand_in_ring",
        }
    }
}
