//! The 64-bit value word of a field in a crate file.
//!
//! Bit 63: array. Bit 62: the value is inlined in the lower 48 bits. Bit 61: the array is compressed. Bits 48 to 55:
//! type. Lower 48 bits: the inlined value or the file offset; an array at offset 0 is empty.

use crate::usd::layer::{Specifier, Variability};

/// The value types used in layers of a bundle, with the format's type numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CrateType {
    Bool = 1,
    Int = 3,
    Float = 8,
    Double = 9,
    String = 10,
    Token = 11,
    AssetPath = 12,
    Quatd = 16,
    Quatf = 17,
    Vec2f = 20,
    Vec3d = 23,
    Vec3f = 24,
    Vec4f = 28,
    Dictionary = 31,
    TokenListOp = 32,
    StringListOp = 33,
    PathListOp = 34,
    ReferenceListOp = 35,
    TokenVector = 41,
    Specifier = 42,
    Variability = 44,
    VariantSelectionMap = 45,
    PayloadListOp = 55,
}

const ARRAY: u64 = 1 << 63;
const INLINED: u64 = 1 << 62;
const COMPRESSED: u64 = 1 << 61;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ValueWord(u64);

impl ValueWord {
    /// `def` or `over`.
    pub fn specifier(specifier: Specifier) -> Self {
        let number = match specifier {
            Specifier::Def(_) => 0,
            Specifier::Over => 1,
        };
        Self::inlined(CrateType::Specifier, number)
    }

    pub fn boolean(value: bool) -> Self {
        Self::inlined(CrateType::Bool, u64::from(value))
    }

    pub fn variability(variability: Variability) -> Self {
        let number = match variability {
            Variability::Varying => 0,
            Variability::Uniform => 1,
        };
        Self::inlined(CrateType::Variability, number)
    }

    /// An inlined value of at most 48 bits.
    pub fn inlined(of: CrateType, value: u64) -> Self {
        Self(INLINED | Self::typed(of, value))
    }

    /// A value at a file offset.
    pub fn stored(of: CrateType, offset: u64) -> Self {
        Self(Self::typed(of, offset))
    }

    pub fn stored_array(of: CrateType, offset: u64) -> Self {
        Self(ARRAY | Self::typed(of, offset))
    }

    pub fn compressed_array(of: CrateType, offset: u64) -> Self {
        Self(ARRAY | COMPRESSED | Self::typed(of, offset))
    }

    pub fn empty_array(of: CrateType) -> Self {
        Self::stored_array(of, 0)
    }

    fn typed(of: CrateType, payload: u64) -> u64 {
        assert!(payload < 1 << 48, "a crate file has 48 bits for a value or its place");
        ((of as u64) << 48) | payload
    }

    pub fn bits(self) -> u64 {
        self.0
    }
}
