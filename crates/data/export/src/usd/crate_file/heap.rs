//! Heap of the values that do not fit into a value word. Equal values are stored once.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use crate::usd::value::Quaternion;

use super::compressed_integers;
use super::section::{put_bytes, put_packed, put_u32, put_u64};
use super::value_word::{CrateType, ValueWord};

/// Size of the header, which precedes the heap.
pub const HEADER_BYTES: usize = 88;

/// Shorter arrays of integers are not compressed; readers rely on this.
const MIN_COMPRESSED: usize = 16;

/// The file from its first byte to the end of the values; the header is blank.
pub struct Heap {
    bytes: Vec<u8>,
    /// Begin and end of stored values by hash.
    placed: BTreeMap<u64, Vec<(usize, usize)>>,
}

impl Default for Heap {
    fn default() -> Self {
        Self { bytes: vec![0; HEADER_BYTES], placed: BTreeMap::new() }
    }
}

impl Heap {
    /// Stores the bytes, unless equal bytes are stored already, and returns their file offset. Offsets are multiples of
    /// eight, so that readers can use arrays in mapped memory directly.
    pub fn place(&mut self, value: &[u8]) -> u64 {
        let mut hasher = DefaultHasher::new();
        value.hash(&mut hasher);
        let places = self.placed.entry(hasher.finish()).or_default();
        if let Some((begin, _)) = places.iter().find(|(begin, end)| self.bytes[*begin..*end] == *value) {
            return *begin as u64;
        }
        let begin = self.bytes.len().next_multiple_of(8);
        self.bytes.resize(begin, 0);
        self.bytes.extend_from_slice(value);
        places.push((begin, self.bytes.len()));
        begin as u64
    }

    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    /// An array of tokens, given by index.
    pub fn tokens(&mut self, numbers: &[u32]) -> ValueWord {
        if numbers.is_empty() {
            return ValueWord::empty_array(CrateType::Token);
        }
        let mut bytes = Vec::new();
        put_u64(&mut bytes, numbers.len() as u64);
        numbers.iter().for_each(|number| put_u32(&mut bytes, *number));
        ValueWord::stored_array(CrateType::Token, self.place(&bytes))
    }

    /// A number; inlined if single precision holds it exactly.
    pub fn double(&mut self, value: f64) -> ValueWord {
        let single = value as f32;
        if f64::from(single) == value {
            return ValueWord::inlined(CrateType::Double, u64::from((single + 0.0).to_bits()));
        }
        ValueWord::stored(CrateType::Double, self.place(&f64_bytes(&[value])))
    }

    /// A vector in single precision.
    pub fn floats<const N: usize>(&mut self, of: CrateType, values: &[f32; N]) -> ValueWord {
        match small_integers(values.iter().map(|value| f64::from(*value))) {
            Some(packed) => ValueWord::inlined(of, packed),
            None => ValueWord::stored(of, self.place(&f32_bytes(values))),
        }
    }

    /// A vector in double precision.
    pub fn doubles<const N: usize>(&mut self, of: CrateType, values: &[f64; N]) -> ValueWord {
        match small_integers(values.iter().copied()) {
            Some(packed) => ValueWord::inlined(of, packed),
            None => ValueWord::stored(of, self.place(&f64_bytes(values))),
        }
    }

    /// Quaternions are never inlined; order x, y, z, w.
    pub fn quaternion_f32(&mut self, Quaternion { w, xyz: [x, y, z] }: Quaternion<f32>) -> ValueWord {
        ValueWord::stored(CrateType::Quatf, self.place(&f32_bytes(&[x, y, z, w])))
    }

    /// As [`Heap::quaternion_f32`].
    pub fn quaternion_f64(&mut self, Quaternion { w, xyz: [x, y, z] }: Quaternion<f64>) -> ValueWord {
        ValueWord::stored(CrateType::Quatd, self.place(&f64_bytes(&[x, y, z, w])))
    }

    /// An array.
    pub fn integers(&mut self, values: &[i32]) -> ValueWord {
        if values.is_empty() {
            return ValueWord::empty_array(CrateType::Int);
        }
        let mut bytes = Vec::new();
        put_u64(&mut bytes, values.len() as u64);
        if values.len() < MIN_COMPRESSED {
            values.iter().for_each(|value| put_bytes(&mut bytes, &value.to_le_bytes()));
            return ValueWord::stored_array(CrateType::Int, self.place(&bytes));
        }
        put_packed(&mut bytes, &compressed_integers(values));
        ValueWord::compressed_array(CrateType::Int, self.place(&bytes))
    }

    /// An array of numbers.
    pub fn singles(&mut self, values: &[f32]) -> ValueWord {
        let rows: Vec<[f32; 1]> = values.iter().map(|value| [*value]).collect();
        self.rows(CrateType::Float, &rows)
    }

    /// An array of vectors.
    pub fn rows<const N: usize>(&mut self, of: CrateType, rows: &[[f32; N]]) -> ValueWord {
        if rows.is_empty() {
            return ValueWord::empty_array(of);
        }
        let mut bytes = Vec::with_capacity(8 + 4 * N * rows.len());
        put_u64(&mut bytes, rows.len() as u64);
        put_bytes(&mut bytes, &f32_bytes(rows.as_flattened()));
        ValueWord::stored_array(of, self.place(&bytes))
    }
}

/// Inlined vector of integers from -128 to 127, one byte per component.
fn small_integers(components: impl Iterator<Item = f64>) -> Option<u64> {
    let mut packed = 0;
    for (k, value) in components.enumerate() {
        let byte = value as i8;
        if f64::from(byte) != value {
            return None;
        }
        packed |= u64::from(byte as u8) << (8 * k);
    }
    Some(packed)
}

/// Little-endian bytes. -0 becomes 0, as in text.
fn f32_bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| (value + 0.0).to_le_bytes()).collect()
}

/// As [`f32_bytes`].
fn f64_bytes(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| (value + 0.0).to_le_bytes()).collect()
}
