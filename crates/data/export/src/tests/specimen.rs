//! Test fixture: a small scene made by hand, with its assets, certificate and images.

use glam::{DQuat, DVec2, DVec3};

use certificate::{
    Appearance, BodyHealth, Certificate, Displacement, Displacements, Fidelity, HealthThresholds, MadeWith,
    MethodShare, ObjectCertificate, Region, Regions, Relaxation, RelaxationKind, ResolveFinding,
    RobotFinding, RotationFinding, TaskTried, Thresholds, Verdict,
};
use geometry::decompose::HullFit;
use geometry::parallel_grasp::ParallelGrasp;
use geometry::repair::Repair;
use geometry::{
    Camera, ConvexHull, Friction, MassProperties, Material, Outline, Pose, Rgb, TexturedMesh, shapes,
};
use imaging::{Image, Texture};
use scene::appraisal::{Appraisal, Criterion, ModelResponse, ProposedTask, Rating, TaskKind};
use scene::clutter::{ClutterFinding, ClutterPlacement, ClutteredObject};
use scene::finished::Frame;
use scene::grasps::{GraspFile, GraspRecord, GraspVerdict};
use scene::instance::{ImageRegion, SupportRelation};
use scene::predicates::{Unmet, UnmetDemand};
use scene::request::RequestOptions;
use scene::text_account::{ChangedPart, TextAccount};
use scene::{
    Goal, GoalPredicate, Input, Instance, InstanceId, Metrics, PredicateKind, Provenance,
    ReconstructionMethod, RelationKind, Scene, SceneRequest, StandIn, Support, Table, TableShape,
    TextMeaning, TextSpan, Understood, Unrecognized, UnrecognizedReason,
};

use crate::{Assets, BodyAsset, BundleFile, ExportSettings, Images, UrdfPaths, UsdForm, write_formats};
use imaging::codec::encode_png;

/// A label with the special characters of every format.
pub(super) const NASTY_LABEL: &str = "a \"red\" <b>mug</b> & 'co'\n--> ]]> \\ {rows} | 🍎\u{7}";

pub(super) fn settings(usd: UsdForm) -> ExportSettings {
    ExportSettings {
        usd,
        author: "tabletopgen".into(),
        licence: "CC0-1.0".into(),
        date: "2026-01-01".into(),
        gravity_m_s2: 9.81,
        mujoco_timestep_s: 0.002,
        mujoco_impratio: 10.0,
        urdf: UrdfPaths::Relative,
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
    let mut image = Image::filled(64, 64, color);
    for y in 0..64 {
        for x in 0..64 {
            if (x / 16 + y / 8) % 2 == 0 {
                image.set_pixel(x, y, [240, 235, (y * 3) as u8, 255]);
            }
        }
    }
    Texture::new(image)
}

/// A table of five boxes, a mug in which a ball rests on nothing but the floor, a turned box beside it.
pub(super) fn specimen() -> (Scene, Certificate, Assets, Images) {
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
            stand_in: (name == "box_1")
                .then(|| StandIn { stands_for: "pencil case".into(), shown_as: "box".into() }),
            image: ImageRegion { bbox_px: [10, 20, 200, 180] },
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
            grasps: (name == "mug_1").then(|| GraspFile {
                robot: "panda".into(),
                gripper_frame: "panda_tool".into(),
                gripper_joint: "finger_joint1".into(),
                grasps: vec![GraspRecord {
                    object_from_tool: Pose::upright(DVec3::new(0.0, 0.04, 0.08), 0.3),
                    opening_m: 0.005,
                    pregrasp_opening_m: 0.025,
                    force_n: 20.0,
                    confidence: 0.8,
                    verdict: GraspVerdict::Stable,
                    slip_m: 0.0001,
                    turn_rad: 0.01,
                }],
            }),
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
        request: SceneRequest::new(Input::Text { text: NASTY_LABEL.into() }, 7, RequestOptions::default()),
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
        light: None,
        text: Some(account()),
        edit: None,
        clutter: Some(clutter()),
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
            rest_side_share: 0.25,
            rest_rotation_rad: 0.0349,
            outline_m: 0.001,
            silhouette_iou: 0.3,
            missed_share: 0.4,
            invented_share: 0.4,
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
            is_judged: true,
            left_out_px: vec![[1, 2, 30, 40]],
            depth: None,
            silhouette_iou: 0.9,
            color_difference: Some(6.5),
            missed: Regions {
                share: 0.02,
                largest: vec![Region {
                    body: InstanceId::new("mug_1").expect("a name"),
                    bbox_px: [10, 12, 20, 30],
                    image_share: 0.001,
                }],
            },
            invented: Regions::default(),
            methods: vec![MethodShare { method: ReconstructionMethod::Category, objects: 2, share: 1.0 }],
            appearance: Appearance { extractor: "specimen".into(), model: "1".into(), similarity: 0.95 },
        },
        objects: objects(),
        appraisal: Some(appraisal()),
        robot: Some(RobotFinding {
            name: "panda".into(),
            objects: 2,
            pickable: 1,
            tasks_proposed: 1,
            tasks_done: 0,
            tasks: vec![TaskTried { instruction: NASTY_LABEL.into(), outcome: "no_path".into() }],
        }),
        clutter: Some(clutter()),
        bodies: health(),
        scale_error: None,
        collisions: Vec::new(),
        resolve: ResolveFinding {
            rounds: 1,
            log: vec![NASTY_LABEL.into()],
            gave_way: vec![
                Relaxation { name: "mug_1".into(), how: RelaxationKind::Shrunk { scale: 0.81 } },
                Relaxation { name: "box_1".into(), how: RelaxationKind::Moved { from: "mug_1".into() } },
            ],
        },
        made_with: MadeWith {
            version: "0".into(),
            adapters: Vec::new(),
            settings: serde_json::json!({ "section": { "key": NASTY_LABEL } }),
        },
    };
    let image = encode_png(&checkered([1, 2, 3, 255]));
    let names = ["table", "mug_1", "box_1"];
    let images = Images {
        hero_png: image.clone(),
        top_png: image.clone(),
        sides_png: vec![("front".into(), image.clone())],
        thumbnails: names.map(|name| (name.to_owned(), image.clone())).into_iter().collect(),
        ..Images::default()
    };
    (scene, certificate, assets, images)
}

/// An account of every kind of finding.
fn account() -> TextAccount {
    let id = |name: &str| InstanceId::new(name).expect("a name");
    let span = || TextSpan { start: 0, end: NASTY_LABEL.len(), text: NASTY_LABEL.into() };
    TextAccount {
        understood: vec![Understood {
            span: span(),
            meaning: TextMeaning::Object { category: "mug".into(), objects: vec![id("mug_1")] },
        }],
        unrecognized: vec![Unrecognized {
            span: span(),
            reason: UnrecognizedReason::UnknownWord,
            nearest_by_spelling: Some("mug".into()),
            nearest_by_meaning: None,
        }],
        goal: Some(Goal {
            instruction: NASTY_LABEL.into(),
            predicates: vec![GoalPredicate {
                predicate: PredicateKind::NextTo,
                object: id("mug_1"),
                target: Some(id("box_1")),
                second_target: None,
            }],
        }),
        stand_ins: vec![id("box_1")],
        fillings: vec![id("mug_1")],
        unmet: vec![Unmet {
            objects: vec![id("mug_1")],
            demand: UnmetDemand::Relation {
                relation: RelationKind::LeftOf,
                targets: vec![id("box_1")],
                distance_m: Some(0.2),
            },
        }],
        of_scene: Some("00112233445566778899".into()),
        changed: vec![ChangedPart {
            span: TextSpan { start: 40, end: 46, text: "teapot".into() },
            by: "removed teapot_1".into(),
        }],
    }
}

fn clutter() -> ClutterFinding {
    let object = |name: &str, placement| ClutteredObject {
        name: InstanceId::new(name).expect("a name"),
        placement,
        contacts: 1,
        hidden_in_hero: 0.3,
        hidden_from_above: 0.1,
    };
    ClutterFinding {
        density: 0.6,
        covered_share: 0.55,
        mean_contacts: 1.0,
        touching: 2,
        hidden_share: 1.0,
        objects: vec![object("mug_1", ClutterPlacement::Kept), object("box_1", ClutterPlacement::Dropped)],
    }
}

fn appraisal() -> Appraisal {
    fn opinion<T>(said: T) -> ModelResponse<T> {
        ModelResponse {
            by: "specimen".into(),
            model: NASTY_LABEL.into(),
            prompt: "judge_text 1".into(),
            said,
        }
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
        rest_limit_m: 0.01,
        overlap_m: 0.0001,
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
    let (scene, certificate, assets, images) = specimen();
    write_formats(&scene, &certificate, &assets, &images, Vec::new(), &settings(usd))
        .expect("the specimen is sound")
}

pub(super) fn text<'a>(files: &'a [BundleFile], path: &str) -> &'a str {
    let file = files.iter().find(|file| file.path == path).unwrap_or_else(|| panic!("{path} is missing"));
    std::str::from_utf8(&file.bytes).expect("text")
}
