//! Stand-ins: what is shown for an object that the catalog does not have.
//!
//! A description, a recognition and a finished scene carry the same mark, and lists of stand-ins are derived from it.
//! In JSON a mark is three fields of the marked object: `stand_in: true`, `stands_for` and `shown_as`. An object that
//! is itself has none of them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The mark of an object that is shown by something else.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StandIn {
    /// The noun that was asked for ("beaker").
    pub stands_for: String,
    /// The label of the category that stands there ("mug", "box-shaped stand-in").
    pub shown_as: String,
}

/// The form in JSON. Files of earlier versions have `stand_in` alone; their words are empty.
#[derive(Serialize, Deserialize, JsonSchema)]
pub(crate) struct Fields {
    /// Present where something else stands in for an object that the catalog does not have.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    #[schemars(extend("const" = true))]
    stand_in: bool,
    /// Of a stand-in: the noun that was asked for.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    stands_for: String,
    /// Of a stand-in: what stands there.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    shown_as: String,
}

/// The mark as fields of the object that has it: `#[serde(flatten, with = "stand_in::fields")]`.
pub mod fields {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::{Fields, StandIn};

    pub fn serialize<S: Serializer>(mark: &Option<StandIn>, serializer: S) -> Result<S::Ok, S::Error> {
        let (stands_for, shown_as) =
            mark.clone().map(|mark| (mark.stands_for, mark.shown_as)).unwrap_or_default();
        Fields { stand_in: mark.is_some(), stands_for, shown_as }.serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<StandIn>, D::Error> {
        let Fields { stand_in, stands_for, shown_as } = Fields::deserialize(deserializer)?;
        Ok(stand_in.then_some(StandIn { stands_for, shown_as }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Marked {
        name: String,
        #[serde(flatten, with = "fields")]
        stand_in: Option<StandIn>,
    }

    #[test]
    fn a_mark_is_three_fields_and_an_object_without_one_has_none() {
        let mark = StandIn { stands_for: "beaker".into(), shown_as: "mug".into() };
        for (stand_in, json) in [
            (Some(mark), r#"{"name":"a","stand_in":true,"stands_for":"beaker","shown_as":"mug"}"#),
            (None, r#"{"name":"a"}"#),
        ] {
            let marked = Marked { name: "a".into(), stand_in };
            assert_eq!(serde_json::to_string(&marked).expect("plain data"), json);
            assert_eq!(serde_json::from_str::<Marked>(json).expect("our own JSON"), marked);
        }
    }

    #[test]
    fn a_mark_of_an_earlier_version_has_no_words() {
        let read: Marked = serde_json::from_str(r#"{"name":"a","stand_in":true}"#).expect("an earlier form");
        let mark = read.stand_in.expect("a mark");
        assert_eq!((mark.stands_for.as_str(), mark.shown_as.as_str()), ("", ""));
    }
}
