//! One row an object: how well it covers its pixels, and how sure its turn is.

use crate::export::report::Report;
use crate::export::report::html::{Cell, Html};

pub fn write(page: &mut Html, report: &Report<'_>) {
    let rows = report.certificate.objects.iter().map(|object| {
        let rotation = &object.rotation;
        let symmetry = match rotation.symmetry_order {
            0 => "any angle".to_owned(),
            1 => "none".to_owned(),
            order => format!("every {:.0}°", 360.0 / f64::from(order)),
        };
        vec![
            Cell::Body(object.name.to_string()),
            Cell::Number(format!("{:.3}", object.silhouette_iou)),
            Cell::Number(format!("{:.1}°", rotation.yaw_rad.to_degrees())),
            Cell::Words(symmetry),
            Cell::Number(format!("{:.2}", rotation.confidence)),
        ]
    });
    let head = ["Object", "Silhouette overlap", "Yaw found", "Symmetry", "Confidence"];
    page.table("", &head, rows.collect());
}
