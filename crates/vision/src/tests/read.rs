//! How near the reading comes to the truth.

use glam::DVec2;

use super::painted::{Painted, paint, settings, settings_to_paint};
use crate::{PictureReading, TopShape, read_picture};
use imaging::{Image, Mask};
use render::overlay::{distinct_color, draw_polyline, tint_mask};
use runtime::Interrupt;

/// Figures of one picture.
#[derive(Debug)]
struct Figures {
    elevation_error_deg: f64,
    azimuth_error_deg: f64,
    outline_iou: f64,
    found: usize,
    wanted: usize,
    read: usize,
    /// Median distance of the found objects' middles, meters.
    position_error_m: f64,
}

fn box_iou(a: &Mask, b: &Mask) -> f64 {
    let (Some(a), Some(b)) = (a.bbox_px(), b.bbox_px()) else { return 0.0 };
    let span = |k: usize| f64::from(a[k + 2].min(b[k + 2])) - f64::from(a[k].max(b[k]));
    let both = span(0).max(0.0) * span(1).max(0.0);
    let area = |c: [u32; 4]| f64::from(c[2] - c[0]) * f64::from(c[3] - c[1]);
    both / (area(a) + area(b) - both)
}

/// The reading drawn onto its picture.
pub(crate) fn overlay(picture: &Image, reading: &PictureReading) -> Image {
    let mut image = picture.clone();
    for (k, object) in reading.objects.iter().enumerate() {
        tint_mask(&mut image, &object.mask, distinct_color(k), 0.45);
        for z in [0.0, object.solid.size.z] {
            let ring: Option<Vec<DVec2>> = object
                .solid
                .footprint()
                .iter()
                .map(|p| reading.camera.project(p.extend(z)).map(|q| q.0))
                .collect();
            draw_polyline(&mut image, &ring.unwrap_or_default(), true, distinct_color(k), 2.0);
        }
    }
    draw_polyline(&mut image, &reading.table.outline_px, true, [255, 0, 255, 255], 2.0);
    image
}

fn compare(painted: &Painted, reading: &PictureReading) -> Figures {
    let width_m = {
        let (low, high) = painted.outline_px.iter().fold((f64::MAX, f64::MIN), |(l, h), p| {
            let met = painted.camera.meet_plane(*p, 0.0).expect("on the table");
            (l.min(met.x), h.max(met.x))
        });
        high - low
    };
    let hull = &reading.table.outline_px;
    let top = Mask::from_fn(painted.top.width_px(), painted.top.height_px(), |x, y| {
        crate::polygon::contains(hull, DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5))
    });
    let degrees = |a: f64, b: f64| (a - b).to_degrees();
    let mut errors = Vec::new();
    for (_, mask, middle, _) in &painted.objects {
        let best =
            reading.objects.iter().max_by(|a, b| box_iou(&a.mask, mask).total_cmp(&box_iou(&b.mask, mask)));
        if let Some(object) = best.filter(|o| box_iou(&o.mask, mask) >= 0.5) {
            // A round table turns with the camera.
            let turn =
                if reading.table.shape == TopShape::Circle { painted.camera.azimuth_rad() } else { 0.0 };
            let place = DVec2::from_angle(turn).rotate(width_m * object.solid.center);
            errors.push((place - *middle).length());
        }
    }
    errors.sort_by(f64::total_cmp);
    Figures {
        elevation_error_deg: degrees(reading.camera.elevation_rad(), painted.camera.elevation_rad()),
        azimuth_error_deg: degrees(reading.camera.azimuth_rad(), painted.camera.azimuth_rad()),
        outline_iou: top.iou(&painted.top),
        found: errors.len(),
        wanted: painted.objects.len(),
        read: reading.objects.len(),
        position_error_m: errors.get(errors.len() / 2).copied().unwrap_or(f64::NAN),
    }
}

#[test]
fn painted_tables_are_read() {
    let (mut found, mut wanted, mut read) = (0, 0, 0);
    let directory = std::env::var_os("TABLETOPGEN_VISION_OVERLAYS");
    let only = std::env::var("TABLETOPGEN_VISION_ONLY").unwrap_or_default();
    for (name, setting) in settings_to_paint().into_iter().filter(|(name, _)| name.contains(&only)) {
        let painted = paint(&setting);
        let started = std::time::Instant::now();
        let result = read_picture(&painted.picture, &settings(), &Interrupt::default());
        let seconds = started.elapsed().as_secs_f64();
        if let Some(directory) = &directory {
            let plain = std::path::Path::new(directory).join(format!("{name}_plain.png"));
            std::fs::write(plain, imaging::codec::encode_png(&painted.picture)).expect("writable");
            let image = match &result {
                Ok(reading) => overlay(&painted.picture, reading),
                Err(_) => crate::reading::outlined(&painted.picture, &settings()),
            };
            let path = std::path::Path::new(directory).join(format!("{name}.png"));
            std::fs::write(path, imaging::codec::encode_png(&image)).expect("the directory is writable");
        }
        match result {
            Ok(reading) => {
                let figures = compare(&painted, &reading);
                assert!(figures.outline_iou > 0.95, "{name} {figures:?}");
                assert!(figures.elevation_error_deg.abs() < 1.5, "{name} {figures:?}");
                assert!(figures.azimuth_error_deg.abs() < 1.5, "{name} {figures:?}");
                assert!(figures.position_error_m < 0.06, "{name} {figures:?}");
                found += figures.found as u32;
                wanted += figures.wanted as u32;
                read += figures.read as u32;
                eprintln!("{name}: {seconds:.2} s {:?} height {:?}", figures, reading.table.height);
                for object in &reading.objects {
                    let kind = format!("{:?}", object.solid.kind);
                    let kind = kind.split(' ').next().unwrap_or("").to_owned();
                    eprintln!(
                        "    {kind} {:.3} size {:.3} on {:?}",
                        object.solid.overlap, object.solid.size, object.stands_on
                    );
                }
            }
            Err(error) => panic!("{name}: {error}"),
        }
    }
    let (recall, precision) = (f64::from(found) / f64::from(wanted), f64::from(found) / f64::from(read));
    eprintln!("recall {recall:.3}, precision {precision:.3} at box overlap 0.5, {wanted} things");
    assert!(recall >= 0.9 && precision >= 0.9, "{recall} {precision}");
}

/// Reads every PNG and JPEG of a directory and writes overlays beside the others:
/// `TABLETOPGEN_PICTURES=dir TABLETOPGEN_VISION_OVERLAYS=dir cargo test --lib -- --ignored pictures_of_a`.
#[test]
#[ignore = "needs a directory of pictures"]
fn pictures_of_a_directory_are_read_or_refused() {
    let from = std::env::var_os("TABLETOPGEN_PICTURES").expect("TABLETOPGEN_PICTURES names a directory");
    let directory = std::env::var_os("TABLETOPGEN_VISION_OVERLAYS").expect("a directory for overlays");
    let mut paths: Vec<_> = std::fs::read_dir(from)
        .expect("a directory")
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .collect();
    paths.sort();
    for path in paths {
        let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let Ok(picture) = imaging::codec::decode_picture(&std::fs::read(&path).expect("readable"), 1 << 26)
        else {
            continue;
        };
        let started = std::time::Instant::now();
        let result = read_picture(&picture, &settings(), &Interrupt::default());
        let seconds = started.elapsed().as_secs_f64();
        let image = match &result {
            Ok(reading) => overlay(&picture, reading),
            Err(_) => crate::reading::outlined(&picture, &settings()),
        };
        let to = std::path::Path::new(&directory).join(format!("{stem}.png"));
        std::fs::write(to, imaging::codec::encode_png(&image)).expect("the directory is writable");
        match result {
            Ok(reading) => {
                let outline: Vec<[f64; 2]> = reading.table.outline_px.iter().map(|p| p.to_array()).collect();
                let boxes: Vec<_> = reading.objects.iter().filter_map(|o| o.mask.bbox_px()).collect();
                let elevation = reading.camera.elevation_rad().to_degrees();
                let record = serde_json::json!({
                    "name": stem, "seconds": seconds, "elevation": elevation, "outline": outline, "boxes": boxes,
                });
                eprintln!("RECORD {record}");
            }
            Err(error) => eprintln!("REFUSED {stem} {seconds:.2} {error}"),
        }
    }
}
