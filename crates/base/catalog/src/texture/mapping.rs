//! Texture coordinates for solids with one image: projected from above, from the front or from the side, or wrapped
//! around a body of revolution.

use geometry::{Solid, Vec2};

/// One image over the solid's box seen from above: u along +x, v along +y.
pub fn mapped_from_above(solid: Solid) -> Solid {
    mapped(solid, |p| (p[0], p[1]))
}

/// One image over the solid's box seen from the front (-y): u along +x, v along +z.
pub fn mapped_from_front(solid: Solid) -> Solid {
    mapped(solid, |p| (p[0], p[2]))
}

/// One image over the solid's box seen from the right (+x): u along +y, v along +z.
pub fn mapped_from_side(solid: Solid) -> Solid {
    mapped(solid, |p| (p[1], p[2]))
}

/// For solids of revolution about +z (their own u already runs once around from +x): v becomes the height
/// between the solid's lowest and highest point, and the image's center (u = 0.5) faces -y.
pub fn wrapped_around(mut solid: Solid) -> Solid {
    let (low, high) = span(solid.positions.iter().map(|p| p.z));
    for (uv, p) in solid.uvs.iter_mut().zip(&solid.positions) {
        *uv = Vec2::new(uv.x - 0.25, ((p.z - low) / (high - low).max(1e-9)) as f32);
    }
    solid
}

/// One upright image on each face of a boxlike solid (by each vertex's dominant normal), stretched over
/// the solid's box; never mirrored.
pub fn mapped_on_box(mut solid: Solid) -> Solid {
    let spans = [0, 1, 2].map(|axis| span(solid.positions.iter().map(|p| p.to_array()[axis])));
    for ((uv, p), n) in solid.uvs.iter_mut().zip(&solid.positions).zip(&solid.normals) {
        let fraction = [0, 1, 2].map(|axis| {
            let (low, high) = spans[axis];
            ((p.to_array()[axis] - low) / (high - low).max(1e-9)) as f32
        });
        let [x, y, z] = fraction;
        let a = n.abs();
        *uv = if a.z >= a.x && a.z >= a.y {
            Vec2::new(x, y)
        } else if a.x >= a.y {
            Vec2::new(if n.x > 0.0 { y } else { 1.0 - y }, z)
        } else {
            Vec2::new(if n.y < 0.0 { x } else { 1.0 - x }, z)
        };
    }
    solid
}

fn mapped(mut solid: Solid, plane: impl Fn([f64; 3]) -> (f64, f64)) -> Solid {
    let (u_low, u_high) = span(solid.positions.iter().map(|p| plane(p.to_array()).0));
    let (v_low, v_high) = span(solid.positions.iter().map(|p| plane(p.to_array()).1));
    for (uv, p) in solid.uvs.iter_mut().zip(&solid.positions) {
        let (a, b) = plane(p.to_array());
        *uv = Vec2::new(
            ((a - u_low) / (u_high - u_low).max(1e-9)) as f32,
            ((b - v_low) / (v_high - v_low).max(1e-9)) as f32,
        );
    }
    solid
}

fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::shapes::cylinder;

    #[test]
    fn wrapped_around_puts_the_image_center_in_front() {
        let can = wrapped_around(cylinder(0.03, 0.1, 0.0, 32));
        let front = can
            .positions
            .iter()
            .zip(&can.normals)
            .zip(&can.uvs)
            .find(|((p, n), _)| p.y < -0.0299 && n.y < -0.9 && p.z > 0.09)
            .expect("the can has a front vertex");
        assert!((front.1.x - 0.5).abs() < 1e-3 && (front.1.y - 1.0).abs() < 1e-6, "{:?}", front.1);
    }
}
