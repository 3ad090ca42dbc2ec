//! Image similarity. One row per object: silhouette overlap, color difference, reconstruction method, yaw and its
//! confidence. One row per region that contains objects in only one of the two images.

use crate::report::Report;
use crate::report::numbers::word;
use certificate::{Region, Regions};
use markup::html::{Cell, Html};

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
            Cell::Number(object.color_difference.map_or("none".to_owned(), |apart| format!("{apart:.1}"))),
            Cell::Words(word(object.method)),
            Cell::Number(format!("{:.1}°", rotation.yaw_rad.to_degrees())),
            Cell::Words(symmetry),
            Cell::Number(format!("{:.2}", rotation.confidence)),
        ]
    });
    let head =
        ["Object", "Silhouette overlap", "Color difference", "Method", "Yaw", "Symmetry", "Confidence"];
    page.table("", &head, rows.collect());
    let fidelity = &report.certificate.fidelity;
    let listed = |what: &'static str, regions: &Regions| {
        let row = move |region: &Region| {
            let [x0, y0, x1, y1] = region.bbox_px;
            vec![
                Cell::Words(what.to_owned()),
                Cell::Body(region.body.to_string()),
                Cell::Words(format!("{x0}, {y0} to {x1}, {y1}")),
                Cell::Number(format!("{:.2} %", 100.0 * region.image_share)),
            ]
        };
        regions.largest.iter().map(row).collect::<Vec<_>>()
    };
    let mut regions = listed("missed", &fidelity.missed);
    regions.extend(listed("invented", &fidelity.invented));
    let left_out = fidelity.left_out_px.iter().map(|[x0, y0, x1, y1]| {
        let area_px = |width: u32, height: u32| f64::from(width) * f64::from(height);
        let camera = &report.scene.camera;
        let share = area_px(x1 - x0, y1 - y0) / area_px(camera.width_px, camera.height_px);
        vec![
            Cell::Words("left out: it does not stand on the table".to_owned()),
            Cell::Words(String::new()),
            Cell::Words(format!("{x0}, {y0} to {x1}, {y1}")),
            Cell::Number(format!("{:.2} %", 100.0 * share)),
        ]
    });
    regions.extend(left_out);
    if let Some(depth) = &fidelity.depth {
        page.leaf("p", &[], &depth.note);
    }
    if !regions.is_empty() {
        page.table("", &["Region", "Object", "Pixels of the image", "Of its area"], regions);
    }
}
