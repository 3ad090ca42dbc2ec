//! The 64-bit value word of a field, and the value it represents.

use super::bytes::{Bytes, integers};
use super::{LayerError, LayerResult};

/// Bit 63: array; 62: inlined value; 61: compressed; 48 to 55: type; lower 48 bits: value or file offset.
#[derive(Clone, Copy)]
pub struct Word(u64);

/// Component count and component order of a numeric type.
enum Shape {
    Singles(usize),
    Doubles(usize),
    /// x, y, z, w.
    SingleQuaternion,
    DoubleQuaternion,
    Integers,
}

const ASSET_PATH: u64 = 12;
const TOKEN: u64 = 11;
const STRING: u64 = 10;
const REFERENCES: u64 = 35;
const PAYLOADS: u64 = 55;
const TOKENS: u64 = 32;
const PATHS: u64 = 34;
const EXPLICIT: u8 = 0b11;
const PREPENDED: u8 = 1 << 5;

impl Word {
    pub fn new(bytes: [u8; 8]) -> Self {
        Self(u64::from_le_bytes(bytes))
    }

    fn of_type(self) -> u64 {
        self.0 >> 48 & 0xff
    }

    fn is_array(self) -> bool {
        self.0 >> 63 != 0
    }

    fn is_inlined(self) -> bool {
        self.0 >> 62 & 1 != 0
    }

    fn is_compressed(self) -> bool {
        self.0 >> 61 & 1 != 0
    }

    fn payload(self) -> u64 {
        self.0 & ((1 << 48) - 1)
    }

    fn content(self, file: &[u8]) -> LayerResult<Bytes<'_>> {
        Bytes::at(file, self.payload() as usize)
    }

    /// Whether the value is a string, which has a string index instead of a token index.
    pub fn is_string(self) -> bool {
        self.of_type() == STRING
    }

    /// The index of a token, asset path or string; of an array of tokens the first index.
    pub fn token(self, file: &[u8]) -> LayerResult<u32> {
        match (self.of_type(), self.is_array(), self.is_inlined()) {
            (TOKEN | ASSET_PATH | STRING, false, true) => Ok(self.payload() as u32),
            (TOKEN, true, false) if self.payload() > 0 => {
                let mut content = self.content(file)?;
                match content.length()? {
                    0 => Err(LayerError::EmptyTokens),
                    _ => Ok(u32::from_le_bytes(content.array()?)),
                }
            }
            (other, ..) => Err(LayerError::ValueNotToken(other)),
        }
    }

    /// The string index of the first layer in a prepended list of references or payloads.
    pub fn first_prepended(self, file: &[u8]) -> LayerResult<u32> {
        let mut content = self.content(file)?;
        let [edit] = content.array()?;
        if ![REFERENCES, PAYLOADS].contains(&self.of_type()) || edit != PREPENDED || content.length()? == 0 {
            return Err(LayerError::NotPrepended("references or payloads"));
        }
        Ok(u32::from_le_bytes(content.array()?))
    }

    /// Token indices of a prepended list.
    pub fn prepended_tokens(self, file: &[u8]) -> LayerResult<Vec<u32>> {
        let mut content = self.content(file)?;
        let [edit] = content.array()?;
        if self.of_type() != TOKENS || edit != PREPENDED {
            return Err(LayerError::NotPrepended("tokens"));
        }
        (0..content.length()?).map(|_| Ok(u32::from_le_bytes(content.array()?))).collect()
    }

    /// The path index of the first path of an explicit list.
    pub fn first_explicit_path(self, file: &[u8]) -> LayerResult<i32> {
        let mut content = self.content(file)?;
        let [edit] = content.array()?;
        if self.of_type() != PATHS || edit != EXPLICIT || content.length()? == 0 {
            return Err(LayerError::NoExplicitPath);
        }
        Ok(i32::from_le_bytes(content.array()?))
    }

    /// All numbers, flattened; quaternions as w, x, y, z.
    pub fn numbers(self, file: &[u8]) -> LayerResult<Vec<f64>> {
        let shape = match self.of_type() {
            1 | 3 => Shape::Integers,
            8 => Shape::Singles(1),
            9 => Shape::Doubles(1),
            16 => Shape::DoubleQuaternion,
            17 => Shape::SingleQuaternion,
            20 => Shape::Singles(2),
            23 => Shape::Doubles(3),
            24 => Shape::Singles(3),
            28 => Shape::Singles(4),
            other => return Err(LayerError::ValueNotNumbers(other)),
        };
        if self.is_inlined() {
            return Ok(self.inlined_numbers(&shape));
        }
        if self.is_array() && self.payload() == 0 {
            return Ok(Vec::new());
        }
        let mut content = self.content(file)?;
        let rows = if self.is_array() { content.length()? } else { 1 };
        if matches!(shape, Shape::Integers) {
            let found = match self.is_compressed() {
                true => integers(&mut content, rows)?,
                false => {
                    (0..rows).map(|_| Ok(i32::from_le_bytes(content.array()?))).collect::<LayerResult<_>>()?
                }
            };
            return Ok(found.into_iter().map(f64::from).collect());
        }
        if self.is_compressed() {
            return Err(LayerError::CompressedNumbers);
        }
        let mut found = Vec::new();
        for _ in 0..rows {
            let at = found.len();
            match shape {
                Shape::Doubles(count) => push_doubles(&mut found, &mut content, count)?,
                Shape::Singles(count) => push_singles(&mut found, &mut content, count)?,
                Shape::DoubleQuaternion => push_doubles(&mut found, &mut content, 4)?,
                Shape::SingleQuaternion => push_singles(&mut found, &mut content, 4)?,
                Shape::Integers => {}
            }
            if matches!(shape, Shape::DoubleQuaternion | Shape::SingleQuaternion) {
                found[at..].rotate_right(1);
            }
        }
        Ok(found)
    }

    /// Inlined numbers: one scalar (doubles in single precision), or a vector of 8-bit integers.
    fn inlined_numbers(self, shape: &Shape) -> Vec<f64> {
        match shape {
            Shape::Integers => vec![f64::from(self.payload() as u32 as i32)],
            Shape::Singles(1) | Shape::Doubles(1) => vec![f32::from_bits(self.payload() as u32).into()],
            Shape::Singles(count) | Shape::Doubles(count) => {
                (0..*count).map(|k| f64::from((self.payload() >> (8 * k)) as u8 as i8)).collect()
            }
            Shape::SingleQuaternion | Shape::DoubleQuaternion => Vec::new(),
        }
    }
}

fn push_doubles(found: &mut Vec<f64>, content: &mut Bytes<'_>, count: usize) -> LayerResult<()> {
    for _ in 0..count {
        found.push(f64::from_le_bytes(content.array()?));
    }
    Ok(())
}

fn push_singles(found: &mut Vec<f64>, content: &mut Bytes<'_>, count: usize) -> LayerResult<()> {
    for _ in 0..count {
        found.push(f32::from_le_bytes(content.array()?).into());
    }
    Ok(())
}
