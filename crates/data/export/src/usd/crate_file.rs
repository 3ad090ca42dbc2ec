//! Writer of OpenUSD's crate format (`.usdc`), version 0.8.0, the default version of OpenUSD's own writer.
//!
//! The file consists of a header, a heap of values, six sections and a table of contents:
//!
//! | section | holds |
//! | --- | --- |
//! | `TOKENS` | the distinct names and texts |
//! | `STRINGS` | the tokens that are strings |
//! | `FIELDS` | the distinct pairs of name and value |
//! | `FIELDSETS` | the distinct lists of fields |
//! | `PATHS` | the tree of prims and properties |
//! | `SPECS` | for each path its spec type and its list of fields |
//!
//! Fields hold 64-bit value words ([`value_word`]): small values are inlined, others are offsets into the heap
//! ([`heap`]). Tables are compressed ([`compression`]). Source: `crateFile.h` and `crateFile.cpp` of OpenUSD. Equal
//! layers give equal bytes.

mod compression;
mod heap;
mod path_tree;
mod section;
mod value_word;
mod values;

use std::collections::BTreeMap;

use super::layer::{Content, Layer, Prim, Property, Specifier, Variability, VariantSet};
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

/// Spec types.
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
    /// Start of its list in `field_sets`.
    field_set: u32,
    spec_type: SpecType,
}

/// The sections under construction.
#[derive(Default)]
struct CrateFile {
    tokens: Interner<String>,
    /// Token indices.
    strings: Interner<u32>,
    /// Token indices with values.
    fields: Interner<(u32, ValueWord)>,
    /// Field indices, each list followed by [`END_OF_FIELDS`].
    field_sets: Vec<u32>,
    known_field_sets: BTreeMap<Vec<u32>, u32>,
    paths: PathTree,
    specs: Vec<Spec>,
    heap: Heap,
}

/// Interned values, numbered in order of first use.
struct Interner<T> {
    values: Vec<T>,
    numbers: BTreeMap<T, u32>,
}

impl<T> Default for Interner<T> {
    fn default() -> Self {
        Self { values: Vec::new(), numbers: BTreeMap::new() }
    }
}

impl<T: Ord + Clone> Interner<T> {
    fn number(&mut self, value: T) -> u32 {
        let next = self.values.len() as u32;
        *self.numbers.entry(value).or_insert_with_key(|value| {
            self.values.push(value.clone());
            next
        })
    }
}

impl CrateFile {
    fn add_layer(&mut self, layer: &Layer) {
        // In the tree of paths the sign of a token index distinguishes properties from prims, so no property may have
        // index 0.
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
        if !prim.variant_sets.is_empty() {
            self.describe_variant_sets(&prim.variant_sets, &mut fields);
        }
        self.spec(path, SpecType::Prim, fields);
        prim.properties().iter().for_each(|property| self.add_property(path, property));
        prim.children().iter().for_each(|child| self.add_prim(path, child));
        prim.variant_sets.iter().for_each(|variant_set| self.add_variant_set(path, variant_set));
    }

    /// Appends the fields of a prim's variant sets.
    fn describe_variant_sets(&mut self, variant_sets: &[VariantSet], fields: &mut Vec<u32>) {
        let names: Vec<String> = variant_sets.iter().map(|variant_set| variant_set.name.to_owned()).collect();
        let strings: Vec<u32> = names.iter().map(|name| self.string(name)).collect();
        let chosen: Vec<(&str, &str)> =
            names.iter().map(|name| (name.as_str(), VariantSet::DISABLED)).collect();
        let word = self.variant_selection(&chosen);
        fields.push(self.field("variantSelection", word));
        let word = self.token_vector(&names);
        fields.push(self.field("variantSetChildren", word));
        let word = self.prepended(CrateType::StringListOp, &strings);
        fields.push(self.field("variantSetNames", word));
    }

    /// Adds the variant set and its variants, which are siblings below the prim.
    fn add_variant_set(&mut self, prim: u32, variant_set: &VariantSet) {
        let path = |file: &mut Self, variant: &str| {
            let element = file.token(&format!("{{{}={variant}}}", variant_set.name));
            file.paths.prim(prim, element)
        };
        let set = path(self, "");
        let word = self.token_vector(&[VariantSet::DISABLED.to_owned(), VariantSet::ENABLED.to_owned()]);
        let fields = vec![self.field("variantChildren", word)];
        self.spec(set, SpecType::VariantSet, fields);
        for variant in [VariantSet::DISABLED, VariantSet::ENABLED] {
            let path = path(self, variant);
            let mut fields = vec![self.field("specifier", ValueWord::specifier(Specifier::Over))];
            if variant == VariantSet::ENABLED {
                let word = self.prepended_payload(&variant_set.payload);
                fields.push(self.field("payload", word));
            }
            self.spec(path, SpecType::Variant, fields);
        }
    }

    fn add_property(&mut self, prim: u32, property: &Property) {
        let element = self.token(&property.name);
        let path = self.paths.property(prim, element);
        let mut fields = Vec::new();
        let mut declare = |file: &mut Self, value_type: ValueType, variability: Variability, custom: bool| {
            let type_name = file.token_word(value_type.name());
            fields.push(file.field("typeName", type_name));
            fields.push(file.field("custom", ValueWord::boolean(custom)));
            fields.push(file.field("variability", ValueWord::variability(variability)));
        };
        let spec_type = match &property.content {
            Content::Attribute { value, variability, interpolation, custom } => {
                declare(self, value.value_type(), *variability, *custom);
                let word = self.value(value);
                fields.push(self.field("default", word));
                if let Some(interpolation) = interpolation {
                    let word = self.token_word(interpolation.token());
                    fields.push(self.field("interpolation", word));
                }
                SpecType::Attribute
            }
            Content::Declaration(value_type) => {
                declare(self, *value_type, Variability::Varying, false);
                SpecType::Attribute
            }
            Content::Connection(value_type, source) => {
                declare(self, *value_type, Variability::Varying, false);
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
            ("TOKENS", section::tokens(&self.tokens.values)),
            ("STRINGS", section::strings(&self.strings.values)),
            ("FIELDS", section::fields(&self.fields.values)),
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
