//! Writer of the text format (`.usda`).

use crate::number::{push_f32, push_f64};

use super::layer::{Content, Layer, Prim, Property, Specifier, Variability, VariantSet};
use super::value::{Dictionary, Entry, Quaternion, Text, Value};

/// The text of the file.
pub fn write(layer: &Layer) -> String {
    let mut writer = Writer::default();
    writer.line("#usda 1.0");
    writer.line("(");
    writer.indented(|writer| {
        if !layer.custom_data.entries().is_empty() {
            writer.dictionary("customLayerData", &layer.custom_data);
        }
        writer.line(&format!("defaultPrim = {}", quoted(&layer.root.name)));
        writer.line("kilogramsPerUnit = 1");
        writer.line("metersPerUnit = 1");
        writer.line("upAxis = \"Z\"");
    });
    writer.line(")");
    writer.prim(&layer.root);
    writer.text
}

/// Lines under construction.
#[derive(Default)]
struct Writer {
    text: String,
    depth: usize,
}

impl Writer {
    fn line(&mut self, line: &str) {
        self.indent();
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn indent(&mut self) {
        for _ in 0..self.depth {
            self.text.push_str("    ");
        }
    }

    fn indented(&mut self, content: impl FnOnce(&mut Writer)) {
        self.depth += 1;
        content(self);
        self.depth -= 1;
    }

    fn dictionary(&mut self, header: &str, dictionary: &Dictionary) {
        self.line(&format!("{header} = {{"));
        self.indented(|writer| {
            for (name, entry) in dictionary.entries() {
                match entry {
                    Entry::Dictionary(inner) => writer.dictionary(&format!("dictionary {name}"), inner),
                    Entry::Value(value) => {
                        writer.indent();
                        writer.text.push_str(&format!("{} {name} = ", value.value_type().name()));
                        push_value(&mut writer.text, value);
                        writer.text.push('\n');
                    }
                }
            }
        });
        self.line("}");
    }

    fn prim(&mut self, prim: &Prim) {
        self.text.push('\n');
        let specified = match prim.specifier {
            Specifier::Def(type_name) => format!("def {type_name}"),
            Specifier::Over => "over".to_owned(),
        };
        self.line(&format!("{specified} \"{}\" (", prim.name));
        let start = self.text.len();
        self.indented(|writer| writer.prim_metadata(prim));
        if self.text.len() == start {
            self.text.truncate(start - " (\n".len());
            self.text.push('\n');
        } else {
            self.line(")");
        }
        self.line("{");
        self.indented(|writer| {
            prim.properties().iter().for_each(|property| writer.property(property));
            prim.children().iter().for_each(|child| writer.prim(child));
            prim.variant_sets.iter().for_each(|variant_set| writer.variant_set(variant_set));
        });
        self.line("}");
    }

    fn variant_set(&mut self, variant_set: &VariantSet) {
        self.line(&format!("variantSet {} = {{", quoted(variant_set.name)));
        self.indented(|writer| {
            writer.line(&format!("{} {{", quoted(VariantSet::DISABLED)));
            writer.line("}");
            writer.line(&format!("{} (", quoted(VariantSet::ENABLED)));
            writer.indented(|writer| writer.line(&format!("prepend payload = @{}@", &*variant_set.payload)));
            writer.line(") {");
            writer.line("}");
        });
        self.line("}");
    }

    fn prim_metadata(&mut self, prim: &Prim) {
        if !prim.schemas.is_empty() {
            let schemas: Vec<String> = prim.schemas.iter().map(|schema| quoted(schema)).collect();
            self.line(&format!("prepend apiSchemas = [{}]", schemas.join(", ")));
        }
        if !prim.asset_info.entries().is_empty() {
            self.dictionary("assetInfo", &prim.asset_info);
        }
        if let Some(name) = &prim.display_name {
            self.line(&format!("displayName = {}", quoted(name)));
        }
        if let Some(kind) = prim.kind {
            self.line(&format!("kind = {}", quoted(kind)));
        }
        if let Some(reference) = &prim.reference {
            self.line(&format!("prepend references = @{}@", &**reference));
        }
        if !prim.variant_sets.is_empty() {
            self.line("variants = {");
            self.indented(|writer| {
                for variant_set in &prim.variant_sets {
                    writer.line(&format!("string {} = {}", variant_set.name, quoted(VariantSet::DISABLED)));
                }
            });
            self.line("}");
            let names: Vec<String> =
                prim.variant_sets.iter().map(|variant_set| quoted(variant_set.name)).collect();
            self.line(&format!("prepend variantSets = [{}]", names.join(", ")));
        }
    }

    fn property(&mut self, property: &Property) {
        let name = &property.name;
        match &property.content {
            Content::Attribute { value, variability, interpolation, custom } => {
                let custom = if *custom { "custom " } else { "" };
                let uniform = match variability {
                    Variability::Uniform => "uniform ",
                    Variability::Varying => "",
                };
                self.attribute(&format!("{custom}{uniform}{} {name}", value.value_type().name()), value);
                if let Some(interpolation) = interpolation {
                    self.text.push_str(" (\n");
                    let line = format!("interpolation = \"{}\"", interpolation.token());
                    self.indented(|writer| writer.line(&line));
                    self.indent();
                    self.text.push(')');
                }
                self.text.push('\n');
            }
            Content::Declaration(value_type) => self.line(&format!("{} {name}", value_type.name())),
            Content::Connection(value_type, source) => {
                self.line(&format!("{} {name}.connect = <{source}>", value_type.name()));
            }
            Content::Relationship(target) => self.line(&format!("rel {name} = <{target}>")),
        }
    }

    fn attribute(&mut self, declaration: &str, value: &Value) {
        self.indent();
        self.text.push_str(declaration);
        self.text.push_str(" = ");
        push_value(&mut self.text, value);
    }
}

fn push_value(text: &mut String, value: &Value) {
    match value {
        Value::Bool(value) => text.push(if *value { '1' } else { '0' }),
        Value::Int(value) => text.push_str(&value.to_string()),
        Value::Float(value) => push_f32(text, *value),
        Value::Double(value) => push_f64(text, *value),
        Value::String(value) | Value::Token(value) => text.push_str(&quoted(value)),
        Value::Asset(path) => {
            text.push('@');
            text.push_str(path);
            text.push('@');
        }
        Value::Float2(values) => push_f32s(text, values),
        Value::Float3(values)
        | Value::Point3f(values)
        | Value::Vector3f(values)
        | Value::Color3f(values)
        | Value::Normal3f(values) => {
            push_f32s(text, values);
        }
        Value::Float4(values) => push_f32s(text, values),
        Value::Double3(values) => push_row(text, ['(', ')'], values, |text, value| push_f64(text, *value)),
        Value::Quatf(Quaternion { w, xyz: [x, y, z] }) => push_f32s(text, &[*w, *x, *y, *z]),
        Value::Quatd(Quaternion { w, xyz: [x, y, z] }) => {
            push_row(text, ['(', ')'], &[*w, *x, *y, *z], |text, value| push_f64(text, *value));
        }
        Value::Floats(values) => push_row(text, ['[', ']'], values, |text, value| push_f32(text, *value)),
        Value::Color3fs(rows) => push_row(text, ['[', ']'], rows, |text, row| push_f32s(text, row)),
        Value::Ints(values) => {
            push_row(text, ['[', ']'], values, |text, value| text.push_str(&value.to_string()));
        }
        Value::Tokens(values) => {
            push_row(text, ['[', ']'], values, |text, value: &Text| text.push_str(&quoted(value)));
        }
        Value::Float3s(rows) | Value::Point3fs(rows) | Value::Normal3fs(rows) => {
            push_row(text, ['[', ']'], rows, |text, row| push_f32s(text, row));
        }
        Value::TexCoord2fs(rows) => push_row(text, ['[', ']'], rows, |text, row| push_f32s(text, row)),
    }
}

/// `(a, b)` in single precision.
fn push_f32s(text: &mut String, values: &[f32]) {
    push_row(text, ['(', ')'], values, |text, value| push_f32(text, *value));
}

fn push_row<T>(text: &mut String, [open, close]: [char; 2], values: &[T], push: impl Fn(&mut String, &T)) {
    text.push(open);
    for (k, value) in values.iter().enumerate() {
        if k > 0 {
            text.push_str(", ");
        }
        push(text, value);
    }
    text.push(close);
}

/// A string literal.
fn quoted(value: &str) -> String {
    let mut text = String::with_capacity(value.len() + 2);
    text.push('"');
    for c in value.chars() {
        match c {
            '"' => text.push_str("\\\""),
            '\\' => text.push_str("\\\\"),
            '\n' => text.push_str("\\n"),
            '\r' => text.push_str("\\r"),
            '\t' => text.push_str("\\t"),
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
    fn string_literals_are_escaped() {
        assert_eq!(quoted("a \"b\" <c>\n\\🍎\u{7}"), "\"a \\\"b\\\" <c>\\n\\\\🍎\\x07\"");
    }

    #[test]
    fn nested_prims_are_indented() {
        let mut root = Prim::new("Xform", "x");
        root.kind = Some("component");
        root.set("a", Value::Bool(true));
        root.add(Prim::new("Scope", "inside"));
        let text = write(&Layer { custom_data: Dictionary::default(), root });
        let expected = "\ndef Xform \"x\" (\n    kind = \"component\"\n)\n{\n    bool a = 1\n\n    \
                        def Scope \"inside\"\n    {\n    }\n}\n";
        assert!(text.ends_with(expected), "{text}");
    }
}
