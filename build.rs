//! Writes the table of the page's files: what `make studio` left in `studio/dist`, with the bytes themselves.
//!
//! Nothing is built here, so that a build needs no Node and no network: without the folder the table is empty, and the
//! server answers with how to build the page. A file `x` is held as it is, as `x.br` and as `x.gz`, as far as these are
//! there; a large one with a compressed form is held in that form alone.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// Larger files are held compressed alone, bytes.
const MAX_PLAIN_BYTES: u64 = 1 << 20;

fn main() -> io::Result<()> {
    let folder = PathBuf::from(variable("CARGO_MANIFEST_DIR")?).join("studio/dist");
    // Cargo runs a script anew each time that a path which it names is missing. Where the source cannot be written
    // to, it does that.
    let _ = fs::create_dir_all(&folder);
    say("rerun-if-changed=build.rs");
    say("rerun-if-changed=studio/dist");
    let mut files = Vec::new();
    list(&folder, &mut files)?;
    files.sort();
    if !folder.join("index.html").exists() {
        files.clear();
        say(
            "warning=the page of the server is not built (studio/dist is empty), and this program will not have it; \
             run `make studio` with Node 20.19 or later, then build again",
        );
    }
    files.retain(|file| !is_compressed(file));
    let mut table = format!("static FILES: [File; {}] = [\n", files.len());
    for file in &files {
        let beside = |ending: &str| {
            let name = format!("{}.{ending}", file.display());
            Some(PathBuf::from(name)).filter(|path| path.exists())
        };
        let (brotli, gzip) = (beside("br"), beside("gz"));
        let is_large = fs::metadata(file)?.len() > MAX_PLAIN_BYTES;
        let plain = Some(file.clone()).filter(|_| !is_large || gzip.is_none());
        let path = file.strip_prefix(&folder).map_err(io::Error::other)?;
        let path = path.to_string_lossy().replace('\\', "/");
        let bytes = |form: &Option<PathBuf>| match form {
            Some(form) => format!("Some(Form::new(include_bytes!({:?})))", form.display().to_string()),
            None => "None".to_owned(),
        };
        let (plain, gzip, brotli) = (bytes(&plain), bytes(&gzip), bytes(&brotli));
        writeln!(table, "    File {{ path: {path:?}, plain: {plain}, gzip: {gzip}, brotli: {brotli} }},")
            .map_err(io::Error::other)?;
    }
    table.push_str("];\n");
    fs::write(PathBuf::from(variable("OUT_DIR")?).join("studio_files.rs"), table)
}

/// A variable that Cargo sets.
fn variable(name: &str) -> io::Result<String> {
    env::var(name).map_err(|error| io::Error::other(format!("Cargo sets {name} for build scripts: {error}")))
}

/// Tells Cargo.
fn say(instruction: &str) {
    println!("cargo::{instruction}");
}

fn is_compressed(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending == "br" || ending == "gz")
}

/// Every file below a folder.
fn list(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    let Ok(entries) = fs::read_dir(folder) else { return Ok(()) };
    for entry in entries {
        let path = entry?.path();
        match path.is_dir() {
            true => list(&path, files)?,
            false => files.push(path),
        }
    }
    Ok(())
}
