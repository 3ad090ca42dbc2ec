//! Documents that people read: Markdown, the HTTP contract, schemas, and the settings with their comments.
//!
//! Left out are the history of changes with its old names, the prompts, whose words are part of recorded exchanges, and
//! `scripts`. Words of records of measurements (`docs/results`) are free, and so are those of code in a document
//! (fences, backticks) and of quoted sentences: they are names and inputs.

use std::fs;
use std::path::{Path, PathBuf};

use crate::allowed::is_allowed;
use crate::source::{packages, root};
use crate::words::banned_in_text;
use crate::{Finding, Rule};

const LEFT_OUT: &str = "CHANGELOG.md";

/// Folder of records, whose words are free.
const RECORDS: &str = "docs/results/";

/// One document.
#[derive(Clone, Debug)]
pub struct Document {
    /// Relative to the repository, with `/`.
    pub path: String,
    pub text: String,
}

/// Every document of the tree, by path.
pub fn documents() -> Vec<Document> {
    documents_below(&[PathBuf::new()])
}

/// Documents that are or stand below `paths`, which are relative to the repository.
pub fn documents_below(paths: &[PathBuf]) -> Vec<Document> {
    let root = root();
    let mut files: Vec<PathBuf> = files_in(&root);
    let folders =
        ["clients", "docs", "docker", "schemas", "benches", "fuzz", "weights", "training", "examples"];
    for folder in folders.iter().map(|folder| root.join(folder)) {
        collect(&folder, &mut files);
    }
    for package in packages() {
        collect(&root.join(package.folder()).join("src"), &mut files);
    }
    files.push(root.join("config/default.toml"));
    let relative = |file: &Path| file.strip_prefix(&root).unwrap_or(file).to_owned();
    files.retain(|file| paths.iter().any(|path| relative(file).starts_with(path)));
    files.sort();
    let read = |file: &PathBuf| {
        let path = relative(file).to_string_lossy().replace('\\', "/");
        fs::read_to_string(file).ok().map(|text| Document { path, text })
    };
    files.iter().filter_map(read).filter(|document| document.path != LEFT_OUT).collect()
}

fn files_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).filter(|path| path.is_file() && is_document(path)).collect()
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    files.extend(files_in(folder));
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let folders = entries.map(|entry| entry.path()).filter(|path| path.is_dir());
    let free = ["target", "corpus", "seeds", "node_modules"];
    for inner in
        folders.filter(|path| !path.file_name().is_some_and(|name| free.iter().any(|free| name == *free)))
    {
        collect(&inner, files);
    }
}

fn is_document(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
    [".md", ".yaml", ".yml", ".schema.json"].iter().any(|ending| name.ends_with(ending))
}

/// Banned words of the document that the table of exceptions does not allow, by line.
pub fn findings(document: &Document) -> Vec<Finding> {
    let mut findings = all_findings(document);
    findings.retain(|finding| !is_allowed(finding));
    findings
}

/// Findings before exceptions.
pub fn all_findings(document: &Document) -> Vec<Finding> {
    let is_markdown = document.path.ends_with(".md");
    let (mut findings, mut in_fence) = (Vec::new(), false);
    let lines = if document.path.starts_with(RECORDS) { "" } else { document.text.as_str() };
    for (k, line) in lines.lines().enumerate() {
        let is_fence = is_markdown && line.trim_start().starts_with("```");
        in_fence ^= is_fence;
        if in_fence || is_fence {
            continue;
        }
        let prose = if is_markdown { without_quotes(line) } else { line.to_owned() };
        for word in banned_in_text(&prose) {
            findings.push(Finding {
                rule: Rule::DocumentWord,
                path: document.path.clone(),
                line: k + 1,
                subject: word,
                text: line.trim().to_owned(),
            });
        }
    }
    findings
}

/// The line without text between two backticks or two quotation marks.
fn without_quotes(line: &str) -> String {
    ['`', '"'].into_iter().fold(line.to_owned(), |text, mark| {
        let mut parts = text.split(mark);
        let mut kept = parts.next().unwrap_or_default().to_owned();
        while let Some(quoted) = parts.next() {
            // A mark without a partner quotes nothing.
            kept.push(' ');
            kept.push_str(parts.next().unwrap_or(quoted));
        }
        kept
    })
}
