//! Plan of the scene as SVG: the table's outline and the numbered footprint of every object.

use glam::{DVec2, DVec3};
use markup::html::Html;

use crate::Body;
use geometry::polygon::convex_hull_2d;
use scene::Table;

/// Width of the drawing's coordinate system.
const WIDTH: f64 = 1000.0;
/// Margin around the drawing, in the same units.
const BORDER: f64 = 12.0;

/// Draws the plan. Objects are numbered from 1 in the order of the scene; those of `at_fault` are highlighted.
pub fn draw(page: &mut Html, table: &Table, objects: &[Body], at_fault: &[bool]) {
    let footprints: Vec<Vec<DVec2>> = objects.iter().map(footprint).collect();
    let (mut low, mut high) = table.outline_m.bounds();
    for corner in footprints.iter().flatten().filter(|corner| corner.is_finite()) {
        (low, high) = (low.min(*corner), high.max(*corner));
    }
    let scale = (WIDTH - 2.0 * BORDER) / (high.x - low.x).max(1e-3);
    let height = scale * (high.y - low.y) + 2.0 * BORDER;
    // The front edge is at the bottom of the drawing.
    let at = |p: DVec2| (BORDER + scale * (p.x - low.x), BORDER + scale * (high.y - p.y));
    let polygon = |corners: &[DVec2]| {
        let words: Vec<String> =
            corners.iter().map(|&p| at(p)).map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        words.join(" ")
    };
    let view_box = format!("0 0 {WIDTH:.0} {height:.0}");
    let label = "The scene from above: the table and the numbered footprints of its objects";
    page.open(
        "svg",
        &[
            ("id", &table.name),
            ("class", "plan"),
            ("viewBox", &view_box),
            ("role", "img"),
            ("aria-label", label),
        ],
    );
    page.void("polygon", &[("class", "table"), ("points", &polygon(table.outline_m.corners()))]);
    for (footprint, bad) in footprints.iter().zip(at_fault) {
        let class = if *bad { "thing bad" } else { "thing" };
        page.void("polygon", &[("class", class), ("points", &polygon(footprint))]);
    }
    for (number, footprint) in (1..).zip(&footprints) {
        let center = footprint.iter().sum::<DVec2>() / footprint.len().max(1) as f64;
        let (x, y) = at(center);
        let attributes = [("x", format!("{x:.1}")), ("y", format!("{y:.1}"))];
        let attributes: Vec<(&str, &str)> = attributes.iter().map(|(name, v)| (*name, v.as_str())).collect();
        page.leaf("text", &attributes, &format!("{number}"));
    }
    page.close();
}

/// Outline of a body's hulls seen from above.
fn footprint(body: &Body) -> Vec<DVec2> {
    let corners = body.hulls.iter().flat_map(|hull| &hull.points);
    let projected: Vec<DVec2> =
        corners.map(|p: &DVec3| body.world_from_object.transform_point(*p).truncate()).collect();
    convex_hull_2d(&projected)
}
