//! A small scene made by hand, and what must hold for the files written from it.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DQuat, DVec2, DVec3};

use geometry::decompose::HullFit;
use geometry::parallel_grasp::ParallelGrasp;
use geometry::repair::Repair;
use geometry::{
    Camera, ConvexHull, Friction, MassProperties, Material, Outline, Pose, Rgb, TexturedMesh, shapes,
};
use imaging::{Image, Texture};
use scene::appraisal::{Appraisal, Criterion, Opinion, ProposedTask, Rating, TaskKind};
use scene::certificate::{
    Appearance, BodyHealth, Concession, Displacement, Displacements, Fidelity, GaveWay, HealthThresholds,
    MadeWith, MethodShare, Metrics, ObjectCertificate, Region, Regions, ResolveFinding, RotationFinding,
    Thresholds, Verdict,
};
use scene::finished::Frame;
use scene::instance::{Picture, SupportRelation};
use scene::request::RequestOptions;
use scene::{
    Certificate, Input, Instance, InstanceId, Provenance, ReconstructionMethod, Scene, SceneRequest, Support,
    Table, TableShape,
};

use super::*;
use imaging::codec::encode_png;

/// A label that breaks every writer that pastes strings together.
const NASTY_LABEL: &str = "a \"red\" <b>mug</b> & 'co'\n--> ]]> \\ {rows} | 🍎\u{7}";

pub(super) fn settings(usd: UsdForm) -> ExportSettings {
    ExportSettings {
        usd,
        author: "tabletopgen".into(),
        licence: "CC0-1.0".into(),
        date: "2026-01-01".into(),
        gravity_m_s2: 9.81,
        mujoco_timestep_s: 0.002,
        mujoco_impratio: 10.0,
        usd_dome_intensity: 600.0,
        usd_sun_intensity: 1800.0,
    }
}

/// Eight corners: the lower four counter-clockwise from above, then the upper four.
fn hexahedron(points: [DVec3; 8]) -> ConvexHull {
    let quads = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    ConvexHull { points: points.to_vec(), triangles }
}

fn box_hull(low: DVec3, high: DVec3) -> ConvexHull {
    let corner = |x: bool, y: bool, z: bool| {
        DVec3::new(
            if x { high.x } else { low.x },
            if y { high.y } else { low.y },
            if z { high.z } else { low.z },
        )
    };
    hexahedron([
        corner(false, false, false),
        corner(true, false, false),
        corner(true, true, false),
        corner(false, true, false),
        corner(false, false, true),
        corner(true, false, true),
        corner(true, true, true),
        corner(false, true, true),
    ])
}

/// A floor and a ring of wedges.
fn cup_hulls(radius_m: f64, height_m: f64, wall_m: f64, segments: usize) -> Vec<ConvexHull> {
    let ring = |radius: f64, z: f64, k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / segments as f64;
        DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    let inner_m = radius_m - wall_m;
    let mut hulls: Vec<ConvexHull> = (0..segments)
        .map(|k| {
            let level = |z| {
                [ring(inner_m, z, k), ring(radius_m, z, k), ring(radius_m, z, k + 1), ring(inner_m, z, k + 1)]
            };
            let ([a, b, c, d], [e, f, g, h]) = (level(0.0), level(height_m));
            hexahedron([a, b, c, d, e, f, g, h])
        })
        .collect();
    let side = inner_m * std::f64::consts::FRAC_1_SQRT_2;
    hulls.push(box_hull(DVec3::new(-side, -side, 0.0), DVec3::new(side, side, wall_m)));
    hulls
}

fn box_mass(mass_kg: f64, size: DVec3, center_of_mass_m: DVec3) -> MassProperties {
    let s = size * size;
    MassProperties {
        mass_kg,
        center_of_mass_m,
        inertia_diagonal_kg_m2: DVec3::new(s.y + s.z, s.x + s.z, s.x + s.y) * mass_kg / 12.0,
        principal_axes_xyzw: DQuat::IDENTITY,
    }
}

fn checkered(color: [u8; 4]) -> Texture {
    let mut picture = Image::filled(64, 64, color);
    for y in 0..64 {
        for x in 0..64 {
            if (x / 16 + y / 8) % 2 == 0 {
                picture.set_pixel(x, y, [240, 235, (y * 3) as u8, 255]);
            }
        }
    }
    Texture::new(picture)
}

/// A table of five boxes, a mug in which a ball rests on nothing but the floor, a turned box beside it.
pub(super) fn specimen() -> (Scene, Certificate, Assets, Pictures) {
    let friction = Friction { static_coefficient: 0.6, dynamic_coefficient: 0.5 };
    let wood = Material::textured("wood", checkered([150, 100, 60, 255]), 0.6);
    let mut table = TexturedMesh::default();
    let mut table_hulls = Vec::new();
    let mut add_part = |low: DVec3, high: DVec3| {
        let solid = shapes::block(high - low).translated(0.5 * (low + high).with_z(2.0 * low.z));
        table.add(solid.with_box_uvs(0.4), &wood);
        table_hulls.push(box_hull(low, high));
    };
    add_part(DVec3::new(-0.5, -0.3, -0.03), DVec3::new(0.5, 0.3, 0.0));
    for (x, y) in [(-0.48, -0.28), (0.42, -0.28), (-0.48, 0.22), (0.42, 0.22)] {
        add_part(DVec3::new(x, y, -0.72), DVec3::new(x + 0.06, y + 0.06, -0.03));
    }
    let profile = [(0.03, 0.0), (0.04, 0.0), (0.04, 0.09)].map(|(x, y)| DVec2::new(x, y));
    let mut mug = TexturedMesh::default();
    let glaze = Material::plain("glaze", Rgb::hex(0xb03028), 0.3);
    mug.add(shapes::shell_of_revolution(&profile, 0.005, 0.005, 32), &glaze);
    let mut steel = Material::metal("steel", Rgb::hex(0xc0c4c8), 0.25);
    steel.opacity = 0.8;
    mug.add(shapes::block(DVec3::new(0.02, 0.01, 0.05)).translated(DVec3::new(0.049, 0.0, 0.02)), &steel);
    let mut crate_mesh = TexturedMesh::default();
    let size = DVec3::new(0.12, 0.08, 0.05);
    crate_mesh.add(shapes::block(size), &Material::textured("print", checkered([40, 90, 160, 255]), 0.7));

    let mug_size = mug.size_m();
    let mut mug_mass = box_mass(0.3, DVec3::new(0.08, 0.08, 0.09), DVec3::new(0.004, 0.0, 0.04));
    // Unequal moments about turned axes, so that a wrong axis order shows.
    mug_mass.inertia_diagonal_kg_m2 = DVec3::new(3.1e-4, 3.6e-4, 4.2e-4);
    mug_mass.principal_axes_xyzw = DQuat::from_xyzw(0.1, -0.3, 0.2, 0.9).normalize();
    let mut mug_hulls = cup_hulls(0.04, 0.09, 0.005, 16);
    mug_hulls.push(box_hull(DVec3::new(0.039, -0.005, 0.02), DVec3::new(0.059, 0.005, 0.07)));
    let instance =
        |name: &str, label: &str, category: &str, pose: Pose, mass, size_m, hulls: usize| Instance {
            name: InstanceId::new(name).expect("a name"),
            label: label.into(),
            category: category.into(),
            picture: Picture { bbox_px: [10, 20, 200, 180] },
            world_from_object: pose,
            yaw_rad: pose.yaw_rad(),
            symmetry_order: 1,
            scale: DVec3::ONE,
            size_m,
            mass,
            friction,
            restitution: 0.1,
            support: Support { parent: "table".into(), relation: SupportRelation::On },
            hulls: hulls as u32,
            mesh: format!("glb/{name}.glb"),
            provenance: Provenance {
                mesh_by: "by hand".into(),
                licence: "CC0-1.0".into(),
                notes: vec![NASTY_LABEL.into()],
            },
        };
    let instances = vec![
        instance(
            "mug_1",
            NASTY_LABEL,
            "mug",
            Pose::upright(DVec3::new(-0.1, 0.05, 0.0), 0.7),
            mug_mass,
            mug_size,
            mug_hulls.len(),
        ),
        instance(
            "box_1",
            "box of pencils",
            "box",
            Pose::upright(DVec3::new(0.15, -0.04, 0.0), -0.4),
            box_mass(0.2, size, DVec3::new(0.0, 0.0, 0.025)),
            size,
            1,
        ),
    ];
    let metrics = Metrics { col_o: 0.0, col_s: 0.0, ss: 1.0, dss_aligned: 1.0, dss_shipped: 1.0 };
    let scene = Scene {
        format: Scene::FORMAT.into(),
        id: "specimen0001".into(),
        seed: 7,
        request: SceneRequest {
            version: SceneRequest::VERSION,
            input: Input::Text { text: NASTY_LABEL.into() },
            seed: 7,
            options: RequestOptions::default(),
        },
        frame: Frame::world(),
        camera: Camera::orbit(640, 480, 0.7, DVec3::new(0.0, 0.0, 0.02), 0.0, 0.8, 1.6),
        table: Table {
            name: "table".into(),
            label: "desk".into(),
            shape: TableShape::Rectangular,
            outline_m: Outline::new(shapes::rectangle(1.0, 0.6)).expect("a rectangle"),
            height_m: 0.72,
            model: "four boxes and a top".into(),
            size_m: DVec3::new(1.0, 0.6, 0.72),
            mass: box_mass(20.0, DVec3::new(1.0, 0.6, 0.1), DVec3::new(0.0, 0.0, -0.1)),
            friction,
            restitution: 0.1,
            hulls: 5,
            mesh: "glb/table.glb".into(),
        },
        instances,
        metrics,
    };
    let asset = |name: &str, category: &str, visual, hulls| BodyAsset {
        name: name.into(),
        label: String::new(),
        category: category.into(),
        wikidata_item: "Q223557".into(),
        substance: "ceramic".into(),
        grasp: (name == "box_1").then_some(ParallelGrasp {
            contacts_m: [-1.0, 1.0].map(|side| DVec3::new(0.0, 0.04 * side, 0.025)),
        }),
        visual,
        hulls,
        rolling_friction_m: 0.0005,
        torsional_friction_m: 0.003,
    };
    let assets = Assets {
        table: asset("table", "table", table, table_hulls),
        instances: vec![
            asset("mug_1", "mug", mug, mug_hulls),
            asset(
                "box_1",
                "box",
                crate_mesh,
                vec![box_hull(-0.5 * size.with_z(0.0), (0.5 * size).with_z(size.z))],
            ),
        ],
    };
    let certificate = Certificate {
        verdict: Verdict::Pass,
        summary: "Nothing was measured.".into(),
        reasons: Vec::new(),
        pairs: 3,
        metrics,
        thresholds: Thresholds {
            penetration_m: 0.001,
            wall_share: 0.25,
            contact_gap_m: 0.001,
            support_dilation_m: 0.002,
            dss_displacement_m: 0.03,
            dss_rotation_rad: 30_f64.to_radians(),
            dss_duration_s: 5.0,
            outline_m: 0.001,
            silhouette_iou: 0.3,
            health: HealthThresholds {
                hull_excess_m: 0.05,
                uncovered_m: 0.01,
                uncovered_share: 0.015,
                open_share: 0.5,
                longest_side_m: [0.003, 5.0],
                density_kg_m3: [10.0, 23000.0],
                friction: 2.0,
            },
        },
        fidelity: Fidelity {
            silhouette_iou: 0.9,
            color_difference: Some(6.5),
            missed: Regions {
                share: 0.02,
                largest: vec![Region {
                    body: InstanceId::new("mug_1").expect("a name"),
                    bbox_px: [10, 12, 20, 30],
                    picture_share: 0.001,
                }],
            },
            invented: Regions::default(),
            methods: vec![MethodShare { method: ReconstructionMethod::Category, objects: 2, share: 1.0 }],
            appearance: Appearance { extractor: "specimen".into(), model: "1".into(), similarity: 0.95 },
        },
        objects: objects(),
        appraisal: Some(appraisal()),
        bodies: health(),
        scale_error: None,
        collisions: Vec::new(),
        resolve: ResolveFinding {
            rounds: 1,
            log: vec![NASTY_LABEL.into()],
            gave_way: vec![
                GaveWay { name: "mug_1".into(), how: Concession::Shrunk { scale: 0.81 } },
                GaveWay { name: "box_1".into(), how: Concession::Moved { from: "mug_1".into() } },
            ],
        },
        made_with: MadeWith {
            version: "0".into(),
            adapters: Vec::new(),
            settings: serde_json::json!({ "section": { "key": NASTY_LABEL } }),
        },
    };
    let picture = encode_png(&checkered([1, 2, 3, 255]));
    let names = ["table", "mug_1", "box_1"];
    let pictures = Pictures {
        hero_png: picture.clone(),
        top_png: picture.clone(),
        sides_png: vec![("front".into(), picture.clone())],
        thumbnails: names.map(|name| (name.to_owned(), picture.clone())).into_iter().collect(),
        ..Pictures::default()
    };
    (scene, certificate, assets, pictures)
}

fn appraisal() -> Appraisal {
    fn opinion<T>(said: T) -> Opinion<T> {
        Opinion { by: "specimen".into(), model: NASTY_LABEL.into(), prompt: "judge_text 1".into(), said }
    }
    Appraisal {
        ratings: Some(opinion(vec![Rating {
            criterion: Criterion::PhysicalPlausibility,
            score: 6,
            why: NASTY_LABEL.into(),
        }])),
        tasks: Some(opinion(vec![ProposedTask {
            instruction: NASTY_LABEL.into(),
            kind: TaskKind::PickAndPlace,
            objects: vec![InstanceId::new("mug_1").expect("a name")],
        }])),
        missing: vec![NASTY_LABEL.into()],
    }
}

fn objects() -> Vec<ObjectCertificate> {
    let moved = Displacement { distance_m: 0.0012, angle_rad: 0.01 };
    let of = |name: &str| ObjectCertificate {
        name: InstanceId::new(name).expect("a name"),
        support_margin_m: Some(0.03),
        moved: Displacements {
            by_resolve: moved,
            by_settling: moved,
            from_aligned: moved,
            after_shipping: moved,
            after_aligning: moved,
        },
        outline_margin_m: 0.1,
        inside_outline: true,
        silhouette_iou: 0.9,
        color_difference: None,
        method: ReconstructionMethod::Category,
        rotation: RotationFinding {
            yaw_rad: 0.7,
            representative_yaw_rad: 0.7,
            symmetry_order: 1,
            shape_symmetry_order: 1,
            symmetry_axis_m: [0.0; 2],
            confidence: 0.8,
            candidates: vec![(0.7, 0.1)],
        },
    };
    ["mug_1", "box_1"].map(of).into()
}

fn health() -> Vec<BodyHealth> {
    let of = |name: &str| BodyHealth {
        name: name.into(),
        watertight: true,
        triangles: 12,
        size_m: [0.1, 0.1, 0.05],
        volume_m3: 5e-4,
        mass_kg: 0.3,
        density_kg_m3: 600.0,
        hulls: 1,
        hull_corners: 8,
        hull_volume_m3: 5e-4,
        hull_excess_m: 1e-3,
        uncovered_m: 0.0,
        hull_fit: HullFit {
            air_share: 0.02,
            hulls_from_mesh_max_m: 1.1e-3,
            hulls_from_mesh_mean_m: 2e-4,
            mesh_from_hulls_max_m: 4e-4,
            mesh_from_hulls_mean_m: 1e-4,
            open_share: 0.97,
        },
        repair: Repair { holes_filled: 1, ..Repair::default() },
    };
    ["table", "mug_1", "box_1"].map(of).into()
}

pub(super) fn files() -> Vec<BundleFile> {
    files_with(UsdForm::Usdc)
}

pub(super) fn files_with(usd: UsdForm) -> Vec<BundleFile> {
    let (scene, certificate, assets, pictures) = specimen();
    write_formats(&scene, &certificate, &assets, &pictures, &settings(usd)).expect("the specimen is sound")
}

pub(super) fn text<'a>(files: &'a [BundleFile], path: &str) -> &'a str {
    let file = files.iter().find(|file| file.path == path).unwrap_or_else(|| panic!("{path} is missing"));
    std::str::from_utf8(&file.bytes).expect("text")
}

/// Leaves a bundle for each form of USD under `target/specimen/` for the independent judges.
#[test]
fn the_specimen_is_written_for_the_judges() {
    for (name, form) in [("usda", UsdForm::Usda), ("usdc", UsdForm::Usdc), ("usdz", UsdForm::Usdz)] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/specimen").join(name);
        if folder.exists() {
            std::fs::remove_dir_all(&folder).expect("target is writable");
        }
        for file in files_with(form) {
            let path = folder.join(&file.path);
            std::fs::create_dir_all(path.parent().expect("inside the folder")).expect("target is writable");
            std::fs::write(path, &file.bytes).expect("target is writable");
        }
    }
}

#[test]
fn threads_and_repetition_do_not_change_a_byte() {
    let with_threads = |count: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("a pool");
        pool.install(files)
    };
    let one = with_threads(1);
    assert_eq!(one, with_threads(3));
    let zip = |files: &[BundleFile]| zip_bundle(files).expect("packs");
    assert_eq!(zip(&one), zip(&one.iter().rev().cloned().collect::<Vec<_>>()));
}

#[test]
fn labels_are_data_in_every_format() {
    let files = files();
    let scene: Scene = serde_json::from_str(text(&files, "scene.json")).expect("our own JSON");
    assert_eq!(scene, specimen().0);
    let as_text = files_with(UsdForm::Usda);
    let usd = text(&as_text, "usd/assets/mug_1/simready_usd/mug_1.usda");
    let escaped = "\"a \\\"red\\\" <b>mug</b> & 'co'\\n--> ]]> \\\\ {rows} | 🍎\\x07\"";
    assert!(usd.contains(&format!("displayName = {escaped}")));
    let mjcf = text(&files, "mjcf/scene.xml");
    assert!(mjcf.contains("&lt;b&gt;mug&lt;/b&gt; &amp; ") && mjcf.contains("&#10;--&gt;"));
    assert!(!text(&files, "README.md").contains("<b>"));
    let manifest: serde_json::Value =
        serde_json::from_str(text(&files, "manifest.json")).expect("our own JSON");
    assert_eq!(manifest["assets"][1]["label"], NASTY_LABEL);
}

#[test]
fn a_format_that_tells_another_scene_is_refused() {
    let (scene, _, assets, _) = specimen();
    let bodies = body::bodies(&scene, &assets).expect("sound");
    let changes = [
        ("mjcf/scene.xml", "mass=\"0.3\"", "mass=\"0.31\""),
        ("mjcf/scene.xml", "pos=\"-0.1 0.05 0\"", "pos=\"0.1 0.05 0\""),
        ("urdf/mug_1/mug_1.urdf", "value=\"0.5\"", "value=\"0.4\""),
        ("urdf/scene.urdf", "0.15 -0.04 0", "-0.04 0.15 0"),
        ("usd/scene.usda", "physics:rigidBodyEnabled = 0", "physics:rigidBodyEnabled = 1"),
        ("usd/assets/mug_1/simready_usd/mug_1.usda", "(0.00031, ", "(0.00036, "),
        ("usd/assets/mug_1/simready_usd/mug_1.usda", "convexHull", "convexDecomposition"),
    ];
    for (path, from, to) in changes {
        let mut files = files_with(UsdForm::Usda);
        let file = files.iter_mut().find(|file| file.path == path).expect("written");
        let before = String::from_utf8(file.bytes.clone()).expect("text");
        assert!(before.contains(from), "{path} has no {from}");
        file.bytes = before.replace(from, to).into_bytes();
        let result = parity::read_back(&bodies, &files);
        assert!(
            matches!(result, Err(ExportError::Parity { .. } | ExportError::Unreadable { .. })),
            "{path} {to}"
        );
    }
}

#[test]
fn every_form_of_usd_is_read_back_and_refused_when_it_tells_another_scene() {
    let (scene, _, assets, _) = specimen();
    let bodies = body::bodies(&scene, &assets).expect("sound");
    let little_endian = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let moments = little_endian(&[3.1e-4, 3.6e-4, 4.2e-4]);
    let other_moments = little_endian(&[3.6e-4, 3.6e-4, 4.2e-4]);
    for (form, path) in
        [(UsdForm::Usdc, "usd/assets/mug_1/simready_usd/mug_1.usdc"), (UsdForm::Usdz, "usd/scene.usdz")]
    {
        let mut files = files_with(form);
        let parity = parity::read_back(&bodies, &files).expect("reads back");
        assert_eq!(parity.usd.hulls, parity.mjcf.hulls);
        let file = files.iter_mut().find(|file| file.path == path).expect("written");
        let at = file.bytes.windows(12).position(|window| window == moments).expect("stands there once");
        file.bytes[at..at + 12].copy_from_slice(&other_moments);
        assert!(parity::read_back(&bodies, &files).is_err(), "{form:?} with other moments");
        let file = files.iter_mut().find(|file| file.path == path).expect("written");
        file.bytes.truncate(file.bytes.len() / 2);
        assert!(parity::read_back(&bodies, &files).is_err(), "{form:?} cut in half");
    }
}

#[test]
fn an_archive_is_what_its_manifest_tells() {
    let files = files();
    let bytes = zip_bundle(&files).expect("packs");
    let told = archive::told_files(&bytes).expect("is");
    assert_eq!(told.len(), files.len() - 1);
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(&bytes)).expect("our own archive");
    let mut content = String::new();
    let mut entry = archive.by_name("scene-specimen0001/mjcf/scene.xml").expect("there");
    std::io::Read::read_to_string(&mut entry, &mut content).expect("text");
    assert_eq!(content, text(&files, "mjcf/scene.xml"));

    let told_error = |change: fn(&mut Vec<BundleFile>)| {
        let mut files = files.clone();
        change(&mut files);
        archive::told_files(&zip_bundle(&files).expect("packs")).expect_err("differs").to_string()
    };
    let stray = BundleFile::text("notes.txt", String::new(), "notes", "text/plain");
    assert!(told_error(|files| files.retain(|file| file.path != "report.json")).contains("report.json"));
    assert!(told_error(|files| files.retain(|file| file.path != "manifest.json")).contains("manifest.json"));
    assert!(told_error(|files| files[3].bytes.push(b' ')).contains(&files[3].path));
    let mut more = files.clone();
    more.push(stray);
    let error = archive::told_files(&zip_bundle(&more).expect("packs")).expect_err("differs");
    assert!(error.to_string().contains("notes.txt"), "{error}");
}

#[test]
fn the_manifest_was_missing_from_the_files_of_a_scene() {
    let files = files();
    let (path, told) = archive::manifest_itself(&zip_bundle(&files).expect("packs")).expect("has one");
    let bytes = text(&files, &path).as_bytes();
    assert_eq!(path, "manifest.json");
    assert_eq!(told, manifest::told_of(bytes, "application/json"));
    assert_eq!((told.size, told.sha256.len()), (bytes.len() as u64, 64));
    let without: Vec<BundleFile> = files.into_iter().filter(|file| file.path != path).collect();
    assert!(archive::manifest_itself(&zip_bundle(&without).expect("packs")).is_err());
}

#[test]
fn unsound_bodies_are_named() {
    let error = |change: fn(&mut Scene, &mut Assets)| {
        let (mut scene, certificate, mut assets, pictures) = specimen();
        change(&mut scene, &mut assets);
        write_formats(&scene, &certificate, &assets, &pictures, &settings(UsdForm::Usdc))
            .expect_err("unsound")
            .to_string()
    };
    assert!(error(|scene, _| scene.instances[0].mass.mass_kg = -1.0).contains("mug_1"));
    assert!(error(|scene, _| scene.instances[0].mass.inertia_diagonal_kg_m2.x = 1.0).contains("triangle"));
    assert!(error(|scene, _| scene.instances[1].hulls = 2).contains("box_1"));
    assert!(
        error(|scene, _| scene.instances[1].name = InstanceId::new("mug_1").expect("ok")).contains("mug_1")
    );
    assert!(
        error(|_, assets| assets.instances[1].hulls[0].triangles.iter_mut().for_each(|t| t.swap(0, 1)))
            .contains("inside out")
    );
    assert!(error(|_, assets| assets.instances.truncate(1)).contains("1 assets"));
}

#[test]
fn the_manifest_tells_every_file() {
    let files = files();
    let manifest: serde_json::Value =
        serde_json::from_str(text(&files, "manifest.json")).expect("our own JSON");
    let told: BTreeMap<&str, u64> = manifest["files"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|file| (file["path"].as_str().expect("a path"), file["size"].as_u64().expect("a size")))
        .collect();
    assert_eq!(told.len(), files.len() - 1);
    for file in files.iter().filter(|file| file.path != "manifest.json") {
        assert_eq!(told.get(file.path.as_str()), Some(&(file.bytes.len() as u64)), "{}", file.path);
    }
}
