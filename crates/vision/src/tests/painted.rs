//! Scenes set by hand and painted, with everything known of them.

use glam::{DVec2, DVec3};

use crate::VisionSettings;
use catalog::{Recipe, build, build_table, category};
use geometry::{Camera, Pose, TexturedMesh};
use imaging::{Image, Mask};
use render::{Background, Lighting, RenderObject, RenderScene, RenderSettings, View, render};

/// Settings as shipped.
pub fn settings() -> VisionSettings {
    VisionSettings {
        work_px: 768,
        fov_x_rad: 35_f64.to_radians(),
        backdrop_share: 0.6,
        backdrop_distance: 6.0,
        surface_sigmas: 3.2,
        min_table_share: 0.06,
        min_outline_fit: 0.9,
        max_outline_residual: 0.02,
        shadow_darkest: 0.22,
        shadow_hue: 0.13,
        min_object_share: 0.0004,
        max_object_share: 0.5,
        max_objects: 48,
    }
}

/// What is to be painted.
#[derive(Clone, Copy)]
pub struct Setting<'a> {
    pub table: &'a str,
    pub material: &'a str,
    pub size_m: DVec3,
    /// Category, place (x, y) in meters, yaw in degrees.
    pub objects: &'a [(&'a str, f64, f64, f64)],
    pub azimuth_deg: f64,
    pub elevation_deg: f64,
    pub floor: bool,
    pub width_px: u32,
    pub height_px: u32,
}

/// A painted scene and the truth about it.
pub struct Painted {
    pub picture: Image,
    pub camera: Camera,
    /// Pixels inside the table's outline, whatever stands on it.
    pub top: Mask,
    pub outline_px: Vec<DVec2>,
    /// Visible pixels, place and extents of each object; the middle of its box, not its origin.
    pub objects: Vec<(String, Mask, DVec2, DVec3)>,
}

pub fn paint(setting: &Setting) -> Painted {
    let table = build_table(setting.table, setting.size_m, None, Some(setting.material), 7).expect("a model");
    let meshes: Vec<(TexturedMesh, Pose)> = setting
        .objects
        .iter()
        .enumerate()
        .map(|(k, &(name, x, y, yaw_deg))| {
            let category = category(name).unwrap_or_else(|| panic!("no category {name}"));
            let recipe = Recipe {
                category: name.to_owned(),
                size_m: category.size.typical_m(),
                color: None,
                material: None,
                seed: 11 + k as u64,
            };
            let mesh = build(&recipe).expect("a generator");
            (mesh, Pose::upright(DVec3::new(x, y, 0.0), f64::to_radians(yaw_deg)))
        })
        .collect();
    let (azimuth, elevation) = (setting.azimuth_deg.to_radians(), setting.elevation_deg.to_radians());
    // As far as shows the whole table with a margin.
    let corners = |camera: &Camera| {
        let (low, high) = table.mesh.bounds();
        (0..8)
            .map(|k| {
                let pick = |bit: usize, l: f64, h: f64| if k >> bit & 1 == 0 { l } else { h };
                DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, 0.25))
            })
            .all(|p| {
                camera.project(p).is_some_and(|(q, _)| {
                    let (w, h) = (f64::from(camera.width_px), f64::from(camera.height_px));
                    q.x > 0.03 * w && q.x < 0.97 * w && q.y > 0.03 * h && q.y < 0.97 * h
                })
            })
    };
    let aim = DVec3::new(0.0, 0.0, -0.25);
    let camera_at = |distance: f64| {
        let (w, h) = (setting.width_px, setting.height_px);
        Camera::orbit(w, h, 35_f64.to_radians(), aim, azimuth, elevation, distance)
    };
    let distance = (0..80).map(|k| 1.2 * 1.04_f64.powi(k)).find(|&d| corners(&camera_at(d))).unwrap_or(8.0);
    let camera = camera_at(distance);
    let mut objects = vec![RenderObject { mesh: &table.mesh, world_from_object: Pose::IDENTITY, id: 1 }];
    objects.extend(meshes.iter().enumerate().map(|(k, (mesh, pose))| RenderObject {
        mesh,
        world_from_object: *pose,
        id: k as u32 + 2,
    }));
    let background =
        if setting.floor { Background::light_with_floor(-setting.size_m.z) } else { Background::light() };
    let scene = RenderScene { objects, lighting: Lighting::studio(azimuth - 0.6, 0.95, 0.6), background };
    let quality =
        RenderSettings { supersampling: 2, shadow_map_px: 1024, sky_directions: 12, sky_map_px: 192 };
    let frame = render(&scene, &View::Perspective(camera), &quality);
    let outline_px: Vec<DVec2> = table
        .outline_m
        .corners()
        .iter()
        .map(|c| camera.project(c.extend(0.0)).expect("in front of the camera").0)
        .collect();
    let top = Mask::from_fn(setting.width_px, setting.height_px, |x, y| {
        let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        camera.meet_plane(pixel, 0.0).is_some_and(|p| table.outline_m.contains(p.truncate()))
    });
    let known = meshes
        .iter()
        .enumerate()
        .map(|(k, (mesh, pose))| {
            let turned = mesh.clone().rotated(pose.rotation).translated(pose.translation_m);
            let (low, high) = turned.bounds();
            let middle = 0.5 * (low + high).truncate();
            (setting.objects[k].0.to_owned(), frame.mask(k as u32 + 2), middle, mesh.size_m())
        })
        .collect();
    Painted { picture: frame.color, camera, top, outline_px, objects: known }
}

/// A setting of the test: rectangular and round, low and high, with and without floor shadow.
pub fn settings_to_paint() -> Vec<(&'static str, Setting<'static>)> {
    const DINING: &[(&str, f64, f64, f64)] = &[
        ("mug", -0.35, 0.1, 30.0),
        ("plate", 0.0, -0.05, 0.0),
        ("wine_bottle", 0.35, 0.22, 0.0),
        ("bowl", 0.38, -0.15, 0.0),
        ("apple", -0.15, 0.25, 0.0),
        ("book", -0.45, -0.2, 20.0),
    ];
    const OFFICE: &[(&str, f64, f64, f64)] = &[
        ("laptop", 0.0, 0.05, 0.0),
        ("mug", 0.4, 0.1, -40.0),
        ("notebook", -0.42, -0.05, 15.0),
        ("potted_plant", -0.45, 0.22, 0.0),
        ("stapler", 0.38, -0.2, 60.0),
    ];
    const ROUND: &[(&str, f64, f64, f64)] = &[
        ("teapot", 0.05, 0.15, 20.0),
        ("teacup", -0.25, -0.05, 0.0),
        ("teacup", 0.25, -0.05, 120.0),
        ("plate", 0.0, -0.25, 0.0),
        ("bread_loaf", -0.25, 0.25, 30.0),
    ];
    let base = Setting {
        table: "dining_table",
        material: "oak",
        size_m: DVec3::new(1.4, 0.8, 0.74),
        objects: DINING,
        azimuth_deg: 0.0,
        elevation_deg: 35.0,
        floor: true,
        width_px: 1024,
        height_px: 768,
    };
    let desk = Setting {
        table: "desk",
        material: "birch",
        objects: OFFICE,
        elevation_deg: 40.0,
        size_m: DVec3::new(1.3, 0.7, 0.74),
        width_px: 1024,
        height_px: 1024,
        ..base
    };
    let round = Setting {
        table: "round_table",
        material: "walnut",
        objects: ROUND,
        elevation_deg: 45.0,
        size_m: DVec3::new(1.0, 1.0, 0.74),
        ..base
    };
    vec![
        ("dining_35", base),
        ("dining_55", Setting { elevation_deg: 55.0, azimuth_deg: 12.0, floor: false, ..base }),
        ("walnut_45", Setting { material: "walnut", elevation_deg: 45.0, azimuth_deg: -20.0, ..base }),
        ("desk_40", desk),
        ("round_45", round),
        (
            "round_30",
            Setting { material: "pine", elevation_deg: 30.0, size_m: DVec3::new(1.1, 1.1, 0.74), ..round },
        ),
    ]
}
