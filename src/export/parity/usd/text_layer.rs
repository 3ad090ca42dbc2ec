//! A layer as text: one attribute a line, blocks by their braces.

use std::collections::BTreeMap;

use super::Layer;
use crate::export::parity::{ReadResult, numbers};

/// Prims by path; their attributes by name, without type and metadata.
pub struct TextLayer<'a>(BTreeMap<String, BTreeMap<&'a str, &'a str>>);

impl<'a> TextLayer<'a> {
    pub fn open(text: &'a str) -> Self {
        let mut found: BTreeMap<String, BTreeMap<&str, &str>> = BTreeMap::new();
        // A brace opens a prim that was announced before it, or a dictionary.
        let (mut open, mut path, mut announced) = (Vec::new(), String::new(), None);
        for line in text.lines().map(str::trim) {
            if let Some(definition) = line.strip_prefix("def ") {
                announced = definition.split('"').nth(1).map(|name| format!("{path}/{name}"));
                if let Some(prim) = &announced {
                    found.entry(prim.clone()).or_default();
                }
            } else if line == "{" {
                open.push(path.clone());
                path = announced.take().unwrap_or_default();
            } else if line.ends_with("= {") {
                open.push(path.clone());
            } else if line == "}" {
                path = open.pop().unwrap_or_default();
            } else if let Some((declaration, value)) = line.split_once(" = ") {
                let owner = announced.as_ref().unwrap_or(&path);
                let name = match declaration.starts_with("prepend") {
                    true => declaration,
                    false => declaration.rsplit(' ').next().unwrap_or_default(),
                };
                if let Some(prim) = found.get_mut(owner) {
                    prim.insert(name, value.trim_end_matches(" ("));
                }
            }
        }
        Self(found)
    }

    fn get(&self, prim: &str, attribute: &str) -> Option<&'a str> {
        self.0.get(prim)?.get(attribute).copied()
    }
}

impl Layer for TextLayer<'_> {
    fn prims(&self) -> Vec<&str> {
        self.0.keys().map(String::as_str).collect()
    }

    fn reference(&self, prim: &str) -> ReadResult<Option<String>> {
        Ok(self.get(prim, "prepend references").map(|asset| asset.trim_matches('@').to_owned()))
    }

    fn numbers(&self, prim: &str, attribute: &str) -> ReadResult<Option<Vec<f64>>> {
        self.get(prim, attribute).map(numbers).transpose()
    }

    fn text(&self, prim: &str, attribute: &str) -> ReadResult<Option<String>> {
        Ok(self.get(prim, attribute).map(|text| text.trim_matches('"').to_owned()))
    }
}
