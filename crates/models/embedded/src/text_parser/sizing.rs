//! Object sizes: a random sample from the category's range, adjusted by the text.

use glam::DVec3;

use super::draft::{Draft, DraftRelation};
use super::measured_size;
use super::measures::Measure;
use catalog::Affordance;
use runtime::seed::child_rng;
use scene::RelationKind;

/// Sets every size. The random sample of an object depends only on the seed and its name. Returns the objects whose
/// stated measures are outside the range of their category.
pub(super) fn size(draft: &mut Draft) -> Vec<usize> {
    let mut out_of_range = Vec::new();
    for k in 0..draft.objects.len() {
        let category = draft.category(k);
        let object = &draft.objects[k];
        let mut rng = child_rng(draft.seed, object.id.as_str());
        let range = object.kind.size;
        let typical = range.typical_m();
        let (low, high) = (range.low_m, range.high_m);
        let attributes = &object.attributes;
        let mut size = range.sample(&mut rng);
        if (attributes.scale - 1.0).abs() > 1e-9 {
            // "small" starts from the smaller half, "large" from the larger; a little beyond the range.
            let end = if attributes.scale < 1.0 { low } else { high };
            size = (0.5 * (size + end) * attributes.scale.sqrt()).clamp(0.8 * low, 1.25 * high);
        }
        for &(axis, factor) in &attributes.stretches {
            let k = match axis {
                'x' => 0,
                'y' => 1,
                'z' => 2,
                _ => usize::from(size.y > size.x),
            };
            size[k] = (size[k] * factor).clamp(0.8 * low[k], 1.25 * high[k]);
        }
        // Round and square objects keep equal width and depth, cubes and balls all three extents.
        let as_deep_as_wide = low.x == low.y && high.x == high.y;
        let as_high = as_deep_as_wide && low.x == low.z && high.x == high.z;
        let is_proportional = attributes.stretches.is_empty() && attributes.measures.len() < 2;
        if is_proportional && as_deep_as_wide && !attributes.measures.is_empty() {
            let mean_m = 0.5 * (size.x + size.y);
            size = DVec3::new(mean_m, mean_m, if as_high { mean_m } else { size.z });
        }
        let is_container = category.affords(Affordance::Container);
        if let (Some(volume_m3), true) =
            (attributes.volume_m3, is_container && attributes.measures.is_empty())
        {
            let factor = (volume_m3 / (CONTENT_SHARE * size.element_product())).cbrt();
            let wanted = factor * size;
            size = wanted.clamp(typical / 3.0, typical * 3.0);
            if (size - wanted).abs().max_element() > 1e-9 {
                out_of_range.push(k);
            }
        }
        let mut is_clamped = false;
        if !attributes.measures.is_empty() {
            let wanted = measured_size::apply(&attributes.measures, size);
            size = wanted.clamp(typical / 3.0, typical * 3.0);
            is_clamped = (size - wanted).abs().max_element() > 1e-9;
        }
        if is_clamped || attributes.mass_kg.is_some_and(|mass_kg| !MASSES_KG.contains(&mass_kg)) {
            out_of_range.push(k);
        }
        if as_deep_as_wide && is_proportional {
            size.x = 0.5 * (size.x + size.y);
            size.y = size.x;
        }
        let object = &mut draft.objects[k];
        object.size_m = size;
        // Ounces of what contains something are a volume.
        if is_container && object.attributes.volume_m3.is_some() {
            object.attributes.mass_kg = None;
        }
        if object.attributes.mass_kg.is_some_and(|mass_kg| !MASSES_KG.contains(&mass_kg)) {
            object.attributes.mass_kg = None;
        }
    }
    make_stacks_stable(draft);
    containers_hold_their_contents(draft);
    carriers_show_below_what_lies_on_them(draft);
    out_of_range
}

/// Objects whose stated lengths exclude each other: two heights, or a cube of two lengths.
pub(super) fn contradictions(draft: &Draft) -> Vec<usize> {
    let differ = |a: &Measure, b: &Measure| (a.meters - b.meters).abs() > 1e-6;
    let contradicts = |&object: &usize| {
        let measures = &draft.objects[object].attributes.measures;
        let range = draft.objects[object].kind.size;
        let is_cubic =
            range.low_m == DVec3::splat(range.low_m.x) && range.high_m == DVec3::splat(range.high_m.x);
        measures
            .iter()
            .enumerate()
            .any(|(k, a)| measures[..k].iter().any(|b| (a.axis == b.axis || is_cubic) && differ(a, b)))
    };
    (0..draft.objects.len()).filter(contradicts).collect()
}

/// Share of the bounding box of a vessel that is its content: a cylinder with walls.
const CONTENT_SHARE: f64 = 0.6;

/// Range of stated masses, kilograms.
const MASSES_KG: std::ops::RangeInclusive<f64> = 0.001..=30.0;

/// Maximum factor by which a container exceeds its usual size to hold its contents.
const MAX_GROWTH: f64 = 1.7;

/// Share of a container's outer width that is free at the height of round contents.
const FREE_WIDTH: f64 = 0.76;

/// Share of a container's outer length that is free for long contents.
const FREE_LENGTH: f64 = 0.85;

/// Enlarges containers whose size the text leaves open until their contents lie side by side (a bowl for three apples,
/// a basket for a baguette). Only containers in which contents lie grow in length: in a mug or a pen holder, slender
/// objects are upright and lean.
fn containers_hold_their_contents(draft: &mut Draft) {
    for host in 0..draft.objects.len() {
        let attributes = &draft.objects[host].attributes;
        let open = attributes.measures.is_empty() && attributes.stretches.is_empty();
        if !open || !draft.category(host).affords(Affordance::Container) {
            continue;
        }
        let inside = |relation: &DraftRelation| {
            relation.to == Some(host) && matches!(relation.kind, RelationKind::In | RelationKind::On)
        };
        let (mut widths, mut longest_m) = (Vec::new(), 0.0_f64);
        for object in &draft.objects {
            if !object.relations.iter().any(inside) {
                continue;
            }
            let mut extents = object.size_m.to_array();
            extents.sort_by(f64::total_cmp);
            if extents[2] <= 2.5 * extents[1] {
                widths.push((extents[1] * extents[2]).sqrt());
            } else {
                longest_m = longest_m.max(extents[2]);
            }
        }
        let is_carrier = draft.category(host).group == "carrier";
        let size = &mut draft.objects[host].size_m;
        if !widths.is_empty() {
            let mean_m = widths.iter().sum::<f64>() / widths.len() as f64;
            let needed_m = enclosing_circle(widths.len()) * mean_m / FREE_WIDTH;
            let growth = (needed_m / size.x.min(size.y)).clamp(1.0, MAX_GROWTH);
            *size *= DVec3::new(growth, growth, growth.sqrt());
        }
        if is_carrier {
            size.x *= (longest_m / FREE_LENGTH / size.x).clamp(1.0, MAX_GROWTH);
        }
    }
}

/// Maximum factor by which a carrier exceeds its usual size to show below what lies on it.
const MAX_CARRIER_GROWTH: f64 = 1.8;

/// Width of a carrier over that of what would cover it: the border that shows.
const SHOWN_BORDER: f64 = 1.08;

/// Height as a share of the smaller width below which an object lies flat and can cover its supporter.
const FLAT: f64 = 0.35;

/// Enlarges carriers whose size the text leaves open and which what lies flat on them would cover whole (a plate below
/// a pizza): no image shows them. Where that would take more than the maximum, the carrier stays as it is.
fn carriers_show_below_what_lies_on_them(draft: &mut Draft) {
    for host in 0..draft.objects.len() {
        let attributes = &draft.objects[host].attributes;
        let is_open = attributes.measures.is_empty() && attributes.stretches.is_empty();
        if !is_open || !draft.category(host).affords(Affordance::Support) {
            continue;
        }
        let [short_m, long_m] = footprint_m(draft.objects[host].size_m);
        let covering =
            |relation: &DraftRelation| relation.to == Some(host) && matches!(relation.kind, RelationKind::On);
        let growth = draft
            .objects
            .iter()
            .filter(|object| object.relations.iter().any(covering))
            .map(|object| (footprint_m(object.size_m), object.size_m.z))
            .filter(|&([short, long], high)| short >= short_m && long >= long_m && high < FLAT * short)
            .map(|([short, long], _)| SHOWN_BORDER * f64::max(short / short_m, long / long_m))
            .fold(1.0, f64::max);
        if growth <= MAX_CARRIER_GROWTH {
            draft.objects[host].size_m *= DVec3::new(growth, growth, 1.0);
        }
    }
}

/// Width and depth, the shorter first.
fn footprint_m(size_m: DVec3) -> [f64; 2] {
    [size_m.x.min(size_m.y), size_m.x.max(size_m.y)]
}

/// Diameter of the smallest circle that holds `count` circles of diameter 1 (Graham et al., "Dense
/// packings of congruent circles in a circle", 1998, rounded up).
fn enclosing_circle(count: usize) -> f64 {
    const KNOWN: [f64; 8] = [0.0, 1.0, 2.0, 2.155, 2.415, 2.702, 3.0, 3.0];
    KNOWN.get(count).copied().unwrap_or_else(|| 1.17 * (count as f64).sqrt())
}

/// Sorts stacks so that larger objects are below. Vessels that are stacked are a set of one shape: a foot that is as
/// wide as the rim below stands on it, another one tips over it or falls inside.
fn make_stacks_stable(draft: &mut Draft) {
    for bottom in 0..draft.objects.len() {
        let mut pile = vec![bottom];
        while let Some(next) = (0..draft.objects.len()).find(|&o| {
            !pile.contains(&o) && draft.objects[o].has(RelationKind::StackedOn, pile.last().copied())
        }) {
            pile.push(next);
        }
        let is_bottom =
            !draft.objects[bottom].relations.iter().any(|relation| relation.kind == RelationKind::StackedOn);
        let alike = pile.iter().all(|&o| draft.category(o).name == draft.category(bottom).name);
        if pile.len() < 2 || !is_bottom || !alike {
            continue;
        }
        let mut sizes: Vec<_> = pile.iter().map(|&o| draft.objects[o].size_m).collect();
        sizes.sort_by(|a, b| (b.x * b.y).total_cmp(&(a.x * a.y)));
        let are_open = pile.iter().all(|&object| {
            let attributes = &draft.objects[object].attributes;
            let is_scaled = (attributes.scale - 1.0).abs() > 1e-9 || !attributes.stretches.is_empty();
            !is_scaled && attributes.measures.is_empty() && attributes.volume_m3.is_none()
        });
        let is_set = are_open && draft.category(bottom).group == "vessel";
        for (&object, size) in pile.iter().zip(&sizes) {
            let object = &mut draft.objects[object];
            object.size_m = if is_set { sizes[0] } else { *size };
            object.shape_of = is_set.then_some(bottom);
        }
    }
}
