//! Holds manifests and paths against the import table.

use crate::layers::{
    CRATES, LAB_MODULES, Layer, NEVER_SHIPPED, ROOT, ROOT_MODULES, crate_layer, module_layer,
};
use crate::manifest::dependencies;
use crate::paths::{NamedPath, paths};
use crate::source::Source;

/// Dependencies of the package that its layer does not allow. `path` is that of the manifest.
pub fn manifest_findings(path: &str, package: &str, manifest: &str) -> Vec<String> {
    let mut findings = Vec::new();
    let layer = crate_layer(package);
    if package != ROOT && layer.is_none() {
        return vec![format!("{path}: crate {package} has no row in the table CRATES of layers.rs")];
    }
    for dependency in dependencies(manifest) {
        let (at, name) = (format!("{path}:{}", dependency.line), dependency.name);
        let in_workspace = name == ROOT || crate_layer(&name).is_some();
        match layer {
            Some(layer) if in_workspace && !layer.may_import(&name) => {
                findings.push(format!("{at}: {package} must not depend on {name}"));
            }
            Some(layer) if layer.forbids(&name).is_some() && !has_exception_in(layer, &name) => {
                findings.push(format!("{at}: {package} must not know {name}"));
            }
            None if NEVER_SHIPPED.contains(&name.as_str()) => {
                findings.push(format!("{at}: the product must not depend on {name}"));
            }
            _ => {}
        }
    }
    findings
}

/// Whether the layer may know a part of the package, so that only its paths can be checked.
fn has_exception_in(layer: &Layer, package: &str) -> bool {
    layer.except.iter().any(|excepted| excepted.split("::").next() == Some(package))
}

/// Paths of the shipped code of `source` that its layer does not allow.
pub fn path_findings(source: &Source) -> Vec<String> {
    let (package, module) = (source.package(), source.top_module());
    let Some(layer) = module_layer(package, module) else {
        return vec![format!("{}: {package}, module {module}, has no row in layers.rs", source.path)];
    };
    let mut findings = Vec::new();
    for path in paths(source) {
        let at = format!("{}:{}", source.path, path.line);
        if let Some(import) = import_of(&path, source)
            && import != layer.name
        {
            let is_config = import == "config" || import == "tabletopgen::config";
            if !layer.may_import(&import) {
                findings.push(format!("{at}: {} must not import {import}", layer.name));
            } else if package == ROOT && is_config && !matches!(layer.name, "app" | "cli" | "service") {
                findings.push(format!("{at}: only app, cli and service may import config"));
            }
        }
        if let Some(outside) = layer.forbids(&path.spelled()) {
            findings.push(format!("{at}: {} must not know {outside} ({})", layer.name, path.spelled()));
        }
    }
    findings.dedup();
    findings
}

/// The layer that the path enters: a crate of the workspace or a module of this crate. `None` where Cargo decides.
fn import_of(path: &NamedPath, source: &Source) -> Option<String> {
    let modules = match source.package() {
        ROOT => ROOT_MODULES,
        "lab" => LAB_MODULES,
        _ => return None,
    };
    let is_module = |name: &str| modules.iter().any(|layer| layer.name == name);
    match path.segments.as_slice() {
        [first, module, ..] if first == "crate" && is_module(module) => Some(module.clone()),
        [first, module, ..] if first == ROOT && source.package() == ROOT && is_module(module) => {
            Some(module.clone())
        }
        [first, module, ..] if first == ROOT => Some(format!("{ROOT}::{module}")),
        [first, ..] if CRATES.iter().any(|layer| layer.name == first) && !declares(source, first) => {
            Some(first.clone())
        }
        _ => None,
    }
}

/// Whether `name` is a module of the file itself.
fn declares(source: &Source, name: &str) -> bool {
    source.shipped.windows(2).any(|pair| pair[0].text == "mod" && pair[1].text == name)
}
