//! The names below `[dependencies]` of a `Cargo.toml`, read line by line.

/// One dependency of a package.
#[derive(Clone, Debug, PartialEq)]
pub struct Dependency {
    /// The package as code names it: no `tabletopgen-` before a crate of the workspace, `_` for `-`.
    pub name: String,
    /// Counted from 1.
    pub line: usize,
}

/// Dependencies that the package needs to build: `[dependencies]` and `[build-dependencies]`, of every target. Tests
/// may depend on anything, so `[dev-dependencies]` do not count.
pub fn dependencies(manifest: &str) -> Vec<Dependency> {
    let (mut found, mut in_table) = (Vec::new(), false);
    for (i, line) in manifest.lines().enumerate() {
        let (line, number) = (line.trim(), i + 1);
        if let Some(header) = line.strip_prefix('[') {
            let header = header.trim_end_matches(']');
            in_table = is_table(header);
            // `[dependencies.name]` is a table of one dependency.
            if let Some((table, name)) = header.rsplit_once('.')
                && is_table(table)
            {
                found.push(Dependency { name: code_name(name), line: number });
            }
        } else if in_table && !line.starts_with('#') && line.contains('=') {
            let key = line.split(['.', '=', ' ']).next().unwrap_or_default().trim_matches('"');
            let renamed = line.split_once("package = \"").and_then(|(_, rest)| rest.split('"').next());
            found.push(Dependency { name: code_name(renamed.unwrap_or(key)), line: number });
        }
    }
    found
}

fn is_table(header: &str) -> bool {
    let table = header.rsplit_once('.').filter(|_| header.starts_with("target.")).map_or(header, |(_, t)| t);
    matches!(table, "dependencies" | "build-dependencies")
}

fn code_name(package: &str) -> String {
    package.strip_prefix("tabletopgen-").unwrap_or(package).replace('-', "_")
}
