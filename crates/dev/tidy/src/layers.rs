//! The import table of `ARCHITECTURE.md`: who may depend on whom, and what each part must not know.
//!
//! To change a rule, change the table here and the one in `ARCHITECTURE.md` together and state the reason in the
//! commit.

/// A crate of the workspace, or a module of a crate that holds several layers.
#[derive(Debug)]
pub struct Layer {
    pub name: &'static str,
    /// Crates of the workspace, or modules of the same crate. `EVERYTHING` permits all.
    pub may_import: &'static [&'static str],
    /// External crates, and paths inside them or inside `std`.
    pub must_not_know: &'static [&'static [&'static str]],
    /// Paths that `must_not_know` would otherwise forbid.
    pub except: &'static [&'static str],
}

/// Permits every crate and module.
pub const EVERYTHING: &str = "EVERYTHING";
/// In place of a name: all but the HTTP interface of the server.
pub const EVERYTHING_BUT_API: &str = "EVERYTHING_BUT_API";

/// The root package, whose modules have a table of their own.
pub const ROOT: &str = "tabletopgen";

const SERVERS: &[&str] = &["axum", "hyper", "hyper_util", "tower", "tower_http"];
const CLIENTS: &[&str] = &["reqwest", "rustls"];
const ROWS: &[&str] = &["sqlx", "object_store"];
const TASKS: &[&str] = &["tokio", "tokio_util", "tokio_stream"];
const FUTURES: &[&str] = &["futures"];
const FILES: &[&str] = &["std::fs", "tempfile"];
const SYSTEM: &[&str] = &["std::net", "std::env", "std::process"];
const CLOCKS: &[&str] = &["std::time::Instant", "std::time::SystemTime"];
/// Random numbers without a seed.
const CHANCE: &[&str] = &["rand::rng", "rand::random", "rand::rngs::ThreadRng", "rand::rngs::SysRng", "uuid"];

/// A pure computation: its result depends on its arguments alone.
const PURE: &[&[&str]] = &[SERVERS, CLIENTS, ROWS, TASKS, FUTURES, FILES, SYSTEM, CLOCKS, CHANCE];
const PURE_BUT_FUTURES: &[&[&str]] = &[SERVERS, CLIENTS, ROWS, TASKS, FILES, SYSTEM, CLOCKS, CHANCE];

/// The folders below `crates/`, the lowest first. A crate depends on those of its own wing and of lower ones.
pub const WINGS: &[&str] = &["base", "language", "method", "models", "data", "server", "dev"];

/// Every crate of the wings. Cargo refuses an import that is no dependency, so the manifests are what is checked.
pub const CRATES: &[Layer] = &[
    layer("runtime", &[], PURE).but(&["tokio::sync"]),
    layer("imaging", &[], PURE),
    layer("gpu", &[], PURE).but(&["std::env::var"]),
    layer("video", &["imaging"], PURE),
    layer("geometry", &["imaging", "runtime"], PURE),
    layer("markup", &[], PURE),
    layer("mesh_io", &["geometry", "imaging"], PURE),
    layer("soft_raster", &["geometry", "imaging"], PURE),
    layer("render", &["geometry", "gpu", "imaging", "runtime"], PURE),
    layer("catalog", &["geometry", "imaging", "runtime"], PURE),
    layer("vision", &["catalog", "geometry", "imaging", "render", "runtime"], PURE),
    layer("pose_estimation", &["geometry", "imaging", "render", "runtime", "soft_raster"], PURE),
    layer("scene", &["geometry", "imaging"], PURE),
    layer("certificate", &["geometry", "scene"], PURE),
    // Of the domain types it takes the support tree alone.
    layer("physics", &["geometry", "runtime", "scene"], PURE),
    // Of certificates it takes what they state; it measures only images.
    layer(
        "evaluation",
        &["certificate", "geometry", "imaging", "markup", "render", "runtime", "scene", "vision"],
        PURE,
    ),
    layer("language", &["catalog", "geometry", "scene"], PURE),
    layer("editing", &["catalog", "geometry", "language", "physics", "runtime", "scene"], PURE),
    layer("batches", &["runtime", "scene"], PURE),
    // Knows nothing of scenes, so that it can be used without them; its linear algebra is nalgebra.
    layer("robot", &["markup"], PURE),
    layer("tasks", &["catalog", "editing", "geometry", "language", "physics", "runtime", "scene"], PURE),
    layer("manipulation", &["geometry", "physics", "robot", "runtime", "scene", "tasks"], PURE),
    layer(
        "export",
        &["certificate", "geometry", "imaging", "markup", "mesh_io", "runtime", "scene"],
        &[SERVERS, CLIENTS, ROWS, TASKS, FILES, SYSTEM],
    ),
    // Datasets are files on a disk: it reads bundles and writes shards.
    layer(
        "datasets",
        &["certificate", "export", "geometry", "imaging", "markup", "runtime", "scene"],
        &[SERVERS, CLIENTS, ROWS, TASKS, FUTURES, SYSTEM, CLOCKS, CHANCE],
    ),
    // Episodes know nothing of scenes: they are numbers and images, and become files on a disk.
    layer(
        "episodes",
        &["imaging", "video"],
        &[SERVERS, CLIENTS, ROWS, TASKS, FUTURES, SYSTEM, CLOCKS, CHANCE],
    ),
    layer(
        "demonstrations",
        &[
            "catalog",
            "episodes",
            "geometry",
            "imaging",
            "manipulation",
            "physics",
            "render",
            "robot",
            "runtime",
            "scene",
            "tasks",
        ],
        PURE,
    ),
    layer(
        "ports",
        &["editing", "geometry", "imaging", "pose_estimation", "runtime", "scene"],
        PURE_BUT_FUTURES,
    ),
    layer(
        "embedded",
        &[
            "catalog",
            "editing",
            "geometry",
            "imaging",
            "language",
            "physics",
            "ports",
            "pose_estimation",
            "render",
            "runtime",
            "scene",
            "tasks",
            "vision",
        ],
        &[SERVERS, CLIENTS, ROWS, TASKS, SYSTEM, CLOCKS, CHANCE],
    )
    // Logs the duration of steps.
    .but(&["std::time::Instant"]),
    // The one client that opens connections, so that its rules about addresses hold for everything.
    layer("http_client", &["runtime"], &[SERVERS, ROWS]),
    layer(
        "remote",
        &[
            "catalog",
            "editing",
            "geometry",
            "http_client",
            "imaging",
            "language",
            "mesh_io",
            "ports",
            "render",
            "runtime",
            "scene",
            "vision",
        ],
        &[SERVERS, CLIENTS, ROWS],
    ),
    // The client of S3 is that of `object_store`; it takes the features of `reqwest` and the provider of cryptography.
    // Rows of batches have the states, counts and budget of the command line's.
    layer("store", &["batches", "runtime", "scene"], &[SERVERS, CLIENTS]).but(&["reqwest", "rustls::crypto"]),
    layer("tidy", &[], &[SERVERS, CLIENTS, ROWS, TASKS, FUTURES]),
    // For tests alone.
    layer("test_settings", &[], PURE),
    layer("test_postgres", &[], &[SERVERS, CLIENTS]),
    // Above the server: nothing that makes scenes may depend on it.
    layer("lab", &[EVERYTHING], &[ROWS, CLIENTS]),
];

/// The modules of the root package.
pub const ROOT_MODULES: &[Layer] = &[
    layer(
        "pipeline",
        &[
            "catalog",
            "certificate",
            "editing",
            "export",
            "geometry",
            "gpu",
            "imaging",
            "manipulation",
            "mesh_io",
            "physics",
            "ports",
            "pose_estimation",
            "render",
            "robot",
            "runtime",
            "scene",
            "store",
            "tasks",
            "vision",
        ],
        &[SERVERS, CLIENTS, ROWS],
    ),
    layer(
        "worker",
        &["background", "pipeline", "runtime", "scene", "spans", "store"],
        &[SERVERS, CLIENTS, ROWS],
    ),
    layer(
        "api",
        &[
            "app",
            "batches",
            "datasets",
            "freezer",
            "imaging",
            "path_without_keys",
            "problem",
            "runtime",
            "scene",
            "schemas",
            "spans",
            "store",
        ],
        &[CLIENTS, ROWS],
    ),
    // These are work of the worker, whose errors are those of stages.
    layer(
        "freezer",
        &["datasets", "pipeline", "runtime", "scene", "schemas", "store", "worker"],
        &[SERVERS, CLIENTS, ROWS],
    ),
    layer(
        "executor",
        &["pipeline", "problem", "runtime", "scene", "store", "worker"],
        &[SERVERS, CLIENTS, ROWS],
    ),
    layer(
        "recorder",
        &[
            "datasets",
            "demonstrations",
            "episodes",
            "pipeline",
            "problem",
            "runtime",
            "scene",
            "store",
            "worker",
        ],
        &[SERVERS, CLIENTS, ROWS],
    ),
    // Sends what the store has for addresses of clients.
    layer("webhooks", &["background", "http_client", "store"], &[SERVERS, CLIENTS, ROWS]),
    // Starts loops that panicked again.
    layer("background", &[], &[SERVERS, CLIENTS, ROWS]),
    // What requests and jobs say of themselves in the log and in traces.
    layer("spans", &["scene", "store"], &[SERVERS, CLIENTS, ROWS, TASKS]),
    // Settings structs stand beside their algorithms; config only gathers them.
    layer(
        "config",
        &[
            "api",
            "catalog",
            "embedded",
            "export",
            "geometry",
            "gpu",
            "http_client",
            "imaging",
            "manipulation",
            "physics",
            "pipeline",
            "ports",
            "pose_estimation",
            "remote",
            "render",
            "scene",
            "schemas",
            "store",
            "vision",
            "webhooks",
            "worker",
        ],
        &[SERVERS, CLIENTS, ROWS, TASKS],
    ),
    // JSON schemas that several types have, which hold those of types of other crates.
    layer(
        "schemas",
        &[
            "batches",
            "certificate",
            "demonstrations",
            "episodes",
            "geometry",
            "manipulation",
            "scene",
            "store",
            "tasks",
        ],
        &[SERVERS, CLIENTS, ROWS, FILES, SYSTEM, TASKS],
    ),
    layer("path_without_keys", &["store"], &[SERVERS, CLIENTS, ROWS, FILES, SYSTEM, TASKS]),
    // Refusals, for all who refuse.
    layer("problem", &["path_without_keys", "schemas"], &[SERVERS, CLIENTS, ROWS, FILES, SYSTEM, TASKS]),
    layer("app", &[EVERYTHING_BUT_API], &[SERVERS, CLIENTS, ROWS]),
    // Puts the parts of a server together.
    layer("service", &[EVERYTHING], &[CLIENTS, ROWS]),
    layer("cli", &[EVERYTHING_BUT_API], &[SERVERS, CLIENTS, ROWS]),
    layer("main", &[EVERYTHING_BUT_API], &[SERVERS, CLIENTS, ROWS]),
    layer("lib", &[], &[]),
];

/// The modules of the laboratory; `tabletopgen::` precedes a module of the root package.
pub const LAB_MODULES: &[Layer] = &[
    layer("synthetic_images", &["catalog", "geometry", "imaging", "render", "runtime"], PURE),
    layer(
        "benchmark",
        &[
            "catalog",
            "embedded",
            "geometry",
            "gpu",
            "imaging",
            "manipulation",
            "physics",
            "ports",
            "pose_estimation",
            "render",
            "robot",
            "runtime",
            "scene",
            "synthetic_images",
            "tabletopgen::config",
            "tabletopgen::pipeline",
            "vision",
        ],
        PURE_BUT_FUTURES,
    ),
    // Speaks the protocols of vendors above the ports.
    layer(
        "mock_vendors",
        &[
            "geometry",
            "imaging",
            "mesh_io",
            "ports",
            "pose_estimation",
            "render",
            "runtime",
            "scene",
            "vision",
        ],
        &[CLIENTS, ROWS, FILES, SYSTEM],
    ),
    layer("app", &[EVERYTHING], &[CLIENTS, ROWS]),
    layer("cli", &[EVERYTHING], &[CLIENTS, ROWS]),
    layer("main", &[EVERYTHING], &[CLIENTS, ROWS]),
    layer("lib", &[], &[]),
];

/// Crates that no crate of the product may depend on.
pub const NEVER_SHIPPED: &[&str] = &["lab", "test_postgres", "test_settings", "tidy"];

const fn layer(
    name: &'static str,
    may_import: &'static [&'static str],
    must_not_know: &'static [&'static [&'static str]],
) -> Layer {
    Layer { name, may_import, must_not_know, except: &[] }
}

impl Layer {
    const fn but(mut self, except: &'static [&'static str]) -> Self {
        self.except = except;
        self
    }

    pub fn may_import(&self, name: &str) -> bool {
        self.may_import.iter().any(|allowed| match *allowed {
            EVERYTHING => true,
            EVERYTHING_BUT_API => name != "api",
            allowed => allowed == name,
        })
    }

    /// The forbidden name that `path` is or starts with.
    pub fn forbids(&self, path: &str) -> Option<&'static str> {
        let is_in = |outer: &str| path == outer || path.starts_with(&format!("{outer}::"));
        if self.except.iter().any(|excepted| is_in(excepted)) {
            return None;
        }
        self.must_not_know.iter().copied().flatten().copied().find(|outside| is_in(outside))
    }
}

/// The rules of the module that `package` and `module` name.
pub fn module_layer(package: &str, module: &str) -> Option<&'static Layer> {
    let modules = match package {
        ROOT => ROOT_MODULES,
        "lab" => LAB_MODULES,
        _ => return crate_layer(package),
    };
    modules.iter().find(|layer| layer.name == module)
}

pub fn crate_layer(package: &str) -> Option<&'static Layer> {
    CRATES.iter().find(|layer| layer.name == package)
}
