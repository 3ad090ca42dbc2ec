//! The union of convex hulls: lines through it, and points drawn on its surface.

use geometry::contact_hull::ContactHull;
use geometry::{ConvexHull, DVec3};
use rand::{Rng, RngExt};

/// Points deeper inside another hull than this are not on the surface, meters.
const INSIDE_M: f64 = 2e-4;
/// Parts of a line with a gap below this are one: hulls of one wall rarely meet exactly. Meters.
const SEAM_M: f64 = 4e-4;

/// Hulls of one object, in its frame.
#[derive(Clone, Debug)]
pub struct HullSolid {
    hulls: Vec<ContactHull>,
    /// Triangles with their outward normals, and the sums of their areas.
    triangles: Vec<([DVec3; 3], DVec3)>,
    areas: Vec<f64>,
}

/// A part of a line that is inside the solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    pub from_m: f64,
    pub to_m: f64,
    /// The outward normals where the line enters and leaves.
    pub enters: DVec3,
    pub leaves: DVec3,
}

impl HullSolid {
    pub fn new(hulls: &[ConvexHull]) -> Self {
        let triangles: Vec<([DVec3; 3], DVec3)> = hulls
            .iter()
            .flat_map(|hull| hull.triangles.iter().map(|t| t.map(|corner| hull.points[corner as usize])))
            .filter_map(|[a, b, c]| Some(([a, b, c], (b - a).cross(c - a).try_normalize()?)))
            .collect();
        let mut sum = 0.0;
        let areas = triangles.iter().map(|([a, b, c], _)| {
            sum += 0.5 * (b - a).cross(c - a).length();
            sum
        });
        Self { areas: areas.collect(), hulls: hulls.iter().map(ContactHull::new).collect(), triangles }
    }

    pub fn hulls(&self) -> &[ContactHull] {
        &self.hulls
    }

    /// The lowest and highest corner of the box around it.
    pub fn bounds_m(&self) -> (DVec3, DVec3) {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.hulls.iter().fold(start, |(low, high), hull| (low.min(hull.low), high.max(hull.high)))
    }

    /// A point of the surface with its outward normal; `None` for a point where two hulls overlap.
    pub fn draw(&self, rng: &mut impl Rng) -> Option<(DVec3, DVec3)> {
        let at = rng.random_range(0.0..*self.areas.last()?);
        let index = self.areas.partition_point(|sum| *sum <= at).min(self.triangles.len() - 1);
        let (mut u, mut v): (f64, f64) = (rng.random_range(0.0..1.0), rng.random_range(0.0..1.0));
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let ([a, b, c], normal) = self.triangles[index];
        let point = a + u * (b - a) + v * (c - a);
        let covered = |hull: &ContactHull| {
            hull.planes.iter().all(|plane| plane.normal.dot(point) < plane.offset_m - INSIDE_M)
        };
        (!self.hulls.iter().any(covered)).then_some((point, normal))
    }

    /// The parts of a line that are inside, in order along it; `direction` is a unit vector.
    pub fn spans(&self, origin: DVec3, direction: DVec3) -> Vec<Span> {
        let mut spans: Vec<Span> =
            self.hulls.iter().filter_map(|hull| span(hull, origin, direction)).collect();
        spans.sort_by(|a, b| a.from_m.total_cmp(&b.from_m));
        let mut joined: Vec<Span> = Vec::with_capacity(spans.len());
        for span in spans {
            match joined.last_mut() {
                Some(last) if span.from_m <= last.to_m + SEAM_M => {
                    if span.to_m > last.to_m {
                        (last.to_m, last.leaves) = (span.to_m, span.leaves);
                    }
                }
                _ => joined.push(span),
            }
        }
        joined
    }
}

/// The part of a line inside a hull.
fn span(hull: &ContactHull, origin: DVec3, direction: DVec3) -> Option<Span> {
    let center = 0.5 * (hull.low + hull.high) - origin;
    let aside = center - center.dot(direction) * direction;
    if aside.length() > 0.5 * (hull.high - hull.low).length() {
        return None;
    }
    let mut span =
        Span { from_m: f64::NEG_INFINITY, to_m: f64::INFINITY, enters: -direction, leaves: direction };
    for plane in &hull.planes {
        let (height, slope) = (plane.normal.dot(origin) - plane.offset_m, plane.normal.dot(direction));
        if slope.abs() < 1e-12 {
            if height > 0.0 {
                return None;
            }
            continue;
        }
        let at = -height / slope;
        if slope < 0.0 && at > span.from_m {
            (span.from_m, span.enters) = (at, plane.normal);
        }
        if slope > 0.0 && at < span.to_m {
            (span.to_m, span.leaves) = (at, plane.normal);
        }
    }
    (span.from_m < span.to_m).then_some(span)
}
