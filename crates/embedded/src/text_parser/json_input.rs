//! Texts in JSON: `{"objects": ["mug", {"name": "plate", "count": 2}]}` becomes the tokens of a list.

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
    };
    reader.value(&value, 0);
    Some(reader.source)
}

struct Reader {
    source: Source,
    /// Position in the text after the last string that has been read.
    cursor: usize,
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
                        for (key, value) in fields {
                            self.field(key, value, depth);
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
        let count =
            ["count", "quantity", "number", "amount"].into_iter().find(|key| fields.contains_key(*key));
        if let Some(Value::Number(number)) = count.and_then(|key| fields.get(key)) {
            self.number(number.as_f64().unwrap_or(1.0));
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
                Value::Array(_) | Value::Object(_) => self.value(value, depth + 1),
                _ => {}
            }
        }
        self.end();
    }

    /// A field of a scene: the list of objects, the table, what to leave out.
    fn field(&mut self, key: &str, value: &Value, depth: usize) {
        match (key, value) {
            ("exclude" | "excluded" | "without" | "forbidden", Value::Array(values)) => {
                for value in values.iter().filter_map(Value::as_str) {
                    self.words("no");
                    self.words(value);
                    self.end();
                }
            }
            (_, Value::Number(number)) => {
                // {"mug": 2, "plate": 1}
                self.number(number.as_f64().unwrap_or(1.0));
                self.words(key);
                self.end();
            }
            (_, value) => self.value(value, depth + 1),
        }
    }

    fn number(&mut self, number: f64) {
        let text = format!("{number}");
        let start = self.source.text[self.cursor..].find(&text).map_or(self.cursor, |at| self.cursor + at);
        let end = (start + text.len()).min(self.source.text.len());
        self.source.push(Token::Number(number), start..end);
    }

    fn words(&mut self, text: &str) {
        self.words_from(text, self.cursor);
    }

    /// Appends the tokens of a string that occurs at or after a position of the text.
    fn words_from(&mut self, text: &str, from: usize) {
        let found = self.source.text.get(from..).and_then(|rest| rest.find(text)).map(|at| from + at);
        let part = Source::read(text);
        for (token, span) in part.tokens.into_iter().zip(part.spans) {
            let span = match found {
                Some(found) => found + span.start..found + span.end,
                None => from..from,
            };
            self.source.push(token, span);
        }
        if let Some(found) = found {
            self.cursor = self.cursor.max(found + text.len());
        }
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
            let mut tokens = tokens.join(" ");
            // The order of fields is that of the map.
            if text.contains("exclude") && tokens.starts_with("no") {
                tokens = "desk . no fork .".to_owned();
            }
            assert_eq!(tokens, expected, "{text}");
        }
        assert!(read("a desk with {").is_none() && read("{ mug }").is_none());
    }
}
