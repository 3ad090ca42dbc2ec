//! The layers, laid over each other: defaults, file, environment, arguments, and a request's own.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use serde_json::{Value as Json, json};
use toml::{Table, Value};

use super::keys::{Key, flatten, keys};
use super::nearest::advice;
use super::value::ValueError;
use super::{Config, ConfigError, ConfigErrors, rules, value};

/// Prefix of environment variables with settings.
const PREFIX: &str = "TABLETOPGEN__";

/// Origin of a value.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case", tag = "from", content = "name")]
pub enum Origin {
    Default,
    File(PathBuf),
    /// The variable.
    Environment(String),
    /// `--set`, or an option that stands for it.
    Argument(String),
    /// `options.set` of a request.
    Request,
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Default => f.write_str("default"),
            Self::File(path) => write!(f, "file {}", path.display()),
            Self::Environment(variable) => write!(f, "environment {variable}"),
            Self::Argument(option) => f.write_str(option),
            Self::Request => f.write_str("options.set"),
        }
    }
}

/// Sources that may override the defaults.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    pub file: Option<PathBuf>,
    /// All variables; those that do not start with `TABLETOPGEN__` are ignored.
    pub environment: Vec<(String, String)>,
    /// Key and value, with the option that said it.
    pub arguments: Vec<(String, String, &'static str)>,
}

/// A valid configuration, and where each value came from.
#[derive(Clone, Debug)]
pub struct Resolved {
    pub config: Config,
    values: BTreeMap<String, (Value, Origin)>,
}

/// Loads and checks a configuration; on failure says everything that is wrong.
pub fn load(sources: Sources) -> Result<Resolved, ConfigErrors> {
    let defaults = keys().iter().map(|(path, key)| (path.clone(), (key.default.clone(), Origin::Default)));
    let mut layers = Layers { values: defaults.collect(), errors: Vec::new() };
    if let Some(path) = sources.file {
        layers.file(path);
    }
    let mut environment = sources.environment;
    environment.sort();
    for (variable, text) in environment {
        if let Some(path) = variable.strip_prefix(PREFIX) {
            let path = path.to_lowercase().replace("__", ".");
            layers.text(path, &text, Origin::Environment(variable));
        }
    }
    for (path, text, option) in sources.arguments {
        layers.text(path, &text, Origin::Argument(option.to_owned()));
    }
    layers.finish()
}

impl Resolved {
    /// The value of a key, if there is that key.
    pub fn value(&self, path: &str) -> Option<&Value> {
        self.values.get(path).map(|(value, _)| value)
    }

    /// With a request's own values for keys that are open to requests; on failure key and complaint of each.
    pub fn with(&self, set: &BTreeMap<String, String>) -> Result<Self, ConfigErrors> {
        let mut layers = Layers { values: self.values.clone(), errors: Vec::new() };
        for (path, text) in set {
            layers.lay(path.clone(), Origin::Request, |key| value::parse_for_request(key, text));
        }
        layers.finish()
    }

    /// Every key with what is known of it, its value and where that came from, sorted by key.
    pub fn entries(&self) -> impl Iterator<Item = (&str, &Key, &Value, &Origin)> {
        self.values.iter().filter_map(|(path, (value, origin))| {
            let key = keys().get(path)?;
            Some((path.as_str(), key, value, origin))
        })
    }

    /// Origin of the value of a key.
    pub fn origin(&self, path: &str) -> &Origin {
        self.values.get(path).map_or(&Origin::Default, |(_, origin)| origin)
    }
}

/// Values as they are laid, and complaints as they come up.
struct Layers {
    values: BTreeMap<String, (Value, Origin)>,
    errors: Vec<ConfigError>,
}

impl Layers {
    fn file(&mut self, path: PathBuf) {
        let origin = Origin::File(path.clone());
        let unreadable = |error: std::io::Error| match error.kind() {
            std::io::ErrorKind::InvalidData => {
                "is no text in UTF-8; give a TOML file with settings".to_owned()
            }
            _ => format!("cannot be read: {error}; give a TOML file with settings"),
        };
        let read = std::fs::read_to_string(&path).map_err(unreadable);
        let table = read.and_then(|text| {
            text.parse::<Table>().map_err(|error| format!("is no TOML: {}", error.to_string().trim_end()))
        });
        match table {
            Ok(table) => {
                for (path, value) in flatten(&table) {
                    self.lay(path, origin.clone(), |key| value::fit(key, value));
                }
            }
            Err(detail) => self.errors.push(ConfigError { key: String::new(), origin, detail }),
        }
    }

    fn text(&mut self, path: String, text: &str, origin: Origin) {
        self.lay(path, origin, |key| value::parse(key, text));
    }

    fn lay(&mut self, path: String, origin: Origin, read: impl FnOnce(&Key) -> Result<Value, ValueError>) {
        let read = match keys().get(&path) {
            Some(key) => read(key).map_err(|error| error.to_string()),
            None => Err(format!("there is no such key; {}", advice(&path))),
        };
        match read {
            Ok(value) => {
                self.values.insert(path, (value, origin));
            }
            Err(detail) => self.errors.push(ConfigError { key: path, origin, detail }),
        }
    }

    fn finish(mut self) -> Result<Resolved, ConfigErrors> {
        if !self.errors.is_empty() {
            return Err(ConfigErrors(self.errors));
        }
        let mut tree = json!({});
        for (path, (value, _)) in &self.values {
            place(&mut tree, path, value);
        }
        let config = match serde_path_to_error::deserialize::<_, Config>(tree) {
            Ok(config) => config,
            Err(error) => {
                let (path, detail) = (error.path().to_string(), error.inner().to_string());
                let origin = self.values.get(&path).map_or(Origin::Default, |(_, origin)| origin.clone());
                return Err(ConfigErrors(vec![ConfigError { key: path, origin, detail }]));
            }
        };
        for (key, detail) in rules::broken(&config) {
            let origin = self.values.get(key).map_or(Origin::Default, |(_, origin)| origin.clone());
            self.errors.push(ConfigError { key: key.to_owned(), origin, detail });
        }
        match self.errors.is_empty() {
            true => Ok(Resolved { config, values: self.values }),
            false => Err(ConfigErrors(self.errors)),
        }
    }
}

/// Puts a leaf where its dotted path says.
fn place(tree: &mut Json, path: &str, leaf: &Value) {
    let mut spot = tree;
    for part in path.split('.') {
        spot = &mut spot[part];
    }
    *spot = Json::deserialize(leaf.clone()).unwrap_or_default();
}
