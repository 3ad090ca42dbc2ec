//! A reader that knows the truth scores in full; one that spoils it loses what it spoils.

use glam::DVec2;
use rayon::prelude::*;

use super::reading::{TableRead, ThingRead};
use super::report::summary;
use super::score::score;
use super::*;
use crate::synthetic::TableShape;
use embedded::photograph::SizeSettings;
use imaging::Mask;
use vision::category_fit::CategoryFitSettings;
use vision::network::Looks;
use vision::network::frame::Look;

/// What a reader with the truth in its hands would say, in a unit of `unit_m` meters.
fn perfect(painting: &Painting, unit_m: f64) -> TableRead {
    let truth = &painting.truth;
    let in_units = |points: &[DVec2]| points.iter().map(|p| *p / unit_m).collect::<Vec<_>>();
    let thing = |(index, object): (usize, &crate::synthetic::ObjectTruth)| ThingRead {
        mask: painting.labels.object(index),
        footprint: in_units(&object.footprint_m),
        height: object.size_m.z / unit_m,
        label: None,
        label_as_foreign: None,
    };
    TableRead {
        elevation_rad: truth.elevation_rad,
        azimuth_rad: truth.azimuth_rad,
        outline_px: truth.table.outline_px.clone(),
        top: in_units(&truth.table.outline_m),
        things: truth.objects.iter().enumerate().map(thing).collect(),
    }
}

fn result(painting: &Painting, read: Option<&TableRead>) -> PictureResult {
    let score = score(&painting.truth, &painting.labels, read);
    PictureResult { number: painting.truth.number, refused: None, score }
}

/// Pictures that show whole tables with things.
fn paintings() -> Vec<Painting> {
    let all = (0..12).map(|number| paint(Split::Test, number, 256));
    all.filter(|painting| painting.truth.table.is_whole && painting.truth.objects.len() > 2).collect()
}

#[test]
fn the_truth_scores_in_full_whatever_its_unit() {
    let paintings = paintings();
    assert!(paintings.len() >= 4, "{} pictures", paintings.len());
    let results: Vec<PictureResult> =
        paintings.iter().map(|painting| result(painting, Some(&perfect(painting, 0.37)))).collect();
    let all = summary(&results.iter().collect::<Vec<_>>());
    assert!(all.painted > 10 && all.found == all.painted && all.invented == 0, "{all:?}");
    assert_eq!((all.recall, all.precision, all.right_outlines), (Some(1.0), Some(1.0), 1.0));
    let worst =
        [all.elevation_deg, all.position_m, all.height, all.yaw_deg].map(|q| q.expect("values").worst);
    assert!(worst.iter().all(|error| *error < 1e-6), "{worst:?}");
}

#[test]
fn a_table_of_no_sides_is_turned_and_shifted_onto_the_truth() {
    let all = (0..40).map(|number| paint(Split::Test, number, 256));
    let shape = |painting: &Painting| painting.truth.table.shape;
    let free =
        |painting: &Painting| painting.truth.table.is_whole && shape(painting) != TableShape::Rectangle;
    let painting = all.into_iter().find(free).expect("some other table");
    let mut read = perfect(&painting, 0.5);
    let turned = |p: &DVec2| DVec2::from_angle(0.7).rotate(*p) + DVec2::new(0.2, -0.1);
    read.azimuth_rad += 0.7;
    read.top = read.top.iter().map(turned).collect();
    read.things.iter_mut().for_each(|thing| thing.footprint = thing.footprint.iter().map(turned).collect());
    let score = result(&painting, Some(&read)).score;
    assert!(!score.things.is_empty());
    assert!(score.things.iter().all(|thing| thing.position_error_m.expect("a place") < 1e-6), "{score:?}");
}

#[test]
fn what_is_spoiled_is_seen() {
    let painting = &paintings()[0];
    let truth = result(painting, Some(&perfect(painting, 1.0))).score;
    let of = |spoil: &dyn Fn(&mut TableRead)| {
        let mut read = perfect(painting, 1.0);
        spoil(&mut read);
        result(painting, Some(&read)).score
    };
    let fewer = of(&|read| {
        // The last painted thing need not count; the one that shows most does.
        let largest = (0..read.things.len()).max_by_key(|k| read.things[*k].mask.area_px()).expect("things");
        read.things.remove(largest);
    });
    assert_eq!((fewer.found, fewer.invented), (truth.found - 1, 0));
    let more = of(&|read| {
        let (width, height) = (painting.truth.width_px, painting.truth.height_px);
        let corner = Mask::from_fn(width, height, |x, y| x < 9 && y < 9);
        read.things.push(ThingRead {
            mask: corner,
            footprint: vec![DVec2::ZERO, DVec2::X, DVec2::Y],
            height: 0.1,
            label: None,
            label_as_foreign: None,
        });
    });
    assert_eq!((more.found, more.invented), (truth.found, 1));
    let shifted = of(&|read| read.outline_px.iter_mut().for_each(|p| p.x += 20.0));
    assert!(shifted.outline_iou < truth.outline_iou - 0.05, "{} {}", shifted.outline_iou, truth.outline_iou);
    let tilted = of(&|read| read.elevation_rad += 0.1);
    assert!((tilted.elevation_error_deg.expect("read") - 0.1_f64.to_degrees()).abs() < 1e-9);
    let moved = of(&|read| {
        read.things.iter_mut().for_each(|thing| thing.footprint.iter_mut().for_each(|p| p.y += 0.03));
        read.things.iter_mut().for_each(|thing| thing.height *= 1.25);
    });
    for thing in &moved.things {
        assert!((thing.position_error_m.expect("a place") - 0.03).abs() < 1e-9, "{thing:?}");
        assert!((thing.height_error - 0.25).abs() < 1e-9, "{thing:?}");
    }
    let none = result(painting, None).score;
    assert_eq!((none.found, none.invented, none.outline_iou), (0, 0, 0.0));
    assert_eq!(none.elevation_error_deg, None);
}

#[test]
fn turned_footprints_are_turned_by_what_they_were_turned() {
    let painting = &paintings()[0];
    let mut read = perfect(painting, 1.0);
    for thing in &mut read.things {
        let middle = thing.footprint.iter().sum::<DVec2>() / thing.footprint.len() as f64;
        thing.footprint.iter_mut().for_each(|p| *p = middle + DVec2::from_angle(0.2).rotate(*p - middle));
    }
    let scores = result(painting, Some(&read)).score.things;
    let yaws: Vec<f64> = scores.iter().filter_map(|thing| thing.yaw_error_deg).collect();
    // Where several rectangles are as small, another one may be nearer.
    assert!(yaws.iter().all(|error| *error < 0.2_f64.to_degrees() + 1e-6), "{yaws:?}");
    assert!(yaws.iter().any(|error| (error - 0.2_f64.to_degrees()).abs() < 1e-6), "{yaws:?}");
}

#[test]
fn perfect_maps_are_read_almost_in_full() {
    let bench = PictureBench {
        reader: Reader::WithPerfectMaps(test_settings::section_without("network", &["weights"])),
        photograph: PhotographSettings {
            vision: vision::tests::painted::settings(),
            sizes: SizeSettings { table_height_m: 0.74, top_view_px: 512, texture_px: 512 },
            naming: test_settings::section("category_fit"),
        },
    };
    let results: Vec<PictureResult> = (0..14)
        .into_par_iter()
        .map(|number| paint(Split::Validation, number, 512))
        .filter(|painting| !painting.truth.objects.is_empty())
        .map(|painting| bench.read(&painting, &Interrupt::default()).expect("not interrupted").0)
        .collect();
    let all = summary(&results.iter().collect::<Vec<_>>());
    eprintln!("{all:?}");
    // One shows nothing that is large enough to count.
    assert!(all.painted > 50 && all.refused <= 1, "{all:?}");
    assert!(all.recall > Some(0.9) && all.precision > Some(0.95) && all.right_outlines > 0.9, "{all:?}");
    assert!(all.labeled > Some(0.1) && all.label_precision > Some(0.7), "{all:?}");
    assert!(all.labeled_as_foreign < Some(0.15), "{all:?}");
    let [elevation_deg, position_m, height, yaw_deg] =
        [all.elevation_deg, all.position_m, all.height, all.yaw_deg].map(|q| q.expect("values").median);
    assert!(elevation_deg < 1.5 && position_m < 0.025 && height < 0.2 && yaw_deg < 8.0, "{all:?}");
}

#[test]
fn perfect_maps_say_the_camera_but_for_what_they_are_told_to_be_off() {
    const OFF_RAD: f64 = 0.1;
    for painting in paintings() {
        let truth = &painting.truth;
        let maps = PerfectMaps { painting: &painting, elevation_off_rad: OFF_RAD };
        let look = Look::whole([truth.width_px, truth.height_px]);
        let maps = maps.maps(&painting.picture, look, &Interrupt::default()).expect("maps");
        let (elevation_rad, focal) = maps.camera();
        let expected = truth.camera.fx / f64::from(truth.width_px.max(truth.height_px));
        assert!((elevation_rad - truth.elevation_rad - OFF_RAD).abs() < 5e-3, "{elevation_rad}");
        assert!((focal - expected).abs() < 5e-3 * expected, "{focal} for {expected}");
    }
}

#[test]
fn labels_are_right_wrong_or_none() {
    let painting = &paintings()[0];
    let of = |label: &dyn Fn(usize) -> Option<&'static str>| {
        let mut read = perfect(painting, 1.0);
        for (index, thing) in read.things.iter_mut().enumerate() {
            (thing.label, thing.label_as_foreign) = (label(index), Some("mug"));
        }
        summary(&[&result(painting, Some(&read))])
    };
    let own = |index: usize| {
        let name = &painting.truth.objects[index].name;
        catalog::category(name).map(|category| category.name.as_str())
    };
    let all = of(&own);
    assert_eq!((all.label_precision, all.labeled_as_foreign), (Some(1.0), Some(1.0)));
    assert_eq!(of(&|_| Some("no such thing")).label_precision, Some(0.0));
    assert_eq!((of(&|_| None).labeled, of(&|_| None).label_precision), (Some(0.0), None));
}
