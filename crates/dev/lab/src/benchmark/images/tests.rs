//! A perfect reader gets full scores; a perturbed one loses the perturbed scores.

use glam::DVec2;
use rayon::prelude::*;

use super::estimate::{ObjectEstimate, TableEstimate};
use super::report::summary;
use super::score::score;
use super::*;
use crate::synthetic_images::TableShape;
use embedded::single_view_reconstruction::PhotographSettings;
use imaging::Mask;
use vision::table_network::DensePredictor;
use vision::table_network::frame::ImageCrop;

/// Estimate of a perfect reader, in a unit of `unit_m` meters.
fn perfect(sample: &SyntheticImage, unit_m: f64) -> TableEstimate {
    let truth = &sample.truth;
    let in_units = |points: &[DVec2]| points.iter().map(|p| *p / unit_m).collect::<Vec<_>>();
    let object = |(index, object): (usize, &crate::synthetic_images::ObjectTruth)| ObjectEstimate {
        mask: sample.labels.object(index),
        footprint: in_units(&object.footprint_m),
        height: object.size_m.z / unit_m,
        label: None,
        label_as_foreign: None,
        label_with_text: None,
        named_by_text: false,
    };
    TableEstimate {
        meters_per_unit: unit_m,
        elevation_rad: truth.elevation_rad,
        azimuth_rad: truth.azimuth_rad,
        outline_px: truth.table.outline_px.clone(),
        top: in_units(&truth.table.outline_m),
        objects: truth
            .objects
            .iter()
            .enumerate()
            .map(object)
            // An object that is hidden entirely has no mask to find.
            .filter(|estimate| estimate.mask.area_px() > 0)
            .collect(),
    }
}

fn result(sample: &SyntheticImage, read: Option<&TableEstimate>) -> ImageResult {
    let score = score(&sample.truth, &sample.labels, read);
    ImageResult { number: sample.truth.number, refused: None, score }
}

/// Images with a whole table and several objects.
fn samples() -> Vec<SyntheticImage> {
    let all = (0..12).map(|number| synthesize(Split::Test, number, 256));
    all.filter(|sample| sample.truth.table.is_whole && sample.truth.objects.len() > 2).collect()
}

#[test]
fn perfect_estimate_scores_fully_in_any_unit() {
    let samples = samples();
    assert!(samples.len() >= 4, "{} pictures", samples.len());
    let results: Vec<ImageResult> =
        samples.iter().map(|sample| result(sample, Some(&perfect(sample, 0.37)))).collect();
    let all = summary(&results.iter().collect::<Vec<_>>());
    assert!(all.expected > 10 && all.detected == all.expected && all.false_positives == 0, "{all:?}");
    assert_eq!((all.recall, all.precision, all.correct_outlines), (Some(1.0), Some(1.0), 1.0));
    let worst =
        [all.elevation_deg, all.position_m, all.height, all.yaw_deg].map(|q| q.expect("values").worst);
    assert!(worst.iter().all(|error| *error < 1e-6), "{worst:?}");
}

#[test]
fn non_rectangular_table_is_aligned_to_truth() {
    let all = (0..40).map(|number| synthesize(Split::Test, number, 256));
    let shape = |sample: &SyntheticImage| sample.truth.table.shape;
    let free =
        |sample: &SyntheticImage| sample.truth.table.is_whole && shape(sample) != TableShape::Rectangle;
    let sample = all.into_iter().find(free).expect("some other table");
    let mut read = perfect(&sample, 0.5);
    let turned = |p: &DVec2| DVec2::from_angle(0.7).rotate(*p) + DVec2::new(0.2, -0.1);
    read.azimuth_rad += 0.7;
    read.top = read.top.iter().map(turned).collect();
    read.objects
        .iter_mut()
        .for_each(|object| object.footprint = object.footprint.iter().map(turned).collect());
    let score = result(&sample, Some(&read)).score;
    assert!(!score.objects.is_empty());
    assert!(score.objects.iter().all(|object| object.position_error_m.expect("a place") < 1e-6), "{score:?}");
}

#[test]
fn score_reflects_each_perturbation() {
    let sample = &samples()[0];
    let truth = result(sample, Some(&perfect(sample, 1.0))).score;
    let of = |perturb: &dyn Fn(&mut TableEstimate)| {
        let mut read = perfect(sample, 1.0);
        perturb(&mut read);
        result(sample, Some(&read)).score
    };
    let fewer = of(&|read| {
        // The last true object may not count; the one with most pixels does.
        let largest =
            (0..read.objects.len()).max_by_key(|k| read.objects[*k].mask.area_px()).expect("things");
        read.objects.remove(largest);
    });
    assert_eq!((fewer.detected, fewer.false_positives), (truth.detected - 1, 0));
    let more = of(&|read| {
        let (width, height) = (sample.truth.width_px, sample.truth.height_px);
        let corner = Mask::from_fn(width, height, |x, y| x < 9 && y < 9);
        read.objects.push(ObjectEstimate {
            mask: corner,
            footprint: vec![DVec2::ZERO, DVec2::X, DVec2::Y],
            height: 0.1,
            label: None,
            label_as_foreign: None,
            label_with_text: None,
            named_by_text: false,
        });
    });
    assert_eq!((more.detected, more.false_positives), (truth.detected, 1));
    let shifted = of(&|read| read.outline_px.iter_mut().for_each(|p| p.x += 20.0));
    assert!(shifted.outline_iou < truth.outline_iou - 0.05, "{} {}", shifted.outline_iou, truth.outline_iou);
    let tilted = of(&|read| read.elevation_rad += 0.1);
    assert!((tilted.elevation_error_deg.expect("read") - 0.1_f64.to_degrees()).abs() < 1e-9);
    let moved = of(&|read| {
        read.objects.iter_mut().for_each(|object| object.footprint.iter_mut().for_each(|p| p.y += 0.03));
        read.objects.iter_mut().for_each(|object| object.height *= 1.25);
    });
    for object in &moved.objects {
        assert!((object.position_error_m.expect("a place") - 0.03).abs() < 1e-9, "{object:?}");
        assert!((object.height_error - 0.25).abs() < 1e-9, "{object:?}");
    }
    let none = result(sample, None).score;
    assert_eq!((none.detected, none.false_positives, none.outline_iou), (0, 0, 0.0));
    assert_eq!(none.elevation_error_deg, None);
}

#[test]
fn yaw_error_equals_footprint_rotation() {
    let sample = &samples()[0];
    let mut read = perfect(sample, 1.0);
    for object in &mut read.objects {
        let center = object.footprint.iter().sum::<DVec2>() / object.footprint.len() as f64;
        object.footprint.iter_mut().for_each(|p| *p = center + DVec2::from_angle(0.2).rotate(*p - center));
    }
    let scores = result(sample, Some(&read)).score.objects;
    let yaws: Vec<f64> = scores.iter().filter_map(|object| object.yaw_error_deg).collect();
    // If several rectangles are equally small, another one may be nearer.
    assert!(yaws.iter().all(|error| *error < 0.2_f64.to_degrees() + 1e-6), "{yaws:?}");
    assert!(yaws.iter().any(|error| (error - 0.2_f64.to_degrees()).abs() < 1e-6), "{yaws:?}");
}

#[test]
fn perfect_maps_yield_high_recall_and_precision() {
    let bench = ImageBench {
        reader: Reader::PerfectMaps(test_settings::section_without("network", &["weights"])),
        network: ReadingNetwork::built_in(test_settings::section_without("network", &["weights"])),
        single_view: SingleViewSettings {
            sizes: PhotographSettings {
                table_height_m: 0.74,
                field_of_view_rad: 0.0,
                intrinsics_px: [0.0; 6],
                top_view_px: 512,
                texture_px: 512,
            },
            naming: test_settings::section("category_fit"),
        },
        text_parser: None,
        beside: BesideImage::Nothing,
    };
    let results: Vec<ImageResult> = (0..14)
        .into_par_iter()
        .map(|number| synthesize(Split::Validation, number, 512))
        .filter(|sample| !sample.truth.objects.is_empty())
        .map(|sample| bench.read(&sample, &CancelFlag::default()).expect("not interrupted").0)
        .collect();
    let all = summary(&results.iter().collect::<Vec<_>>());
    eprintln!("{all:?}");
    // One image shows no object that is large enough to count.
    assert!(all.expected > 50 && all.refused <= 1, "{all:?}");
    assert!(all.recall > Some(0.88) && all.precision > Some(0.95) && all.correct_outlines > 0.9, "{all:?}");
    assert!(all.labeled > Some(0.1) && all.label_precision > Some(0.7), "{all:?}");
    assert!(all.labeled_as_foreign < Some(0.15), "{all:?}");
    let [elevation_deg, position_m, height, yaw_deg] =
        [all.elevation_deg, all.position_m, all.height, all.yaw_deg].map(|q| q.expect("values").median);
    assert!(elevation_deg < 1.5 && position_m < 0.025 && height < 0.2 && yaw_deg < 8.0, "{all:?}");
}

#[test]
fn perfect_maps_encode_camera_with_elevation_offset() {
    const OFF_RAD: f64 = 0.1;
    for sample in samples() {
        let truth = &sample.truth;
        let maps = PerfectMaps { image: &sample, elevation_off_rad: OFF_RAD };
        let crop = ImageCrop::whole([truth.width_px, truth.height_px]);
        let maps = maps.maps(&sample.image, crop, &CancelFlag::default()).expect("maps");
        let (elevation_rad, focal) = maps.camera(None);
        let expected = truth.camera.fx / f64::from(truth.width_px.max(truth.height_px));
        assert!((elevation_rad - truth.elevation_rad - OFF_RAD).abs() < 5e-3, "{elevation_rad}");
        assert!((focal - expected).abs() < 5e-3 * expected, "{focal} for {expected}");
    }
}

#[test]
fn label_precision_counts_correct_wrong_and_missing_labels() {
    let sample = &samples()[0];
    let of = |label: &dyn Fn(usize) -> Option<&'static str>| {
        let mut read = perfect(sample, 1.0);
        for (index, object) in read.objects.iter_mut().enumerate() {
            (object.label, object.label_as_foreign) = (label(index), Some("mug"));
        }
        summary(&[&result(sample, Some(&read))])
    };
    let own = |index: usize| {
        let name = &sample.truth.objects[index].name;
        catalog::category(name).map(|category| category.name.as_str())
    };
    let all = of(&own);
    assert_eq!((all.label_precision, all.labeled_as_foreign), (Some(1.0), Some(1.0)));
    assert_eq!(of(&|_| Some("no such thing")).label_precision, Some(0.0));
    assert_eq!((of(&|_| None).labeled, of(&|_| None).label_precision), (Some(0.0), None));
}
