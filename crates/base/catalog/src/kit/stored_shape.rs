//! A shape that is read when an object of it is built.
//!
//! Shapes are most of the catalog's text. Commands that only need names and sizes do not read them.

use std::sync::OnceLock;

use serde::{Deserialize, Deserializer};

use super::Shape;

/// The shape of a category, or its text in a file that is compiled in.
#[derive(Clone, Debug)]
pub struct StoredShape {
    /// Content of the table `[category.shape]`; empty where the shape was read with its category.
    text: &'static str,
    shape: OnceLock<Shape>,
}

impl StoredShape {
    /// The shape with this content of its table, which a test has read.
    pub(crate) fn unread(text: &'static str) -> Self {
        Self { text, shape: OnceLock::new() }
    }

    pub(crate) fn get(&self) -> &Shape {
        self.shape.get_or_init(|| {
            toml::from_str(self.text).expect("the built-in shapes can be read (a test reads each)")
        })
    }
}

impl<'de> Deserialize<'de> for StoredShape {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let shape = Shape::deserialize(deserializer)?;
        Ok(Self { text: "", shape: OnceLock::from(shape) })
    }
}
