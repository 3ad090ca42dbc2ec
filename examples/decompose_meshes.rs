//! Writes meshes and their hulls for `benches/decompose_beside_coacd.py`, which compares them with those of another
//! program.
//!
//! `cargo run --release --example decompose_meshes -- meshes OUT_DIR FOLDER` writes thirty objects of the catalog and
//! the OBJ files of a folder, repaired, one OBJ file each with an `o` line before each closed shell, and prints what
//! repairing changed. `... -- hulls OUT_DIR FILE=HULLS...` cuts each OBJ file into at most so many hulls in one thread,
//! writes them as an OBJ file of the same name with an `o` line before each, and prints name, CPU seconds and how far
//! they stick out. `... -- hulls OUT_DIR FILE=shipped` does it with the shipped settings. Meters.

use std::error::Error;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use catalog::{Recipe, build, category};
use geometry::decompose::{DecomposeSettings, decompose};
use geometry::repair::repaired;
use geometry::shells::shells;
use geometry::{DVec3, Material, Rgb, Solid, TexturedMesh, Vec2, Vec3};
use runtime::CancelFlag;
use runtime::seed::{child_rng, child_seed};
use tabletopgen::config::Sources;
use tabletopgen::config::layers::load;

/// Thin-walled, hollow, with handles, forked, of many parts: what a decomposition can get wrong.
const CATEGORIES: [&str; 30] = [
    "basket",
    "bookend",
    "bowl",
    "c_clamp",
    "cactus",
    "chess_pawn",
    "desk_lamp",
    "donut",
    "eyeglasses",
    "file_tray",
    "headphones",
    "ladle",
    "model_airplane",
    "mug",
    "napkin_holder",
    "pen_holder",
    "pitcher",
    "plate",
    "pliers",
    "potted_plant",
    "power_drill",
    "saucepan",
    "scissors",
    "storage_bin",
    "teacup",
    "teapot",
    "teddy_bear",
    "tray",
    "whisk",
    "wine_glass",
];

fn main() -> Result<(), Box<dyn Error>> {
    const USAGE: &str =
        "say what to do: decompose_meshes meshes OUT_DIR FOLDER | hulls OUT_DIR FILE=HULLS...";
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let shipped = load(Sources::default())?.config.decompose;
    match &arguments[..] {
        [what, out, folder] if what == "meshes" => meshes(Path::new(out), Path::new(folder), &shipped),
        [what, out, files @ ..] if what == "hulls" => hulls(Path::new(out), files, &shipped),
        _ => Err(USAGE.into()),
    }
}

fn meshes(out: &Path, folder: &Path, settings: &DecomposeSettings) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(out)?;
    let mut all: Vec<(String, TexturedMesh)> = Vec::new();
    for name in CATEGORIES {
        let known = category(name).ok_or_else(|| format!("the catalog has no {name}"))?;
        let recipe = Recipe {
            category: name.to_owned(),
            size_m: known.size.sample(&mut child_rng(0, "size")),
            color: None,
            material: None,
            seed: child_seed(0, "mesh"),
        };
        all.push((name.to_owned(), build(&recipe).ok_or_else(|| format!("{name} cannot be built"))?));
    }
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder)?.map(|entry| entry.map(|e| e.path())).collect::<Result<_, _>>()?;
    files.retain(|path| path.extension().is_some_and(|extension| extension == "obj"));
    files.sort();
    for path in files {
        all.push((stem(&path)?, read_obj(&path)?));
    }
    for (name, mesh) in all {
        let (shells, repair) = repaired(shells(&mesh), settings.min_thickness_m);
        let surfaces = shells.iter().map(|shell| (&shell.points[..], &shell.triangles[..]));
        std::fs::write(out.join(format!("{name}.obj")), obj(surfaces))?;
        writeln!(std::io::stdout(), "{name} {}", serde_json::to_string(&repair)?)?;
    }
    Ok(())
}

fn hulls(out: &Path, files: &[String], shipped: &DecomposeSettings) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(out)?;
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    for file in files {
        let (path, highest) = file.rsplit_once('=').ok_or_else(|| format!("{file}: say FILE=HULLS"))?;
        let mesh = read_obj(Path::new(path))?;
        let settings =
            if highest == "shipped" { shipped.clone() } else { closest(highest.parse()?, shipped) };
        let measured = one_thread.install(|| {
            let started = cpu_seconds();
            let found = decompose(&mesh, &settings, &CancelFlag::default());
            (found, started, cpu_seconds())
        });
        let (found, cpu_s) = (measured.0?, measured.2? - measured.1?);
        let name = stem(Path::new(path))?;
        let surfaces = found.hulls.iter().map(|hull| (&hull.points[..], &hull.triangles[..]));
        std::fs::write(out.join(format!("{name}.obj")), obj(surfaces))?;
        writeln!(std::io::stdout(), "{name} {cpu_s} {}", found.max_excess_m)?;
    }
    Ok(())
}

/// Settings that make the most of a number of hulls: what tells them apart is volume, not how far they stick out.
fn closest(max_hulls: u32, shipped: &DecomposeSettings) -> DecomposeSettings {
    DecomposeSettings {
        tolerance_m: 0.0001,
        joined_excess_m: 1.0,
        max_hulls,
        max_pieces: (4 * max_hulls).clamp(shipped.max_pieces, 512),
        ..shipped.clone()
    }
}

/// Time this thread has run, which other programs on the machine do not lengthen.
fn cpu_seconds() -> std::io::Result<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat")?;
    let nanoseconds = text.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
    nanoseconds.map(|ns| ns * 1e-9).ok_or_else(|| std::io::Error::other("schedstat tells no time"))
}

fn stem(path: &Path) -> Result<String, Box<dyn Error>> {
    let stem = path.file_stem().and_then(|stem| stem.to_str());
    Ok(stem.ok_or_else(|| format!("{} has no name", path.display()))?.to_owned())
}

/// Corners and triangles of an OBJ file; polygons are cut into fans.
fn read_obj(path: &Path) -> Result<TexturedMesh, Box<dyn Error>> {
    let mut solid = Solid::default();
    for line in std::fs::read_to_string(path)?.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let at: Vec<f64> = words.take(3).map(str::parse).collect::<Result<_, _>>()?;
                let [x, y, z] = at[..] else { return Err(format!("{}: {line}", path.display()).into()) };
                solid.positions.push(DVec3::new(x, y, z));
            }
            Some("f") => {
                let corners: Vec<u32> = words
                    .map(|word| word.split('/').next().unwrap_or_default().parse::<u32>().map(|v| v - 1))
                    .collect::<Result<_, _>>()?;
                solid.triangles.extend(corners.windows(2).skip(1).map(|w| [corners[0], w[0], w[1]]));
            }
            _ => {}
        }
    }
    solid.normals = vec![Vec3::Z; solid.positions.len()];
    solid.uvs = vec![Vec2::ZERO; solid.positions.len()];
    let mut mesh = TexturedMesh::default();
    mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
    Ok(mesh)
}

fn obj<'a>(surfaces: impl Iterator<Item = (&'a [DVec3], &'a [[u32; 3]])>) -> String {
    let mut text = String::new();
    let mut first = 1;
    for (index, (points, triangles)) in surfaces.enumerate() {
        let _ = writeln!(text, "o part_{index}");
        for p in points {
            let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
        }
        for [a, b, c] in triangles {
            let _ = writeln!(text, "f {} {} {}", first + a, first + b, first + c);
        }
        first += points.len() as u32;
    }
    text
}
