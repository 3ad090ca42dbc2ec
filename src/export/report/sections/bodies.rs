//! One row a body: its mesh and its hulls.

use crate::export::report::Report;
use crate::export::report::html::{Cell, Html};
use crate::export::report::numbers::{mm, percent, significant};

pub fn write(page: &mut Html, report: &Report<'_>) {
    let limits = &report.certificate.thresholds.health;
    let head = [
        "Body",
        "Size (m)",
        "Triangles",
        "Closed",
        "Volume (l)",
        "Density (kg/m³)",
        "Hulls",
        "Corners of a hull, most",
        "Volume of hulls to mesh",
        "Hulls stick out",
        "Mesh outside hulls",
    ];
    let judged = |text: String, good: bool| if good { Cell::Number(text) } else { Cell::Bad(text) };
    let rows = report.certificate.bodies.iter().map(|body| {
        let [x, y, z] = body.size_m;
        let side = x.max(y).max(z);
        let within = |[low, high]: [f64; 2], value: f64| (low..=high).contains(&value);
        vec![
            Cell::Body(body.name.clone()),
            judged(format!("{x:.3} × {y:.3} × {z:.3}"), within(limits.longest_side_m, side)),
            Cell::Number(body.triangles.to_string()),
            Cell::Mark(body.watertight),
            Cell::Number(significant(1e3 * body.volume_m3)),
            judged(significant(body.density_kg_m3), within(limits.density_kg_m3, body.density_kg_m3)),
            Cell::Number(body.hulls.to_string()),
            Cell::Number(body.hull_corners.to_string()),
            Cell::Number(percent((1e3 * body.hull_volume_m3 / body.volume_m3).round() / 1e3)),
            judged(mm(body.hull_excess_m), body.hull_excess_m <= limits.hull_excess_m),
            judged(mm(body.uncovered_m), body.uncovered_m <= limits.uncovered_m),
        ]
    });
    page.table("", &head, rows.collect());
    page.leaf(
        "p",
        &[("class", "note")],
        "Volumes of overlapping parts and hulls count twice; how far the mesh lies outside its hulls is a lower \
         bound.",
    );
}
