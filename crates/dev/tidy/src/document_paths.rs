//! Paths of the repository in Markdown: in backticks, and as targets of links. A path that a document names must exist.

use std::path::{Component, Path, PathBuf};

use crate::documents::Document;
use crate::source::root;

/// Folders at the top of the repository. A name in backticks that begins with one of these is a path.
const FOLDERS: &[&str] = &[
    ".ci",
    "benches",
    "clients",
    "config",
    "crates",
    "docker",
    "docs",
    "examples",
    "fuzz",
    "migrations",
    "python",
    "schemas",
    "scripts",
    "src",
    "tests",
    "training",
    "weights",
];

/// Paths that do not exist, as `path:line: message`. Templates in sources are about other folders and pass.
pub fn findings(document: &Document) -> Vec<String> {
    if !document.path.ends_with(".md") || document.path.starts_with("crates/") {
        return Vec::new();
    }
    let root = root();
    let folder = Path::new(&document.path).parent().unwrap_or(Path::new(""));
    let mut findings = Vec::new();
    for (k, line) in document.text.lines().enumerate() {
        let named = line.split('`').skip(1).step_by(2).filter(|name| is_path(name)).map(PathBuf::from);
        let linked = targets(line).map(|target| without_dots(&folder.join(target)));
        let dead = named.chain(linked).filter(|path| !root.join(path).exists());
        findings.extend(dead.map(|path| {
            format!("{}:{}: there is no {} in the repository", document.path, k + 1, path.display())
        }));
    }
    findings
}

fn is_path(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-' | '/');
    let first = name.split_once('/').map(|(first, _)| first);
    name.chars().all(plain) && first.is_some_and(|first| FOLDERS.contains(&first))
}

/// Targets of links in the repository, without their anchors.
fn targets(line: &str) -> impl Iterator<Item = &str> {
    let ends = line.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    let files = ends.map(|(target, _)| target.split('#').next().unwrap_or_default());
    files.filter(|target| !target.is_empty() && !target.contains(':'))
}

/// The path with `..` taken away together with the folder before it.
fn without_dots(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(plain.pop()),
            Component::CurDir => {}
            part => plain.push(part),
        }
    }
    plain
}
