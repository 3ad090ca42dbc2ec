//! A rendered image, read as a client's image, all the way to meshes.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::*;
use crate::analyst::describe;
use crate::text_parser::TextParserSettings;
use catalog::{Recipe, build, build_table, category};
use geometry::{Camera, Material, Pose, Rgb, TexturedMesh, shapes};
use imaging::{Image, Mask};
use ports::{
    CompletionRequest, ProviderError, RecognitionHints, ReconstructionRequest, ReferenceImage, TopViewRequest,
};
use render::{Background, Lighting, RenderObject, RenderScene, RenderSettings, View, render};
use runtime::CancelFlag;
use scene::request::{MetricAnchor, RequestOptions};
use scene::{RecognizedObject, TableShape};

fn settings() -> SingleViewSettings {
    let sizes = PhotographSettings {
        table_height_m: 0.74,
        field_of_view_rad: 0.0,
        intrinsics_px: [0.0; 6],
        top_view_px: 512,
        texture_px: 512,
    };
    SingleViewSettings { sizes, naming: test_settings::section("category_fit") }
}

fn reader() -> ImageReader {
    let network = ReadingNetwork::built_in(test_settings::section_without("network", &["weights"]));
    ImageReader::new(network, settings())
}

const TABLE_SIZE_M: DVec3 = DVec3::new(1.4, 0.8, 0.74);

/// Category, position (x, y) in meters, yaw in degrees.
const OBJECTS: [(&str, f64, f64, f64); 6] = [
    ("mug", -0.35, 0.1, 30.0),
    ("plate", 0.0, -0.05, 0.0),
    ("wine_bottle", 0.35, 0.22, 0.0),
    ("bowl", 0.38, -0.15, 0.0),
    ("apple", -0.15, 0.25, 0.0),
    ("book", -0.45, -0.2, 20.0),
];

/// A rendering of a laid dining table, and the true centers of the objects' boxes, meters.
fn rendered_table(azimuth_deg: f64, elevation_deg: f64) -> (Image, Vec<DVec2>) {
    rendered_room(azimuth_deg, elevation_deg, &[])
}

/// Rendered table with furniture around it: blocks on the floor, by extents and center (x, y), meters.
fn rendered_room(azimuth_deg: f64, elevation_deg: f64, furniture: &[(DVec3, DVec2)]) -> (Image, Vec<DVec2>) {
    let table = build_table("dining_table", TABLE_SIZE_M, None, Some("oak"), 7).expect("a model");
    let objects: Vec<(TexturedMesh, Pose)> = OBJECTS
        .iter()
        .enumerate()
        .map(|(k, &(name, x, y, yaw_deg))| {
            let size_m = category(name).expect("in the catalog").size.typical_m();
            let (color, material, seed) = (None, None, 11 + k as u64);
            let recipe = Recipe { category: name.to_owned(), size_m, color, material, seed };
            let mesh = build(&recipe).expect("a generator");
            (mesh, Pose::upright(DVec3::new(x, y, 0.0), f64::to_radians(yaw_deg)))
        })
        .collect();
    let mut shown = vec![RenderObject { mesh: &table.mesh, world_from_object: Pose::IDENTITY, id: 1 }];
    shown.extend(objects.iter().map(|(mesh, pose)| RenderObject { mesh, world_from_object: *pose, id: 2 }));
    let blocks: Vec<(TexturedMesh, Pose)> = furniture
        .iter()
        .map(|&(size_m, at)| {
            let mut mesh = TexturedMesh::default();
            mesh.add(shapes::block(size_m), &Material::plain("paint", Rgb::hex(0x3a_4a_5c), 0.6));
            (mesh, Pose::upright(at.extend(-TABLE_SIZE_M.z), 0.0))
        })
        .collect();
    shown.extend(blocks.iter().map(|(mesh, pose)| RenderObject { mesh, world_from_object: *pose, id: 3 }));
    let (azimuth_rad, elevation_rad) = (azimuth_deg.to_radians(), elevation_deg.to_radians());
    let scene = RenderScene {
        objects: shown,
        lighting: Lighting::studio(azimuth_rad - 0.6, 0.95, 0.6),
        background: Background::light_with_floor(-TABLE_SIZE_M.z),
    };
    let aim = DVec3::new(0.0, 0.0, -0.25);
    let camera = Camera::orbit(1024, 768, 0.6109, aim, azimuth_rad, elevation_rad, 3.0);
    let quality =
        RenderSettings { supersampling: 2, shadow_map_px: 1024, sky_directions: 12, sky_map_px: 192 };
    let image = render(&scene, &View::Perspective(camera), &quality).color;
    let center = |(mesh, pose): &(TexturedMesh, Pose)| {
        let (low, high) = mesh.clone().rotated(pose.rotation).translated(pose.translation_m).bounds();
        0.5 * (low + high).truncate()
    };
    (image, objects.iter().map(center).collect())
}

fn is_watertight(mesh: &TexturedMesh) -> bool {
    let bits = |v: u32| (mesh.positions[v as usize] + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut balance: BTreeMap<_, i32> = BTreeMap::new();
    for t in mesh.triangles() {
        for k in 0..3 {
            let (a, b) = (bits(t[k]), bits(t[(k + 1) % 3]));
            if a < b {
                *balance.entry((a, b)).or_default() += 1;
            } else {
                *balance.entry((b, a)).or_default() -= 1;
            }
        }
    }
    balance.values().all(|&count| count == 0)
}

fn volume(mesh: &TexturedMesh) -> f64 {
    mesh.triangles()
        .map(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            a.dot(b.cross(c)) / 6.0
        })
        .sum()
}

/// The backs of two chairs and a cabinet stand behind the far edge, a stool to the left and a box before the table.
/// An image without anything beside it.
fn alone(image: &Image) -> ReferenceImage {
    ReferenceImage { image: Arc::new(image.clone()), known: None, depth: None }
}

#[test]
fn furniture_around_the_table_does_not_stand_on_it() {
    let furniture = [
        (DVec3::new(0.42, 0.06, 1.0), DVec2::new(-0.3, 0.5)),
        (DVec3::new(0.42, 0.06, 1.0), DVec2::new(0.3, 0.52)),
        (DVec3::new(0.3, 0.3, 0.95), DVec2::new(0.75, 0.75)),
        (DVec3::new(0.3, 0.3, 0.6), DVec2::new(-0.95, 0.0)),
        (DVec3::new(0.25, 0.2, 0.5), DVec2::new(0.2, -0.62)),
    ];
    let (image, true_centers_m) = rendered_room(0.0, 30.0, &furniture);
    let (stop, options) = (CancelFlag::default(), RequestOptions::default());
    let found = recognize(&alone(&image), 5, &options, None, &reader(), &stop).expect("recognized");
    let outside = |object: &RecognizedObject| {
        let center = object.seen_as.as_ref().expect("a solid").center;
        let scale = TABLE_SIZE_M.x / found.table.size_m.x;
        true_centers_m.iter().all(|true_m| (scale * center - *true_m).length() > 0.12)
    };
    let strangers: Vec<&str> =
        found.objects.iter().filter(|object| outside(object)).map(|object| object.id.as_str()).collect();
    assert!(strangers.is_empty(), "{strangers:?} of {found:#?}");
    assert!(found.objects.len() + 1 >= true_centers_m.len(), "{}", found.objects.len());
}

#[test]
fn rendered_table_is_reconstructed_with_objects_at_their_positions() {
    let stop = CancelFlag::default();
    let (image, true_centers_m) = rendered_table(0.0, 35.0);
    let image = Arc::new(image);
    let reader = reader();
    let reference = ReferenceImage { image: image.clone(), known: None, depth: None };
    let recognition =
        recognize(&alone(&image), 5, &RequestOptions::default(), None, &reader, &stop).expect("recognized");
    assert_eq!(recognition.table.shape, TableShape::Rectangular);
    let size = recognition.table.size_m;
    assert!(
        (size.x / TABLE_SIZE_M.x - 1.0).abs() < 0.1 && (size.y / TABLE_SIZE_M.y - 1.0).abs() < 0.12,
        "{size}"
    );
    assert_eq!(recognition.table.material.as_deref(), Some("oak"));
    assert_eq!(recognition.objects.len(), true_centers_m.len());
    let again =
        recognize(&alone(&image), 5, &RequestOptions::default(), None, &reader, &stop).expect("recognized");
    assert_eq!(recognition, again);

    let masks = segment(&alone(&image), &recognition, &reader, &stop).expect("segmented").masks;
    let recognition = Arc::new(recognition);
    let request = TopViewRequest {
        reference: reference.clone(),
        recognition: recognition.clone(),
        masks: Arc::new(masks.clone()),
        rendered: None,
        refused: Vec::new(),
    };
    let top = top_view(&request, &settings(), &stop).expect("rectified");
    let known = top.known.expect("known");
    assert_eq!(known.objects.len(), masks.len());
    let [x0, y0, x1, y1] = known.table.bbox_px().expect("a table").map(f64::from);
    let mut off_m = Vec::new();
    let mut meshes = Vec::new();
    for (k, (object, mask)) in recognition.objects.iter().zip(&masks).enumerate() {
        let others = Mask::from_fn(image.width_px(), image.height_px(), |x, y| {
            masks.iter().enumerate().any(|(j, other)| j != k && other.visible.contains(x, y))
        });
        let request = CompletionRequest {
            reference: reference.clone(),
            object: object.clone(),
            visible: mask.visible.clone(),
            others,
            camera: Some(recognition.camera),
            alone: None,
        };
        let completion = complete(&request, &stop).expect("completed");
        let request = ReconstructionRequest {
            object: object.clone(),
            completion,
            camera: recognition.camera,
            rendered: false,
            seed: 9 + k as u64,
        };
        let raw = reconstruct(&request, &settings(), &stop).expect("reconstructed");
        assert!(is_watertight(&raw.mesh) && volume(&raw.mesh) > 0.0, "{} {:?}", object.id, raw.notes);
        assert!((raw.mesh.size_m().max_element() - 1.0).abs() < 1e-6);
        let (mesh, fit, _) =
            reconstruct::stood_up(&request.object, &request.completion, &request.camera, &settings())
                .expect("reconstructed");
        assert!((mesh.size_m() / object.size_m - 1.0).abs().max_element() < 1e-6);
        meshes.push((mesh, Pose::upright(fit.center.extend(0.0), fit.yaw_rad)));

        // The object's box on the top view lies at its true position.
        let found = known.objects[k].visible.bbox_px().expect("a footprint").map(f64::from);
        let center = DVec2::new(
            0.5 * (found[0] + found[2]) - 0.5 * (x0 + x1),
            0.5 * (y0 + y1) - 0.5 * (found[1] + found[3]),
        );
        let place = center * TABLE_SIZE_M.x / (x1 - x0);
        let nearest =
            true_centers_m.iter().map(|center| (*center - place).length()).fold(f64::INFINITY, f64::min);
        off_m.push(nearest);
    }
    off_m.sort_by(f64::total_cmp);
    eprintln!("distances from where they stood: {off_m:.3?} m");
    assert!(off_m[off_m.len() / 2] < 0.04 && off_m[off_m.len() - 1] < 0.06, "{off_m:?}");

    if let Some(directory) = std::env::var_os("TABLETOPGEN_VISION_OVERLAYS") {
        let table = &recognition.table;
        let built =
            build_table(&table.model, table.size_m, table.color, table.material.as_deref(), table.seed)
                .expect("a model");
        let mut objects = vec![RenderObject { mesh: &built.mesh, world_from_object: Pose::IDENTITY, id: 1 }];
        objects.extend(meshes.iter().map(|(mesh, pose)| RenderObject {
            mesh,
            world_from_object: *pose,
            id: 2,
        }));
        let scene = RenderScene {
            objects,
            lighting: Lighting::studio(-0.6, 0.95, 0.6),
            background: Background::light(),
        };
        let quality =
            RenderSettings { supersampling: 1, shadow_map_px: 512, sky_directions: 8, sky_map_px: 128 };
        let turned = |azimuth_deg: f64| {
            let eye = recognition.camera.world_from_camera.translation_m;
            let camera = geometry::Camera::orbit(
                800,
                600,
                0.5,
                DVec3::new(0.0, 0.0, -0.1),
                azimuth_deg.to_radians(),
                recognition.camera.elevation_rad(),
                1.1 * eye.length(),
            );
            render(&scene, &View::Perspective(camera), &quality).color
        };
        let same = render(&scene, &View::Perspective(recognition.camera), &quality).color;
        let (left, back) = (turned(-50.0), turned(150.0));
        let page = render::annotate::sheet(
            &[(&same, "same view"), (&left, "left"), (&back, "back"), (&top.image, "top")],
            2,
            640,
        );
        let path = std::path::Path::new(&directory).join("reconstructed.png");
        std::fs::write(path, imaging::codec::encode_png(&page)).expect("writable");
    }
}

#[test]
fn request_sets_scale_and_contradictions_are_rejected() {
    let stop = CancelFlag::default();
    let (image, _) = rendered_table(0.0, 35.0);
    let reader = reader();
    let anchor = MetricAnchor { object: "table".into(), width_m: 2.0 };
    let options = RequestOptions { metric_anchor: Some(anchor), ..Default::default() };
    let recognition = recognize(&alone(&image), 5, &options, None, &reader, &stop).expect("recognized");
    assert!((recognition.table.size_m.x - 2.0).abs() < 1e-12);
    let table = scene::TableSpec { shape: Some(TableShape::Round), ..Default::default() };
    let options = RequestOptions { table: Some(table), ..Default::default() };
    let refused = recognize(&alone(&image), 5, &options, None, &reader, &stop);
    assert!(matches!(refused, Err(ProviderError::Rejected { code: "table_differs", .. })), "{refused:?}");
}

/// The text names all six objects, a fork that is not there, and two masses.
#[test]
fn text_names_the_objects_of_a_rendered_table() {
    let stop = CancelFlag::default();
    let (image, true_centers_m) = rendered_table(0.0, 35.0);
    let text = "a table with a wine bottle, a mug that weighs 300 g, a bowl, a glass apple, a book, a plate and a fork";
    let parser: TextParserSettings = test_settings::section("analyst");
    let described = describe(text, 5, &RequestOptions::default(), &parser).expect("described");
    let hints = RecognitionHints::of(&described).expect("valid hints");
    let options = RequestOptions {
        metric_anchor: Some(MetricAnchor { object: "table".into(), width_m: TABLE_SIZE_M.x }),
        ..Default::default()
    };
    let recognition =
        recognize(&alone(&image), 5, &options, Some(&hints), &reader(), &stop).expect("recognized");
    recognition.validate().expect("valid");
    let mut right = 0;
    for object in &recognition.objects {
        let center = object.seen_as.as_ref().expect("a primitive").center;
        let nearest = (0..OBJECTS.len())
            .min_by(|a, b| {
                true_centers_m[*a].distance(center).total_cmp(&true_centers_m[*b].distance(center))
            })
            .expect("objects");
        right += usize::from(object.category == OBJECTS[nearest].0);
    }
    let names: Vec<(&str, &str)> =
        recognition.objects.iter().map(|object| (object.id.as_str(), object.category.as_str())).collect();
    assert!(right >= 5 && recognition.objects.len() <= 7, "{names:?}");
    assert!(!names.iter().any(|(_, category)| *category == "fork"), "{names:?}");
    let of = |id: &str| recognition.objects.iter().find(|object| object.id.as_str() == id).expect(id);
    assert_eq!((of("mug_1").mass_kg, of("bowl_1").mass_kg), (Some(0.3), None));
    assert_eq!(of("apple_1").material.as_deref(), Some("glass"));
}

/// A stated height sets the scale: the same image with a mug of twice the height is twice as large.
#[test]
fn stated_sizes_set_the_scale_of_the_image() {
    let stop = CancelFlag::default();
    let image = rendered_table(0.0, 35.0).0;
    let (reader, parser) = (reader(), test_settings::section::<TextParserSettings>("analyst"));
    let width_m = |height_cm: f64| {
        let text = format!("a mug {height_cm} cm tall, a plate, a bowl, an apple, a wine bottle and a book");
        let described = describe(&text, 5, &RequestOptions::default(), &parser).expect("described");
        let hints = RecognitionHints::of(&described).expect("valid hints");
        assert!(hints.named().iter().any(|named| named.size_is_stated), "{hints:?}");
        let options = RequestOptions::default();
        let recognition =
            recognize(&alone(&image), 5, &options, Some(&hints), &reader, &stop).expect("recognized");
        let mug = recognition.objects.iter().find(|object| object.category == "mug").expect("a mug");
        assert!((mug.size_m.z / (0.01 * height_cm) - 1.0).abs() < 0.2, "{} for {height_cm} cm", mug.size_m.z);
        recognition.table.size_m.x
    };
    let (small, large) = (width_m(8.0), width_m(12.0));
    assert!((large / small - 1.5).abs() < 0.05, "{small} {large}");
}

#[test]
fn images_without_table_are_rejected() {
    let stop = CancelFlag::default();
    let reader = reader();
    let code =
        |image: &Image| match recognize(&alone(image), 1, &RequestOptions::default(), None, &reader, &stop) {
            Err(ProviderError::Rejected { code, .. }) => code,
            other => panic!("{other:?}"),
        };
    let codes = ["no_table_top", "no_objects", "camera_unclear"];
    assert!(codes.contains(&code(&Image::filled(400, 300, [230, 230, 232, 255]))));
    assert_eq!(code(&Image::filled(40, 30, [230, 230, 232, 255])), "image_too_small");
    let mut noise = Image::filled(400, 300, [0; 4]);
    for y in 0..300 {
        for x in 0..400 {
            let k = (x * 7919 + y * 104_729 + x * y * 31) % 256;
            noise.set_pixel(x, y, [k as u8, (k * 7 % 256) as u8, (k * 13 % 256) as u8, 255]);
        }
    }
    assert!(codes.contains(&code(&noise)));
}

#[test]
fn reader_caches_each_image_once() {
    let stop = CancelFlag::default();
    let image = rendered_table(0.0, 35.0).0;
    let shared = reader();
    let again = shared.clone();
    let [first, same] =
        [&shared, &again].map(|reader| reader.reading(&image, None, &stop).expect("readable"));
    assert!(Arc::ptr_eq(&first, &same));
    // The mirror image has the same size and other pixels.
    let mut mirrored = image.clone();
    for y in 0..image.height_px() {
        (0..image.width_px())
            .for_each(|x| mirrored.set_pixel(x, y, image.pixel(image.width_px() - 1 - x, y)));
    }
    let other = again.reading(&mirrored, None, &stop).expect("readable");
    assert!(!Arc::ptr_eq(&first, &other));
}
