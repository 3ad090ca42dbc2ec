//! Every category and table decomposed: a table of how well hulls fit and what they cost.
//!
//! `cargo test --release --lib decompose::sweep -- --ignored --nocapture`

use rayon::prelude::*;

use super::tests::settings;
use super::*;
use crate::catalog::{Recipe, build, build_table, categories, table_models};
use crate::geometry::seed::{child_rng, child_seed};

struct Line {
    name: String,
    hulls: usize,
    corners: usize,
    excess_m: f64,
    uncovered_m: f64,
    fit: HullFit,
    milliseconds: f64,
    triangles: usize,
    shells: usize,
}

/// Time this thread has run, which other programs on the machine do not lengthen.
fn cpu_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split_whitespace().next().and_then(|t| t.parse::<f64>().ok()).unwrap_or(0.0) * 1e-9
}

fn measured(name: String, mesh: &TexturedMesh) -> Line {
    let started = cpu_seconds();
    let d = decompose(mesh, &settings(), &Interrupt::default()).expect("the catalog has volume");
    let milliseconds = (cpu_seconds() - started) * 1e3;
    let solid = MeshSolid::new(mesh).expect("the catalog is solid");
    for (index, shell) in shells(mesh).iter().enumerate() {
        let area_m2: f64 = shell.corners().map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum();
        let thickness_m = 2.0 * shell.volume_m3() / area_m2;
        if !shell.is_closed() || thickness_m < 4e-4 {
            let (low, high) = shell.bounds();
            eprintln!(
                "{name}: shell {index} closed {} {thickness_m:.1e} m {low:.4} {high:.4}",
                shell.is_closed()
            );
        }
    }
    let field = Field::new(&solid);
    let excess_m = d
        .hulls
        .iter()
        .map(|h| excess(h, &field, 0.0015, 0.0, f64::INFINITY, &Interrupt::default()).expect("nobody asks"))
        .map(|e| e.distance_m)
        .fold(0.0, f64::max);
    let faces: Vec<_> = d.hulls.iter().map(planes).collect();
    let uncovered_m = mesh
        .triangles()
        .flat_map(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            [a, b, c, (a + b + c) / 3.0]
        })
        .map(|p| faces.iter().map(|f| distance_above(f, p)).fold(f64::INFINITY, f64::min))
        .fold(0.0, f64::max);
    let l = Line {
        name,
        hulls: d.hulls.len(),
        corners: d.hulls.iter().map(|h| h.points.len()).max().unwrap_or(0),
        excess_m,
        uncovered_m,
        fit: fit(&solid, &field, &d.hulls, &Interrupt::default()).expect("figures"),
        milliseconds,
        triangles: mesh.triangle_count(),
        shells: shells(mesh).len(),
    };
    eprintln!(
        "{:24} {:5} tri {:3} shells {:3} hulls {:3} corners {:6.2} mm out {:6.2} mm bare \
         {:5.1} mm Hausdorff {:5.2} air {:5.3} open {:7.1} ms",
        l.name,
        l.triangles,
        l.shells,
        l.hulls,
        l.corners,
        l.excess_m * 1e3,
        l.uncovered_m * 1e3,
        l.fit.hausdorff_m() * 1e3,
        l.fit.air_share,
        l.fit.open_share,
        l.milliseconds
    );
    l
}

#[test]
#[ignore = "minutes; prints a table"]
fn the_whole_catalog() {
    let only = std::env::var("ONLY").unwrap_or_default();
    let seeds: u64 = std::env::var("SEEDS").ok().and_then(|s| s.parse().ok()).unwrap_or(3);
    let mut meshes: Vec<(String, TexturedMesh)> = categories()
        .par_iter()
        .flat_map_iter(|category| (0..seeds).map(move |seed| (category, seed)))
        .filter(|(category, _)| only.is_empty() || only.split(',').any(|o| o == category.name))
        .filter_map(|(category, seed)| {
            let recipe = Recipe {
                category: category.name.clone(),
                size_m: category.size.sample(&mut child_rng(seed, "size")),
                color: None,
                material: None,
                seed: child_seed(seed, "mesh"),
            };
            Some((format!("{} {seed}", category.name), build(&recipe)?))
        })
        .collect();
    for model in table_models().iter().filter(|m| only.is_empty() || only.contains(m.name)) {
        for (k, size_m) in
            [model.low_m, model.high_m, 0.5 * (model.low_m + model.high_m)].into_iter().enumerate()
        {
            let table: Option<_> = build_table(model.name, size_m, None, None, k as u64);
            meshes.extend(table.map(|t| (format!("{} {k}", model.name), t.mesh)));
        }
    }
    let lines: Vec<Line> = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a pool")
        .install(|| meshes.into_iter().map(|(name, mesh)| measured(name, &mesh)).collect());
    let mean = |f: &dyn Fn(&Line) -> f64| lines.iter().map(f).sum::<f64>() / lines.len() as f64;
    let count = |f: &dyn Fn(&Line) -> bool| lines.iter().filter(|l| f(l)).count();
    let (hulls, out) = (mean(&|l| l.hulls as f64), mean(&|l| l.excess_m * 1e3));
    let (bare, time) = (mean(&|l| l.uncovered_m * 1e3), mean(&|l| l.milliseconds));
    eprintln!(
        "{} meshes: mean {hulls:.1} hulls, {out:.2} mm out, {bare:.2} mm bare, {time:.1} ms",
        lines.len()
    );
    eprintln!(
        "above 2 mm {}, above 5 mm {}, above 60 ms {}, above 32 hulls {}",
        count(&|l| l.excess_m > 2e-3),
        count(&|l| l.excess_m > 5e-3),
        count(&|l| l.milliseconds > 60.0),
        count(&|l| l.hulls > 32)
    );
}
