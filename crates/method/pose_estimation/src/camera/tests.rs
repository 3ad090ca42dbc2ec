//! Wrong camera angles are recovered from rendered silhouettes; exact ones stay; a mesh of the wrong shape has no
//! effect.

use super::*;
use crate::yaw::tests::settings;
use geometry::{Material, Pose, Rgb, shapes};
use render::{RenderObject, View, render_geometry};

const DEGREE_RAD: f64 = std::f64::consts::PI / 180.0;

fn camera() -> Camera {
    Camera::orbit(800, 600, 0.61, DVec3::new(0.0, 0.0, -0.2), 0.15, 0.7, 3.0)
}

/// A top on four legs, world frame.
fn table() -> TexturedMesh {
    let material = Material::plain("gray", Rgb::hex(0x808080), 0.5);
    let mut mesh = TexturedMesh::default();
    let mut block = |size: DVec3, at: DVec3| {
        let mut part = TexturedMesh::default();
        part.add(shapes::block(size), &material);
        mesh.append(part.translated(at));
    };
    block(DVec3::new(1.2, 0.7, 0.04), DVec3::new(0.0, 0.0, -0.04));
    for (x, y) in [(-0.55, -0.3), (0.55, -0.3), (-0.55, 0.3), (0.55, 0.3)] {
        block(DVec3::new(0.05, 0.05, 0.68), DVec3::new(x, y, -0.72));
    }
    mesh
}

fn objects() -> Vec<(TexturedMesh, Pose)> {
    let names = ["mug", "book", "plate", "stapler", "bowl"];
    let built = |(k, name): (usize, &&str)| {
        let category = catalog::category(name).expect("in the catalog");
        let recipe = catalog::Recipe {
            category: (*name).to_owned(),
            size_m: category.size.typical_m(),
            color: None,
            material: None,
            seed: 3,
        };
        let mesh = catalog::build(&recipe).expect("builds");
        let at = DVec3::new(-0.45 + 0.22 * k as f64, 0.15 - 0.1 * (k % 3) as f64, 0.0);
        (mesh, Pose::upright(at, 0.9 * k as f64))
    };
    names.iter().enumerate().map(built).collect()
}

struct ObservedScene {
    table: TexturedMesh,
    objects: Vec<(TexturedMesh, Pose)>,
    table_mask: Mask,
    masks: Vec<Mask>,
    all: Mask,
    none: Mask,
}

fn seen() -> ObservedScene {
    let (table, objects) = (table(), objects());
    let mut placed = vec![RenderObject { mesh: &table, world_from_object: Pose::IDENTITY, id: 1 }];
    placed.extend(objects.iter().zip(2..).map(|((mesh, pose), id)| RenderObject {
        mesh,
        world_from_object: *pose,
        id,
    }));
    let frame = render_geometry(&placed, &View::Perspective(camera()));
    let table_mask = frame.mask(1);
    let masks: Vec<Mask> = (0..objects.len()).map(|k| frame.mask(k as u32 + 2)).collect();
    let none = Mask::empty(800, 600);
    let mut all = none.clone();
    masks.iter().for_each(|mask| all.unite(mask));
    ObservedScene { table, objects, table_mask, masks, all, none }
}

impl ObservedScene {
    fn refined(&self, camera: &Camera, with_table: bool) -> RefinedCamera {
        let table = with_table.then_some(ObservedMesh {
            mesh: &self.table,
            mask: &self.table_mask,
            unknown: &self.all,
            support_height_m: self.table.bounds().0.z,
        });
        let objects = self.objects.iter().zip(&self.masks);
        let objects = objects
            .map(|((mesh, _), mask)| ObservedMesh { mesh, mask, unknown: &self.none, support_height_m: 0.0 })
            .collect();
        let problem = CameraProblem { camera, table, objects };
        refine_camera(&problem, &settings(), &CancelFlag::default()).expect("not interrupted")
    }
}

/// Of azimuth and elevation, degrees.
fn off_deg(found: &RefinedCamera) -> [f64; 2] {
    let truth = camera();
    let azimuth = found.camera.azimuth_rad() - truth.azimuth_rad();
    let elevation = found.camera.elevation_rad() - truth.elevation_rad();
    [azimuth.abs() / DEGREE_RAD, elevation.abs() / DEGREE_RAD]
}

#[test]
fn table_determines_both_angles_and_keeps_exact_camera() {
    let seen = seen();
    for (azimuth, elevation) in [(0.0, 0.0), (2.0, 5.0), (-2.0, -5.0), (1.3, -3.0)] {
        let given = camera().orbited(azimuth * DEGREE_RAD, elevation * DEGREE_RAD);
        let found = seen.refined(&given, true);
        assert_eq!(found.witness, CameraWitness::Table);
        let off = off_deg(&found);
        assert!(off[0] < 0.3 && off[1] < 0.5, "{azimuth} {elevation}: {off:?} {found:?}");
    }
}

#[test]
fn objects_determine_elevation_without_table() {
    let seen = seen();
    for elevation in [0.0, 4.0, -4.0] {
        let found = seen.refined(&camera().orbited(0.0, elevation * DEGREE_RAD), false);
        assert_eq!(found.witness, CameraWitness::Objects);
        assert!(off_deg(&found)[1] < 1.0, "{elevation}: {found:?}");
    }
}

#[test]
fn refine_camera_is_robust_to_one_bad_mesh() {
    let mut seen = seen();
    seen.objects[0].0 = seen.objects[0].0.clone().scaled(DVec3::new(1.0, 1.0, 1.6));
    let found = seen.refined(&camera().orbited(0.0, 3.0 * DEGREE_RAD), false);
    assert!(off_deg(&found)[1] < 1.5, "{found:?}");
    // A table of a different shape has no effect either: the objects are used instead.
    seen.table = seen.objects[1].0.clone().scaled(DVec3::new(0.3, 4.0, 0.2));
    assert_ne!(seen.refined(&camera(), true).witness, CameraWitness::Table);
}

#[test]
fn refine_camera_does_not_depend_on_thread_count() {
    let seen = seen();
    let given = camera().orbited(0.02, -0.05);
    let on = |threads: usize, table: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| seen.refined(&given, table))
    };
    for table in [true, false] {
        assert_eq!(on(1, table), on(3, table));
    }
}
