//! Text of a USD layer: indentation, blocks, arrays, escaped strings.

use crate::export::number::{push_f32, push_f64};

/// A layer under construction.
#[derive(Default)]
pub struct Layer {
    text: String,
    depth: usize,
}

impl Layer {
    /// The header, with the conventions of every layer of a bundle; `metadata` are further lines.
    pub fn new(default_prim: &str, metadata: impl FnOnce(&mut Layer)) -> Self {
        let mut layer = Layer::default();
        layer.line("#usda 1.0");
        layer.line("(");
        layer.depth += 1;
        metadata(&mut layer);
        layer.line(&format!("defaultPrim = {}", quoted(default_prim)));
        layer.line("kilogramsPerUnit = 1");
        layer.line("metersPerUnit = 1");
        layer.line("upAxis = \"Z\"");
        layer.depth -= 1;
        layer.line(")");
        layer
    }

    /// One indented line.
    pub fn line(&mut self, line: &str) {
        for _ in 0..self.depth {
            self.text.push_str("    ");
        }
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// Lines between `{` and `}` after `header`.
    pub fn block(&mut self, header: &str, content: impl FnOnce(&mut Layer)) {
        self.line(&format!("{header} = {{"));
        self.depth += 1;
        content(self);
        self.depth -= 1;
        self.line("}");
    }

    /// `def <kind> "<name>" (<metadata lines>) { <content> }`. The name must be an identifier.
    pub fn prim(&mut self, kind: &str, name: &str, metadata: &[&str], content: impl FnOnce(&mut Layer)) {
        self.text.push('\n');
        if metadata.is_empty() {
            self.line(&format!("def {kind} \"{name}\""));
        } else {
            self.line(&format!("def {kind} \"{name}\" ("));
            self.depth += 1;
            metadata.iter().for_each(|line| self.line(line));
            self.depth -= 1;
            self.line(")");
        }
        self.line("{");
        self.depth += 1;
        content(self);
        self.depth -= 1;
        self.line("}");
    }

    /// `<declaration> = [a, b, ...]`, each element written by `push`.
    pub fn array<T>(
        &mut self,
        declaration: &str,
        elements: impl IntoIterator<Item = T>,
        push: impl Fn(&mut String, T),
        metadata: &str,
    ) {
        for _ in 0..self.depth {
            self.text.push_str("    ");
        }
        self.text.push_str(declaration);
        self.text.push_str(" = [");
        for (k, element) in elements.into_iter().enumerate() {
            if k > 0 {
                self.text.push_str(", ");
            }
            push(&mut self.text, element);
        }
        self.text.push(']');
        self.text.push_str(metadata);
        self.text.push('\n');
    }

    pub fn finish(self) -> String {
        self.text
    }
}

/// `(x, y, z)` in single precision.
pub fn push_tuple_f32(text: &mut String, values: &[f32]) {
    push_tuple(text, values, |text, value| push_f32(text, *value));
}

/// `(x, y, z)` in double precision.
pub fn tuple(values: &[f64]) -> String {
    let mut text = String::new();
    push_tuple(&mut text, values, |text, value| push_f64(text, *value));
    text
}

/// `(a, b)` with a writer of one's own for the elements.
pub fn push_tuple<T>(text: &mut String, values: &[T], push: impl Fn(&mut String, &T)) {
    text.push('(');
    for (k, value) in values.iter().enumerate() {
        if k > 0 {
            text.push_str(", ");
        }
        push(text, value);
    }
    text.push(')');
}

/// A string literal. NUL, which would end the string in many readers, becomes U+FFFD.
pub fn quoted(value: &str) -> String {
    let mut text = String::with_capacity(value.len() + 2);
    text.push('"');
    for c in value.chars() {
        match c {
            '"' => text.push_str("\\\""),
            '\\' => text.push_str("\\\\"),
            '\n' => text.push_str("\\n"),
            '\r' => text.push_str("\\r"),
            '\t' => text.push_str("\\t"),
            '\0' => text.push('\u{fffd}'),
            c if c.is_ascii_control() => text.push_str(&format!("\\x{:02x}", c as u32)),
            c => text.push(c),
        }
    }
    text.push('"');
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_are_escaped() {
        assert_eq!(quoted("a \"b\" <c>\n\\🍎\u{7}"), "\"a \\\"b\\\" <c>\\n\\\\🍎\\x07\"");
    }

    #[test]
    fn blocks_nest() {
        let mut layer = Layer::new("x", |_| {});
        layer.prim("Xform", "x", &["kind = \"component\""], |layer| layer.line("bool a = 1"));
        let text = layer.finish();
        assert!(text.ends_with("\ndef Xform \"x\" (\n    kind = \"component\"\n)\n{\n    bool a = 1\n}\n"));
    }
}
