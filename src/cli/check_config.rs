//! `check-config`: the configuration as it comes out of all layers.

use clap::Args;
use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::options::ConfigOptions;
use super::{Exit, Failure, terminal};
use crate::app::config::keys::Allowed;
use crate::app::config::{Origin, Resolved};
use crate::app::features::Features;
use crate::app::remote::Remote;

/// Arguments of `check-config`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Print JSON: value, origin, unit, range and meaning of every key
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Prints the configuration, or fails with everything that is wrong with it.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let resolved = arguments.options.load(Vec::new())?;
    // Weights and keys that will not do are as wrong as a value out of its range.
    Features::load(&resolved)?;
    Remote::load(&resolved)?;
    terminal::print(&if arguments.json { as_json(&resolved) } else { as_toml(&resolved) });
    Ok(Exit::Success)
}

/// TOML that reads back, with the origin of every value that is not the default's.
fn as_toml(resolved: &Resolved) -> String {
    let mut text = String::new();
    let mut section = "";
    let mut entries: Vec<_> = resolved
        .entries()
        .map(|(path, _, value, origin)| (path.rsplit_once('.').unwrap_or(("", path)), value, origin))
        .collect();
    // A section's own keys stand together, before those of the sections inside it.
    entries.sort_by_key(|(path, ..)| *path);
    for ((of, name), value, origin) in entries {
        if of != section {
            let gap = if section.is_empty() { "" } else { "\n" };
            text.push_str(&format!("{gap}[{of}]\n"));
            section = of;
        }
        let from = match origin {
            Origin::Default => String::new(),
            origin => format!("  # {origin}"),
        };
        text.push_str(&format!("{name} = {value}{from}\n"));
    }
    text
}

fn as_json(resolved: &Resolved) -> String {
    let mut keys = Map::new();
    for (path, key, value, origin) in resolved.entries() {
        let plain = |value: &toml::Value| Value::deserialize(value.clone()).unwrap_or_default();
        let mut about = json!({
            "value": plain(value), "default": plain(&key.default), "origin": origin.to_string(),
            "unit": key.unit, "meaning": key.meaning,
        });
        if let Allowed::Range { low, high } = key.allowed {
            about["range"] = json!({ "low": low, "high": high });
        }
        keys.insert(path.to_owned(), about);
    }
    format!("{:#}\n", Value::Object(keys))
}
