//! Texture coordinates for boards cut from a log: the image's u axis (the grain) runs along a part.

use glam::{DVec2, DVec3};

use geometry::Solid;

/// Length of wood that one repeat of a grain texture shows.
pub const METERS_PER_REPEAT: f64 = 0.6;

/// Box-maps `solid` with u along `axis` (a unit axis direction) and v across it, one texture repeat each
/// [`METERS_PER_REPEAT`]; end grain gets the two remaining axes.
pub fn along(solid: Solid, axis: DVec3) -> Solid {
    along_repeating(solid, axis, METERS_PER_REPEAT)
}

/// As [`along`] with another repeat length, for objects smaller than furniture.
pub fn along_repeating(mut solid: Solid, axis: DVec3, meters_per_repeat: f64) -> Solid {
    // Adjacent parts must not show the same piece of the log.
    let first = solid.positions.first().copied().unwrap_or_default();
    let offset = DVec2::new(0.37 * first.x + 0.61 * first.z, 1.7 * first.y + 1.3 * first.x);
    for ((uv, p), n) in solid.uvs.iter_mut().zip(&solid.positions).zip(&solid.normals) {
        let a = n.abs();
        let (along_x, along_y) = (axis.x.abs() > 0.5, axis.y.abs() > 0.5);
        let flat = if a.z >= a.x && a.z >= a.y {
            if along_y { DVec2::new(p.y, p.x) } else { DVec2::new(p.x, p.y) }
        } else if a.x >= a.y {
            if along_y || along_x { DVec2::new(p.y, p.z) } else { DVec2::new(p.z, p.y) }
        } else if along_x || along_y {
            DVec2::new(p.x, p.z)
        } else {
            DVec2::new(p.z, p.x)
        };
        *uv = ((flat + offset) / meters_per_repeat).as_vec2();
    }
    solid
}
