//! One source file as the checks read it, and the files of the whole tree.

use std::fs;
use std::path::{Path, PathBuf};

use crate::lexer::{CommentLine, Token, lex};
use crate::python_lexer;
use crate::test_code::without_tests;

/// One Rust, WGSL or Python file.
#[derive(Clone, Debug)]
pub struct Source {
    /// Relative to the repository, with `/`.
    pub path: String,
    pub text: String,
    pub tokens: Vec<Token>,
    pub comments: Vec<CommentLine>,
    /// The tokens that do not stand under `cfg(test)`.
    pub shipped: Vec<Token>,
    /// Only tests, benchmarks or examples compile this file.
    pub is_test: bool,
}

impl Source {
    pub fn new(path: &str, text: &str) -> Self {
        Self::with_test_modules(path, text).0
    }

    fn with_test_modules(path: &str, text: &str) -> (Self, Vec<String>) {
        let lexed = if is_python(path) { python_lexer::lex(text) } else { lex(text) };
        let (shipped, test_modules) = without_tests(&lexed.tokens);
        let source = Self {
            path: path.to_owned(),
            text: text.to_owned(),
            tokens: lexed.tokens,
            comments: lexed.comments,
            shipped,
            is_test: if is_python(path) { is_python_test(path) } else { !is_below_src(path) },
        };
        (source, test_modules)
    }

    pub fn is_rust(&self) -> bool {
        self.path.ends_with(".rs")
    }

    /// `scene` of `crates/base/scene/src/job.rs`; `tabletopgen` of the root package; `fuzz` of `fuzz/`.
    pub fn package(&self) -> &str {
        match self.path.split('/').collect::<Vec<_>>().as_slice() {
            ["crates", _, package, ..] => package,
            ["fuzz", ..] => "fuzz",
            _ => "tabletopgen",
        }
    }

    /// `["align", "dro"]` of `crates/x/src/align/dro.rs`; empty for `lib.rs` and `main.rs`.
    pub fn module(&self) -> Vec<&str> {
        let inner = self.below_src();
        if matches!(inner, "lib" | "main") { Vec::new() } else { inner.split('/').collect() }
    }

    /// First segment of [`Self::module`], or `lib` or `main`.
    pub fn top_module(&self) -> &str {
        self.below_src().split('/').next().unwrap_or_default()
    }

    fn below_src(&self) -> &str {
        let inner = match self.path.split_once("/src/") {
            Some((_, inner)) => inner,
            None => self.path.trim_start_matches("src/"),
        };
        inner.trim_end_matches(".rs")
    }

    /// The source line without indentation.
    pub fn line(&self, line: usize) -> &str {
        self.text.lines().nth(line - 1).unwrap_or_default().trim()
    }
}

fn is_below_src(path: &str) -> bool {
    path.starts_with("src/") || (path.starts_with("crates/") && path.split('/').nth(3) == Some("src"))
}

fn is_python(path: &str) -> bool {
    path.ends_with(".py")
}

/// Modules of unit tests. The judges below `tests/` are programs, whose messages people read.
fn is_python_test(path: &str) -> bool {
    let name = path.rsplit('/').next().unwrap_or_default();
    path.starts_with("python/tabletopgen_checks/tests/") || name.starts_with("test_")
}

/// The folder of the repository. Cargo tells it at run time: a program in a shared target directory may have been built
/// from another clone.
pub fn root() -> PathBuf {
    let package =
        std::env::var("CARGO_MANIFEST_DIR").unwrap_or_else(|_| env!("CARGO_MANIFEST_DIR").to_owned());
    let root = Path::new(&package).join("../../..");
    root.canonicalize().unwrap_or(root)
}

/// Every source file of the tree, by path.
pub fn tree() -> Vec<Source> {
    sources_below(&folders())
}

/// The folders of source files, relative to the repository.
pub fn folders() -> Vec<PathBuf> {
    let parts = ["src", "tests", "benches", "examples"];
    let mut folders: Vec<PathBuf> = parts.iter().map(PathBuf::from).collect();
    folders.extend(["fuzz/fuzz_targets", "clients", "python", "docker", "training"].map(PathBuf::from));
    folders.extend(packages().iter().flat_map(|package| parts.map(|part| package.folder().join(part))));
    folders
}

/// A crate of a wing.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Package {
    pub wing: String,
    pub name: String,
}

impl Package {
    /// Relative to the repository.
    pub fn folder(&self) -> PathBuf {
        Path::new("crates").join(&self.wing).join(&self.name)
    }

    /// Path of its manifest, relative to the repository, with `/`.
    pub fn manifest(&self) -> String {
        format!("crates/{}/{}/Cargo.toml", self.wing, self.name)
    }
}

/// The folders two below `crates/` that hold a manifest.
pub fn packages() -> Vec<Package> {
    let mut packages: Vec<Package> = folder_names(Path::new("crates"))
        .into_iter()
        .flat_map(|wing| {
            let names = folder_names(&Path::new("crates").join(&wing));
            names.into_iter().map(move |name| Package { wing: wing.clone(), name })
        })
        .filter(|package| root().join(package.folder()).join("Cargo.toml").is_file())
        .collect();
    packages.sort();
    packages
}

fn folder_names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(root().join(folder)).into_iter().flatten().flatten();
    entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
}

/// The source files that are or stand below `paths`, which are relative to the repository.
pub fn sources_below(paths: &[PathBuf]) -> Vec<Source> {
    let root = root();
    let mut files = Vec::new();
    for path in paths {
        collect(&root.join(path), &mut files);
    }
    files.sort();
    files.dedup();
    let (mut sources, mut test_modules) = (Vec::new(), Vec::new());
    for file in files {
        // Another program may remove or rename a file between the listing and the reading.
        let Ok(text) = fs::read_to_string(&file) else { continue };
        let relative = file.strip_prefix(&root).unwrap_or(&file).to_string_lossy().replace('\\', "/");
        let (source, declared) = Source::with_test_modules(&relative, &text);
        let folder = relative.strip_suffix("/lib.rs").or(relative.strip_suffix("/main.rs"));
        let folder = folder.unwrap_or(relative.trim_end_matches(".rs"));
        test_modules.extend(declared.into_iter().map(|name| format!("{folder}/{name}")));
        sources.push(source);
    }
    for source in &mut sources {
        let name = source.path.trim_end_matches(".rs");
        source.is_test |= test_modules.iter().any(|t| name == t || name.starts_with(&format!("{t}/")));
    }
    sources
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) {
    if path.is_file() {
        let extension = path.extension().and_then(|extension| extension.to_str());
        if matches!(extension, Some("rs" | "wgsl" | "py")) {
            files.push(path.to_owned());
        }
        return;
    }
    let entries = fs::read_dir(path).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| entry.file_name() != "target") {
        collect(&entry.path(), files);
    }
}
