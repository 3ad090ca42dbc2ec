//! Encoding of values as value words, with the heap for values that do not fit.

use crate::usd::layer::Path;
use crate::usd::value::{Dictionary, Entry, Value};

use super::CrateFile;
use super::path_tree::PathTree;
use super::section::{put_bytes, put_u32, put_u64};
use super::value_word::{CrateType, ValueWord};

/// Header bits of a list edit (`SdfListOp`): which lists it contains.
const LIST_IS_EXPLICIT: u8 = 1 << 0;
const LIST_HAS_EXPLICIT: u8 = 1 << 1;
const LIST_PREPENDS: u8 = 1 << 5;

impl CrateFile {
    /// The names of children, in order.
    pub fn token_vector(&mut self, names: &[String]) -> ValueWord {
        let mut bytes = Vec::new();
        put_u64(&mut bytes, names.len() as u64);
        names.iter().for_each(|name| put_u32(&mut bytes, self.token(name)));
        ValueWord::stored(CrateType::TokenVector, self.heap.place(&bytes))
    }

    /// The word of a value: inlined, or an offset into the heap.
    pub fn value(&mut self, value: &Value) -> ValueWord {
        match value {
            Value::Bool(value) => ValueWord::boolean(*value),
            Value::Int(value) => ValueWord::inlined(CrateType::Int, u64::from(*value as u32)),
            Value::Float(value) => ValueWord::inlined(CrateType::Float, u64::from((value + 0.0).to_bits())),
            Value::Double(value) => self.heap.double(*value),
            Value::String(text) => ValueWord::inlined(CrateType::String, u64::from(self.string(text))),
            Value::Token(text) => self.token_word(text),
            Value::Asset(path) => ValueWord::inlined(CrateType::AssetPath, u64::from(self.token(path))),
            Value::Float2(values) => self.heap.floats(CrateType::Vec2f, values),
            Value::Float3(values)
            | Value::Point3f(values)
            | Value::Vector3f(values)
            | Value::Color3f(values)
            | Value::Normal3f(values) => self.heap.floats(CrateType::Vec3f, values),
            Value::Float4(values) => self.heap.floats(CrateType::Vec4f, values),
            Value::Double3(values) => self.heap.doubles(CrateType::Vec3d, values),
            Value::Quatf(quaternion) => self.heap.quaternion_f32(*quaternion),
            Value::Quatd(quaternion) => self.heap.quaternion_f64(*quaternion),
            Value::Ints(values) => self.heap.integers(values),
            Value::Tokens(texts) => {
                let numbers: Vec<u32> = texts.iter().map(|text| self.token(text)).collect();
                self.heap.tokens(&numbers)
            }
            Value::Floats(values) => self.heap.singles(values),
            Value::Float3s(rows) | Value::Point3fs(rows) | Value::Normal3fs(rows) | Value::Color3fs(rows) => {
                self.heap.rows(CrateType::Vec3f, rows)
            }
            Value::TexCoord2fs(rows) => self.heap.rows(CrateType::Vec2f, rows),
        }
    }

    /// A dictionary: names with value words, in order. Nested values are stored first.
    pub fn dictionary(&mut self, dictionary: &Dictionary) -> ValueWord {
        let mut bytes = Vec::new();
        put_u64(&mut bytes, dictionary.entries().len() as u64);
        for (name, entry) in dictionary.entries() {
            let word = match entry {
                Entry::Value(value) => self.value(value),
                Entry::Dictionary(inner) => self.dictionary(inner),
            };
            put_u32(&mut bytes, self.string(name));
            // Offset from here to the value word, which follows directly.
            put_u64(&mut bytes, 8);
            put_u64(&mut bytes, word.bits());
        }
        ValueWord::stored(CrateType::Dictionary, self.heap.place(&bytes))
    }

    /// A list edit that prepends elements, given by index.
    pub fn prepended(&mut self, of: CrateType, numbers: &[u32]) -> ValueWord {
        let mut bytes = vec![LIST_PREPENDS];
        put_u64(&mut bytes, numbers.len() as u64);
        numbers.iter().for_each(|number| put_u32(&mut bytes, *number));
        ValueWord::stored(of, self.heap.place(&bytes))
    }

    /// A prepended reference to the default prim of another layer.
    pub fn prepended_reference(&mut self, asset: &str) -> ValueWord {
        let mut bytes = self.prepended_layer(asset);
        let custom_data_entries = 0;
        put_u64(&mut bytes, custom_data_entries);
        ValueWord::stored(CrateType::ReferenceListOp, self.heap.place(&bytes))
    }

    /// As [`Self::prepended_reference`], for a payload.
    pub fn prepended_payload(&mut self, asset: &str) -> ValueWord {
        let bytes = self.prepended_layer(asset);
        ValueWord::stored(CrateType::PayloadListOp, self.heap.place(&bytes))
    }

    fn prepended_layer(&mut self, asset: &str) -> Vec<u8> {
        let mut bytes = vec![LIST_PREPENDS];
        put_u64(&mut bytes, 1);
        put_u32(&mut bytes, self.string(asset));
        // The empty path means the default prim.
        put_u32(&mut bytes, self.paths.empty());
        let (time_offset, time_scale) = (0.0_f64, 1.0_f64);
        put_bytes(&mut bytes, &time_offset.to_le_bytes());
        put_bytes(&mut bytes, &time_scale.to_le_bytes());
        bytes
    }

    /// The selected variant of each variant set.
    pub fn variant_selection(&mut self, chosen: &[(&str, &str)]) -> ValueWord {
        let mut bytes = Vec::new();
        put_u64(&mut bytes, chosen.len() as u64);
        for (set, variant) in chosen {
            put_u32(&mut bytes, self.string(set));
            put_u32(&mut bytes, self.string(variant));
        }
        ValueWord::stored(CrateType::VariantSelectionMap, self.heap.place(&bytes))
    }

    /// An explicit list edit with one path.
    pub fn explicit_path(&mut self, target: &Path) -> ValueWord {
        let mut path = PathTree::ROOT;
        for name in target.prim_names() {
            let element = self.token(name);
            path = self.paths.prim(path, element);
        }
        if let Some(name) = target.property_name() {
            let element = self.token(name);
            path = self.paths.property(path, element);
        }
        let mut bytes = vec![LIST_IS_EXPLICIT | LIST_HAS_EXPLICIT];
        put_u64(&mut bytes, 1);
        put_u32(&mut bytes, path);
        ValueWord::stored(CrateType::PathListOp, self.heap.place(&bytes))
    }
}
