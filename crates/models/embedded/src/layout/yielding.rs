//! The order in which demands yield when a layout cannot meet all of them.

/// Demands that a layout may leave unmet; each variant includes the earlier ones. Supports never yield.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Yielding {
    #[default]
    Nothing,
    /// Habits of the theme: co-occurrence priors and place settings.
    Habits,
    /// Closeness: next to and around, without a stated distance.
    Closeness,
    /// Named places of the table.
    Places,
    /// Stated distances, positions, yaws, and the gaps of arrangements.
    Distances,
    /// All relations, and the shapes of arrangements.
    Relations,
}

impl Yielding {
    /// In the order in which they are tried.
    pub const ALL: [Self; 6] =
        [Self::Nothing, Self::Habits, Self::Closeness, Self::Places, Self::Distances, Self::Relations];

    /// Attempts with this much yielding, of `attempts` in the settings.
    pub fn attempts(self, attempts: u32) -> u32 {
        if self == Self::Nothing { attempts } else { (attempts / 3).max(1) }
    }

    /// Name of the random stream of an attempt.
    pub fn stream(self, number: u32) -> String {
        if self == Self::Nothing { format!("layout {number}") } else { format!("layout {self:?} {number}") }
    }
}
