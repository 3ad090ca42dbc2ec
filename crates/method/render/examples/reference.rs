//! Renders laid tables of the catalog by the forward renderer and by the path tracer, and prints the time of an image:
//! `cargo run --release -p tabletopgen-render --example reference -- OUT_DIR [SAMPLES] [WIDTH_PX]`.

use std::error::Error;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use catalog::{Recipe, build, build_table, category};
use geometry::{Camera, DVec3, Pose, TexturedMesh};
use imaging::codec::encode_png;
use render::{
    Background, Lighting, PathTraceSettings, PathTracer, RenderObject, RenderScene, RenderSettings, Room,
    SceneCache, Tabletop, View,
};

const SETTINGS: RenderSettings =
    RenderSettings { supersampling: 2, shadow_map_px: 1024, sky_directions: 16, sky_map_px: 256 };

/// Name, material of the table, seed of the room, and objects with their places.
type LaidTable = (&'static str, &'static str, u64, &'static [(&'static str, f64, f64)]);

const SCENES: [LaidTable; 3] = [
    (
        "glass",
        "walnut",
        1,
        &[
            ("wine_glass", -0.15, -0.1),
            ("drinking_glass", -0.03, -0.2),
            ("saucepan", 0.2, 0.12),
            ("kettle", -0.1, 0.15),
            ("spoon", 0.08, -0.2),
            ("soda_can", -0.28, 0.05),
        ],
    ),
    (
        "contact",
        "oak",
        2,
        &[("mug", -0.2, 0.05), ("bowl", 0.0, 0.0), ("book", 0.22, -0.05), ("apple", -0.05, -0.2)],
    ),
    (
        "white",
        "white_lacquer",
        6,
        &[("plate", 0.0, -0.1), ("teapot", -0.2, 0.15), ("vase", 0.2, 0.1), ("fork", -0.2, -0.12)],
    ),
];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let out: PathBuf = arguments.first().ok_or("say where to write: reference OUT_DIR")?.into();
    let number = |place: usize, usual: u32| arguments.get(place).map_or(Ok(usual), |given| given.parse());
    let (samples_per_pixel, width_px) = (number(1, 64)?, number(2, 640)?);
    std::fs::create_dir_all(&out)?;
    for (name, wood, seed, objects) in SCENES {
        let meshes = laid(wood, objects).ok_or("the catalog lacks something")?;
        let bodies: Vec<RenderObject> = meshes
            .iter()
            .zip(1..)
            .map(|((mesh, world_from_object), id)| RenderObject {
                mesh,
                world_from_object: *world_from_object,
                id,
            })
            .collect();
        let (low, high) = meshes[0].0.bounds();
        let room = Room::around(low, high, Tabletop::of(&bodies[0]), seed);
        let camera =
            Camera::orbit(width_px, width_px * 3 / 4, 0.52, DVec3::new(0.0, 0.0, 0.05), 0.42, 0.6, 1.6);
        let view = View::Perspective(camera);
        let lighting = Lighting::daylight(0.42 - 0.7, 0.95).exposed_for(&room);
        let background = Background::in_room(room);
        let start = Instant::now();
        let forward =
            SceneCache::new(bodies.clone(), &SETTINGS).for_rooms().color(lighting, background, &view);
        let forward_took = start.elapsed();
        let start = Instant::now();
        let tracer = PathTracer::new(&RenderScene { objects: bodies, lighting, background });
        let prepared = start.elapsed();
        let settings =
            PathTraceSettings { samples_per_pixel, max_bounces: PathTraceSettings::MANY_BOUNCES, seed: 1 };
        let traced = tracer.image(&view, &settings, |_, _| ());
        let triangles: usize = meshes.iter().map(|(mesh, _)| mesh.triangle_count()).sum();
        writeln!(
            std::io::stdout().lock(),
            "{name}: {triangles} triangles, forward {forward_took:.2?}, tracer prepared in {prepared:.2?}, done after {:.2?}",
            start.elapsed()
        )?;
        std::fs::write(out.join(format!("{name}_high.png")), encode_png(&forward))?;
        std::fs::write(out.join(format!("{name}_reference.png")), encode_png(&traced.color))?;
    }
    Ok(())
}

/// The table and the objects on it, each of its typical size.
fn laid(wood: &str, objects: &[(&str, f64, f64)]) -> Option<Vec<(TexturedMesh, Pose)>> {
    let table = build_table("dining_table", DVec3::new(1.1, 0.8, 0.74), None, Some(wood), 4)?;
    let mut placed = vec![(table.mesh, Pose::IDENTITY)];
    for (k, (name, x, y)) in objects.iter().enumerate() {
        let size_m = category(name)?.size.typical_m();
        let recipe = Recipe { category: (*name).into(), size_m, color: None, material: None, seed: k as u64 };
        placed.push((build(&recipe)?, Pose::upright(DVec3::new(*x, *y, 0.0), 0.7 * k as f64)));
    }
    Some(placed)
}
