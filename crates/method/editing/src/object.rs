//! The objects of a finished scene, as references and the search for places see them.

use geometry::Rgb;
use glam::DVec3;
use scene::predicates::PosedFootprint;
use scene::{InstanceId, Supporter};

/// One object of the scene. Lists of these are in the order of `scene.json`, so that indices agree with its support
/// tree.
#[derive(Clone, Debug)]
pub struct EditableObject {
    pub name: InstanceId,
    /// Name of the object for users ("red coffee mug").
    pub label: String,
    pub category: String,
    /// Whether the category only stands in for what the label says.
    pub stand_in: bool,
    /// The color that covers most of its surface.
    pub color: Option<Rgb>,
    pub material: Option<String>,
    /// Extents in its own frame.
    pub size_m: DVec3,
    /// Vertical projection of the object in the world.
    pub footprint: PosedFootprint,
    pub supporter: Supporter,
}
