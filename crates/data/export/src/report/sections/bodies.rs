//! One row per body: its mesh and its hulls.

use crate::report::Report;
use crate::report::numbers::{mm, percent, significant};
use geometry::repair::Repair;
use markup::html::{Cell, Html};

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
        "Air in hulls",
        "Hausdorff distance",
        "Mean distance",
        "Openings left open",
        "Repaired before",
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
            judged(mm(body.uncovered_m), body.uncovered_m <= limits.max_uncovered_m(body.size_m)),
            Cell::Number(percent((1e3 * body.hull_fit.air_share).round() / 1e3)),
            Cell::Number(mm(body.hull_fit.hausdorff_m())),
            Cell::Number(mm(body.hull_fit.mean_m())),
            judged(
                percent((1e3 * body.hull_fit.open_share).round() / 1e3),
                body.hull_fit.open_share >= limits.open_share,
            ),
            Cell::Words(repaired(&body.repair)),
        ]
    });
    page.table("", &head, rows.collect());
    page.leaf(
        "p",
        &[("class", "note")],
        "Volumes of overlapping parts and hulls count twice; how far the mesh lies outside its hulls is a lower \
         bound. Air is that in the union of the hulls, over the solid in it; distances are those between the surface \
         of that union and the mesh, the farther and the mean of both ways; openings are what lies in the convex \
         hull of the whole mesh and farther from it than a fiftieth of its size and than 1.5 mm, where they are 2 % of \
         that hull or more. Hulls are made of the repaired mesh; \
         the visual mesh stays as it came.",
    );
}

/// The repairs of a mesh before its convex decomposition.
fn repaired(repair: &Repair) -> String {
    let done = [
        (repair.corners_welded, "corners welded"),
        (repair.triangles_turned, "triangles turned"),
        (repair.holes_filled, "holes filled"),
        (repair.sheets_thickened, "sheets thickened"),
        (repair.shells_remeshed, "shells drawn anew"),
    ];
    let done: Vec<String> =
        done.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect();
    if done.is_empty() { "nothing".to_owned() } else { done.join(", ") }
}
