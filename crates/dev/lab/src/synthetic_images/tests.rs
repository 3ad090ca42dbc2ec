//! Consistency of labels, ground truth and image of synthetic images.

use glam::DVec2;
use rayon::prelude::*;

use super::*;
use geometry::Outline;

/// A few small images of each split.
fn samples() -> Vec<SyntheticImage> {
    let numbers: Vec<(Split, u64)> =
        Split::ALL.iter().flat_map(|split| (0..8).map(move |n| (*split, n))).collect();
    numbers.into_par_iter().map(|(split, number)| synthesize(split, number, 192)).collect()
}

fn name_of(sample: &SyntheticImage) -> String {
    format!("{} {}", sample.truth.split.name(), sample.truth.number)
}

#[test]
fn synthesize_is_deterministic_per_split_and_number() {
    let [a, b, c] =
        [(Split::Test, 3), (Split::Test, 3), (Split::Test, 4)].map(|(split, n)| synthesize(split, n, 160));
    assert_eq!(a, b);
    assert_ne!(a.jpeg, c.jpeg);
    assert_ne!(a.jpeg, synthesize(Split::Training, 3, 160).jpeg);
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    assert_eq!(alone.install(|| synthesize(Split::Test, 3, 160)), a);
}

#[test]
fn labels_match_objects_and_visible_pixel_counts() {
    for sample in samples() {
        let (labels, truth) = (&sample.labels, &sample.truth);
        let context = name_of(&sample);
        assert_eq!(labels.values.len(), (truth.width_px * truth.height_px) as usize, "{context}");
        assert_eq!((sample.image.width_px(), sample.image.height_px()), (truth.width_px, truth.height_px));
        let highest = labels.values.iter().max().copied().unwrap_or(0);
        assert!(
            usize::from(highest) < usize::from(Labels::FIRST_OBJECT) + truth.objects.len().max(1),
            "{context}: {highest}"
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
fn top_labels_lie_within_outline_and_frame_labels_outside() {
    for sample in samples() {
        let truth = &sample.truth;
        let outline = Outline::new(truth.table.outline_m.clone()).expect("an outline");
        for (k, value) in sample.labels.values.iter().enumerate() {
            let (x, y) = (k as u32 % truth.width_px, k as u32 / truth.width_px);
            let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let inside_m =
                truth.camera.meet_plane(pixel, 0.0).map_or(-1.0, |p| outline.depth_inside_m(p.truncate()));
            match *value {
                Labels::TOP => assert!(inside_m > -0.012, "{} {pixel}: top {inside_m}", name_of(&sample)),
                Labels::FRAME => assert!(inside_m < 0.012, "{} {pixel}: frame {inside_m}", name_of(&sample)),
                _ => {}
            }
        }
    }
}

#[test]
fn objects_on_table_lie_within_outline_without_overlap() {
    for sample in samples() {
        let outline = Outline::new(sample.truth.table.outline_m.clone()).expect("an outline");
        let standing: Vec<&ObjectTruth> =
            sample.truth.objects.iter().filter(|object| object.stands_on.is_none()).collect();
        for (k, object) in standing.iter().enumerate() {
            let context = format!("{} {}", name_of(&sample), object.name);
            assert!(object.contact_z_m.abs() < 1e-9, "{context}");
            assert!(
                object.footprint_m.iter().all(|p| outline.depth_inside_m(*p) >= 0.0),
                "{context} sticks out"
            );
            let own = Outline::new(object.footprint_m.clone()).expect("a footprint");
            for other in &standing[k + 1..] {
                let depth_m = other.footprint_m.iter().map(|p| own.depth_inside_m(*p)).fold(0.0, f64::max);
                assert!(depth_m <= 1e-9, "{context} runs {depth_m} m into {}", other.name);
            }
        }
        for object in sample.truth.objects.iter().filter(|object| object.stands_on.is_some()) {
            assert!(object.contact_z_m > -1e-3, "{} {} sinks", name_of(&sample), object.name);
        }
    }
}

#[test]
fn images_contain_only_contents_of_their_split() {
    for sample in samples() {
        let truth = &sample.truth;
        for object in truth.objects.iter().filter(|object| !object.is_composite) {
            assert_eq!(Split::of_category(&object.name), truth.split, "{} {}", name_of(&sample), object.name);
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
        assert_eq!(odd, None, "{}", name_of(&sample));
    }
}

#[test]
fn truth_and_labels_round_trip_through_files() {
    let sample = synthesize(Split::Validation, 1, 128);
    let text = serde_json::to_string(&sample.truth).expect("JSON");
    let back: ImageTruth = serde_json::from_str(&text).expect("the same");
    assert_eq!(back, sample.truth);
    let labels = image::load_from_memory(&sample.labels.png()).expect("a PNG").to_luma8();
    assert_eq!(labels.into_raw(), sample.labels.values);
}
