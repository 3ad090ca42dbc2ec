//! Validation of deserialized values: every violation with the JSON pointer of its field.

use std::fmt;

/// A field with an invalid value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// JSON pointer of the field, such as `/options/max_objects`; empty for the whole value.
    pub pointer: String,
    /// The requirement that the field does not meet.
    pub detail: String,
}

/// All violations of one value; never empty.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct InvalidValue(pub Vec<Violation>);

impl fmt::Display for InvalidValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, Violation { pointer, detail }) in self.0.iter().enumerate() {
            let separator = if index == 0 { "" } else { "; " };
            write!(f, "{separator}{pointer}: {detail}")?;
        }
        Ok(())
    }
}

/// Collects violations.
#[derive(Default)]
pub(crate) struct Violations(Vec<Violation>);

impl Violations {
    /// Records a violation unless the condition holds.
    pub fn require(&mut self, holds: bool, pointer: impl Into<String>, detail: impl Into<String>) {
        if !holds {
            self.0.push(Violation { pointer: pointer.into(), detail: detail.into() });
        }
    }

    /// Requires positive, finite extents.
    pub fn require_size(&mut self, size_m: glam::DVec3, pointer: impl Into<String>) {
        let holds = size_m.min_element() > 0.0 && size_m.is_finite();
        self.require(holds, pointer, "must be positive and finite");
    }

    /// The recorded violations.
    pub fn into_vec(self) -> Vec<Violation> {
        self.0
    }

    /// Adds violations of a nested value.
    pub fn extend(&mut self, prefix: &str, nested: Vec<Violation>) {
        self.0.extend(nested.into_iter().map(|Violation { pointer, detail }| Violation {
            pointer: format!("{prefix}{pointer}"),
            detail,
        }));
    }
}

/// Implements `validate`, and serialization of which deserialization validates. The type must derive both with
/// `#[serde(remote = "Self")]` and have a method `violations`.
macro_rules! validated {
    ($name:ident) => {
        impl $name {
            /// Checks the value; deserialization does the same.
            ///
            /// # Errors
            ///
            /// Every violation with the pointer of its field.
            pub fn validate(&self) -> Result<(), $crate::validation::InvalidValue> {
                let violations = self.violations();
                if violations.is_empty() { Ok(()) } else { Err($crate::validation::InvalidValue(violations)) }
            }
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                // The inherent function, which the derive macro generates.
                let value = Self::deserialize(deserializer)?;
                value.validate().map_err(<D::Error as serde::de::Error>::custom)?;
                Ok(value)
            }
        }

        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                // The inherent function, which the derive macro generates.
                Self::serialize(self, serializer)
            }
        }
    };
}
pub(crate) use validated;
