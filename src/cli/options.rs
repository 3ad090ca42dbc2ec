//! Options several commands share: the configuration and what overrides it.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{Failure, number};
use crate::app::config::{Resolved, Sources};
use crate::app::{added_categories, config};
use scene::request::{OnUnknown, RequestOptions};

/// Sources of settings.
#[derive(Clone, Debug, Default, Args)]
pub struct ConfigOptions {
    /// TOML file laid over the defaults [default: $TABLETOPGEN_CONFIG, or tabletopgen/config.toml in the folder of
    /// the user's configuration, if it is there]
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Override one setting, such as decompose.max_hulls=16 (repeatable; `check-config` lists them all)
    #[arg(long, value_name = "KEY=VALUE", value_parser = assignment)]
    pub set: Vec<(String, String)>,
}

impl ConfigOptions {
    /// The file: the one that was named, or the usual one where it exists.
    pub fn file(&self) -> Option<PathBuf> {
        let variable =
            |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let usual = || {
            let folder = variable("XDG_CONFIG_HOME").or_else(|| Some(variable("HOME")?.join(".config")))?;
            Some(folder.join("tabletopgen/config.toml")).filter(|file| file.is_file())
        };
        self.config.clone().or_else(|| variable("TABLETOPGEN_CONFIG")).or_else(usual)
    }

    /// The configuration out of all layers, with the categories that it names added to the catalog; `more` are options
    /// that stand for a setting.
    pub fn load(&self, more: Vec<(String, String, &'static str)>) -> Result<Resolved, Failure> {
        let arguments = self.set.iter().map(|(key, value)| (key.clone(), value.clone(), "--set"));
        let sources = Sources {
            file: self.file(),
            // A variable that is no UTF-8 cannot be one of ours.
            environment: std::env::vars_os()
                .filter_map(|(name, value)| Some((name.into_string().ok()?, value.into_string().ok()?)))
                .collect(),
            arguments: arguments.chain(more).collect(),
        };
        let resolved = config::layers::load(sources)?;
        added_categories::load(&resolved)?;
        Ok(resolved)
    }
}

/// Options of reading a text.
#[derive(Clone, Debug, Default, Args)]
pub struct TextOptions {
    /// Refuse a scene of more objects (1 to 64)
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number::whole::<u32>(1..=64))]
    max_objects: Option<u32>,
    /// Treatment of parts of the text that are not understood [default: stand-in]
    #[arg(long, value_name = "POLICY")]
    on_unknown: Option<UnknownPolicy>,
}

/// [`OnUnknown`] as an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum UnknownPolicy {
    /// Make no scene
    Fail,
    /// Let a plain shape stand in for an object that the catalog does not have
    #[value(alias = "stand_in")]
    StandIn,
    /// Leave unknown objects out
    Drop,
}

impl TextOptions {
    /// As options of a request.
    pub fn request_options(&self) -> RequestOptions {
        let on_unknown = self.on_unknown.map(|policy| match policy {
            UnknownPolicy::Fail => OnUnknown::Fail,
            UnknownPolicy::StandIn => OnUnknown::StandIn,
            UnknownPolicy::Drop => OnUnknown::Drop,
        });
        RequestOptions { max_objects: self.max_objects, on_unknown, ..RequestOptions::default() }
    }
}

/// An argument that assigns no setting.
#[derive(Debug, thiserror::Error)]
#[error("give key=value, such as worker.fan_out=2")]
struct NoAssignment;

/// `key=value`.
fn assignment(text: &str) -> Result<(String, String), NoAssignment> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => Ok((key.trim().to_owned(), value.trim().to_owned())),
        _ => Err(NoAssignment),
    }
}
