//! A layer in OpenUSD's crate format (`.usdc`), version 0.8.0, which OpenUSD itself writes unless a layer needs more.
//!
//! The file is a header, a heap of values, six sections and a table of contents that names them:
//!
//! | section | holds |
//! | --- | --- |
//! | `TOKENS` | every name and text, once |
//! | `STRINGS` | which tokens are texts |
//! | `FIELDS` | pairs of a name and a value, once |
//! | `FIELDSETS` | lists of fields, once |
//! | `PATHS` | the tree of prims and properties |
//! | `SPECS` | what stands at a path: its kind and its list of fields |
//!
//! Fields carry their values as 64-bit words ([`value_word`]): small ones in the word, others by their place
//! in the heap ([`heap`]). Tables are compressed ([`compression`]). Source: `crateFile.h` and `crateFile.cpp` of
//! OpenUSD. Equal layers give equal bytes.

mod compression;
mod heap;
mod path_tree;
mod section;
mod value_word;
mod values;

use std::collections::BTreeMap;

use super::layer::{Content, Layer, Prim, Property, Specifier, Switch, Variability};
use super::value::{Value, ValueType};
use compression::{compressed, compressed_integers};
use heap::Heap;
use path_tree::PathTree;
use section::{put_bytes, put_u64};
use value_word::{CrateType, ValueWord};

const VERSION: [u8; 3] = [0, 8, 0];

/// Ends a list of fields.
const END_OF_FIELDS: u32 = u32::MAX;

/// The bytes of the file.
pub fn write(layer: &Layer) -> Vec<u8> {
    let mut file = CrateFile::default();
    file.add_layer(layer);
    file.finish()
}

/// Kinds of specs.
#[derive(Clone, Copy)]
enum SpecType {
    Attribute = 1,
    Prim = 6,
    PseudoRoot = 7,
    Relationship = 8,
    Variant = 10,
    VariantSet = 11,
}

struct Spec {
    path: u32,
    /// Where its list begins in `field_sets`.
    field_set: u32,
    spec_type: SpecType,
}

/// The sections under construction.
#[derive(Default)]
struct CrateFile {
    tokens: Numbered<String>,
    /// Numbers of tokens.
    strings: Numbered<u32>,
    /// Numbers of tokens, with values.
    fields: Numbered<(u32, ValueWord)>,
    /// Numbers of fields, each list followed by [`END_OF_FIELDS`].
    field_sets: Vec<u32>,
    known_field_sets: BTreeMap<Vec<u32>, u32>,
    paths: PathTree,
    specs: Vec<Spec>,
    heap: Heap,
}

/// Different things, numbered as they come.
struct Numbered<T> {
    things: Vec<T>,
    numbers: BTreeMap<T, u32>,
}

impl<T> Default for Numbered<T> {
    fn default() -> Self {
        Self { things: Vec::new(), numbers: BTreeMap::new() }
    }
}

impl<T: Ord + Clone> Numbered<T> {
    fn number(&mut self, thing: T) -> u32 {
        let next = self.things.len() as u32;
        *self.numbers.entry(thing).or_insert_with_key(|thing| {
            self.things.push(thing.clone());
            next
        })
    }
}

impl CrateFile {
    fn add_layer(&mut self, layer: &Layer) {
        // The sign of a token's number tells properties from prims in the tree of paths, so that no
        // property may have the number 0.
        let root_element = self.token("");
        assert_eq!(root_element, 0, "the first token of a file");
        let mut fields = Vec::new();
        if !layer.custom_data.entries().is_empty() {
            let word = self.dictionary(&layer.custom_data);
            fields.push(self.field("customLayerData", word));
        }
        let root_name = std::slice::from_ref(&layer.root.name);
        for (name, word) in [
            ("defaultPrim", self.token_word(&layer.root.name)),
            ("kilogramsPerUnit", self.value(&Value::Double(1.0))),
            ("metersPerUnit", self.value(&Value::Double(1.0))),
            ("upAxis", self.token_word("Z")),
            ("primChildren", self.token_vector(root_name)),
        ] {
            fields.push(self.field(name, word));
        }
        self.spec(PathTree::ROOT, SpecType::PseudoRoot, fields);
        self.add_prim(PathTree::ROOT, &layer.root);
    }

    fn add_prim(&mut self, parent: u32, prim: &Prim) {
        let element = self.token(&prim.name);
        let path = self.paths.prim(parent, element);
        let mut fields = vec![self.field("specifier", ValueWord::specifier(prim.specifier))];
        if let Specifier::Def(type_name) = prim.specifier {
            let type_name = self.token_word(type_name);
            fields.push(self.field("typeName", type_name));
        }
        if !prim.schemas.is_empty() {
            let tokens: Vec<u32> = prim.schemas.iter().map(|schema| self.token(schema)).collect();
            let word = self.prepended(CrateType::TokenListOp, &tokens);
            fields.push(self.field("apiSchemas", word));
        }
        if !prim.asset_info.entries().is_empty() {
            let word = self.dictionary(&prim.asset_info);
            fields.push(self.field("assetInfo", word));
        }
        if let Some(name) = &prim.display_name {
            let word = self.value(&Value::String(name.clone()));
            fields.push(self.field("displayName", word));
        }
        if let Some(kind) = prim.kind {
            let word = self.token_word(kind);
            fields.push(self.field("kind", word));
        }
        if let Some(reference) = &prim.reference {
            let word = self.prepended_reference(reference);
            fields.push(self.field("references", word));
        }
        if !prim.properties().is_empty() {
            let names: Vec<String> = prim.properties().iter().map(|property| property.name.clone()).collect();
            let word = self.token_vector(&names);
            fields.push(self.field("properties", word));
        }
        if !prim.children().is_empty() {
            let names: Vec<String> = prim.children().iter().map(|child| child.name.clone()).collect();
            let word = self.token_vector(&names);
            fields.push(self.field("primChildren", word));
        }
        if !prim.switches.is_empty() {
            self.describe_switches(&prim.switches, &mut fields);
        }
        self.spec(path, SpecType::Prim, fields);
        prim.properties().iter().for_each(|property| self.add_property(path, property));
        prim.children().iter().for_each(|child| self.add_prim(path, child));
        prim.switches.iter().for_each(|switch| self.add_switch(path, switch));
    }

    /// What a prim says of its variant sets.
    fn describe_switches(&mut self, switches: &[Switch], fields: &mut Vec<u32>) {
        let names: Vec<String> = switches.iter().map(|switch| switch.name.to_owned()).collect();
        let strings: Vec<u32> = names.iter().map(|name| self.string(name)).collect();
        let chosen: Vec<(&str, &str)> = names.iter().map(|name| (name.as_str(), Switch::OFF)).collect();
        let word = self.variant_selection(&chosen);
        fields.push(self.field("variantSelection", word));
        let word = self.token_vector(&names);
        fields.push(self.field("variantSetChildren", word));
        let word = self.prepended(CrateType::StringListOp, &strings);
        fields.push(self.field("variantSetNames", word));
    }

    /// The set and its variants, which stand beside each other below the prim.
    fn add_switch(&mut self, prim: u32, switch: &Switch) {
        let path = |file: &mut Self, variant: &str| {
            let element = file.token(&format!("{{{}={variant}}}", switch.name));
            file.paths.prim(prim, element)
        };
        let set = path(self, "");
        let word = self.token_vector(&[Switch::OFF.to_owned(), Switch::ON.to_owned()]);
        let fields = vec![self.field("variantChildren", word)];
        self.spec(set, SpecType::VariantSet, fields);
        for variant in [Switch::OFF, Switch::ON] {
            let path = path(self, variant);
            let mut fields = vec![self.field("specifier", ValueWord::specifier(Specifier::Over))];
            if variant == Switch::ON {
                let word = self.prepended_payload(&switch.payload);
                fields.push(self.field("payload", word));
            }
            self.spec(path, SpecType::Variant, fields);
        }
    }

    fn add_property(&mut self, prim: u32, property: &Property) {
        let element = self.token(&property.name);
        let path = self.paths.property(prim, element);
        let mut fields = Vec::new();
        let mut declare = |file: &mut Self, value_type: ValueType, variability: Variability| {
            let type_name = file.token_word(value_type.name());
            fields.push(file.field("typeName", type_name));
            fields.push(file.field("custom", ValueWord::boolean(false)));
            fields.push(file.field("variability", ValueWord::variability(variability)));
        };
        let spec_type = match &property.content {
            Content::Attribute { value, variability, interpolation } => {
                declare(self, value.value_type(), *variability);
                let word = self.value(value);
                fields.push(self.field("default", word));
                if let Some(interpolation) = interpolation {
                    let word = self.token_word(interpolation.token());
                    fields.push(self.field("interpolation", word));
                }
                SpecType::Attribute
            }
            Content::Declaration(value_type) => {
                declare(self, *value_type, Variability::Varying);
                SpecType::Attribute
            }
            Content::Connection(value_type, source) => {
                declare(self, *value_type, Variability::Varying);
                let word = self.explicit_path(source);
                fields.push(self.field("connectionPaths", word));
                SpecType::Attribute
            }
            Content::Relationship(target) => {
                fields.push(self.field("custom", ValueWord::boolean(false)));
                fields.push(self.field("variability", ValueWord::variability(Variability::Uniform)));
                let word = self.explicit_path(target);
                fields.push(self.field("targetPaths", word));
                SpecType::Relationship
            }
        };
        self.spec(path, spec_type, fields);
    }

    fn spec(&mut self, path: u32, spec_type: SpecType, mut fields: Vec<u32>) {
        fields.push(END_OF_FIELDS);
        let begin = self.field_sets.len() as u32;
        let field_set = *self.known_field_sets.entry(fields).or_insert_with_key(|fields| {
            self.field_sets.extend(fields);
            begin
        });
        self.specs.push(Spec { path, field_set, spec_type });
    }

    fn field(&mut self, name: &str, word: ValueWord) -> u32 {
        let name = self.token(name);
        self.fields.number((name, word))
    }

    fn token(&mut self, text: &str) -> u32 {
        self.tokens.number(text.to_owned())
    }

    fn token_word(&mut self, text: &str) -> ValueWord {
        ValueWord::inlined(CrateType::Token, u64::from(self.token(text)))
    }

    fn string(&mut self, text: &str) -> u32 {
        let token = self.token(text);
        self.strings.number(token)
    }

    fn finish(self) -> Vec<u8> {
        let mut bytes = self.heap.into_bytes();
        let sections = [
            ("TOKENS", section::tokens(&self.tokens.things)),
            ("STRINGS", section::strings(&self.strings.things)),
            ("FIELDS", section::fields(&self.fields.things)),
            ("FIELDSETS", section::counted_integers(&self.field_sets)),
            ("PATHS", self.paths.section()),
            ("SPECS", section::specs(&self.specs)),
        ];
        let mut contents = Vec::new();
        put_u64(&mut contents, sections.len() as u64);
        for (name, section) in sections {
            let mut padded_name = [0; 16];
            padded_name[..name.len()].copy_from_slice(name.as_bytes());
            put_bytes(&mut contents, &padded_name);
            put_u64(&mut contents, bytes.len() as u64);
            put_u64(&mut contents, section.len() as u64);
            put_bytes(&mut bytes, &section);
        }
        let contents_at = bytes.len() as u64;
        put_bytes(&mut bytes, &contents);
        bytes[..8].copy_from_slice(b"PXR-USDC");
        bytes[8..11].copy_from_slice(&VERSION);
        bytes[16..24].copy_from_slice(&contents_at.to_le_bytes());
        bytes
    }
}
