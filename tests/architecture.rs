//! The import table and the habits of `ARCHITECTURE.md`, enforced by reading the source files whole.
//!
//! A finding names file, line and rule. To change a rule, change the table here and the one in
//! `ARCHITECTURE.md` together, and say why in the commit.

#[path = "architecture/source.rs"]
mod source;
#[path = "architecture/paths.rs"]
mod paths;

use paths::paths;
use source::{Source, sources};

/// A module, the modules of this crate it may import, and the outside world it must not know.
struct Row {
    module: &'static str,
    may_import: &'static [&'static str],
    must_not_know: &'static [&'static str],
}

const TOOLBOX: &[&str] = &["geometry", "render", "physics", "catalog", "vision", "align"];

const NO_WORLD: &[&str] = &[
    "tokio",
    "sqlx",
    "axum",
    "hyper",
    "hyper_util",
    "tower",
    "tower_http",
    "reqwest",
    "object_store",
    "futures",
    "tempfile",
    "std::fs",
    "std::net",
    "std::env",
    "std::process",
    "std::time::Instant",
    "std::time::SystemTime",
    "rand::rng",
    "rand::random",
    "rand::rngs::ThreadRng",
    "rand::rngs::SysRng",
    "uuid",
];
const NO_TOKIO: &[&str] =
    &["tokio", "sqlx", "axum", "hyper", "reqwest", "object_store", "std::fs", "std::net", "std::env"];
const NO_ROWS_NO_HTTP: &[&str] = &["sqlx", "axum", "hyper", "hyper_util", "tower", "tower_http"];
const NO_HTTP: &[&str] = &["axum", "hyper", "hyper_util", "tower", "tower_http"];
const NO_WORLD_BUT_FUTURES: &[&str] = &[
    "tokio",
    "sqlx",
    "axum",
    "hyper",
    "object_store",
    "std::fs",
    "std::net",
    "std::env",
    "std::process",
    "std::time::Instant",
    "std::time::SystemTime",
    "rand::rng",
    "rand::random",
    "uuid",
];
const NO_ROWS: &[&str] = &["sqlx", "object_store"];

/// "Who may import whom" of `ARCHITECTURE.md`; what `TOOLBOX` stands for is spelled out there.
const TABLE: &[Row] = &[
    Row { module: "geometry", may_import: &[], must_not_know: NO_WORLD },
    Row { module: "render", may_import: &["geometry"], must_not_know: NO_WORLD },
    Row { module: "physics", may_import: &["geometry"], must_not_know: NO_WORLD },
    Row { module: "catalog", may_import: &["geometry"], must_not_know: NO_WORLD },
    Row { module: "vision", may_import: &["geometry", "render", "catalog"], must_not_know: NO_WORLD },
    Row { module: "align", may_import: &["geometry", "render"], must_not_know: NO_WORLD },
    // Beside the toolbox, not of it: nothing that makes scenes may use it.
    Row { module: "synthetic", may_import: &["geometry", "render", "catalog"], must_not_know: NO_WORLD },
    Row { module: "scene", may_import: &["geometry"], must_not_know: NO_WORLD },
    Row { module: "export", may_import: &["scene", "geometry"], must_not_know: NO_TOKIO },
    Row { module: "provider", may_import: &["scene", "TOOLBOX"], must_not_know: NO_ROWS_NO_HTTP },
    Row { module: "job", may_import: &["scene"], must_not_know: NO_ROWS_NO_HTTP },
    Row { module: "store", may_import: &["job"], must_not_know: NO_HTTP },
    Row {
        module: "pipeline",
        may_import: &["scene", "provider", "export", "store", "TOOLBOX"],
        must_not_know: NO_ROWS_NO_HTTP,
    },
    // Ports of its own stand before the real ones; what a job is, app knows.
    Row {
        module: "evaluate",
        may_import: &["pipeline", "provider", "scene", "synthetic", "TOOLBOX"],
        must_not_know: NO_WORLD_BUT_FUTURES,
    },
    // Speaks vendors' protocols on top of the ports; it asks nobody.
    Row {
        module: "dev_providers",
        may_import: &["provider", "scene", "export", "TOOLBOX"],
        must_not_know: &["sqlx", "object_store", "std::fs", "std::env", "std::process"],
    },
    Row { module: "worker", may_import: &["job", "pipeline", "store"], must_not_know: NO_ROWS_NO_HTTP },
    Row { module: "api", may_import: &["job", "scene", "store"], must_not_know: NO_ROWS },
    // Settings structs sit beside their algorithms; config only gathers them.
    Row {
        module: "config",
        may_import: &["scene", "provider", "export", "store", "pipeline", "worker", "api", "TOOLBOX"],
        must_not_know: &["tokio", "sqlx", "axum"],
    },
    Row { module: "app", may_import: &["EVERYTHING"], must_not_know: &[] },
    Row { module: "cli", may_import: &["EVERYTHING"], must_not_know: &[] },
    Row { module: "main", may_import: &["EVERYTHING"], must_not_know: &[] },
    Row { module: "lib", may_import: &[], must_not_know: &[] },
];

/// Only these may import `config`: who wires the program, and who lays the command line over the settings.
const WIRING: &[&str] = &["app", "cli"];

/// Longest a file may be. Files that are longer for a reason stand in `LONG_FILES`, at their length.
const MAX_LINES: usize = 600;
const LONG_FILES: &[(&str, usize)] = &[];

/// Names that say nothing about what is inside.
const VAGUE_NAMES: &[&str] =
    &["mod", "util", "utils", "common", "helper", "helpers", "types", "misc", "shared", "stuff", "prelude"];

#[test]
fn modules_import_only_what_the_table_allows() {
    let mut findings = Vec::new();
    for source in sources("src").iter().filter(|source| !source.is_test) {
        let Some(row) = TABLE.iter().find(|row| row.module == source.row()) else {
            findings.push(format!("{}: module {} has no row in the import table", source.path, source.row()));
            continue;
        };
        findings.extend(import_findings(source, row));
    }
    report("imports", findings);
}

fn import_findings(source: &Source, row: &Row) -> Vec<String> {
    let mut findings = Vec::new();
    for named in paths(source) {
        let at = format!("{}:{}", source.path, named.line);
        if let [root, module, ..] = named.segments.as_slice()
            && (root == "crate" || root == "tabletopgen")
            && TABLE.iter().any(|row| row.module == module)
            && module != row.module
        {
            let listed = row.may_import.iter().any(|allowed| match *allowed {
                "EVERYTHING" => true,
                "TOOLBOX" => TOOLBOX.contains(&module.as_str()),
                allowed => allowed == module,
            });
            if !listed {
                findings.push(format!("{at}: {} must not import {module}", row.module));
            } else if module == "config" && !WIRING.contains(&row.module) {
                findings.push(format!("{at}: only {} may import config", WIRING.join(" and ")));
            }
        }
        let spelled = named.segments.join("::");
        let known = row
            .must_not_know
            .iter()
            .find(|outside| spelled == **outside || spelled.starts_with(&format!("{outside}::")));
        if let Some(outside) = known {
            findings.push(format!("{at}: {} must not know {outside} ({spelled})", row.module));
        }
    }
    findings.dedup();
    findings
}

/// One client speaks outward, so that its rules about addresses hold for everything.
#[test]
fn only_the_remote_adapters_speak_outward() {
    let mut findings = Vec::new();
    let sources = sources("src");
    for source in sources.iter().filter(|source| !source.path.starts_with("src/provider/remote/")) {
        for named in paths(source) {
            if named.segments.first().is_some_and(|root| root == "reqwest" || root == "rustls") {
                let (at, spelled) = (format!("{}:{}", source.path, named.line), named.segments.join("::"));
                findings.push(format!("{at}: only src/provider/remote may know {spelled}"));
            }
        }
    }
    report("outbound", findings);
}

#[test]
fn every_row_of_the_table_is_a_module() {
    let all = sources("src");
    let missing = TABLE.iter().filter(|row| !all.iter().any(|source| source.row() == row.module));
    report("the import table", missing.map(|row| format!("there is no module {}", row.module)).collect());
}

#[test]
fn files_open_with_what_they_are_about() {
    let mut findings = Vec::new();
    for source in everything() {
        if !source.text.starts_with("//! ") {
            findings.push(format!("{}:1: the file must open with `//!`: what it is about", source.path));
        } else if source.text.starts_with("//! (in progress)") {
            findings.push(format!("{}:1: the file does not say yet what it is about", source.path));
        }
    }
    report("file documentation", findings);
}

#[test]
fn files_are_named_after_what_is_inside() {
    let vague = everything().into_iter().filter(|source| {
        let name = source.path.trim_end_matches(".rs");
        name.split('/').any(|part| VAGUE_NAMES.contains(&part))
    });
    report(
        "file names",
        vague.map(|s| format!("{}: the name says nothing; name.rs, not mod.rs", s.path)).collect(),
    );
}

#[test]
fn files_are_short() {
    let all = everything();
    let mut findings = Vec::new();
    for source in &all {
        let lines = source.text.lines().count();
        let limit = LONG_FILES.iter().find(|(path, _)| *path == source.path).map_or(MAX_LINES, |(_, n)| *n);
        if lines > limit {
            findings.push(format!("{}: {lines} lines; at most {limit}. One thing per file", source.path));
        } else if limit > MAX_LINES && lines <= MAX_LINES {
            findings.push(format!("{}: short now; take it out of LONG_FILES", source.path));
        }
    }
    for (path, _) in LONG_FILES {
        if !all.iter().any(|source| source.path == *path) {
            findings.push(format!("{path}: not there any more; take it out of LONG_FILES"));
        }
    }
    let mut lengths: Vec<usize> =
        all.iter().filter(|s| s.path.starts_with("src/")).map(|s| s.text.lines().count()).collect();
    lengths.sort_unstable();
    let (median, ninth) = (lengths[lengths.len() / 2], lengths[lengths.len() * 9 / 10]);
    if median >= 150 || ninth >= 400 {
        findings.push(format!(
            "half the files are under {median} lines and nine in ten under {ninth}; 150 and 400 are meant"
        ));
    }
    report("file lengths", findings);
}

#[test]
fn code_that_ships_has_no_shortcuts() {
    let mut findings = Vec::new();
    for source in sources("src").iter().filter(|source| !source.is_test) {
        let prints = matches!(source.row(), "cli" | "main");
        for window in source.tokens.windows(3) {
            let words = [window[0].text.as_str(), window[1].text.as_str(), window[2].text.as_str()];
            let found = match words {
                ["todo" | "unimplemented" | "dbg", "!", _] => words[0],
                ["println" | "eprintln" | "print" | "eprint", "!", _] if !prints => words[0],
                [".", "unwrap" | "unwrap_err", "("] => words[1],
                _ => continue,
            };
            findings.push(format!("{}:{}: {found} outside tests", source.path, window[0].line));
        }
    }
    report("shortcuts", findings);
}

#[test]
fn settings_are_documented_and_have_no_default() {
    let mut findings = Vec::new();
    for source in sources("src").iter().filter(|source| !source.is_test) {
        findings.extend(settings_findings(source));
    }
    report("settings", findings);
}

/// Line by line: `struct ...Settings {` to its closing brace, with the attributes above it.
fn settings_findings(source: &Source) -> Vec<String> {
    let lines: Vec<&str> = source.text.lines().collect();
    let mut findings = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        let Some(name) = line.strip_prefix("pub struct ").and_then(|rest| rest.strip_suffix(" {")) else {
            continue;
        };
        if !name.ends_with("Settings") {
            continue;
        }
        let above = lines[..i].iter().rev().take_while(|l| l.starts_with("#[") || l.starts_with("///"));
        if above.clone().any(|l| l.starts_with("#[derive(") && l.contains("Default")) {
            findings.push(format!(
                "{}:{}: {name} must not derive Default; defaults live in config",
                source.path,
                i + 1
            ));
        }
        if !above.into_iter().any(|l| l.starts_with("///")) {
            findings.push(format!("{}:{}: {name} has no documentation", source.path, i + 1));
        }
        let fields = lines[i + 1..].iter().take_while(|l| **l != "}").enumerate();
        for (k, field) in fields.filter(|(_, l)| l.starts_with("    pub ")) {
            let before = lines[..i + 1 + k].iter().rev().find(|l| !l.trim_start().starts_with("#["));
            // A section of settings is documented where its own struct is.
            let is_section = field.trim_end_matches(',').ends_with("Settings");
            if !is_section && !before.is_some_and(|l| l.trim_start().starts_with("///")) {
                let field = field.trim().trim_end_matches(',');
                findings.push(format!(
                    "{}:{}: {name}: `{field}` has no documentation",
                    source.path,
                    i + 2 + k
                ));
            }
        }
    }
    findings
}

#[test]
fn the_reader_sees_what_it_should() {
    let read = |path: &str, text: &str| {
        let (tokens, _) = source::without_tests(&source::tokens(text));
        let source = Source { path: path.into(), text: text.into(), tokens, is_test: false };
        let row = TABLE.iter().find(|row| row.module == source.row()).expect("a row of the table");
        import_findings(&source, row).len()
    };
    let caught: &[(&str, &str)] = &[
        ("src/geometry/pose.rs", "use crate::render::View;"),
        ("src/render/view.rs", "use crate::{\n    geometry::Pose,\n    physics::{self as p, Body},\n};"),
        ("src/render.rs", "fn f() -> crate::align::Yaw { todo }"),
        ("src/align/dro.rs", "use super::super::catalog::build;"),
        ("src/scene.rs", "use super::store::Store;"),
        ("src/geometry/cast.rs", "use std::{fmt, fs::{self, File}};"),
        ("src/catalog.rs", "fn f() { let t = std::time::Instant::now(); }"),
        ("src/provider/http.rs", "#[cfg(not(test))] use crate::job::JobState;"),
        ("src/export.rs", "fn f<'a>(x: &'a str) -> char { '\"' } use crate::store::Store;"),
        ("src/worker.rs", "use crate::config::Config;"),
    ];
    for (path, text) in caught {
        assert!(read(path, text) > 0, "nothing is found in {path}: {text}");
    }
    let fine: &[(&str, &str)] = &[
        ("src/geometry/pose.rs", "// use crate::render::View;\n/* use /* crate::api */ crate::render */"),
        (
            "src/geometry/pose.rs",
            "const A: &str = r#\"use crate::render::View; \" \"#; const B: &str = \"crate::api::x\";",
        ),
        (
            "src/geometry/pose.rs",
            "#[cfg(test)] mod tests { use crate::render::View; fn f() { std::fs::read(p); } }",
        ),
        (
            "src/geometry/pose.rs",
            "#[cfg(test)]\n#[allow(dead_code)]\nfn check(x: [u8; 3]) { crate::render::x() }",
        ),
        (
            "src/render.rs",
            "use crate::geometry::{Pose, TexturedMesh}; use super::geometry::Camera; use self::view::View;",
        ),
        ("src/app.rs", "use crate::config::Config;"),
    ];
    for (path, text) in fine {
        assert_eq!(read(path, text), 0, "found in {path}: {text}");
    }
}

fn everything() -> Vec<Source> {
    ["src", "tests", "benches"].into_iter().flat_map(sources).collect()
}

fn report(what: &str, findings: Vec<String>) {
    assert!(findings.is_empty(), "{} findings about {what}:\n  {}\n", findings.len(), findings.join("\n  "));
}
