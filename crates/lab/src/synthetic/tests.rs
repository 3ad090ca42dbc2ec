//! Properties of painted pictures: what the labels, the truth and the picture say of each other.

use glam::DVec2;
use rayon::prelude::*;

use super::*;
use geometry::Outline;

/// A few small pictures of each split.
fn some() -> Vec<Painting> {
    let numbers: Vec<(Split, u64)> =
        Split::ALL.iter().flat_map(|split| (0..8).map(move |n| (*split, n))).collect();
    numbers.into_par_iter().map(|(split, number)| paint(split, number, 192)).collect()
}

fn named(painting: &Painting) -> String {
    format!("{} {}", painting.truth.split.name(), painting.truth.number)
}

#[test]
fn the_same_number_gives_the_same_bytes_and_others_do_not() {
    let [a, b, c] =
        [(Split::Test, 3), (Split::Test, 3), (Split::Test, 4)].map(|(split, n)| paint(split, n, 160));
    assert_eq!(a, b);
    assert_ne!(a.jpeg, c.jpeg);
    assert_ne!(a.jpeg, paint(Split::Training, 3, 160).jpeg);
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    assert_eq!(alone.install(|| paint(Split::Test, 3, 160)), a);
}

#[test]
fn every_label_is_an_object_and_every_count_is_that_of_the_label() {
    for painting in some() {
        let (labels, truth) = (&painting.labels, &painting.truth);
        let context = named(&painting);
        assert_eq!(labels.values.len(), (truth.width_px * truth.height_px) as usize, "{context}");
        assert_eq!(
            (painting.picture.width_px(), painting.picture.height_px()),
            (truth.width_px, truth.height_px)
        );
        let most = labels.values.iter().max().copied().unwrap_or(0);
        assert!(
            usize::from(most) < usize::from(Labels::FIRST_OBJECT) + truth.objects.len().max(1),
            "{context}: {most}"
        );
        for (index, object) in truth.objects.iter().enumerate() {
            let mask = labels.object(index);
            assert_eq!(mask.area_px(), object.visible_px, "{context} {index}");
            assert!(object.visible_share <= 1.0 + 1e-9, "{context} {index} {}", object.visible_share);
            assert!(object.stands_on.is_none_or(|below| below < index), "{context} {index}");
            let Some([x0, y0, x1, y1]) = mask.bbox_px() else { continue };
            let [bx0, by0, bx1, by1] = object.box_px;
            let within = f64::from(x0) >= bx0 - 1.0
                && f64::from(y0) >= by0 - 1.0
                && f64::from(x1) <= bx1 + 1.0
                && f64::from(y1) <= by1 + 1.0;
            assert!(within, "{context} {index}: {:?} beyond {:?}", [x0, y0, x1, y1], object.box_px);
        }
    }
}

#[test]
fn bare_top_lies_within_the_outline_and_nothing_else_of_the_table_does() {
    for painting in some() {
        let truth = &painting.truth;
        let outline = Outline::new(truth.table.outline_m.clone()).expect("an outline");
        for (k, value) in painting.labels.values.iter().enumerate() {
            let (x, y) = (k as u32 % truth.width_px, k as u32 / truth.width_px);
            let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let inside_m =
                truth.camera.meet_plane(pixel, 0.0).map_or(-1.0, |p| outline.depth_inside_m(p.truncate()));
            match *value {
                Labels::TOP => assert!(inside_m > -0.012, "{} {pixel}: top {inside_m}", named(&painting)),
                Labels::FRAME => assert!(inside_m < 0.012, "{} {pixel}: frame {inside_m}", named(&painting)),
                _ => {}
            }
        }
    }
}

#[test]
fn things_on_the_table_stand_within_it_and_apart() {
    for painting in some() {
        let outline = Outline::new(painting.truth.table.outline_m.clone()).expect("an outline");
        let standing: Vec<&ObjectTruth> =
            painting.truth.objects.iter().filter(|object| object.stands_on.is_none()).collect();
        for (k, object) in standing.iter().enumerate() {
            let context = format!("{} {}", named(&painting), object.name);
            assert!(object.contact_z_m.abs() < 1e-9, "{context}");
            assert!(
                object.footprint_m.iter().all(|p| outline.depth_inside_m(*p) >= 0.0),
                "{context} sticks out"
            );
            let own = Outline::new(object.footprint_m.clone()).expect("a footprint");
            for other in &standing[k + 1..] {
                let clear = other.footprint_m.iter().all(|p| own.depth_inside_m(*p) <= 1e-9);
                assert!(clear, "{context} runs into {}", other.name);
            }
        }
        for object in painting.truth.objects.iter().filter(|object| object.stands_on.is_some()) {
            assert!(object.contact_z_m > -1e-3, "{} {} sinks", named(&painting), object.name);
        }
    }
}

#[test]
fn pictures_show_only_what_their_split_may() {
    for painting in some() {
        let truth = &painting.truth;
        for object in truth.objects.iter().filter(|object| !object.is_composite) {
            assert_eq!(Split::of_category(&object.name), truth.split, "{} {}", named(&painting), object.name);
        }
        let finishes =
            finish::FINISHES.iter().map(|(finish, ..)| finish).filter(|finish| finish.split() == truth.split);
        assert!(
            finishes.into_iter().any(|finish| finish.name() == truth.table.finish),
            "{}",
            truth.table.finish
        );
        let mut backdrops =
            backdrop::KINDS.iter().map(|(kind, ..)| kind).filter(|kind| kind.split() == truth.split);
        assert!(backdrops.any(|kind| kind.name() == truth.backdrop), "{}", truth.backdrop);
        let mut composites =
            composite::KINDS.iter().map(|(kind, ..)| kind).filter(|kind| kind.split() == truth.split);
        let own: Vec<&str> = composites.by_ref().map(|kind| kind.name()).collect();
        let odd =
            truth.objects.iter().find(|object| object.is_composite && !own.contains(&object.name.as_str()));
        assert_eq!(odd, None, "{}", named(&painting));
    }
}

#[test]
fn truth_survives_its_file() {
    let painting = paint(Split::Validation, 1, 128);
    let text = serde_json::to_string(&painting.truth).expect("JSON");
    let back: PictureTruth = serde_json::from_str(&text).expect("the same");
    assert_eq!(back, painting.truth);
    let labels = image::load_from_memory(&painting.labels.png()).expect("a PNG").to_luma8();
    assert_eq!(labels.into_raw(), painting.labels.values);
}
