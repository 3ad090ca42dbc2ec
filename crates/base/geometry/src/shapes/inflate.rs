//! Inflation of an outline: a closed body with this silhouette whose thickness follows its width.
//!
//! As in Teddy (Igarashi, Matsuoka and Tanaka 1999), wide parts become thick and narrow parts thin, but without a
//! spine. Half the thickness is the square root of the solution f of Poisson's equation, laplacian f = -2, with f = 0
//! on the outline. The cross section of a long strip is a circle, and bodies blend smoothly into limbs. f is solved
//! on a grid whose boundary squares the outline cuts (Shortley and Weller 1938; marching squares). Two sheets of the
//! same triangles, one on either side of the outline's plane, share their rim. A lying body is flattened below until
//! its foot supports its center of mass. A standing body is cut off slightly above its lowest point and is as thick
//! there as if it continued below.
//!
//! Limitations: the outline has no holes, and parts connected by less than a square are dropped. Cost: about a
//! millisecond at 700 squares, a tenth of that at 150.

mod grid;

use glam::{DVec2, DVec3, Vec2};

use self::grid::Grid;
use crate::Solid;
use crate::polygon::convex_hull_2d;
use crate::posed_primitive::Posture;

/// Height at which a standing body is cut off, share of its height.
const CUT_OFF: f64 = 0.03;
/// Shares of half the thickness that are tried for the flattening of a lying body.
const FLATTENED: [f64; 7] = [0.08, 0.15, 0.25, 0.4, 0.55, 0.7, 0.85];
/// Smallest distance of a lying body's center of mass from the edge of its foot, in half thicknesses.
const WITHIN_FOOT: f64 = 0.2;
/// Minimum half depth of the foot of a standing body, and the height up to which it applies, shares of the height.
const FOOT_HALF_DEPTH: f64 = 0.07;
const FOOT_HEIGHT: f64 = 0.05;

/// An outline with its thickness function.
#[derive(Clone, Debug)]
pub struct Inflation {
    posture: Posture,
    /// Vertices of either sheet in the outline's plane, and half the thickness there; 0 on the rim.
    places: Vec<DVec2>,
    half: Vec<f64>,
    /// Triangles of the sheet from whose side the outline is counter-clockwise.
    triangles: Vec<[u32; 3]>,
    /// Edges of the sheets along which a standing body was cut off, left to right.
    foot: Vec<[u32; 2]>,
}

impl Inflation {
    /// Inflates a simple outline (any orientation), in the xy plane if lying and in the xz plane if standing, on a
    /// grid of about `squares` squares inside it. `None` if the outline encloses nothing.
    pub fn new(outline: &[DVec2], posture: Posture, squares: u32) -> Option<Self> {
        let grid = match posture {
            Posture::Lying => Grid::new(outline, None, squares)?,
            Posture::Standing => {
                let heights = outline.iter().map(|p| p.y);
                let (low, high) = heights
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
                let cut = low + CUT_OFF * (high - low);
                Grid::new(&above(outline, cut), Some(cut), squares)?
            }
        };
        let grid::Sheet { places, half, triangles, foot } = grid.sheet();
        let highest = half.iter().copied().fold(0.0, f64::max);
        (highest > 0.0 && triangles.len() > 2).then_some(Self { posture, places, half, triangles, foot })
    }

    /// Maximum thickness if the body is everywhere as thick as it is wide.
    pub fn natural_thickness(&self) -> f64 {
        2.0 * self.fattest()
    }

    fn fattest(&self) -> f64 {
        self.half.iter().copied().fold(0.0, f64::max)
    }

    /// The closed shell with maximum thickness `thickness`: positions as in the outline's plane, the lowest at z = 0,
    /// and outward triangles.
    pub fn shell(&self, thickness: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let count = self.places.len() as u32;
        let (front, back): (Vec<DVec3>, Vec<DVec3>) = match self.posture {
            Posture::Lying => {
                let flattened = self.flattened();
                let scale = thickness / ((2.0 - flattened) * self.fattest());
                let floor = (1.0 - flattened) * self.fattest();
                let sheet = |upper: bool| {
                    let z = move |half: f64| if upper { half } else { -half.min(floor) };
                    self.places
                        .iter()
                        .zip(&self.half)
                        .map(move |(p, half)| p.extend(scale * (z(*half) + floor)))
                };
                (sheet(true).collect(), sheet(false).collect())
            }
            Posture::Standing => {
                let low = self.places.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
                let high = self.places.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
                let foot = (FOOT_HALF_DEPTH * (high - low)).min(0.5 * thickness);
                let scale = 0.5 * thickness / self.fattest();
                let sheet = |side: f64| {
                    self.places.iter().zip(&self.half).map(move |(p, half)| {
                        let at_foot = p.y - low <= FOOT_HEIGHT * (high - low) && *half > 0.0;
                        let half = if at_foot { (scale * half).max(foot) } else { scale * half };
                        DVec3::new(p.x, side * half, p.y - low)
                    })
                };
                (sheet(-1.0).collect(), sheet(1.0).collect())
            }
        };
        let positions = front.into_iter().chain(back).collect();
        let mut triangles = self.triangles.clone();
        triangles.extend(self.triangles.iter().map(|[a, b, c]| [a + count, c + count, b + count]));
        for [a, b] in &self.foot {
            triangles.extend([[*a, a + count, b + count], [*a, b + count, *b]]);
        }
        (positions, triangles)
    }

    /// The body with these extents, the center of its box above the origin and its base on z = 0.
    pub fn solid(&self, size_m: DVec3) -> Solid {
        let thickness = match self.posture {
            Posture::Lying => size_m.z,
            Posture::Standing => size_m.y,
        };
        let (positions, triangles) = self.shell(thickness);
        let (low, high) = positions
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let scale = size_m / (high - low).max(DVec3::splat(1e-12));
        let base = (0.5 * (low + high)).truncate().extend(low.z);
        let placed: Vec<DVec3> = positions.iter().map(|p| scale * (*p - base)).collect();
        let uvs: Vec<Vec2> =
            positions.iter().map(|p| ((*p - low) / (high - low)).truncate().as_vec2()).collect();
        Solid::from_corners(&placed, &uvs, &triangles)
    }

    /// The share of half the thickness to cut off so that the center of mass of a lying body is above its foot.
    fn flattened(&self) -> f64 {
        let fattest = self.fattest();
        let mut weight = 0.0;
        let mut moment = DVec2::ZERO;
        for t in &self.triangles {
            let [a, b, c] = t.map(|v| self.places[v as usize]);
            let thick = t.iter().map(|v| self.half[*v as usize]).sum::<f64>();
            let mass = thick * (b - a).perp_dot(c - a);
            weight += mass;
            moment += mass * (a + b + c) / 3.0;
        }
        let center = moment / weight.max(1e-300);
        let stands_on = |cut: f64| {
            let touching =
                self.places.iter().zip(&self.half).filter(|(_, half)| **half >= (1.0 - cut) * fattest);
            let hull = convex_hull_2d(&touching.map(|(p, _)| *p).collect::<Vec<_>>());
            let depth = (0..hull.len()).map(|k| {
                let (a, b) = (hull[k], hull[(k + 1) % hull.len()]);
                (b - a).normalize_or_zero().perp_dot(center - a)
            });
            hull.len() > 2 && depth.fold(f64::INFINITY, f64::min) >= WITHIN_FOOT * fattest
        };
        let [.., highest] = FLATTENED;
        FLATTENED.into_iter().find(|cut| stands_on(*cut)).unwrap_or(highest)
    }
}

/// The part of a simple polygon above a height (Sutherland and Hodgman). If it has several components, they are
/// connected by edges along the cut.
fn above(polygon: &[DVec2], low: f64) -> Vec<DVec2> {
    let mut left = Vec::with_capacity(polygon.len() + 4);
    for (k, &here) in polygon.iter().enumerate() {
        let before = polygon[(k + polygon.len() - 1) % polygon.len()];
        if (before.y < low) != (here.y < low) {
            let x = before.x + (here.x - before.x) * (low - before.y) / (here.y - before.y);
            left.push(DVec2::new(x, low));
        }
        if here.y >= low {
            left.push(here);
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{circle, ellipse};

    fn extents(solid: &Solid) -> DVec3 {
        let (low, high) = solid
            .positions
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        assert!(low.z.abs() < 1e-12 && (low + high).truncate().length() < 1e-9, "{low} {high}");
        high - low
    }

    /// A figure with a head, two arms and two legs, as wide as high; legs end at z = 0.
    fn figure() -> Vec<DVec2> {
        let half = [
            (0.02, 0.0),
            (0.12, 0.0),
            (0.13, 0.2),
            (0.15, 0.35),
            (0.3, 0.33),
            (0.33, 0.4),
            (0.15, 0.47),
            (0.09, 0.5),
            (0.13, 0.6),
            (0.1, 0.7),
            (0.0, 0.73),
        ];
        let right = half.map(|(x, z)| DVec2::new(x, z));
        let left = half.iter().rev().skip(1).map(|(x, z)| DVec2::new(-x, *z));
        let mut outline: Vec<DVec2> = right.into_iter().chain(left).collect();
        outline.push(DVec2::new(0.0, 0.12));
        outline
    }

    #[test]
    fn inflation_of_a_strip_is_a_cylinder_and_of_a_disc_a_lens() {
        let strip = [(-1.0, -0.05), (1.0, -0.05), (1.0, 0.05), (-1.0, 0.05)].map(|(x, y)| DVec2::new(x, y));
        let strip = Inflation::new(&strip, Posture::Lying, 700).expect("encloses");
        assert!((strip.natural_thickness() / 0.1 - 1.0).abs() < 0.04, "{}", strip.natural_thickness());
        let disc = Inflation::new(&circle(0.1, 64), Posture::Lying, 700).expect("encloses");
        assert!(
            (disc.natural_thickness() / 0.2 - 0.5_f64.sqrt()).abs() < 0.03,
            "{}",
            disc.natural_thickness()
        );
    }

    #[test]
    fn inflated_bodies_are_closed_and_rest_on_a_level_foot() {
        let size = DVec3::new(0.66, 0.22, 0.7);
        let standing = Inflation::new(&figure(), Posture::Standing, 700).expect("encloses").solid(size);
        let lying_size = DVec3::new(0.3, 0.06, 0.05);
        let lying =
            Inflation::new(&ellipse(0.3, 0.06, 40), Posture::Lying, 700).expect("encloses").solid(lying_size);
        for (solid, size) in [(&standing, size), (&lying, lying_size)] {
            assert!(solid.is_watertight() && solid.volume_m3() > 0.0);
            assert!((extents(solid) / size - 1.0).abs().max_element() < 1e-9);
            assert!((200..4000).contains(&solid.triangles.len()), "{}", solid.triangles.len());
            let level: f64 = solid
                .triangles
                .iter()
                .map(|t| t.map(|v| solid.positions[v as usize]))
                .filter(|corners| corners.iter().all(|p| p.z.abs() < 1e-9))
                .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).z)
                .sum();
            assert!(level < -0.02 * size.x * size.y, "a foot of {level}");
        }
        let widths = |low: f64, high: f64| {
            let band = standing.positions.iter().filter(|p| (low..high).contains(&p.z));
            band.map(|p| p.y).fold(0.0, f64::max)
        };
        assert!(widths(0.2, 0.3) > 1.1 * widths(0.46, 0.5), "the belly is fatter than the neck");
    }

    #[test]
    fn inflated_taper_rests_on_more_than_its_thick_end() {
        let carrot =
            [(-0.1, -0.02), (0.1, -0.004), (0.1, 0.004), (-0.1, 0.02)].map(|(x, y)| DVec2::new(x, y));
        let solid = Inflation::new(&carrot, Posture::Lying, 700)
            .expect("encloses")
            .solid(DVec3::new(0.2, 0.04, 0.04));
        let mass: f64 = solid.volume_m3();
        let moment: f64 = solid
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| solid.positions[v as usize]);
                a.dot(b.cross(c)) / 6.0 * (a.x + b.x + c.x) / 4.0
            })
            .sum();
        let feet = solid.positions.iter().filter(|p| p.z.abs() < 1e-9).map(|p| p.x);
        let reach = feet.fold(f64::NEG_INFINITY, f64::max);
        assert!(reach > moment / mass, "foot to {reach}, center of mass at {}", moment / mass);
    }

    #[test]
    fn inflate_rejects_empty_outline() {
        assert!(Inflation::new(&[], Posture::Lying, 100).is_none());
        assert!(Inflation::new(&[DVec2::ZERO; 5], Posture::Standing, 100).is_none());
        let line = [DVec2::ZERO, DVec2::X, DVec2::ZERO];
        assert!(Inflation::new(&line, Posture::Lying, 100).is_none());
    }
}
