//! Examples of imports that the checks find and that they let pass.

use tidy::imports::{manifest_findings, path_findings};
use tidy::manifest::dependencies;
use tidy::source::Source;

#[test]
fn imports_against_the_table_are_found() {
    let cases: &[(&str, &str)] = &[
        ("src/api.rs", "use crate::worker::Worker;"),
        ("src/pipeline/place.rs", "use crate::{\n    pipeline::Services,\n    api::{self as a, Jobs},\n};"),
        ("src/pipeline.rs", "fn f() -> crate::worker::Turn { g() }"),
        ("src/pipeline/certify/write.rs", "use super::super::super::api::serve;"),
        ("src/worker.rs", "use super::api::Store;"),
        ("src/worker.rs", "use crate::config::Config;"),
        ("src/api.rs", "use render::View;"),
        ("src/api.rs", "use ::render::View;"),
        ("src/pipeline.rs", "#[cfg(not(test))] use remote::Chat;"),
        ("src/worker.rs", "fn f<'a>(x: &'a str) -> char { '\"' } use embedded::Painter;"),
        ("crates/dev/lab/src/synthetic/shape.rs", "use crate::evaluate::Score;"),
        ("crates/dev/lab/src/evaluate.rs", "use tabletopgen::api::serve;"),
        ("crates/base/geometry/src/cast.rs", "use std::{fmt, fs::{self, File}};"),
        ("crates/base/catalog/src/lib.rs", "fn f() { let t = std::time::Instant::now(); }"),
        ("crates/base/runtime/src/cpu.rs", "use tokio::task::spawn;"),
        ("crates/method/physics/src/settle.rs", "fn f() -> f64 { rand::random() }"),
        ("crates/data/export/src/zip.rs", "use std::{env, path::Path};"),
        ("crates/server/store/src/lib.rs", "use axum::Router;"),
        ("crates/no_such_crate/src/lib.rs", ""),
        ("src/no_such_module.rs", ""),
    ];
    for (path, text) in cases {
        assert!(!path_findings(&Source::new(path, text)).is_empty(), "nothing is found in {path}: {text}");
    }
}

#[test]
fn allowed_imports_comments_strings_and_tests_pass() {
    let cases: &[(&str, &str)] = &[
        ("src/api.rs", "// use crate::worker::Worker;\n/* use /* crate::worker */ crate::worker::x */"),
        (
            "src/api.rs",
            "const A: &str = r#\"use crate::worker::X; \" \"#; const B: &str = \"crate::worker::x\";",
        ),
        ("src/api.rs", "#[cfg(test)] mod tests { use crate::worker::X; fn f() { sqlx::query(p); } }"),
        ("src/api.rs", "#[cfg(test)]\n#[allow(dead_code)]\nfn check(x: [u8; 3]) { crate::worker::x() }"),
        ("src/api.rs", "use scene::Job; use super::api::serve; use self::jobs::list;"),
        ("src/api.rs", "mod render; fn f() { render::page() }"),
        ("src/app.rs", "use crate::config::Config;"),
        ("src/worker.rs", "use crate::pipeline::Services;"),
        ("crates/base/runtime/src/cpu.rs", "use tokio::sync::oneshot;"),
        ("crates/base/geometry/src/cast.rs", "use std::{fmt, time::Duration};"),
        ("crates/server/store/src/lib.rs", "use std::fs::File;"),
    ];
    for (path, text) in cases {
        assert_eq!(path_findings(&Source::new(path, text)), Vec::<String>::new(), "{path}: {text}");
    }
}

#[test]
fn manifests_give_dependencies_of_the_product_only() {
    let manifest = "\
[package]
name = \"a\"

[dependencies]
geometry.workspace = true
# comment = \"1\"
serde = { version = \"1\", features = [\"derive\"] }
renamed = { package = \"tabletopgen-mesh-io\", path = \"../mesh_io\" }
tower-http = \"0.7\"

[dependencies.tokio]
version = \"1\"

[target.'cfg(unix)'.dependencies]
rustls.workspace = true

[build-dependencies]
cc = \"1\"

[dev-dependencies]
sqlx.workspace = true

[features]
fast = []
";
    let names: Vec<_> = dependencies(manifest).into_iter().map(|dependency| dependency.name).collect();
    assert_eq!(names, ["geometry", "serde", "mesh_io", "tower_http", "tokio", "rustls", "cc"]);
}

#[test]
fn dependencies_against_the_table_are_found() {
    let findings = |package: &str, name: &str| {
        let manifest = format!("[dependencies]\n{name}.workspace = true\n");
        manifest_findings("Cargo.toml", package, &manifest).len()
    };
    let refused = [
        ("geometry", "render"),
        ("geometry", "tokio"),
        ("scene", "store"),
        ("store", "axum"),
        ("tidy", "scene"),
        ("render", "tabletopgen"),
        ("tabletopgen", "lab"),
        ("no_such_crate", "serde"),
    ];
    for (package, name) in refused {
        assert_eq!(findings(package, name), 1, "{package} on {name}");
    }
    let accepted = [
        ("render", "geometry"),
        ("runtime", "tokio"),
        ("lab", "tabletopgen"),
        ("tabletopgen", "store"),
        ("store", "sqlx"),
    ];
    for (package, name) in accepted {
        assert_eq!(findings(package, name), 0, "{package} on {name}");
    }
}
