//! Assignment by evidence that is written down, and by fits to renderings.

use glam::{DVec2, DVec3};

use super::super::tests::seen;
use super::*;
use crate::category_fit::evidence;
use catalog::{Recipe, build, category};

/// A fit of that overlap, of typical size unless the logarithm of its size says otherwise.
fn fit(overlap: f64, oversize: f64) -> Option<CategoryMatch> {
    Some(CategoryMatch {
        category: "mug",
        is_lying: false,
        log_guess: -2.0,
        is_fitted: true,
        variant: 0,
        center: DVec2::ZERO,
        yaw_rad: 0.0,
        size_m: DVec3::splat(0.1),
        overlap,
        stray: 0.0,
        oversize,
        usual_spread: 0.1,
        by_ramp: 0.5,
        by_mesh: 0.5,
        contrast: 5.0,
        off_palette: 10.0,
    })
}

fn object(kind: usize) -> NamedObject {
    NamedObject { kind, color: None }
}

/// Objects of which the image alone says little: six guesses fit them not too badly.
fn unclear(count: usize) -> Vec<ObjectEvidence> {
    let matches: Vec<CategoryMatch> = (0..6).filter_map(|_| fit(0.8, 0.0)).collect();
    vec![ObjectEvidence { matches, log_other: -1.0, solid_overlap: 0.9, ..ObjectEvidence::default() }; count]
}

fn assigned(
    fits: &[Vec<Option<CategoryMatch>>],
    colors: &[Rgb],
    named: &[NamedObject],
) -> Vec<Option<usize>> {
    assign_named(&unclear(fits.len()), fits, colors, named).objects
}

#[test]
fn counts_bound_the_assignment_and_the_better_fit_wins() {
    let gray = [Rgb([0.5; 3]); 2];
    for (fits, named, expected) in [
        (vec![vec![fit(0.95, 0.0)], vec![fit(0.85, 0.0)]], vec![object(0)], vec![Some(0), None]),
        (vec![vec![fit(0.85, 0.0)], vec![fit(0.95, 0.0)]], vec![object(0)], vec![None, Some(0)]),
        (vec![vec![fit(0.95, 0.0)], vec![fit(0.9, 0.0)]], vec![object(0), object(0)], vec![Some(0), Some(1)]),
        (vec![vec![fit(0.95, 0.0)], vec![fit(0.9, 0.0)]], vec![], vec![None, None]),
        // A pair that fits in total, though the first object fits its second kind better.
        (
            vec![vec![fit(0.9, 0.0), fit(0.95, 0.0)], vec![None, fit(0.95, 0.0)]],
            vec![object(0), object(1)],
            vec![Some(0), Some(1)],
        ),
        // What does not fit at all stays without a name.
        (vec![vec![fit(0.2, 0.0)], vec![None]], vec![object(0), object(0)], vec![None, None]),
    ] {
        assert_eq!(assigned(&fits, &gray, &named), expected, "{named:?}");
    }
}

#[test]
fn colors_tell_objects_of_one_kind_apart() {
    let (red, blue) = (Rgb([0.8, 0.1, 0.1]), Rgb([0.1, 0.2, 0.8]));
    let fits = vec![vec![fit(0.9, 0.0)], vec![fit(0.9, 0.0)]];
    let named = |color| NamedObject { kind: 0, color: Some(color) };
    assert_eq!(assigned(&fits, &[red, blue], &[named(red), named(blue)]), [Some(0), Some(1)]);
    assert_eq!(assigned(&fits, &[red, blue], &[named(blue), named(red)]), [Some(1), Some(0)]);
    assert_eq!(assigned(&fits, &[red, blue], &[named(blue)]), [None, Some(0)]);
    // A dark red is nearer to red than to blue.
    let dark = Rgb([0.4, 0.05, 0.05]);
    assert!(color_cost(dark, Some(red)) < color_cost(dark, Some(blue)));
    assert_eq!(color_cost(dark, None), 0.0);
}

#[test]
fn sizes_agree_on_the_scale_of_the_image() {
    let gray = [Rgb([0.5; 3]); 3];
    // Everything is larger by the same factor but for one object of the other size.
    let fits =
        vec![vec![fit(0.9, 0.5), None], vec![fit(0.9, 0.5), None], vec![fit(0.9, 0.5), fit(0.9, -0.7)]];
    let named = [object(0), object(0), object(0), object(1)];
    let found = assign_named(&unclear(3), &fits, &gray, &named);
    assert!(found.log_scale > 0.15, "{found:?}");
    assert_eq!(found.objects, [Some(0), Some(1), Some(2)]);
}

/// Four categories and a stand-in.
#[test]
fn renderings_that_nothing_is_guessed_of_get_the_names_of_a_text() {
    let settings = test_settings::section::<CategoryFitSettings>("category_fit");
    let cancel = CancelFlag::default();
    let kind = |name: &str| {
        let category = category(name).expect("in the catalog");
        NamedKind { category, size: category.size }
    };
    let kinds = ["mango", "pineapple", "toy_giraffe", "watering_can", "stand_in_box"].map(kind);
    for (index, own) in kinds.iter().enumerate().take(4) {
        let size_m = 1.1 * own.size.typical_m();
        let recipe =
            Recipe { category: own.category.name.clone(), size_m, color: None, material: None, seed: 5 };
        let (image, reading) = seen(&build(&recipe).expect("a mesh"), 0.6);
        // The recognizer has no idea.
        let guesses = [Vec::new()];
        let fits =
            named_evidence(&image, &reading, &guesses, &kinds, &settings, &cancel).expect("not interrupted");
        let all = evidence(&image, &reading, &guesses, &settings, &cancel).expect("not interrupted");
        let named: Vec<NamedObject> = (0..kinds.len()).map(object).collect();
        let found = assign_named(&all, &fits, &[reading.objects[0].color], &named);
        assert_eq!(found.objects, [Some(index)], "{}: {fits:?}", own.category.name);
    }
}
