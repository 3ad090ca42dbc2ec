//! Reader of layers in the crate format, versions 0.8 and 0.9. The tables of tokens, fields and paths are parsed when
//! the layer is opened, values on access.

mod bytes;
mod error;
mod value;

pub use error::LayerError;

use std::collections::BTreeMap;

use super::Layer;
use crate::round_trip::{ReadError, ReadResult};
use bytes::{Bytes, integers, unpacked};
use value::Word;

pub struct CrateLayer<'a> {
    file: &'a [u8],
    tokens: Vec<String>,
    /// Token indices.
    strings: Vec<u32>,
    /// Prims by path; fields by name. The layer itself has the empty path.
    prims: BTreeMap<String, Fields>,
    /// As `prims`; paths end in a dot and the name of the property.
    properties: BTreeMap<String, Fields>,
    /// As `prims`; paths end in `/{set=variant}`.
    variants: BTreeMap<String, Fields>,
    /// By path index.
    paths: BTreeMap<i32, String>,
}

type Fields = BTreeMap<String, Word>;

type LayerResult<T> = Result<T, LayerError>;

/// Kinds of specs.
const ATTRIBUTE: u32 = 1;
const PRIM: u32 = 6;
const PSEUDO_ROOT: u32 = 7;
const RELATIONSHIP: u32 = 8;
const VARIANT: u32 = 10;
const VARIANT_SET: u32 = 11;

impl<'a> CrateLayer<'a> {
    pub fn open(file: &'a [u8]) -> LayerResult<Self> {
        if !file.starts_with(b"PXR-USDC") {
            return Err(LayerError::NotCrate);
        }
        let mut header = Bytes::at(file, 8)?;
        let [major, minor, ..] = header.array::<8>()?;
        if (major, minor) != (0, 8) && (major, minor) != (0, 9) {
            return Err(LayerError::Version { major, minor });
        }
        let mut contents = Bytes::at(file, header.length()?)?;
        let mut sections = BTreeMap::new();
        for _ in 0..contents.length()? {
            let name = contents.array::<16>()?;
            let name = String::from_utf8_lossy(&name).trim_end_matches('\0').to_owned();
            let (start, size) = (contents.length()?, contents.length()?);
            let section = start.checked_add(size).and_then(|end| file.get(start..end));
            sections.insert(name.clone(), section.ok_or(LayerError::SectionEndsBehind(name))?);
        }
        let section = |name: &'static str| match sections.get(name) {
            Some(section) => Bytes::at(section, 0),
            None => Err(LayerError::NoSection(name)),
        };
        let tokens = read_tokens(section("TOKENS")?)?;
        let mut layer = Self {
            file,
            strings: read_strings(section("STRINGS")?)?,
            prims: BTreeMap::new(),
            properties: BTreeMap::new(),
            variants: BTreeMap::new(),
            paths: BTreeMap::new(),
            tokens,
        };
        let fields = layer.read_fields(section("FIELDS")?)?;
        let mut sets = section("FIELDSETS")?;
        let count = sets.length()?;
        let sets = integers(&mut sets, count)?;
        let paths = layer.read_paths(section("PATHS")?)?;
        let mut specs = section("SPECS")?;
        let count = specs.length()?;
        let [numbers, begins, kinds] =
            [integers(&mut specs, count)?, integers(&mut specs, count)?, integers(&mut specs, count)?];
        for ((number, begin), kind) in numbers.into_iter().zip(begins).zip(kinds) {
            let path = paths.get(&number).ok_or(LayerError::SpecWithoutPath)?.clone();
            let set = sets.get(begin as usize..).ok_or(LayerError::SpecWithoutFields)?;
            let mut spec_fields = Fields::new();
            for field in set.iter().take_while(|field| **field >= 0) {
                let (name, word) = fields.get(*field as usize).ok_or(LayerError::NoField)?;
                spec_fields.insert(name.clone(), *word);
            }
            let known = match kind as u32 {
                VARIANT_SET => continue,
                VARIANT => layer.variants.insert(path, spec_fields),
                PSEUDO_ROOT | PRIM => layer.prims.insert(path, spec_fields),
                ATTRIBUTE | RELATIONSHIP => layer.properties.insert(path, spec_fields),
                kind => return Err(LayerError::SpecKind { path, kind }),
            };
            if known.is_some() {
                return Err(LayerError::SpecTwice);
            }
        }
        layer.paths = paths;
        Ok(layer)
    }

    fn read_fields(&self, mut section: Bytes<'_>) -> LayerResult<Vec<(String, Word)>> {
        let count = section.length()?;
        let names = integers(&mut section, count)?;
        let size = count.checked_mul(8).ok_or(LayerError::TooMany("fields"))?;
        let words = unpacked(&mut section, size)?;
        if words.len() != size {
            return Err(LayerError::NoValues);
        }
        let words = words.chunks_exact(8).map(|word| Word::new(word.try_into().expect("eight bytes")));
        names
            .into_iter()
            .zip(words)
            .map(|(name, word)| Ok((self.token(name as u32)?.to_owned(), word)))
            .collect()
    }

    /// Paths by path index.
    fn read_paths(&self, mut section: Bytes<'_>) -> LayerResult<BTreeMap<i32, String>> {
        let _with_the_empty_one = section.length()?;
        let count = section.length()?;
        let rows =
            [integers(&mut section, count)?, integers(&mut section, count)?, integers(&mut section, count)?];
        let [numbers, tokens, jumps] = rows;
        let mut paths = BTreeMap::new();
        // Parents of the subtrees not yet read, by the row at which they begin.
        let mut parent_at: BTreeMap<usize, String> = BTreeMap::new();
        let mut parent: Option<String> = None;
        for (row, ((number, token), jump)) in numbers.into_iter().zip(tokens).zip(jumps).enumerate() {
            let parent_here = parent_at.remove(&row).or(parent.take());
            let path = match &parent_here {
                None if row == 0 => String::new(),
                None => return Err(LayerError::NoParent(row)),
                Some(above) if token < 0 => format!("{above}.{}", self.token(token.unsigned_abs())?),
                Some(above) => format!("{above}/{}", self.token(token as u32)?),
            };
            // 0: only a sibling follows; -1: only a child; -2: neither; else both, the sibling at this distance.
            parent = match jump {
                0 => parent_here,
                -1 => Some(path.clone()),
                -2 => None,
                ahead if ahead > 0 => {
                    let above = parent_here.ok_or(LayerError::BesideRoot)?;
                    parent_at.insert(row + ahead as usize, above);
                    Some(path.clone())
                }
                other => return Err(LayerError::PathJump(other)),
            };
            paths.insert(number, path);
        }
        Ok(paths)
    }

    fn token(&self, number: u32) -> LayerResult<&str> {
        self.tokens.get(number as usize).map(String::as_str).ok_or(LayerError::NoToken(number))
    }

    fn string(&self, number: u32) -> LayerResult<&str> {
        let token = self.strings.get(number as usize).ok_or(LayerError::NoString(number))?;
        self.token(*token)
    }

    /// A token, a string, the first element of an array of tokens, or a number as text.
    fn text_of(&self, word: Word) -> ReadResult<String> {
        if let Ok(numbers) = word.numbers(self.file) {
            return Ok(numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" "));
        }
        if word.is_string() {
            return Ok(self.string(word.token(self.file)?)?.to_owned());
        }
        Ok(self.token(word.token(self.file)?)?.to_owned())
    }

    fn default_of(&self, prim: &str, attribute: &str) -> Option<Word> {
        self.properties.get(&format!("{prim}.{attribute}"))?.get("default").copied()
    }
}

fn read_tokens(mut section: Bytes<'_>) -> LayerResult<Vec<String>> {
    let (count, size) = (section.length()?, section.length()?);
    let text = unpacked(&mut section, size)?;
    let text = String::from_utf8(text).map_err(|_| LayerError::TokenNotUtf8)?;
    let tokens: Vec<String> = text.split_terminator('\0').map(str::to_owned).collect();
    if tokens.len() != count {
        return Err(LayerError::TokenCount { found: tokens.len(), wanted: count });
    }
    Ok(tokens)
}

fn read_strings(mut section: Bytes<'_>) -> LayerResult<Vec<u32>> {
    (0..section.length()?).map(|_| Ok(u32::from_le_bytes(section.array()?))).collect()
}

impl Layer for CrateLayer<'_> {
    fn prims(&self) -> Vec<&str> {
        self.prims.keys().map(String::as_str).filter(|path| !path.is_empty()).collect()
    }

    fn reference(&self, prim: &str) -> ReadResult<Option<String>> {
        match self.prims.get(prim).and_then(|fields| fields.get("references")) {
            Some(word) => Ok(Some(self.string(word.first_prepended(self.file)?)?.to_owned())),
            None => Ok(None),
        }
    }

    fn numbers(&self, prim: &str, attribute: &str) -> ReadResult<Option<Vec<f64>>> {
        let place = || format!("{prim}.{attribute}");
        let read =
            |word: Word| word.numbers(self.file).map_err(|error| ReadError::from(error).within(place()));
        self.default_of(prim, attribute).map(read).transpose()
    }

    fn text(&self, prim: &str, attribute: &str) -> ReadResult<Option<String>> {
        self.default_of(prim, attribute).map(|word| self.text_of(word)).transpose()
    }

    fn field(&self, prim: &str, field: &str) -> ReadResult<Option<String>> {
        let word = self.prims.get(prim).and_then(|fields| fields.get(field));
        word.map(|word| self.text_of(*word)).transpose()
    }

    fn has_schema(&self, prim: &str, schema: &str) -> ReadResult<bool> {
        let Some(word) = self.prims.get(prim).and_then(|fields| fields.get("apiSchemas")) else {
            return Ok(false);
        };
        for token in word.prepended_tokens(self.file)? {
            if self.token(token)? == schema {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn target(&self, prim: &str, relationship: &str) -> ReadResult<Option<String>> {
        let fields = self.properties.get(&format!("{prim}.{relationship}"));
        let Some(word) = fields.and_then(|fields| fields.get("targetPaths")) else { return Ok(None) };
        let number = word.first_explicit_path(self.file)?;
        match self.paths.get(&number) {
            Some(path) => Ok(Some(path.clone())),
            None => Err(ReadError::wrong(format!("{prim}.{relationship}"), "leads to no path")),
        }
    }

    fn payload(&self, prim: &str, variant_set: &str) -> ReadResult<Option<String>> {
        let fields = self.variants.get(&format!("{prim}/{{{variant_set}=Enabled}}"));
        match fields.and_then(|fields| fields.get("payload")) {
            Some(word) => Ok(Some(self.string(word.first_prepended(self.file)?)?.to_owned())),
            None => Ok(None),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::text_layer::TextLayer;
    use super::*;
    use crate::usd::random_layer;

    #[test]
    fn crate_and_text_readers_agree_on_random_layers() {
        let mut numbers = 0;
        for seed in 0..random_layer::LAYERS {
            let (text, bytes) = random_layer::written(seed);
            let (text, layer) = (TextLayer::open(&text), CrateLayer::open(&bytes).expect("our own file"));
            assert_eq!(layer.prims(), text.prims());
            for prim in layer.prims() {
                assert_eq!(layer.reference(prim).ok(), text.reference(prim).ok(), "{prim}");
                let name = layer.field(prim, "displayName").ok();
                assert_eq!(name, text.field(prim, "displayName").ok(), "{prim}");
                for name in ["Newton", "MuJoCo", "aSet", "PhysicsMassAPI", "MadeUpAPI"] {
                    assert_eq!(layer.payload(prim, name).ok(), text.payload(prim, name).ok(), "{prim}");
                    assert_eq!(layer.has_schema(prim, name).ok(), text.has_schema(prim, name).ok(), "{prim}");
                }
            }
            for field in ["upAxis", "metersPerUnit", "kilogramsPerUnit", "defaultPrim"] {
                assert_eq!(layer.field("", field).ok(), text.field("", field).ok(), "{field}");
            }
            for path in layer.properties.keys() {
                let (prim, attribute) = path.split_once('.').expect("a property");
                if let Some(target) = layer.target(prim, attribute).expect("a path") {
                    let written = text.target(prim, attribute).expect("a path");
                    assert_eq!(written, Some(target), "{path} of layer {seed}");
                }
                let Ok(Some(found)) = layer.numbers(prim, attribute) else { continue };
                let written = text.numbers(prim, attribute).expect("numbers").expect("there");
                let single = |values: &[f64]| values.iter().map(|value| *value as f32).collect::<Vec<_>>();
                assert_eq!(single(&found), single(&written), "{path} of layer {seed}");
                numbers += found.len();
            }
        }
        assert!(numbers > 100_000, "only {numbers} numbers were compared");
    }

    #[test]
    fn open_rejects_truncated_files() {
        let (_, bytes) = random_layer::written(1);
        for end in (0..bytes.len()).step_by(7) {
            assert!(CrateLayer::open(&bytes[..end]).is_err(), "the first {end} bytes");
        }
    }
}
