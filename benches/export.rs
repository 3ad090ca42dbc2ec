//! Writing: every format from one scene and read back, and the archive.

mod breakfast;

use std::hint::black_box;

use certificate::{
    Appearance, Certificate, Fidelity, HealthThresholds, MadeWith, Regions, ResolveFinding, Thresholds,
    Verdict,
};
use criterion::{Criterion, criterion_group, criterion_main};
use export::{Assets, BodyAsset, Images, write_formats, zip_bundle};
use physics::Body;
use scene::finished::Frame;
use scene::instance::ImageRegion;
use scene::request::RequestOptions;
use scene::{Input, Instance, InstanceId, Metrics, Provenance, Scene, SceneRequest, Support, Table};

use breakfast::{Breakfast, SEED, TEXT};

fn bench(criterion: &mut Criterion) {
    let scene = Breakfast::new();
    let (bodies, _) = scene.bodies();
    let (finished, certificate) = (finished(&scene, &bodies), certificate(&scene));
    let assets = Assets {
        table: asset("table", &scene.table, &bodies[0]),
        instances: scene
            .objects()
            .iter()
            .zip(&scene.meshes)
            .zip(&bodies[1..])
            .map(|((object, mesh), body)| asset(&object.category, mesh, body))
            .collect(),
    };
    let (images, settings) = (Images::default(), &scene.config.export);
    let write = || write_formats(black_box(&finished), &certificate, &assets, &images, Vec::new(), settings);
    let files = write().expect("the breakfast can be written");
    criterion.bench_function("export/formats", |b| b.iter(write));
    criterion.bench_function("export/archive", |b| b.iter(|| zip_bundle(black_box(&files))));
}

fn asset(category: &str, visual: &geometry::TexturedMesh, body: &Body) -> BodyAsset {
    BodyAsset {
        name: body.name.clone(),
        label: body.name.clone(),
        category: category.to_owned(),
        wikidata_item: "Q223557".into(),
        substance: "ceramic".into(),
        grasp: None,
        visual: visual.clone().snap_to_f32(),
        hulls: body.hulls.clone(),
        rolling_friction_m: body.rolling_friction_m,
        torsional_friction_m: 0.003,
    }
}

fn finished(scene: &Breakfast, bodies: &[Body]) -> Scene {
    let seen = &scene.ground_truth().known.recognition;
    let supports = scene.supports();
    let instances = scene.objects().iter().zip(&scene.meshes).zip(1..).map(|((object, mesh), k)| {
        let body: &Body = &bodies[k];
        let supporter = supports.supporter(k - 1);
        Instance {
            name: InstanceId::new(&body.name).expect("a name"),
            label: object.label.clone(),
            category: object.category.clone(),
            stand_in: None,
            image: ImageRegion { bbox_px: [0, 0, 1, 1] },
            world_from_object: body.world_from_object,
            yaw_rad: body.world_from_object.yaw_rad(),
            symmetry_order: 1,
            scale: glam::DVec3::ONE,
            size_m: mesh.size_m(),
            mass: body.mass,
            friction: body.friction,
            restitution: body.restitution,
            support: Support {
                parent: bodies[supporter.parent.map_or(0, |parent| parent + 1)].name.clone(),
                relation: supporter.relation,
            },
            hulls: body.hulls.len() as u32,
            mesh: format!("glb/{}.glb", body.name),
            grasps: None,
            provenance: Provenance { mesh_by: "bench".into(), licence: "CC0-1.0".into(), notes: Vec::new() },
        }
    });
    let table = &bodies[0];
    Scene {
        format: Scene::FORMAT.into(),
        id: "bench".into(),
        seed: SEED,
        request: SceneRequest::new(Input::Text { text: TEXT.into() }, SEED, RequestOptions::default()),
        frame: Frame::world(),
        camera: seen.camera,
        table: Table {
            name: "table".into(),
            label: seen.table.label.clone(),
            shape: seen.table.shape,
            outline_m: scene.outline.clone(),
            height_m: seen.table.size_m.z,
            model: seen.table.model.clone(),
            size_m: scene.table.size_m(),
            mass: table.mass,
            friction: table.friction,
            restitution: table.restitution,
            hulls: table.hulls.len() as u32,
            mesh: "glb/table.glb".into(),
        },
        instances: instances.collect(),
        metrics: METRICS,
        text: None,
        light: None,
        edit: None,
        clutter: None,
    }
}

const METRICS: Metrics = Metrics { col_o: 0.0, col_s: 0.0, ss: 1.0, dss_aligned: 1.0, dss_shipped: 1.0 };

fn certificate(scene: &Breakfast) -> Certificate {
    let certify = &scene.config.certify;
    Certificate {
        verdict: Verdict::Pass,
        summary: "Nothing was measured.".into(),
        reasons: Vec::new(),
        pairs: 0,
        metrics: METRICS,
        thresholds: Thresholds {
            penetration_m: certify.penetration_m,
            wall_share: certify.wall_share,
            contact_gap_m: certify.contact_gap_m,
            support_dilation_m: certify.support_dilation_m,
            dss_displacement_m: certify.dss_displacement_m,
            dss_rotation_rad: certify.dss_rotation_rad,
            dss_duration_s: certify.dss_duration_s,
            rest_side_share: certify.rest_side_share,
            rest_rotation_rad: certify.rest_rotation_rad,
            outline_m: 0.001,
            silhouette_iou: scene.config.fidelity.min_silhouette_iou,
            missed_share: 0.4,
            invented_share: 0.4,
            health: HealthThresholds {
                hull_excess_m: scene.config.health.hull_excess_m,
                uncovered_m: scene.config.health.uncovered_m,
                uncovered_share: scene.config.health.uncovered_share,
                open_share: scene.config.health.min_open_share,
                longest_side_m: [scene.config.health.min_side_m, scene.config.health.max_side_m],
                density_kg_m3: [scene.config.health.min_density_kg_m3, scene.config.health.max_density_kg_m3],
                friction: scene.config.health.max_friction,
            },
        },
        fidelity: Fidelity {
            is_judged: true,
            left_out_px: Vec::new(),
            depth: None,
            silhouette_iou: 1.0,
            color_difference: None,
            missed: Regions::default(),
            invented: Regions::default(),
            methods: Vec::new(),
            appearance: Appearance { extractor: "none".into(), model: "1".into(), similarity: 1.0 },
        },
        objects: Vec::new(),
        bodies: Vec::new(),
        scale_error: None,
        collisions: Vec::new(),
        resolve: ResolveFinding { rounds: 1, log: Vec::new(), gave_way: Vec::new() },
        appraisal: None,
        robot: None,
        clutter: None,
        made_with: MadeWith { version: "0".into(), adapters: Vec::new(), settings: serde_json::Value::Null },
    }
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = bench }
criterion_main!(benches);
