//! Overview of a scene from an image, on one sheet: the image, the pixels of each object, the table from above, and the
//! finished scene from the image's camera.

use imaging::Image;
use render::annotate::sheet;

/// Side of a cell, pixels.
const CELL_PX: u32 = 640;

pub(super) struct Panels<'a> {
    pub image: &'a Image,
    pub masks: &'a Image,
    pub top_view: &'a Image,
    pub scene: &'a Image,
    pub agreement: &'a Image,
    /// The finished scene from above.
    pub above: &'a Image,
}

pub(super) fn drawn(panels: &Panels<'_>) -> Image {
    let cells = [
        (panels.image, "the image"),
        (panels.masks, "what was found in it"),
        (panels.top_view, "the image, rectified from above"),
        (panels.scene, "the finished scene from the same camera"),
        (panels.agreement, "both (green), missed (red), invented (blue)"),
        (panels.above, "the finished scene from above"),
    ];
    sheet(&cells, 3, CELL_PX)
}
