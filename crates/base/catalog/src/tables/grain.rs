//! Texture coordinates for boards cut from a log: the image's u axis (the grain) runs along a part.

use glam::{DVec2, DVec3};

use geometry::Solid;

/// Length and width of the wood that one repeat of a texture of a table shows: that of the longest boards, so that
/// tops show nearly no part of it twice.
pub const METERS_PER_REPEAT: DVec2 = DVec2::new(1.8, 1.2);

/// Repeats of end grain for one of long grain, along the width of a board: pores are seen end on, as short dots.
const END_GRAIN: f64 = 5.0;

/// Box-maps `solid` with u along `axis` (a unit axis direction) and v across it, one texture repeat each
/// [`METERS_PER_REPEAT`]; end grain gets the two remaining axes.
pub fn along(mut solid: Solid, axis: DVec3) -> Solid {
    // Adjacent parts must not show the same piece of the log.
    let first = solid.positions.first().copied().unwrap_or_default();
    let offset = DVec2::new(0.37 * first.x + 0.61 * first.z, 1.7 * first.y + 1.3 * first.x);
    for ((uv, p), n) in solid.uvs.iter_mut().zip(&solid.positions).zip(&solid.normals) {
        let a = n.abs();
        let (along_x, along_y) = (axis.x.abs() > 0.5, axis.y.abs() > 0.5);
        let mut stretch = 1.0;
        let flat = if a.z >= a.x && a.z >= a.y {
            if along_y { DVec2::new(p.y, p.x) } else { DVec2::new(p.x, p.y) }
        } else if a.x >= a.y {
            if along_x {
                stretch = END_GRAIN;
            }
            if along_y || along_x { DVec2::new(p.y, p.z) } else { DVec2::new(p.z, p.y) }
        } else if along_x || along_y {
            if along_y {
                stretch = END_GRAIN;
            }
            DVec2::new(p.x, p.z)
        } else {
            DVec2::new(p.z, p.x)
        };
        let repeats = (flat + offset) / METERS_PER_REPEAT;
        *uv = DVec2::new(stretch * repeats.x, repeats.y).as_vec2();
    }
    solid
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::shapes::block;

    #[test]
    fn grain_runs_along_the_axis_and_is_short_at_the_ends() {
        let board = along(block(DVec3::new(1.2, 0.1, 0.03)), DVec3::X);
        let span = |facing: DVec3, of: &dyn Fn(usize) -> f64| {
            let of_face =
                (0..board.positions.len()).filter(|k| board.normals[*k].as_dvec3().dot(facing) > 0.9).map(of);
            let (low, high) =
                of_face.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), c| (a.min(c), b.max(c)));
            high - low
        };
        let u = |k: usize| f64::from(board.uvs[k].x);
        let v = |k: usize| f64::from(board.uvs[k].y);
        assert!((span(DVec3::Z, &u) - 1.2 / METERS_PER_REPEAT.x).abs() < 1e-5);
        assert!((span(DVec3::Z, &v) - 0.1 / METERS_PER_REPEAT.y).abs() < 1e-5);
        assert!((span(DVec3::X, &u) - END_GRAIN * 0.1 / METERS_PER_REPEAT.x).abs() < 1e-5);
        assert!((span(DVec3::X, &v) - 0.03 / METERS_PER_REPEAT.y).abs() < 1e-5);
    }
}
