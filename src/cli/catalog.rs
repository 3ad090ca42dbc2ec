//! `catalog`: the objects that scenes are made of.

use std::fmt::Write;
use std::path::PathBuf;

use clap::{Args, Subcommand};
use serde_json::json;

use super::counting::Counting;
use super::options::ConfigOptions;
use super::output::file;
use super::{Exit, Failure, terminal};
use crate::app::added_categories::{self, FileError};
use crate::app::catalog::{Catalog, CategoryView, catalog};
use crate::app::catalog_check::{self, CategoryFinding};
use imaging::codec::encode_png;

/// Arguments of `catalog`.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// List every category with its group and typical size
    List {
        /// Only categories of this group, such as cutlery
        #[arg(long, value_name = "NAME")]
        group: Option<String>,
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        options: ConfigOptions,
    },
    /// Show what is known of a category: words, size, mass, substance, colors, uses
    Show {
        /// Name of the category, or another word for it
        name: String,
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        options: ConfigOptions,
    },
    /// Check your own categories, or all: closed meshes, sizes, hulls, masses, and whether the objects stand
    Check(CheckArguments),
}

/// Arguments of `catalog check`.
#[derive(Debug, Args)]
struct CheckArguments {
    /// File with `[[category]]` tables; every category of the catalog where it is left out
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
    /// Write an image with three objects of each category
    #[arg(long, value_name = "FILE")]
    sheet: Option<PathBuf>,
    /// Replace the image if it is there
    #[arg(long)]
    force: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Lists the catalog, or shows a category.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    terminal::print(&match arguments.action {
        Action::Check(arguments) => return check(&arguments),
        Action::List { group, json, options } => {
            options.load(Vec::new())?;
            let mut catalog = catalog();
            if let Some(group) = group {
                catalog.categories.retain(|category| category.group == group);
                if catalog.categories.is_empty() {
                    return Err(no_group(&group));
                }
            }
            if json {
                format!("{:#}\n", json!(catalog))
            } else {
                catalog.categories.iter().map(line).collect()
            }
        }
        Action::Show { name, json, options } => {
            options.load(Vec::new())?;
            let catalog = catalog();
            let category = named(&catalog, &name)?;
            if json { format!("{:#}\n", json!(category)) } else { text(category) }
        }
    });
    Ok(Exit::Success)
}

/// The categories of a file are checked as if `catalog.paths` named it.
fn check(arguments: &CheckArguments) -> Result<Exit, Failure> {
    let CheckArguments { file: input, sheet, force, json, options } = arguments;
    if let Some(path) = sheet {
        file::check(path, "--sheet", *force, input.as_deref().as_slice())?;
    }
    let unusable = |error: FileError| Failure::usage(error.to_string());
    let (resolved, checked) = match input {
        None => (options.load(Vec::new())?, ::catalog::categories().iter().collect()),
        Some(input) => {
            let (own, _) = added_categories::read(input).map_err(unusable)?;
            let name = input.to_string_lossy().into_owned();
            let resolved = options.load(vec![("catalog.paths".to_owned(), name, "FILE")])?;
            let own = own.iter().filter_map(|category| ::catalog::category(&category.name)).collect();
            (resolved, own)
        }
    };
    let checked: Vec<&::catalog::Category> = checked;
    // A file takes moments, the whole catalog minutes.
    let counting = Counting::new("objects checked", *json || input.is_some());
    let seen = |done: usize, all: usize| counting.see(done as u64, all as u64);
    let (findings, image) = catalog_check::check(&checked, &resolved.config, seen);
    if let Some(path) = sheet {
        file::write(path, &encode_png(&image), *force)?;
    }
    let sound = findings.iter().all(|finding| finding.objections.is_empty());
    terminal::print(&match json {
        true => format!("{:#}\n", json!({ "sound": sound, "categories": findings })),
        false => findings.iter().map(finding_text).collect(),
    });
    Ok(if sound { Exit::Success } else { Exit::Error })
}

fn finding_text(finding: &CategoryFinding) -> String {
    let verdict = if finding.objections.is_empty() { "ok" } else { "FAULTY" };
    let mut text = format!("{verdict:<8}{}\n", finding.name);
    for object in &finding.objects {
        let [width, depth, height] = object.size_m.map(|side_m| 1000.0 * side_m);
        let (moved_mm, turned_deg) = (1000.0 * object.moved_m, object.turned_rad.to_degrees());
        let _ = writeln!(
            text,
            "        {width:.0} x {depth:.0} x {height:.0} mm, {:.3} kg, {} triangles, {} hulls, moved {moved_mm:.1} mm, \
             turned {turned_deg:.1} degrees",
            object.mass_kg, object.triangles, object.hulls
        );
    }
    for objection in &finding.objections {
        let _ = writeln!(text, "        {objection}");
    }
    text
}

fn named<'c>(catalog: &'c Catalog, name: &str) -> Result<&'c CategoryView, Failure> {
    let known = ::catalog::category_called(name);
    let view = known.and_then(|known| catalog.categories.iter().find(|category| category.name == known.name));
    view.ok_or_else(|| {
        Failure::usage(format!("the catalog has no {name:?}; `tabletopgen catalog list` lists what it has"))
    })
}

fn no_group(name: &str) -> Failure {
    let mut groups: Vec<&str> =
        ::catalog::categories().iter().map(|category| category.group.as_str()).collect();
    groups.sort_unstable();
    groups.dedup();
    Failure::usage(format!("the catalog has no group {name:?}; its groups are {}", groups.join(", ")))
}

fn line(category: &CategoryView) -> String {
    let [width, depth, height] = typical_m(category);
    format!(
        "{:<28} {:<16} {:>4.0} x {:>4.0} x {:>4.0} mm\n",
        category.name,
        category.group,
        1000.0 * width,
        1000.0 * depth,
        1000.0 * height
    )
}

/// Mean of the smallest and the largest size, meters.
fn typical_m(category: &CategoryView) -> [f64; 3] {
    std::array::from_fn(|axis| f64::midpoint(category.size.low_m[axis], category.size.high_m[axis]))
}

fn text(category: &CategoryView) -> String {
    let mm = |size_m: [f64; 3]| size_m.map(|side_m| format!("{:.0}", 1000.0 * side_m)).join(" x ");
    let mut text = format!("{} ({})\n", category.label, category.name);
    let mut row = |name: &str, value: String| {
        if !value.is_empty() {
            // Memory takes everything.
            let _ = writeln!(text, "  {name:<16} {value}");
        }
    };
    row("group", category.group.to_owned());
    row("other words", category.synonyms.join(", "));
    row("stands in for", category.stands_in_for.join(", "));
    row(
        "size",
        format!("{} to {} mm (width x depth x height)", mm(category.size.low_m), mm(category.size.high_m)),
    );
    row(
        "mass",
        category.mass_kg.map_or("by volume and substance".to_owned(), |mass_kg| format!("{mass_kg} kg")),
    );
    row("substance", category.substance.to_owned());
    row("colors", category.palette.join(", "));
    let word = |value: serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    row("affords", category.affordances.iter().map(|of| word(json!(of))).collect::<Vec<_>>().join(", "));
    row("also", category.states.iter().map(|of| word(json!(of))).collect::<Vec<_>>().join(", "));
    text
}
