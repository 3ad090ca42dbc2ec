//! Texts in JSON: `{"objects": ["mug", {"name": "plate", "count": 2}]}` becomes the tokens of a list.

use std::ops::Range;

use serde_json::Value;

use super::tokens::{Source, Token};

/// Depth of nesting that is read.
const MAX_DEPTH: usize = 6;

/// The tokens of a JSON text; `None` for another text.
pub(super) fn read(text: &str) -> Option<Source> {
    let trimmed = text.trim_start();
    if !trimmed.starts_with(['{', '[']) {
        return None;
    }
    let value: Value = serde_json::from_str(text).ok()?;
    let mut reader = Reader {
        source: Source { text: text.to_owned(), ..Source::default() },
        cursor: text.len() - trimmed.len(),
        from: 0,
    };
    reader.value(&value, 0);
    reader.source.markers = markers(text);
    Some(reader.source)
}

/// Bytes of the keys and of the literals "true", "false" and "null".
fn markers(text: &str) -> Vec<Range<usize>> {
    let mut markers = Vec::new();
    let mut at = 0;
    while let Some(next) = text[at..].find(|c: char| c == '"' || c.is_ascii_alphabetic()) {
        let start = at + next;
        if text[start..].starts_with('"') {
            let inner = start + 1;
            let mut escaped = false;
            let length = text[inner..].find(|c: char| {
                let closes = c == '"' && !escaped;
                escaped = c == '\\' && !escaped;
                closes
            });
            let Some(length) = length else { break };
            at = inner + length + 1;
            if text[at..].trim_start().starts_with(':') && length > 0 {
                markers.push(inner..inner + length);
            }
        } else {
            let length = text[start..].find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(text.len() - start);
            markers.push(start..start + length);
            at = start + length;
        }
    }
    markers
}

/// The name and the unit of a key such as "height_cm".
fn unit_of(key: &str) -> Option<(&str, &str)> {
    key.rsplit_once('_').filter(|(_, unit)| matches!(*unit, "cm" | "mm" | "m" | "kg" | "g"))
}

struct Reader {
    source: Source,
    /// Position in the text after the last string that has been read.
    cursor: usize,
    /// Position where the current object begins.
    from: usize,
}

impl Reader {
    fn value(&mut self, value: &Value, depth: usize) {
        match value {
            Value::String(text) => {
                self.words(text);
                self.end();
            }
            Value::Array(values) if depth < MAX_DEPTH => {
                for value in values {
                    self.value(value, depth + 1);
                }
            }
            Value::Object(fields) if depth < MAX_DEPTH => {
                let name = ["name", "object", "category", "label", "type", "item"]
                    .into_iter()
                    .find(|key| fields.get(*key).is_some_and(Value::is_string));
                match name {
                    Some(name) => self.object(fields, name, depth),
                    None => {
                        let is_inventory =
                            fields.values().all(|value| value.is_boolean() || value.is_number());
                        for (key, value) in fields {
                            self.field(key, value, depth, is_inventory);
                        }
                    }
                }
            }
            _ => {}
        }
    }

    /// An object: count, properties, name, then everything else in the order of the text.
    fn object(&mut self, fields: &serde_json::Map<String, Value>, name: &str, depth: usize) {
        let start = self.cursor;
        let before = std::mem::replace(&mut self.from, start);
        let count = ["count", "quantity", "number", "amount", "n", "qty", "num", "how_many"]
            .into_iter()
            .find(|key| fields.contains_key(*key));
        if let Some(Value::Number(number)) = count.and_then(|key| fields.get(key)) {
            self.count(number.as_f64().unwrap_or(1.0));
        }
        let properties = ["size", "color", "colour", "material", "shape"];
        for property in properties {
            if let Some(Value::String(text)) = fields.get(property) {
                self.words_from(text, start);
            }
        }
        if let Some(Value::String(text)) = fields.get(name) {
            self.words_from(text, start);
        }
        let mut measures = Vec::new();
        for (key, value) in fields {
            let is_read = key == name || Some(key.as_str()) == count || properties.contains(&key.as_str());
            match value {
                Value::String(text) if !is_read => {
                    let relation = key.replace('_', " ");
                    if !matches!(
                        relation.as_str(),
                        "position" | "location" | "place" | "relation" | "state" | "pose"
                    ) {
                        self.words_from(&relation, start);
                    }
                    self.words_from(text, start);
                }
                Value::Number(number) if !is_read => measures.push((key, number.as_f64().unwrap_or(0.0))),
                Value::Array(_) | Value::Object(_) => self.value(value, depth + 1),
                _ => {}
            }
        }
        for (key, number) in measures {
            self.measure(key, number);
        }
        self.from = before;
        self.end();
    }

    /// A field of a scene: the list of objects, the table, what to leave out.
    fn field(&mut self, key: &str, value: &Value, depth: usize, is_inventory: bool) {
        match (key, value) {
            // {"table": "round"}, {"table": {"shape": "round"}}
            ("table" | "desk" | "surface", value @ (Value::String(_) | Value::Object(_))) => {
                let start = self.cursor;
                let fields = value.as_object();
                let texts: Vec<&str> = match value {
                    Value::Object(fields) => fields.values().filter_map(Value::as_str).collect(),
                    text => text.as_str().into_iter().collect(),
                };
                for text in &texts {
                    self.words_from(text, start);
                }
                let named = |text: &&str| {
                    ["table", "desk", "bench", "counter"].iter().any(|noun| text.contains(noun))
                };
                if !texts.iter().any(named) {
                    self.words_from(key, start.saturating_sub(key.len() + 4));
                }
                for (key, value) in fields.into_iter().flatten() {
                    match value {
                        Value::Number(number) => self.measure(key, number.as_f64().unwrap_or(0.0)),
                        Value::Array(_) | Value::Object(_) => {
                            self.end();
                            self.value(value, depth + 1);
                        }
                        _ => {}
                    }
                }
                self.end();
            }
            ("exclude" | "excluded" | "without" | "forbidden", Value::Array(values)) => {
                for value in values.iter().filter_map(Value::as_str) {
                    self.words("no");
                    self.words(value);
                    self.end();
                }
            }
            // {"mug": true, "fork": false} among counts.
            (key, Value::Bool(is_there)) if is_inventory => {
                if !is_there {
                    self.word("no");
                }
                self.words(key);
                self.end();
            }
            // A setting of the scene, which is reported.
            ("seed" | "version" | "id" | "index" | "fps" | "timeout" | "steps", Value::Number(number)) => {
                self.number(number.as_f64().unwrap_or(0.0));
                self.end();
            }
            (key, Value::Number(number)) if unit_of(key).is_some() => {
                self.measure(key, number.as_f64().unwrap_or(0.0));
                self.end();
            }
            (_, Value::Number(number)) => {
                // {"mug": 2, "plate": 1}
                self.count(number.as_f64().unwrap_or(1.0));
                self.words(key);
                self.end();
            }
            (_, value) => self.value(value, depth + 1),
        }
    }

    /// "height_cm": 12 is a measure of the object; another number is a sentence of its own, which is reported.
    fn measure(&mut self, key: &str, number: f64) {
        match unit_of(key) {
            Some((name, unit)) => {
                if !matches!(name, "mass" | "weight") {
                    self.word(name);
                }
                self.number(number);
                self.word(unit);
            }
            None => {
                self.end();
                self.number(number);
            }
        }
    }

    /// A word at the current position of the text.
    fn word(&mut self, word: &str) {
        let at = self.cursor;
        self.source.push(Token::Word(word.to_owned()), at..at);
    }

    fn number(&mut self, number: f64) {
        let span = self.span_of(number);
        self.source.push(Token::Number(number), span);
    }

    /// A number of objects; none of them is an exclusion.
    fn count(&mut self, number: f64) {
        let span = self.span_of(number);
        let token = if number == 0.0 { Token::Word("zero".to_owned()) } else { Token::Number(number) };
        self.source.push(token, span);
    }

    /// The bytes of a number that no token has yet, within the current object.
    fn span_of(&self, number: f64) -> Range<usize> {
        let (text, written) = (&self.source.text, format!("{number}"));
        let is_part = |c: char| c.is_ascii_digit() || c == '.';
        let found = text[self.from..].match_indices(&written).map(|(at, _)| self.from + at).find(|&at| {
            let before = text[..at].trim_end().ends_with([':', '[', ',']);
            let after = text[at + written.len()..].starts_with(is_part);
            before && !after && self.source.spans.iter().all(|span| span.start != at)
        });
        let start = found.unwrap_or(self.cursor);
        start..if found.is_some() { start + written.len() } else { start }
    }

    fn words(&mut self, text: &str) {
        self.words_from(text, self.cursor);
    }

    /// Appends the tokens of a string that occurs at or after a position of the text.
    fn words_from(&mut self, text: &str, from: usize) {
        let found = self.source.text.get(from..).and_then(|rest| rest.find(text)).map(|at| from + at);
        let escaped = if found.is_none() { self.escaped(text, from) } else { None };
        let part = Source::read(text);
        for (token, span) in part.tokens.into_iter().zip(part.spans) {
            let span = match (found, &escaped) {
                (Some(found), _) => found + span.start..found + span.end,
                (None, Some(literal)) => literal.clone(),
                (None, None) => from..from,
            };
            self.source.push(token, span);
        }
        let end = found.map(|found| found + text.len()).or(escaped.map(|literal| literal.end));
        self.cursor = self.cursor.max(end.unwrap_or(0));
    }

    /// The bytes of the string literal that has this value, if it is written with escapes ("caf\u00e9").
    fn escaped(&self, value: &str, from: usize) -> Option<Range<usize>> {
        let text = &self.source.text;
        let mut open = from.saturating_sub(1);
        while let Some(start) = text.get(open..)?.find('"').map(|at| open + at) {
            let mut is_escape = false;
            let length = text[start + 1..].find(|c: char| {
                let closes = c == '"' && !is_escape;
                is_escape = c == '\\' && !is_escape;
                closes
            })?;
            let end = start + 1 + length;
            if serde_json::from_str::<String>(&text[start..=end]).is_ok_and(|literal| literal == value) {
                return Some(start + 1..end);
            }
            open = end + 1;
        }
        None
    }

    fn end(&mut self) {
        let at = self.cursor;
        self.source.push(Token::End, at..at);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_lists_become_lists() {
        for (text, expected) in [
            (r#"{"objects": ["mug", {"name": "plate", "count": 2}]}"#, "mug . 2 plate ."),
            (r#"["red mug", "book"]"#, "red mug . book ."),
            (r#"{"items": [{"object": "mug", "color": "red", "on": "plate"}]}"#, "red mug on plate ."),
            (r#"{"mug": 3}"#, "3 mug ."),
            (r#"{"objects": ["desk"], "exclude": ["fork"]}"#, "desk . no fork ."),
            (r#"{"table": "round"}"#, "round table ."),
            (r#"[{"name": "mug", "height_cm": 12}]"#, "mug height 12 cm ."),
            (r#"{"fork": 0}"#, "zero fork ."),
            (r#"{"mug": true, "fork": false}"#, "mug . no fork ."),
            (r#"{"table": {"shape": "round", "diameter_cm": 90}}"#, "round table diameter 90 cm ."),
            (r#"["caf\u00e9 cup"]"#, "cafe cup ."),
        ] {
            let source = read(text).expect(text);
            let tokens: Vec<String> = source
                .tokens
                .iter()
                .map(|token| match token {
                    Token::Word(word) => word.clone(),
                    Token::Number(number) => number.to_string(),
                    Token::Pause => ",".to_owned(),
                    Token::End => ".".to_owned(),
                })
                .collect();
            assert_eq!(tokens.join(" "), expected, "{text}");
        }
        assert!(read("a desk with {").is_none() && read("{ mug }").is_none());
    }
}
