//! `catalog`: the objects that scenes are made of.

use std::fmt::Write;

use clap::{Args, Subcommand};
use serde_json::json;

use super::{Exit, Failure, terminal};
use crate::app::catalog::{Catalog, CategoryView, catalog};

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
    },
    /// Show what is known of a category: words, size, mass, substance, colors, uses
    Show {
        /// Name of the category, or another word for it
        name: String,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
}

/// Lists the catalog, or shows a category.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let mut catalog = catalog();
    terminal::print(&match arguments.action {
        Action::List { group, json } => {
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
        Action::Show { name, json } => {
            let category = named(&catalog, &name)?;
            if json { format!("{:#}\n", json!(category)) } else { text(category) }
        }
    });
    Ok(Exit::Success)
}

fn named<'c>(catalog: &'c Catalog, name: &str) -> Result<&'c CategoryView, Failure> {
    let name = name.to_lowercase();
    let is_named = |category: &&CategoryView| {
        category.name == name || category.label == name || category.synonyms.contains(&name)
    };
    catalog.categories.iter().find(is_named).ok_or_else(|| {
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
