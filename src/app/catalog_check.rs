//! Checks of categories: their meshes, hulls and masses, whether they stand, and images of them.

use std::sync::atomic::{AtomicUsize, Ordering};

use catalog::checks::{CHECKS, Check, nowhere_inside_out};
use catalog::{Category, Recipe, build};
use geometry::decompose::{DecomposeError, decompose_and_fit};
use geometry::shapes::block;
use geometry::solid_query::MeshSolid;
use geometry::{Camera, DVec3, Material, Pose, Rgb, TexturedMesh};
use imaging::Image;
use physics::{Body, stability};
use rayon::prelude::*;
use render::annotate::sheet;
use render::{Background, Lighting, RenderObject, RenderScene, View};
use runtime::CancelFlag;
use runtime::seed::{child_rng, child_seed};
use serde::Serialize;

use crate::config::Config;
use crate::pipeline::catalog_body::{CatalogBodyError, body_of, body_with};
use crate::pipeline::certify::uncovered_m;

/// Objects of a category that are built: of different sizes, colors and details.
const SEEDS: u64 = 3;
/// Side of an image on the sheet, pixels.
const IMAGE_PX: u32 = 256;
const COLUMNS: usize = 6;
/// Densities of solid objects and of hollow ones, of cotton and of gold.
const DENSITIES_KG_M3: std::ops::RangeInclusive<f64> = 5.0..=19_500.0;

/// Objects of a category, and their faults.
#[derive(Debug, Serialize)]
pub struct CategoryFinding {
    pub name: String,
    pub objects: Vec<ObjectFinding>,
    /// Faults, in words; none of a sound category.
    pub objections: Vec<String>,
}

/// An object of a category.
#[derive(Debug, Serialize)]
pub struct ObjectFinding {
    pub size_m: [f64; 3],
    pub mass_kg: f64,
    pub triangles: usize,
    pub hulls: usize,
    /// The way that it moves in the time of the certificate's simulation, meters, and the angle, radians.
    pub moved_m: f64,
    pub turned_rad: f64,
}

/// The findings of some categories, and a sheet with an image of each object. After each object `seen` gets the number
/// of those checked, and of all.
pub fn check(
    categories: &[&Category],
    config: &Config,
    seen: impl Fn(usize, usize) + Sync,
) -> (Vec<CategoryFinding>, Image) {
    let recipes: Vec<(&Category, u64)> =
        categories.iter().flat_map(|category| (0..SEEDS).map(move |seed| (*category, seed))).collect();
    let done = AtomicUsize::new(0);
    let one = |(category, seed): &(&Category, u64)| {
        let checked = checked(category, *seed, config);
        seen(done.fetch_add(1, Ordering::Relaxed) + 1, recipes.len());
        checked
    };
    let checked: Vec<_> = recipes.par_iter().map(one).collect();
    let mut findings: Vec<CategoryFinding> = Vec::new();
    let mut images: Vec<(&Image, &str)> = Vec::new();
    for ((category, seed), object) in recipes.iter().zip(&checked) {
        if *seed == 0 {
            let (objects, objections) = (Vec::new(), Vec::new());
            findings.push(CategoryFinding { name: category.name.clone(), objects, objections });
        }
        let Some(finding) = findings.last_mut() else { continue };
        finding.objections.extend(object.objections.iter().map(|why| format!("object {seed}: {why}")));
        if let Some((found, image)) = &object.found {
            images.push((image, &category.name));
            finding.objects.push(ObjectFinding { ..*found });
        }
    }
    (findings, sheet(&images, COLUMNS, IMAGE_PX))
}

/// An object with what is wrong with it.
struct Checked {
    /// Absent where it has no body.
    found: Option<(ObjectFinding, Image)>,
    objections: Vec<String>,
}

fn checked(category: &Category, seed: u64, config: &Config) -> Checked {
    let recipe = Recipe {
        category: category.name.clone(),
        size_m: category.size.sample(&mut child_rng(seed, "size")),
        color: None,
        material: None,
        seed: child_seed(seed, "mesh"),
    };
    let (body, mesh, mut objections) = match body(&recipe, config) {
        Ok(made) => made,
        Err(error) => return Checked { found: None, objections: vec![error.to_string()] },
    };
    let checks = CHECKS.into_iter().chain([nowhere_inside_out as Check]);
    objections.extend(checks.filter_map(|check| check(&recipe, &mesh)));
    let density_kg_m3 = body.mass.mass_kg / mesh_volume_m3(&mesh).max(f64::MIN_POSITIVE);
    if !DENSITIES_KG_M3.contains(&density_kg_m3) {
        objections.push(format!(
            "it weighs {:.3} kg, {density_kg_m3:.0} kg for each cubic meter of its mesh; see `mass_kg`",
            body.mass.mass_kg
        ));
    }
    let (mass_kg, hulls) = (body.mass.mass_kg, body.hulls.len());
    let (mut moved_m, mut turned_rad) = (0.0, 0.0);
    let simulated = table(config)
        .map(|table| stability(&[table, body], &config.certify, &config.settle, &CancelFlag::default()));
    match simulated {
        Ok(Ok(stable)) => {
            let movement = stable.movements[1];
            (moved_m, turned_rad) = (movement.displacement_m, movement.rotation_rad);
            if !movement.at_rest {
                let (moved_mm, turned_deg) = (1e3 * moved_m, turned_rad.to_degrees());
                objections.push(format!(
                    "alone on a table it moves {moved_mm:.1} mm and turns {turned_deg:.1} degrees; \
                     widen its foot, or set `rest_m` of its shape"
                ));
            }
        }
        Ok(Err(error)) => objections.push(error.to_string()),
        Err(error) => objections.push(error.to_string()),
    }
    let found = ObjectFinding {
        size_m: mesh.size_m().to_array(),
        mass_kg,
        triangles: mesh.triangle_count(),
        hulls,
        moved_m,
        turned_rad,
    };
    Checked { found: Some((found, image(&mesh, config))), objections }
}

/// The body of a recipe with its mesh, and what the certificate would object to in its hulls.
fn body(recipe: &Recipe, config: &Config) -> Result<(Body, TexturedMesh, Vec<String>), CatalogBodyError> {
    let mesh = build(recipe).ok_or(CatalogBodyError::NoMesh)?;
    let (found, fit) = decompose_and_fit(&mesh, &config.decompose, &CancelFlag::default())?;
    let (limits, outside_m) = (config.health.thresholds(), uncovered_m(&mesh, &found.hulls));
    let mut objections = Vec::new();
    if !MeshSolid::new(&mesh).map_err(DecomposeError::from)?.is_watertight() {
        objections.push(
            "the mesh is not watertight where its parts meet; move them by half a millimeter".to_owned(),
        );
    }
    if outside_m > limits.max_uncovered_m(mesh.size_m().to_array()) {
        let outside_mm = 1e3 * outside_m;
        objections.push(format!(
            "a part lies {outside_mm:.1} mm outside all of its {} hulls; make thin shells solid, and drop small parts",
            found.hulls.len()
        ));
    }
    if found.max_excess_m > limits.hull_excess_m {
        objections.push(format!("a hull sticks out of the mesh by {:.1} mm", 1e3 * found.max_excess_m));
    }
    if fit.open_share < limits.open_share {
        let percent = 100.0 * fit.open_share;
        objections.push(format!("its hulls leave {percent:.0} % of its openings open; thicken its walls"));
    }
    let body = body_with(&recipe.category, &mesh, &recipe.category, found.hulls)?;
    Ok((body, mesh, objections))
}

/// Volume that the mesh encloses; overlaps of parts count twice.
fn mesh_volume_m3(mesh: &TexturedMesh) -> f64 {
    let corners = |t: [u32; 3]| t.map(|v| mesh.positions[v as usize]);
    mesh.triangles().map(corners).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// A large table whose top is at z = 0.
fn table(config: &Config) -> Result<Body, CatalogBodyError> {
    let top = block(DVec3::new(4.0, 4.0, 0.1)).translated(DVec3::new(0.0, 0.0, -0.1));
    let mut mesh = TexturedMesh::default();
    mesh.add(top, &Material::plain("top", Rgb::hex(0xb0_84_55), 0.5));
    Ok(Body { fixed: true, ..body_of("table", &mesh, "table", &config.decompose)? })
}

/// From the front, a little from the right and above.
fn image(mesh: &TexturedMesh, config: &Config) -> Image {
    let (azimuth_rad, elevation_rad, field_rad) = (0.5, 0.5, 0.5);
    let (low_m, high_m) = mesh.bounds();
    let radius_m = 0.5 * (high_m - low_m).length();
    let distance_m = 1.1 * radius_m / (0.5_f64 * field_rad).sin();
    let center_m = 0.5 * (low_m + high_m);
    let camera =
        Camera::orbit(IMAGE_PX, IMAGE_PX, field_rad, center_m, azimuth_rad, elevation_rad, distance_m);
    let object = RenderObject { mesh, world_from_object: Pose::IDENTITY, id: 1 };
    let scene = RenderScene {
        objects: vec![object],
        lighting: Lighting::studio(azimuth_rad - 0.7, 0.95, 0.6),
        background: Background::light_with_floor(0.0),
    };
    render::render(&scene, &View::Perspective(camera), &config.render).color
}
