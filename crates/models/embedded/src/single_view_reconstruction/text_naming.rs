//! Names of the objects of an image: by the image alone, or with the help of a text that names what is in it.
//!
//! The recognizer guesses from the pixels, and its guesses are checked by their shapes and sizes.
//! With a text, the objects of the image are assigned to the named ones jointly ([`vision::category_fit`]). What is
//! left over keeps the category that the image alone gives it, except one that the text excludes. Stated sizes set
//! the scale of the image.

use catalog::{SizeRange, categories, category};
use imaging::Image;
use imaging::Mask;
use ports::{NamedObject, RecognitionHints};
use runtime::{CancelFlag, Cancelled};
use scene::instance::SupportRelation;
use vision::category_fit::{self, CategoryAssignment, CategoryFitSettings, CategoryMatch, NamedKind};
use vision::object_recognizer::CategoryGuess;
use vision::{ImageReading, ObjectReading};

/// Names of the objects of an image, in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectNames {
    /// The named object of the text that it is, by its index.
    pub named: Vec<Option<usize>>,
    /// Category of the object. For an object that the text names, the fit of that category, if its mesh could be
    /// compared.
    pub categories: Vec<Option<CategoryAssignment>>,
    /// Factor from the image's lengths to meters, if sizes are stated or typical sizes agree.
    pub scale: Option<f64>,
    /// Whether the factor comes from sizes that the text states.
    pub scale_is_stated: bool,
}

/// Relative half range of the sizes of an object with a stated size, and of a stand-in.
const STATED_SPREAD: f64 = 0.03;
const STAND_IN_SPREAD: f64 = 0.25;

/// Names the objects of a reading in meters; `guesses` are the recognizer's.
///
/// # Errors
///
/// [`Cancelled`] if `cancel` was set.
pub fn name_objects(
    image: &Image,
    reading: &ImageReading,
    guesses: &[Vec<CategoryGuess>],
    hints: Option<&RecognitionHints>,
    settings: &CategoryFitSettings,
    cancel: &CancelFlag,
) -> Result<ObjectNames, Cancelled> {
    let evidence = category_fit::evidence(image, reading, guesses, settings, cancel)?;
    let Some(hints) = hints else {
        let naming = category_fit::assign_categories(&evidence, settings, |_, _| true);
        let named = vec![None; evidence.len()];
        let category_fit::Naming { objects, scale } = naming;
        return Ok(ObjectNames { named, categories: objects, scale, scale_is_stated: false });
    };
    let (kinds, named) = kinds_of(hints.named());
    let fits = category_fit::named_evidence(image, reading, guesses, &kinds, settings, cancel)?;
    let colors: Vec<_> = reading.objects.iter().map(|object| object.color).collect();
    let assigned = category_fit::assign_named(&evidence, &fits, &colors, &named).objects;
    let is_absent = |category: &str| hints.absent().iter().any(|absent| absent == category);
    let others = category_fit::assign_categories(&evidence, settings, |object, category| {
        assigned[object].is_none() && !is_absent(category)
    });
    let fit = |object: usize, hint: usize| fits[object][named[hint].kind].clone();
    let stated = stated_scale(hints, &assigned, fit);
    let of_text = |object: usize, hint: usize| {
        fit(object, hint).map(|category_match| CategoryAssignment { category_match, confidence: 1.0 })
    };
    let categories: Vec<Option<CategoryAssignment>> = assigned
        .iter()
        .zip(others.objects)
        .enumerate()
        .map(|(object, (hint, other))| hint.map_or(other, |hint| of_text(object, hint)))
        .collect();
    let scale = stated.or_else(|| category_fit::vote(&categories));
    Ok(ObjectNames { named: assigned, categories, scale, scale_is_stated: stated.is_some() })
}

/// The different kinds of the named objects, and the kind of each.
fn kinds_of(named: &[NamedObject]) -> (Vec<NamedKind>, Vec<category_fit::NamedObject>) {
    let mut kinds: Vec<NamedKind> = Vec::new();
    let mut objects = Vec::with_capacity(named.len());
    for object in named {
        // Descriptions have categories of the catalog; a plain body stands for any other.
        let category = category(&object.category).or_else(|| category("stand_in_box"));
        let Some(category) = category.or(categories().first()) else { continue };
        let around = |spread: f64| SizeRange {
            low_m: object.size_m * (1.0 - spread),
            high_m: object.size_m * (1.0 + spread),
        };
        let size = match (object.size_is_stated, object.stand_in.is_some()) {
            (true, _) => around(STATED_SPREAD),
            (false, true) => around(STAND_IN_SPREAD),
            (false, false) => category.size,
        };
        let is_known = |kind: &NamedKind| kind.category.name == category.name && kind.size == size;
        let kind = kinds.iter().position(is_known).unwrap_or_else(|| {
            kinds.push(NamedKind { category, size });
            kinds.len() - 1
        });
        objects.push(category_fit::NamedObject { kind, color: object.color });
    }
    (kinds, objects)
}

/// The scale by the median of the objects whose size the text states.
fn stated_scale(
    hints: &RecognitionHints,
    assigned: &[Option<usize>],
    fit: impl Fn(usize, usize) -> Option<CategoryMatch>,
) -> Option<f64> {
    let stated = |hint: &usize| hints.named()[*hint].size_is_stated;
    let pairs =
        assigned.iter().enumerate().filter_map(|(object, hint)| Some((object, (*hint).filter(stated)?)));
    let mut oversizes: Vec<f64> =
        pairs.filter_map(|(object, hint)| fit(object, hint)).map(|found| found.oversize).collect();
    oversizes.sort_by(f64::total_cmp);
    oversizes.get(oversizes.len() / 2).map(|median| (-median).exp())
}

/// Corrects the supports of a reading by those that the text states, where the pixels permit it: the boxes of both
/// objects meet. Returns how each object is carried.
pub(super) fn state_supports(
    reading: &mut ImageReading,
    hints: &RecognitionHints,
    named: &[Option<usize>],
) -> Vec<SupportRelation> {
    let mut relations = vec![SupportRelation::On; reading.objects.len()];
    for (object, hint) in named.iter().enumerate() {
        let Some((relation, supporter)) = hint.and_then(|hint| hints.named()[hint].supporter.as_ref()) else {
            continue;
        };
        let is_supporter =
            |hint: &Option<usize>| hint.is_some_and(|hint| &hints.named()[hint].id == supporter);
        let Some(below) = named.iter().position(is_supporter) else { continue };
        let objects = &mut reading.objects;
        if below != object
            && meet(&objects[object].mask, &objects[below].mask)
            && !rests_on(objects, below, object)
        {
            objects[object].stands_on = Some(below);
            relations[object] = *relation;
        }
    }
    relations
}

/// Whether `object` rests on `base`, directly or indirectly.
fn rests_on(objects: &[ObjectReading], object: usize, base: usize) -> bool {
    let mut at = Some(object);
    for _ in 0..=objects.len() {
        match at {
            Some(here) if here == base => return true,
            Some(here) => at = objects[here].stands_on,
            None => return false,
        }
    }
    true
}

/// Whether the boxes of two masks overlap or nearly touch.
fn meet(a: &Mask, b: &Mask) -> bool {
    let (Some(a), Some(b)) = (a.bbox_px(), b.bbox_px()) else { return false };
    let gap = |low_a: u32, high_a: u32, low_b: u32, high_b: u32| {
        low_a.saturating_sub(high_b).max(low_b.saturating_sub(high_a))
    };
    let slack = ((a[3] - a[1]).min(b[3] - b[1]) / 10).max(2);
    gap(a[0], a[2], b[0], b[2]) <= slack && gap(a[1], a[3], b[1], b[3]) <= slack
}
