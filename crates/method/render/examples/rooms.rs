//! Renders laid tables of the catalog in rooms of several seeds, and tells how long an image takes:
//! `cargo run --release -p tabletopgen-render --example rooms -- OUT_DIR`.

use std::error::Error;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use catalog::{Recipe, build, build_table, category};
use geometry::{Camera, DVec3, Pose, TexturedMesh};
use imaging::codec::encode_png;
use render::{Background, Lighting, RenderObject, RenderSettings, Room, SceneCache, Tabletop, View};

const SETTINGS: RenderSettings =
    RenderSettings { supersampling: 2, shadow_map_px: 1024, sky_directions: 16, sky_map_px: 256 };

/// Name, table model and its material, seed of the room, and objects with their places.
type LaidTable = (&'static str, &'static str, &'static str, u64, &'static [(&'static str, f64, f64)]);

const SCENES: [LaidTable; 4] = [
    (
        "shiny",
        "dining_table",
        "walnut",
        1,
        &[
            ("wine_glass", -0.15, -0.1),
            ("drinking_glass", -0.05, -0.22),
            ("saucepan", 0.2, 0.12),
            ("kettle", -0.1, 0.15),
            ("spoon", 0.05, -0.2),
            ("soda_can", -0.3, 0.05),
            ("soda_can", -0.36, -0.04),
        ],
    ),
    (
        "desk",
        "dining_table",
        "oak",
        2,
        &[("laptop", 0.0, 0.05), ("mug", -0.25, 0.1), ("book", 0.28, -0.12), ("desk_lamp", -0.32, 0.2)],
    ),
    (
        "tools",
        "dining_table",
        "pine",
        3,
        &[("hammer", -0.2, 0.0), ("power_drill", 0.1, 0.1), ("wrench", 0.2, -0.15)],
    ),
    (
        "breakfast",
        "dining_table",
        "white_lacquer",
        6,
        &[
            ("plate", 0.0, -0.1),
            ("teapot", -0.2, 0.15),
            ("bowl", 0.25, 0.05),
            ("fork", -0.2, -0.12),
            ("mug", 0.15, -0.2),
        ],
    ),
];

fn main() -> Result<(), Box<dyn Error>> {
    let out: PathBuf = std::env::args().nth(1).ok_or("say where to write: rooms OUT_DIR")?.into();
    std::fs::create_dir_all(&out)?;
    for (name, model, wood, seed, objects) in SCENES {
        let meshes = laid(model, wood, objects).ok_or("the catalog lacks something")?;
        let bodies = meshes.iter().zip(1..).map(|((mesh, world_from_object), id)| RenderObject {
            mesh,
            world_from_object: *world_from_object,
            id,
        });
        let bodies: Vec<RenderObject> = bodies.collect();
        let (low, high) = meshes[0].0.bounds();
        let room = Room::around(low, high, Tabletop::of(&bodies[0]), seed);
        let start = Instant::now();
        let scene_cache = SceneCache::new(bodies, &SETTINGS).for_rooms();
        let cached = start.elapsed();
        let target = DVec3::new(0.0, 0.0, 0.05);
        for (view_name, azimuth_rad, elevation_rad, distance_m) in
            [("hero", 0.42, 0.6, 1.75), ("side", 0.0, 0.3, 3.2), ("left", -1.57, 0.3, 3.2)]
        {
            let target = if view_name == "hero" { target } else { target - DVec3::Z * 0.3 };
            let camera = Camera::orbit(960, 720, 0.52, target, azimuth_rad, elevation_rad, distance_m);
            let view = View::Perspective(camera);
            let plain = Lighting::studio(azimuth_rad - 0.7, 0.95, 0.6);
            let start = Instant::now();
            let old = scene_cache.color(plain, Background::light_with_floor(low.z), &view);
            let old_took = start.elapsed();
            let lighting = Lighting::daylight(azimuth_rad - 0.7, 0.95).exposed_for(&room);
            let start = Instant::now();
            let new = scene_cache.color(lighting, Background::in_room(room), &view);
            let took = start.elapsed();
            writeln!(
                std::io::stdout().lock(),
                "{name} {view_name}: cache {cached:.0?}, plain {old_took:.0?}, room {took:.0?}"
            )?;
            std::fs::write(out.join(format!("{name}_{view_name}_plain.png")), encode_png(&old))?;
            std::fs::write(out.join(format!("{name}_{view_name}.png")), encode_png(&new))?;
        }
    }
    Ok(())
}

/// The table and the objects on it, each of its typical size.
fn laid(model: &str, wood: &str, objects: &[(&str, f64, f64)]) -> Option<Vec<(TexturedMesh, Pose)>> {
    let table = build_table(model, DVec3::new(1.1, 0.8, 0.74), None, Some(wood), 4)?;
    let mut placed = vec![(table.mesh, Pose::IDENTITY)];
    for (k, (name, x, y)) in objects.iter().enumerate() {
        let size_m = category(name)?.size.typical_m();
        let recipe = Recipe { category: (*name).into(), size_m, color: None, material: None, seed: k as u64 };
        placed.push((build(&recipe)?, Pose::upright(DVec3::new(*x, *y, 0.0), 0.7 * k as f64)));
    }
    Some(placed)
}
