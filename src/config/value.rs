//! Values: from text to the type of a key, and whether they lie where they may.

use std::fmt;

use toml::Value;

use super::keys::{Allowed, Key};

/// Reason why a key does not take a value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ValueError {
    /// Text that is not of the type of the key. A key of numbers states their range.
    #[error("{text:?} is not {kind}{}", advice(.range.as_ref()))]
    Unreadable { text: String, kind: &'static str, range: Option<Range> },
    #[error("{given} is not {kind}")]
    OtherType { given: Value, kind: &'static str },
    #[error("the list is empty; give at least one value")]
    EmptyList,
    #[error("{number} is outside its range, {range}")]
    OutOfRange { number: f64, range: Range },
    #[error("{number} is not a finite number")]
    NotFinite { number: f64 },
    #[error("{word:?} is not one of {}", .words.join(", "))]
    UnknownWord { word: String, words: Vec<String> },
    #[error("belongs to the server and cannot be set for one scene")]
    NotOpenToRequests,
    #[error("has {given} values; a request may give at most {max}")]
    TooMany { given: usize, max: usize },
}

/// Numbers that a key takes; both ends included.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    low: f64,
    high: Option<f64>,
    unit: String,
}

impl Range {
    /// Range of the allowed values, where they have one.
    fn of(allowed: &Allowed, unit: &str) -> Option<Self> {
        match *allowed {
            Allowed::Range { low, high } => Some(Self { low, high, unit: unit.to_owned() }),
            Allowed::Anything | Allowed::Words(_) => None,
        }
    }

    fn contains(&self, number: f64) -> bool {
        number.is_finite() && number >= self.low && self.high.is_none_or(|high| number <= high)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self { low, high: Some(high), unit } => write!(f, "from {low} to {high} ({unit})"),
            Self { low, high: None, unit } => write!(f, "{low} or more ({unit})"),
        }
    }
}

fn advice(range: Option<&Range>) -> String {
    match range {
        Some(range @ Range { high: Some(_), .. }) => format!("; give one {range}"),
        Some(range) => format!("; give {range}"),
        None => String::new(),
    }
}

/// A value of the key's type, inside its range, out of TOML.
pub fn fit(key: &Key, given: Value) -> Result<Value, ValueError> {
    let value = convert(&key.default, given)?;
    check(&key.allowed, &key.unit, &value)?;
    Ok(value)
}

/// A value of the key's type, inside its range, out of plain text, as environment variables, arguments and requests
/// carry it: numbers and `true` as they are, words without quotes, lists as `1, 2` or `[1, 2]`.
pub fn parse(key: &Key, text: &str) -> Result<Value, ValueError> {
    let value = typed(&key.default, text.trim(), Range::of(&key.allowed, &key.unit).as_ref())?;
    check(&key.allowed, &key.unit, &value)?;
    Ok(value)
}

/// A value out of plain text in a request, which may set fewer keys, in narrower ranges, and lists no longer than the
/// default's: no request may take the workers for itself.
pub fn parse_for_request(key: &Key, text: &str) -> Result<Value, ValueError> {
    let Some(allowed) = &key.open_to_requests else {
        return Err(ValueError::NotOpenToRequests);
    };
    let value = typed(&key.default, text.trim(), None)?;
    if let (Value::Array(given), Value::Array(default)) = (&value, &key.default)
        && given.len() > default.len()
    {
        return Err(ValueError::TooMany { given: given.len(), max: default.len() });
    }
    check(allowed, &key.unit, &value)?;
    Ok(value)
}

/// A text as a value of the type of `like`. The range is for the error alone.
fn typed(like: &Value, text: &str, range: Option<&Range>) -> Result<Value, ValueError> {
    let wrong = || ValueError::Unreadable { text: text.to_owned(), kind: kind(like), range: range.cloned() };
    match like {
        Value::Integer(_) => text.parse().map(Value::Integer).map_err(|_| wrong()),
        Value::Float(_) => text.parse().map(Value::Float).map_err(|_| wrong()),
        Value::Boolean(_) => text.parse().map(Value::Boolean).map_err(|_| wrong()),
        Value::Array(items) => {
            let inner = text.strip_prefix('[').and_then(|text| text.strip_suffix(']')).unwrap_or(text);
            let like = items.first().ok_or_else(wrong)?;
            let parts = inner.split(',').map(str::trim).filter(|part| !part.is_empty());
            parts.map(|part| typed(like, part, range)).collect::<Result<_, _>>().map(Value::Array)
        }
        Value::String(_) => {
            let bare = text.strip_prefix('"').and_then(|text| text.strip_suffix('"')).unwrap_or(text);
            Ok(Value::String(bare.to_owned()))
        }
        Value::Datetime(_) | Value::Table(_) => Err(wrong()),
    }
}

/// `2` for `2.0` is fine; every other type must be the default's.
fn convert(like: &Value, given: Value) -> Result<Value, ValueError> {
    match (like, given) {
        (Value::Float(_), Value::Integer(whole)) => Ok(Value::Float(whole as f64)),
        (Value::Array(items), Value::Array(given)) => match items.first() {
            Some(like) => {
                given.into_iter().map(|item| convert(like, item)).collect::<Result<_, _>>().map(Value::Array)
            }
            None => Ok(Value::Array(given)),
        },
        (like, given) if like.same_type(&given) => Ok(given),
        (like, given) => Err(ValueError::OtherType { given, kind: kind(like) }),
    }
}

fn kind(value: &Value) -> &'static str {
    match value {
        Value::Integer(_) => "a whole number",
        Value::Float(_) => "a number",
        Value::Boolean(_) => "true or false",
        Value::String(_) => "a text",
        Value::Array(_) => "a list",
        Value::Datetime(_) => "a date",
        Value::Table(_) => "a section",
    }
}

fn check(allowed: &Allowed, unit: &str, value: &Value) -> Result<(), ValueError> {
    match (allowed, value) {
        (_, Value::Array(items)) => {
            if items.is_empty() {
                return Err(ValueError::EmptyList);
            }
            items.iter().try_for_each(|item| check(allowed, unit, item))
        }
        (_, Value::Integer(whole)) => within(*whole as f64, Range::of(allowed, unit)),
        (Allowed::Range { .. }, Value::Float(number)) => within(*number, Range::of(allowed, unit)),
        (_, Value::Float(number)) if !number.is_finite() => Err(ValueError::NotFinite { number: *number }),
        (Allowed::Words(words), Value::String(word)) if !words.contains(word) => {
            Err(ValueError::UnknownWord { word: word.clone(), words: words.clone() })
        }
        _ => Ok(()),
    }
}

fn within(number: f64, range: Option<Range>) -> Result<(), ValueError> {
    match range {
        Some(range) if !range.contains(number) => Err(ValueError::OutOfRange { number, range }),
        _ => Ok(()),
    }
}
