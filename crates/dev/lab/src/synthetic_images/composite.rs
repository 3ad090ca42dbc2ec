//! Objects composed of random primitives. They make a network learn objects on a table top instead of the 136
//! catalog categories.

mod materials;
mod containers;
mod flat_shapes;
mod upright_shapes;

use glam::DVec3;

use super::Split;
use super::sampling::{of_split, uniform};
use geometry::{Material, Rgb, Solid, TexturedMesh};
use runtime::seed::Rng;

/// Kinds of composites. Each belongs to one split.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Surfaces of revolution, closed or hollow: vases, bottles, pots.
    Turned,
    /// A box with smaller blocks, buttons and prints on it.
    Boxy,
    /// Rounded lumps.
    Lumps,
    /// Paper, cards, mats, maps, open booklets.
    Sheet,
    /// A bar with a head, lying.
    Tool,
    /// Bent wire and rings.
    Wire,
    /// Primitives that touch and intersect each other.
    Jumble,
    /// A stack of slabs and cones, each smaller than the one below.
    Stepped,
    /// A foot, a stem, a shade.
    Lamp,
    /// A body with head and limbs.
    Figure,
    /// An open frame of bars.
    Rack,
}

pub(super) const KINDS: &[(Kind, Split, f64)] = &[
    (Kind::Turned, Split::Training, 1.5),
    (Kind::Boxy, Split::Training, 2.5),
    (Kind::Lumps, Split::Training, 1.0),
    (Kind::Sheet, Split::Training, 1.5),
    (Kind::Tool, Split::Training, 1.5),
    (Kind::Wire, Split::Training, 0.8),
    (Kind::Jumble, Split::Training, 1.2),
    (Kind::Stepped, Split::Validation, 1.0),
    (Kind::Lamp, Split::Test, 1.0),
    (Kind::Figure, Split::Test, 1.0),
    (Kind::Rack, Split::Test, 0.7),
];

#[cfg(test)]
impl Kind {
    /// The split whose images use it.
    pub fn split(self) -> Split {
        KINDS.iter().find(|(kind, _, _)| *kind == self).expect("every kind is in the list").1
    }
}

impl Kind {
    /// `composite_[a-z]+`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Turned => "composite_turned",
            Self::Boxy => "composite_boxy",
            Self::Lumps => "composite_lumps",
            Self::Sheet => "composite_sheet",
            Self::Tool => "composite_tool",
            Self::Wire => "composite_wire",
            Self::Jumble => "composite_jumble",
            Self::Stepped => "composite_stepped",
            Self::Lamp => "composite_lamp",
            Self::Figure => "composite_figure",
            Self::Rack => "composite_rack",
        }
    }

    /// Samples a kind of the split.
    pub(super) fn draw(split: Split, rng: &mut Rng) -> Self {
        of_split(rng, split, KINDS)
    }

    /// Whether other objects may be placed on it.
    pub(super) fn carries(self) -> bool {
        matches!(self, Self::Boxy | Self::Sheet | Self::Stepped)
    }
}

/// A mesh of that kind in the canonical frame, meters. Its color stays near `tone` if given.
pub(super) fn build(kind: Kind, tone: Option<Rgb>, rng: &mut Rng) -> TexturedMesh {
    let mut made = CompositeBuilder { mesh: TexturedMesh::default(), tone, rng };
    match kind {
        Kind::Turned => made.turned(),
        Kind::Boxy => made.boxy(),
        Kind::Lumps => made.lumps(),
        Kind::Sheet => made.sheet(),
        Kind::Tool => made.tool(),
        Kind::Wire => made.wire(),
        Kind::Jumble => made.jumble(),
        Kind::Stepped => made.stepped(),
        Kind::Lamp => made.lamp(),
        Kind::Figure => made.figure(),
        Kind::Rack => made.rack(),
    }
    made.mesh.seated()
}

struct CompositeBuilder<'a> {
    mesh: TexturedMesh,
    tone: Option<Rgb>,
    rng: &'a mut Rng,
}

impl CompositeBuilder<'_> {
    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        uniform(self.rng, low, high)
    }

    fn add(&mut self, solid: Solid, at: DVec3, material: &Material) {
        self.mesh.add(solid.translated(at), material);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::seed::child_rng;

    #[test]
    fn every_kind_builds_objects_that_fit_on_a_table() {
        for (kind, _, _) in KINDS {
            for seed in 0..25 {
                let mesh = build(*kind, None, &mut child_rng(seed, kind.name()));
                let size = mesh.size_m();
                let context = format!("{kind:?} {seed} {size}");
                assert!(size.max_element() < 0.7 && size.truncate().min_element() > 0.001, "{context}");
                assert!(mesh.bounds().0.z.abs() < 1e-9, "{context}");
                assert!(mesh.positions.iter().all(|p| p.is_finite()), "{context}");
                assert!((12..8000).contains(&mesh.triangle_count()), "{context} {}", mesh.triangle_count());
            }
        }
    }
}
