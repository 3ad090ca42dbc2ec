//! Manifests and modules against the import table.

use std::fs;

use tidy::imports::{manifest_findings, path_findings};
use tidy::layers::{CRATES, LAB_MODULES, Layer, ROOT, ROOT_MODULES, WINGS};
use tidy::manifest::dependencies;
use tidy::paths::paths;
use tidy::source::{Package, packages, root};

use crate::{report, shipped};

fn manifest(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

#[test]
fn crates_depend_only_on_what_the_table_allows() {
    let mut findings = manifest_findings("Cargo.toml", ROOT, &manifest("Cargo.toml"));
    for package in packages() {
        findings.extend(manifest_findings(
            &package.manifest(),
            &package.name,
            &manifest(&package.manifest()),
        ));
    }
    report("dependencies", findings);
}

#[test]
fn no_crate_depends_on_a_wing_above_its_own() {
    let packages = packages();
    let floor = |package: &Package| {
        let wing = WINGS.iter().position(|wing| *wing == package.wing);
        wing.unwrap_or_else(|| panic!("{} is no wing of the table", package.wing))
    };
    let mut findings = Vec::new();
    for package in &packages {
        for dependency in dependencies(&manifest(&package.manifest())) {
            let above =
                packages.iter().find(|other| other.name == dependency.name && floor(other) > floor(package));
            findings.extend(above.map(|other| {
                format!(
                    "{}:{}: {} is in the wing {}",
                    package.manifest(),
                    dependency.line,
                    other.name,
                    other.wing
                )
            }));
        }
    }
    report("wings", findings);
}

/// A dependency would make the checks wait for its compilation.
#[test]
fn the_checks_have_no_dependencies() {
    assert_eq!(dependencies(&manifest("crates/dev/tidy/Cargo.toml")), []);
}

#[test]
fn modules_import_only_what_the_table_allows() {
    report("imports", shipped().flat_map(path_findings).collect());
}

#[test]
fn every_row_of_the_table_is_a_crate_or_a_module() {
    let packages = packages();
    let exists = |name: &str| packages.iter().any(|package| package.name == name);
    let no_crate = CRATES.iter().filter(|layer| !exists(layer.name));
    let no_module = |package: &'static str, modules: &'static [Layer]| {
        modules.iter().filter(move |layer| {
            !shipped().any(|source| source.package() == package && source.top_module() == layer.name)
        })
    };
    let missing = no_crate.chain(no_module(ROOT, ROOT_MODULES)).chain(no_module("lab", LAB_MODULES));
    report("the import table", missing.map(|layer| format!("there is no {}", layer.name)).collect());
}

/// An exception that no file uses permits more than the code needs.
#[test]
fn every_exception_of_the_table_is_used() {
    let mut findings = Vec::new();
    for layer in CRATES {
        for excepted in layer.except {
            let prefix = format!("{excepted}::");
            let files = shipped().filter(|source| source.package() == layer.name);
            let is_used = files.flat_map(paths).any(|path| {
                let spelled = path.spelled();
                spelled == *excepted || spelled.starts_with(&prefix)
            });
            if !is_used {
                findings.push(format!("{}: {excepted} is not used; remove the exception", layer.name));
            }
        }
    }
    report("exceptions", findings);
}
