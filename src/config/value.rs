//! Values: from text to the type of a key, and whether they lie where they may.

use toml::Value;

use super::keys::{Allowed, Key};

/// A value of the key's type, inside its range, out of TOML.
pub fn fit(key: &Key, given: Value) -> Result<Value, String> {
    let value = convert(&key.default, given)?;
    check(&key.allowed, &key.unit, &value)?;
    Ok(value)
}

/// A value of the key's type, inside its range, out of plain text, as environment variables, arguments and requests
/// carry it: numbers and `true` as they are, words without quotes, lists as `1, 2` or `[1, 2]`.
pub fn parse(key: &Key, text: &str) -> Result<Value, String> {
    let value = typed(&key.default, text.trim()).map_err(|wrong| wrong + &range_in_words(key))?;
    check(&key.allowed, &key.unit, &value)?;
    Ok(value)
}

/// A value out of plain text in a request, which may set fewer keys, in narrower ranges, and lists no longer than the
/// default's: no request may take the workers for itself.
pub fn parse_for_request(key: &Key, text: &str) -> Result<Value, String> {
    let Some(allowed) = &key.open_to_requests else {
        return Err("belongs to the server and cannot be set for one scene".to_owned());
    };
    let value = typed(&key.default, text.trim())?;
    if let (Value::Array(given), Value::Array(default)) = (&value, &key.default)
        && given.len() > default.len()
    {
        return Err(format!("has {} values; a request may give at most {}", given.len(), default.len()));
    }
    check(allowed, &key.unit, &value)?;
    Ok(value)
}

/// The range of a key, to be added to what is wrong with a value that is no number.
fn range_in_words(key: &Key) -> String {
    match &key.allowed {
        Allowed::Range { low, high: Some(high) } => format!("; give one from {low} to {high} ({})", key.unit),
        Allowed::Range { low, high: None } => format!("; give {low} or more ({})", key.unit),
        Allowed::Anything | Allowed::Words(_) => String::new(),
    }
}

fn typed(like: &Value, text: &str) -> Result<Value, String> {
    let wrong = || format!("{text:?} is not {}", kind(like));
    match like {
        Value::Integer(_) => text.parse().map(Value::Integer).map_err(|_| wrong()),
        Value::Float(_) => text.parse().map(Value::Float).map_err(|_| wrong()),
        Value::Boolean(_) => text.parse().map(Value::Boolean).map_err(|_| wrong()),
        Value::Array(items) => {
            let inner = text.strip_prefix('[').and_then(|text| text.strip_suffix(']')).unwrap_or(text);
            let like = items.first().ok_or_else(wrong)?;
            let parts = inner.split(',').map(str::trim).filter(|part| !part.is_empty());
            parts.map(|part| typed(like, part)).collect::<Result<_, _>>().map(Value::Array)
        }
        Value::String(_) => {
            let bare = text.strip_prefix('"').and_then(|text| text.strip_suffix('"')).unwrap_or(text);
            Ok(Value::String(bare.to_owned()))
        }
        Value::Datetime(_) | Value::Table(_) => Err(wrong()),
    }
}

/// `2` for `2.0` is fine; every other type must be the default's.
fn convert(like: &Value, given: Value) -> Result<Value, String> {
    match (like, given) {
        (Value::Float(_), Value::Integer(whole)) => Ok(Value::Float(whole as f64)),
        (Value::Array(items), Value::Array(given)) => match items.first() {
            Some(like) => {
                given.into_iter().map(|item| convert(like, item)).collect::<Result<_, _>>().map(Value::Array)
            }
            None => Ok(Value::Array(given)),
        },
        (like, given) if like.same_type(&given) => Ok(given),
        (like, given) => Err(format!("{given} is not {}", kind(like))),
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

fn check(allowed: &Allowed, unit: &str, value: &Value) -> Result<(), String> {
    match (allowed, value) {
        (_, Value::Array(items)) => {
            if items.is_empty() {
                return Err("the list is empty; give at least one value".into());
            }
            items.iter().try_for_each(|item| check(allowed, unit, item))
        }
        (Allowed::Range { low, high }, Value::Integer(whole)) => within(*whole as f64, *low, *high, unit),
        (Allowed::Range { low, high }, Value::Float(number)) => within(*number, *low, *high, unit),
        (_, Value::Float(number)) if !number.is_finite() => Err(format!("{number} is not a finite number")),
        (Allowed::Words(words), Value::String(word)) if !words.contains(word) => {
            Err(format!("{word:?} is not one of {}", words.join(", ")))
        }
        _ => Ok(()),
    }
}

fn within(number: f64, low: f64, high: Option<f64>, unit: &str) -> Result<(), String> {
    let inside = number.is_finite() && number >= low && high.is_none_or(|high| number <= high);
    let range = match high {
        Some(high) => format!("from {low} to {high}"),
        None => format!("{low} or more"),
    };
    if inside { Ok(()) } else { Err(format!("{number} is outside its range, {range} ({unit})")) }
}
