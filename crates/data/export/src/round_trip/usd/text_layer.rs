//! Reader of layers in the text format (`.usda`), as this crate writes them: one attribute per line.

use std::collections::BTreeMap;

use super::Layer;
use crate::round_trip::{ReadResult, numbers};

/// Fields and attributes of a prim by name, without types and metadata of attributes.
type Fields<'a> = BTreeMap<&'a str, &'a str>;

pub struct TextLayer<'a> {
    /// By path; the layer's own fields have the empty path.
    prims: BTreeMap<String, Fields<'a>>,
    /// The layers that variants load, by prim and variant set.
    payloads: BTreeMap<(String, &'a str), &'a str>,
}

impl<'a> TextLayer<'a> {
    pub fn open(text: &'a str) -> Self {
        let mut found: BTreeMap<String, Fields<'_>> = BTreeMap::from([(String::new(), BTreeMap::new())]);
        let (mut payloads, mut variant_set) = (BTreeMap::new(), "");
        // A brace opens the prim declared before it, a dictionary, a variant set or a variant.
        let (mut open, mut path, mut declared) = (Vec::new(), String::new(), None);
        for line in text.lines().map(str::trim) {
            if let Some(set) = line.strip_prefix("variantSet ") {
                variant_set = set.split('"').nth(1).unwrap_or_default();
            }
            let definition = line.strip_prefix("def ").or(line.strip_prefix("over "));
            if let Some(definition) = definition {
                declared = definition.split('"').nth(1).map(|name| format!("{path}/{name}"));
                if let Some(prim) = &declared {
                    let fields = found.entry(prim.clone()).or_default();
                    if let Some((kind, _)) = definition.split_once(" \"") {
                        fields.insert("typeName", kind);
                    }
                }
            } else if line == "{" {
                open.push(path.clone());
                path = declared.take().unwrap_or_default();
            } else if line.ends_with('{') {
                open.push(path.clone());
            } else if let Some(payload) = line.strip_prefix("prepend payload = ") {
                payloads.insert((path.clone(), variant_set), payload);
            } else if line == "}" {
                path = open.pop().unwrap_or_default();
            } else if let Some((declaration, value)) = line.split_once(" = ") {
                let owner = declared.as_ref().unwrap_or(&path);
                let name = match declaration.starts_with("prepend") {
                    true => declaration,
                    false => declaration.rsplit(' ').next().unwrap_or_default(),
                };
                if let Some(prim) = found.get_mut(owner) {
                    prim.insert(name, value.trim_end_matches(" ("));
                }
            }
        }
        Self { prims: found, payloads }
    }

    fn get(&self, prim: &str, attribute: &str) -> Option<&'a str> {
        self.prims.get(prim)?.get(attribute).copied()
    }
}

impl Layer for TextLayer<'_> {
    fn prims(&self) -> Vec<&str> {
        self.prims.keys().map(String::as_str).filter(|path| !path.is_empty()).collect()
    }

    fn reference(&self, prim: &str) -> ReadResult<Option<String>> {
        Ok(self.get(prim, "prepend references").map(|asset| asset.trim_matches('@').to_owned()))
    }

    fn numbers(&self, prim: &str, attribute: &str) -> ReadResult<Option<Vec<f64>>> {
        self.get(prim, attribute).map(numbers).transpose()
    }

    fn text(&self, prim: &str, attribute: &str) -> ReadResult<Option<String>> {
        Ok(self.get(prim, attribute).map(unquoted))
    }

    fn field(&self, prim: &str, field: &str) -> ReadResult<Option<String>> {
        self.text(prim, field)
    }

    fn has_schema(&self, prim: &str, schema: &str) -> ReadResult<bool> {
        let applied = self.get(prim, "prepend apiSchemas").unwrap_or_default();
        Ok(applied.contains(&format!("\"{schema}\"")))
    }

    fn target(&self, prim: &str, relationship: &str) -> ReadResult<Option<String>> {
        Ok(self.get(prim, relationship).map(|path| path.trim_matches(['<', '>']).to_owned()))
    }

    fn payload(&self, prim: &str, variant_set: &str) -> ReadResult<Option<String>> {
        let payload = self.payloads.get(&(prim.to_owned(), variant_set));
        Ok(payload.map(|asset| asset.trim_matches('@').to_owned()))
    }
}

/// The content of a string literal, or of the first of a list, without quotes and escapes.
fn unquoted(literal: &str) -> String {
    let mut text = String::new();
    let literal = literal.strip_prefix('[').unwrap_or(literal);
    let mut rest = literal.strip_prefix('"').unwrap_or(literal).chars();
    while let Some(c) = rest.next() {
        match c {
            '"' => break,
            '\\' => match rest.next() {
                Some('n') => text.push('\n'),
                Some('r') => text.push('\r'),
                Some('t') => text.push('\t'),
                Some('x') => {
                    let digits: String = rest.by_ref().take(2).collect();
                    text.extend(u8::from_str_radix(&digits, 16).map(char::from));
                }
                other => text.extend(other),
            },
            c => text.push(c),
        }
    }
    text
}
