//! Tests of eight configurations at a time against forward kinematics.

use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::kinematics::link_poses;
use crate::model::sphere_model::Spheres8;

#[test]
fn spheres_of_eight_configurations_are_where_forward_kinematics_puts_them() {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    for (name, opening_m) in [("panda", 0.05), ("piper", 0.02)] {
        let robot = Robot::built_in(name, None).expect("built in");
        let arm = ArmSpheres::new(&robot, opening_m);
        let configurations: Vec<Vec<f64>> = (0..8)
            .map(|_| {
                robot.limits().iter().map(|l| random.random_range(l.min_position..l.max_position)).collect()
            })
            .collect();
        let positions: Vec<f32x8> = (0..robot.dof())
            .map(|joint| f32x8::from(std::array::from_fn(|lane| configurations[lane][joint] as f32)))
            .collect();
        let mut spheres = Spheres8::default();
        arm.place_spheres8(&positions, &mut spheres);
        assert_eq!(spheres.x_m.len(), arm.spheres().len());
        for (lane, configuration) in configurations.iter().enumerate() {
            let poses = link_poses(&robot, configuration, opening_m);
            for (i, sphere) in arm.spheres().iter().enumerate() {
                let expected = poses[sphere.link] * Point3::from(sphere.center_m.map(f64::from));
                let [x, y, z] = [&spheres.x_m, &spheres.y_m, &spheres.z_m].map(|l| l[i].to_array()[lane]);
                let computed = Point3::new(f64::from(x), f64::from(y), f64::from(z));
                assert!((computed - expected).norm() < 3e-6, "{name} sphere {i}: {computed} {expected}");
            }
        }
    }
}

#[test]
fn bounding_spheres_contain_the_spheres_of_their_links() {
    let robot = Robot::built_in("panda", None).expect("built in");
    let held = LinkSphere { link: robot.tool().link, center_m: [0.0, 0.0, 0.2], radius_m: 0.05 };
    let arm = ArmSpheres::new(&robot, 0.08).with_attached(&[held]);
    assert!(arm.spheres().contains(&held));
    assert!(arm.spheres().is_sorted_by_key(|sphere| sphere.link));
    for sphere in arm.spheres() {
        let bound =
            arm.bounding_spheres().iter().find(|bound| bound.link == sphere.link).expect("one a link");
        let apart = Vector3::from(bound.center_m) - Vector3::from(sphere.center_m);
        assert!(apart.norm() + sphere.radius_m <= bound.radius_m + 1e-6);
    }
}

#[test]
fn joint_about_x_turns_like_forward_kinematics() {
    let text = include_str!("../../../tests/robots/gantry.toml");
    let robot = Robot::parse(text, "gantry.toml", None).expect("a robot");
    let arm = ArmSpheres::new(&robot, 0.0);
    let configuration = [0.3, -0.7];
    let positions: Vec<f32x8> = configuration.iter().map(|q| f32x8::splat(*q as f32)).collect();
    let mut poses = LinkPoses8::default();
    arm.place_links8(&positions, &mut poses);
    for (pose, expected) in poses.links.iter().zip(link_poses(&robot, &configuration, 0.0)) {
        let point = expected * Point3::new(0.1, 0.2, 0.3);
        for (computed, expected) in pose.place([0.1, 0.2, 0.3]).iter().zip(point.iter()) {
            assert!((f64::from(computed.to_array()[5]) - expected).abs() < 1e-6);
        }
    }
}
