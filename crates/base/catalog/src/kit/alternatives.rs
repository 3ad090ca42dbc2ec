//! One surface or several, of which an object has one.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::surface::Surface;
use crate::Order;

/// Surfaces of which every object has one, drawn by its random stream. Written as one table or as a list of tables.
#[derive(Clone, Debug)]
pub(super) struct Alternatives(Vec<Surface>);

impl Alternatives {
    /// The object's surface; `None` for an empty list.
    pub fn drawn(&self, order: &mut Order) -> Option<&Surface> {
        match self.0.as_slice() {
            [] => None,
            [only] => Some(only),
            several => Some(&several[order.pick(several.len())]),
        }
    }
}

impl<'de> Deserialize<'de> for Alternatives {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrMany;

        impl<'de> Visitor<'de> for OneOrMany {
            type Value = Alternatives;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a surface or a list of surfaces")
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Alternatives, A::Error> {
                Surface::deserialize(MapAccessDeserializer::new(map)).map(|only| Alternatives(vec![only]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Alternatives, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(seq)).map(Alternatives)
            }
        }

        deserializer.deserialize_any(OneOrMany)
    }
}
