//! Renders every category and every table model of the catalog, labelled, onto sheets, and a few sentences
//! as whole scenes: `cargo run --release --example contact_sheet -- OUT_DIR [objects|scenes] [SENTENCE]...`.
//!
//! With `RUST_LOG=tabletopgen=debug` the image generator says how long each of its steps takes.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use catalog::{Recipe, build, build_table, categories, table_models};
use embedded::image_generator::EmbeddedImageGenerator;
use embedded::single_view_reconstruction::SingleViewSettings;
use embedded::text_parser::{DescribeOptions, describe};
use geometry::{Camera, DVec3, Pose, TexturedMesh};
use imaging::Image;
use imaging::codec::encode_png;
use ports::{Call, ImageGenerator};
use rayon::prelude::*;
use render::annotate::sheet;
use render::{Background, Lighting, RenderObject, RenderScene, RenderSettings, View, render};
use runtime::CancelFlag;
use runtime::CpuPool;
use tabletopgen::config::Sources;
use tabletopgen::config::layers::load;

/// Four families, and tables of other shapes.
const SENTENCES: &[&str] = &[
    "an office desk",
    "a dinner for two",
    "a workbench with a hammer, three screwdrivers, pliers and a wrench",
    "a sewing table",
    "a round breakfast table",
    "a hobby desk",
    "a stack of three books with a mug on top, a desk lamp and four pencils in a pen holder",
    "tea time on an oval table",
    "a triangular table with a bowl of apples, a vase and two candles",
    "game night",
    "a kidney-shaped table with a laptop, a mouse to its right and a mug with a spoon in it",
    "a painting table",
    "a mechanic's bench",
    "kitchen table with a cutting board, two tomatoes on the board, a frying pan and four eggs in a bowl",
    "coffee table in the living room",
    "four plates around a vase, each with a fork and a knife",
];

/// Objects on a sheet.
const PER_SHEET: usize = 64;

const RENDER: RenderSettings =
    RenderSettings { supersampling: 2, shadow_map_px: 1024, sky_directions: 24, sky_map_px: 192 };

fn main() -> Result<(), Box<dyn Error>> {
    tracing_subscriber::fmt().with_env_filter(tracing_subscriber::EnvFilter::from_default_env()).init();
    let mut arguments = std::env::args().skip(1);
    let out: PathBuf = arguments.next().ok_or("say where to write: contact_sheet OUT_DIR")?.into();
    let what = arguments.next();
    std::fs::create_dir_all(&out)?;
    if what.as_deref() != Some("scenes") {
        objects(&out)?;
    }
    if what.as_deref() != Some("things") {
        let own: Vec<String> = arguments.collect();
        let sentences: Vec<&str> =
            if own.is_empty() { SENTENCES.to_vec() } else { own.iter().map(String::as_str).collect() };
        let failures = scenes(&out, &sentences)?;
        if failures > 0 {
            return Err(format!("{failures} sentences were not painted").into());
        }
    }
    Ok(())
}

/// Sheets of each family of categories and one of tables.
fn objects(out: &Path) -> Result<(), Box<dyn Error>> {
    let families = ["dining_kitchen", "office_living", "workbench_utility", "crafting_hobby"];
    for family in families {
        let kinds: Vec<_> = categories().iter().filter(|kind| kind.families[0] == family).collect();
        let images: Vec<Option<(Image, String)>> = kinds
            .par_iter()
            .map(|kind| {
                let size_m = kind.size.typical_m();
                let recipe =
                    Recipe { category: kind.name.clone(), size_m, color: None, material: None, seed: 7 };
                build(&recipe).map(|mesh| (portrait(&mesh, 0.0), kind.label.clone()))
            })
            .collect();
        for (page, images) in images.chunks(PER_SHEET).enumerate() {
            write_sheet(&out.join(format!("catalog_{family}_{page}.png")), images)?;
        }
    }
    let tables: Vec<Option<(Image, String)>> = table_models()
        .par_iter()
        .map(|model| {
            let size_m = 0.5 * (model.low_m + model.high_m);
            build_table(model.name, size_m, None, None, 3)
                .map(|table| (portrait(&table.mesh, -size_m.z), model.label.to_owned()))
        })
        .collect();
    write_sheet(&out.join("catalog_tables.png"), &tables)
}

fn write_sheet(path: &Path, images: &[Option<(Image, String)>]) -> Result<(), Box<dyn Error>> {
    let cells: Vec<(&Image, &str)> = images.iter().flatten().map(|(p, label)| (p, label.as_str())).collect();
    std::fs::write(path, encode_png(&sheet(&cells, 8, 200)))?;
    Ok(())
}

/// The mesh from the front left, filling the frame.
fn portrait(mesh: &TexturedMesh, floor_z_m: f64) -> Image {
    let (low, high) = mesh.bounds();
    let center: DVec3 = 0.5 * (low + high);
    let distance_m = 1.75 * (high - low).length();
    let camera = Camera::orbit(400, 400, 0.6, center, -0.5, 0.6, distance_m);
    let scene = RenderScene {
        objects: vec![RenderObject { mesh, world_from_object: Pose::IDENTITY, id: 1 }],
        lighting: Lighting::studio(0.9, 0.95, 0.7),
        background: Background::light_with_floor(floor_z_m),
    };
    render(&scene, &View::Perspective(camera), &RENDER).color
}

/// Renders each sentence; the number of those that failed.
fn scenes(out: &Path, sentences: &[&str]) -> Result<usize, Box<dyn Error>> {
    let config = load(Sources::default())?.config;
    let image_generator = EmbeddedImageGenerator {
        photograph: SingleViewSettings { sizes: config.photograph, naming: config.category_fit },
        layout: config.layout,
        image_generator: config.image_generator,
        render: config.render,
        decompose: config.decompose,
        settle: config.settle,
        resolve: config.resolve,
        certify: config.certify,
    };
    let call = Call::without_budget(CpuPool::new(0)?, CancelFlag::default());
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let mut failures = 0;
    let mut report = String::new();
    for (number, sentence) in sentences.iter().enumerate() {
        let seed = number as u64 + 1;
        let described = describe(
            sentence,
            seed,
            &DescribeOptions { max_objects: 64, table: None, on_unknown: Default::default() },
            &config.analyst,
        )?;
        let count = described.objects.len();
        let start = Instant::now();
        let rendered = runtime.block_on(image_generator.reference(&call, Arc::new(described), seed));
        let seconds = start.elapsed().as_secs_f64();
        match rendered {
            Ok(generated) => {
                std::fs::write(out.join(format!("scene_{number:02}.png")), encode_png(&generated.image))?;
                if let Some(ground_truth) = &generated.ground_truth {
                    if let Some(top) = &ground_truth.top {
                        std::fs::write(out.join(format!("top_{number:02}.png")), encode_png(&top.image))?;
                    }
                    let alone: Vec<(&Image, &str)> = ground_truth
                        .alone
                        .iter()
                        .map(|alone| (&alone.completion.image, alone.id.as_str()))
                        .collect();
                    std::fs::write(
                        out.join(format!("alone_{number:02}.png")),
                        encode_png(&sheet(&alone, 6, 200)),
                    )?;
                }
                report += &format!("{number:02} {seconds:6.2} s {count:3} objects  {sentence}\n");
            }
            Err(error) => {
                failures += 1;
                report += &format!("{number:02} {seconds:6.2} s {count:3} objects  {sentence}: {error}\n");
            }
        }
    }
    std::fs::write(out.join("scenes.txt"), report)?;
    Ok(failures)
}
