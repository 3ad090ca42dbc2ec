//! Grasp of an object by a parallel gripper.

use catalog::{Affordance, PhysicalProperties, category};
use geometry::parallel_grasp::{Gripper, ParallelGrasp, parallel_grasp};
use store::Digest;

use crate::pipeline::composition::FoundGrasp;
use crate::pipeline::resolve::Loaded;

/// Raised when [`grasp`] gives other results for the same object.
const SEARCH: &str = "parallel_grasp/1";

/// The grasp of an object: the `known` one if everything that decides it is as it was, otherwise a new one.
pub(super) fn known_or_found(
    known: Option<&FoundGrasp>,
    category_name: &str,
    physical: &PhysicalProperties,
    geometry: &Loaded,
) -> FoundGrasp {
    let key = key(category_name, physical, geometry);
    match known.filter(|known| known.key == key) {
        Some(known) => known.clone(),
        None => {
            let found = grasp(category_name, physical, geometry);
            FoundGrasp { key, contacts_m: found.map(|grasp| grasp.contacts_m) }
        }
    }
}

/// Of the shape, the hulls and what else the search reads.
fn key(category_name: &str, physical: &PhysicalProperties, geometry: &Loaded) -> Digest {
    let (mesh, hulls) = (&geometry.mesh, &geometry.hulls);
    let mut bytes = format!("{SEARCH} {category_name} ").into_bytes();
    bytes.extend(physical.friction.dynamic_coefficient.to_le_bytes());
    let points = [&physical.mass.center_of_mass_m].into_iter().chain(&mesh.positions);
    let points = points.chain(hulls.iter().flat_map(|hull| &hull.points));
    bytes.extend(points.flat_map(|point| point.to_array()).flat_map(f64::to_le_bytes));
    let corners = mesh.triangles().chain(hulls.iter().flat_map(|hull| hull.triangles.iter().copied()));
    bytes.extend(corners.flatten().flat_map(u32::to_le_bytes));
    Digest::of(&bytes)
}

/// A grasp of an object that the catalog says can be taken; `None` of others, and where a common gripper has no room.
fn grasp(category_name: &str, physical: &PhysicalProperties, geometry: &Loaded) -> Option<ParallelGrasp> {
    category(category_name).filter(|category| category.affords(Affordance::Graspable))?;
    let friction = physical.friction.dynamic_coefficient;
    let center_of_mass_m = physical.mass.center_of_mass_m;
    parallel_grasp(&geometry.solid, &geometry.hulls, center_of_mass_m, friction, Gripper::COMMON)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rayon::prelude::*;

    use super::*;
    use catalog::{Category, Recipe, build, categories, physical_properties};
    use geometry::convex_hull::{distance_above, planes};
    use geometry::decompose::{DecomposeSettings, decompose};
    use geometry::solid_query::MeshSolid;
    use geometry::{ConvexHull, DVec3, Friction};
    use runtime::CancelFlag;

    /// The catalog's object of typical size and its grasp.
    fn taken(category: &Category) -> (Loaded, Option<ParallelGrasp>) {
        let mesh = build(&Recipe::typical(&category.name, None, None).expect("a category")).expect("a mesh");
        let defaults: toml::Table =
            include_str!("../../../config/default.toml").parse().expect("our own file");
        let settings: DecomposeSettings = defaults["decompose"].clone().try_into().expect("our own section");
        let hulls = decompose(&mesh, &settings, &CancelFlag::default());
        let physical = physical_properties(&mesh, &category.name, None).expect("a mass");
        let loaded = Loaded {
            solid: Arc::new(MeshSolid::new(&mesh).expect("a solid")),
            hulls: hulls.expect("hulls").hulls,
            mesh: Arc::new(mesh),
        };
        let found = grasp(&category.name, &physical, &loaded);
        (loaded, found)
    }

    /// Whether samples of a box, `half` along `axes` about a point, lie outside all hulls.
    fn is_free(hulls: &[ConvexHull], center: DVec3, axes: [DVec3; 3], half: [f64; 3]) -> bool {
        let counts = [5, 9, 19];
        let at = |axis: usize, k: i32| {
            let share = 2.0 * f64::from(k) / f64::from(counts[axis] - 1) - 1.0;
            share * half[axis] * axes[axis]
        };
        let faces: Vec<_> = hulls.iter().map(planes).collect();
        (0..counts[0] * counts[1] * counts[2]).all(|k| {
            let (x, y, z) = (k % counts[0], k / counts[0] % counts[1], k / counts[0] / counts[1]);
            let p = center + at(0, x) + at(1, y) + at(2, z);
            faces.iter().all(|faces| distance_above(faces, p) > -1e-5)
        })
    }

    /// Whether two closed fingers of 10 x 20 x 45 mm, the pads 8 mm above their tips, touch nothing when they come
    /// along one of the directions in which hands come: from above, as much as the closing line allows, or from a side.
    fn fingers_fit(loaded: &Loaded, grasp: &ParallelGrasp) -> bool {
        let [a, b] = grasp.contacts_m;
        let closing = (b - a).normalize();
        let upright = (DVec3::Z - closing.z * closing).normalize_or_zero();
        let across = upright.cross(closing);
        let floor_m = loaded.solid.bounds().0.z;
        [upright, across, -across].into_iter().any(|up| {
            let axes = [closing, up.cross(closing), up];
            // Flat objects are taken between pads whose tips touch the table; tilted fingers reach it with an edge.
            let edge_m = 0.013 * closing.z.abs() + 0.01 * up.cross(closing).z.abs();
            let room_m = (a.z.min(b.z) - floor_m - edge_m) / up.z.max(0.3);
            let below_m = if up == upright { room_m.clamp(0.0, 0.008) } else { 0.008 };
            let along = (0.0225 - below_m) * up;
            [(a, -closing), (b, closing)].into_iter().all(|(pad, away)| {
                is_free(&loaded.hulls, pad + 0.0051 * away + along, axes, [0.005, 0.01, 0.0224])
            })
        })
    }

    /// Regression: contacts of vessels lay 48 to 182 mm below the rim, and fingers would have gone through their walls.
    #[test]
    fn fingers_of_every_grasp_touch_what_they_grasp_alone() {
        let graspable = categories().iter().filter(|category| category.affords(Affordance::Graspable));
        // All vessels, and a share of the others.
        let sample: Vec<&Category> = graspable
            .enumerate()
            .filter(|(k, category)| category.affords(Affordance::Container) || k % 6 == 0)
            .map(|(_, category)| category)
            .collect();
        let failures: Vec<String> = sample
            .par_iter()
            .filter_map(|category| {
                let (loaded, found) = taken(category);
                let fits = found.is_none_or(|grasp| fingers_fit(&loaded, &grasp));
                (!fits).then(|| format!("{}: {found:?}", category.name))
            })
            .collect();
        assert!(sample.len() > 40 && failures.is_empty(), "{failures:#?}");
    }

    #[test]
    fn a_grasp_is_searched_again_only_where_the_object_differs() {
        let (mut loaded, found) = taken(category("mug").expect("in the catalog"));
        let physical = physical_properties(&loaded.mesh, "mug", None).expect("a mass");
        let first = known_or_found(None, "mug", &physical, &loaded);
        assert_eq!(first.contacts_m, found.map(|grasp| grasp.contacts_m));
        let planted = FoundGrasp { contacts_m: Some([DVec3::X, DVec3::Y]), ..first.clone() };
        let known = |physical: &PhysicalProperties, loaded: &Loaded| {
            known_or_found(Some(&planted), "mug", physical, loaded).contacts_m
        };
        assert_eq!(known(&physical, &loaded), planted.contacts_m);
        let slippery = PhysicalProperties {
            friction: Friction { dynamic_coefficient: 0.1, ..physical.friction },
            ..physical
        };
        assert_ne!(known(&slippery, &loaded), planted.contacts_m);
        loaded.hulls[0].points[0].x += 1e-4;
        assert_ne!(known(&physical, &loaded), planted.contacts_m);
    }

    #[test]
    fn vessels_are_taken_near_the_rim_or_by_a_handle() {
        for name in ["mug", "bowl", "vase", "drinking_glass", "pitcher", "saucepan", "wine_bottle", "teacup"]
        {
            let category = category(name).expect("in the catalog");
            let (loaded, found) = taken(category);
            let [a, b] = found.unwrap_or_else(|| panic!("{name} has no grasp")).contacts_m;
            let top_m = loaded.solid.bounds().1.z;
            let depth_m = top_m - 0.5 * (a.z + b.z);
            let reach_m = (0.5 * (a + b)).truncate().length();
            let widest = loaded.mesh.positions.iter().map(|p| p.truncate().length()).fold(0.0, f64::max);
            assert!(depth_m < 0.038 || reach_m > 0.6 * widest, "{name}: {depth_m} m deep, {reach_m} m out");
        }
    }
}
