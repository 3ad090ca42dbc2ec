//! Place settings: the fork is left of the plate, the knife right of it and the spoon right of the knife, as the person
//! sees them who sits at the edge.

use glam::DVec3;

use super::*;

/// Texts, and how many settings they have.
const SETTINGS: &[(&str, usize)] = &[
    ("A dining table set for two", 2),
    ("A place setting", 1),
    ("a table with two place settings", 2),
    ("a table with four place settings", 4),
    ("a round table with three place settings", 3),
    ("place settings for four: plate, fork left, knife right, spoon right", 4),
];

/// The layout with everything that the text states, on the first table with room.
fn laid_out(text: &str, seed: u64) -> SampledLayout {
    let description = described(text, seed);
    let meshes = meshes(&description.objects);
    let model = description.table.model.clone().expect("the analyst names a model");
    let size_m = description.table.size_m.expect("the analyst gives a size");
    let objects = objects(&description.objects, &meshes);
    let stated = StatedDemands::of(&description);
    let on_grown = |growth: f64| {
        let size_m = (growth * size_m.truncate()).extend(size_m.z);
        let outline = build_table(&model, size_m, None, None, 1).expect("a model").outline_m;
        let problem = LayoutProblem {
            objects: &objects,
            stated: &stated,
            outline: &outline,
            max_yielding: Yielding::Nothing,
        };
        let outcome = lay_out(problem, seed, &settings(), &CancelFlag::default()).ok()?;
        Some((outline, outcome.poses))
    };
    let grown = [1.0, 1.15, 1.35, 1.6].into_iter().find_map(on_grown);
    let (outline, poses) = grown.unwrap_or_else(|| panic!("{text} ({seed}): no room"));
    SampledLayout { description, meshes, outline, poses }
}

impl SampledLayout {
    /// Position of an object for the person at a plate: to the right, and away from the person, meters.
    fn as_seen_from(&self, plate: usize, object: usize) -> DVec2 {
        let at = self.footprint(plate).center();
        // The shortest way out over the edge, to 4 mm.
        let way_out_m = |way: DVec2| {
            (1..1000)
                .map(|k| 0.004 * f64::from(k))
                .find(|&m| !self.outline.contains(at + m * way))
                .unwrap_or(9.0)
        };
        let ways = (0..120).map(|k| DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / 120.0));
        let nearest_m = ways.map(way_out_m).fold(f64::INFINITY, f64::min);
        // The person sits at an edge that is nearest, or nearly so.
        let inward = (self.poses[plate].rotation * DVec3::Y).truncate();
        let away_m = way_out_m(-inward);
        assert!(
            away_m < 1.2 * nearest_m + 0.01,
            "{away_m} m to the person, {nearest_m} m to the nearest edge"
        );
        let offset = self.footprint(object).center() - at;
        DVec2::new(offset.dot(-inward.perp()), offset.dot(inward))
    }

    /// Objects of a category with a relation to an object.
    fn at(&self, target: usize, category: &str) -> Vec<usize> {
        let objects = &self.description.objects;
        let id = &objects[target].id;
        let is_at = |k: &usize| {
            objects[*k].category == category
                && objects[*k].relations.iter().any(|relation| relation.target.as_ref() == Some(id))
        };
        (0..objects.len()).filter(is_at).collect()
    }
}

#[test]
fn cutlery_is_where_the_person_expects_it_at_every_setting() {
    let mut far = 0;
    for &(text, settings) in SETTINGS {
        for seed in 1..=2 {
            let layout = laid_out(text, seed);
            let objects = &layout.description.objects;
            let plates: Vec<usize> = (0..objects.len()).filter(|&k| objects[k].category == "plate").collect();
            assert_eq!(plates.len(), settings, "{text} ({seed})");
            let mut first = None;
            for plate in plates {
                let side = |category: &str| {
                    let at = layout.at(plate, category);
                    assert_eq!(at.len(), 1, "{text} ({seed}): {category} of {}", objects[plate].id);
                    layout.as_seen_from(plate, at[0])
                };
                let (fork, knife) = (side("fork"), side("knife"));
                let context = format!("{text} ({seed}): {}", objects[plate].id);
                assert!(fork.x < -0.05 && fork.y.abs() < -fork.x, "{context}: fork at {fork}");
                assert!(knife.x > 0.05 && knife.y.abs() < knife.x, "{context}: knife at {knife}");
                if text.contains("spoon") {
                    let spoon = side("spoon");
                    assert!(spoon.x > knife.x + 0.01, "{context}: spoon at {spoon}, knife at {knife}");
                }
                let (first_fork, first_knife) = *first.get_or_insert((fork, knife));
                let differs_m = fork.distance(first_fork).max(knife.distance(first_knife));
                assert!(differs_m < 0.03, "{context}: laid {differs_m} m otherwise than the first");
                far += usize::from(layout.footprint(plate).center().y > 0.1);
            }
        }
    }
    assert!(far > 3, "only {far} settings are at the far edge");
}
