//! Settings structs are documented field by field and have no `Default`: defaults stand in the configuration file.

use crate::source::Source;

/// Line by line: `struct ...Settings {` to its closing brace, with the attributes above it.
pub fn settings_findings(source: &Source) -> Vec<String> {
    let lines: Vec<&str> = source.text.lines().collect();
    let mut findings = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        let name = line.strip_prefix("pub struct ").and_then(|rest| rest.strip_suffix(" {"));
        let Some(name) = name.filter(|name| name.ends_with("Settings")) else { continue };
        let at = |line: usize| format!("{}:{}: {name}", source.path, line + 1);
        let above = lines[..i].iter().rev().take_while(|l| l.starts_with("#[") || l.starts_with("///"));
        if above.clone().any(|l| l.starts_with("#[derive(") && l.contains("Default")) {
            findings.push(format!("{} must not derive Default; defaults stand in config", at(i)));
        }
        if !above.into_iter().any(|l| l.starts_with("///")) {
            findings.push(format!("{} has no documentation", at(i)));
        }
        let fields = lines[i + 1..].iter().take_while(|l| **l != "}").enumerate();
        for (k, field) in fields.filter(|(_, l)| l.starts_with("    pub ")) {
            let before = lines[..i + 1 + k].iter().rev().find(|l| !l.trim_start().starts_with("#["));
            // A section of settings is documented at its own struct.
            let is_section = field.trim_end_matches(',').ends_with("Settings");
            if !is_section && !before.is_some_and(|l| l.trim_start().starts_with("///")) {
                let field = field.trim().trim_end_matches(',');
                findings.push(format!("{}: `{field}` has no documentation", at(i + 1 + k)));
            }
        }
    }
    findings.extend(default_impls(source));
    findings
}

/// `impl Default for ...Settings` in code that ships.
fn default_impls(source: &Source) -> Vec<String> {
    let windows = source.shipped.windows(4);
    let impls = windows.filter(|w| {
        w[0].text == "impl" && w[1].text == "Default" && w[2].text == "for" && w[3].text.ends_with("Settings")
    });
    impls
        .map(|w| format!("{}:{}: {} must not implement Default", source.path, w[0].line, w[3].text))
        .collect()
}
