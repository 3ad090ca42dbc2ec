//! A small sphere around spheres.

use nalgebra::Point3;

use super::arm::Sphere;

/// After this many steps the radius is within about a percent of the least.
const STEPS: usize = 200;

/// A sphere that encloses all of `spheres`, within about a percent of the smallest one.
///
/// The method is that of Badoiu and Clarkson, "Smaller core-sets for balls": the center moves towards the farthest
/// sphere by ever smaller shares.
pub fn enclosing_sphere(spheres: &[Sphere]) -> Sphere {
    let reach_m = |center: &Point3<f64>, sphere: &Sphere| (sphere.center_m - center).norm() + sphere.radius_m;
    let radius_m = |center: &Point3<f64>| spheres.iter().map(|s| reach_m(center, s)).fold(0.0, f64::max);
    let mut center_m = Point3::from(
        spheres.iter().map(|s| s.center_m.coords).sum::<nalgebra::Vector3<f64>>()
            / spheres.len().max(1) as f64,
    );
    let mut best = Sphere { center_m, radius_m: radius_m(&center_m) };
    for step in 1..=STEPS {
        let farthest = spheres.iter().max_by(|a, b| reach_m(&center_m, a).total_cmp(&reach_m(&center_m, b)));
        let Some(farthest) = farthest else { break };
        let towards = farthest.center_m - center_m;
        let distance_m = towards.norm();
        if distance_m == 0.0 {
            break;
        }
        // The farthest point of the farthest sphere, seen from the center.
        let point_m = center_m + towards * ((distance_m + farthest.radius_m) / distance_m);
        center_m += (point_m - center_m) / (step + 1) as f64;
        let now_m = radius_m(&center_m);
        if now_m < best.radius_m {
            best = Sphere { center_m, radius_m: now_m };
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_spheres_are_enclosed_tightly() {
        let spheres = [
            Sphere { center_m: Point3::new(0.0, 0.0, 0.0), radius_m: 0.1 },
            Sphere { center_m: Point3::new(1.0, 0.0, 0.0), radius_m: 0.3 },
        ];
        let around = enclosing_sphere(&spheres);
        for sphere in &spheres {
            assert!((sphere.center_m - around.center_m).norm() + sphere.radius_m <= around.radius_m + 1e-12);
        }
        assert!(around.radius_m < 0.7 * 1.01, "{around:?}");
    }

    #[test]
    fn one_sphere_encloses_itself() {
        let sphere = Sphere { center_m: Point3::new(0.1, 0.2, 0.3), radius_m: 0.05 };
        assert_eq!(enclosing_sphere(&[sphere]), sphere);
    }
}
