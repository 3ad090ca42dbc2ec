//! Writer of indented XML on top of quick-xml. Every value is escaped.

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};

/// A document under construction. Elements are closed in the order they were opened.
pub struct XmlDocument {
    writer: Writer<Vec<u8>>,
    open: Vec<&'static str>,
}

impl XmlDocument {
    /// Starts with the XML declaration.
    pub fn new() -> Self {
        let mut document = Self::fragment();
        document.write(Event::Decl(BytesDecl::new("1.0", Some("utf-8"), None)));
        document
    }

    /// Elements that become a part of another document.
    pub fn fragment() -> Self {
        Self { writer: Writer::new_with_indent(Vec::new(), b' ', 2), open: Vec::new() }
    }

    /// A comment, in which two hyphens become one.
    pub fn comment(&mut self, text: &str) {
        self.write(Event::Comment(BytesText::new(&format!(" {} ", text.replace("--", "-")))));
    }

    /// Opens an element.
    pub fn open(&mut self, name: &'static str, attributes: &[(&str, &str)]) {
        self.write(Event::Start(element(name, attributes)));
        self.open.push(name);
    }

    /// Closes the innermost open element.
    pub fn close(&mut self) {
        if let Some(name) = self.open.pop() {
            self.write(Event::End(BytesEnd::new(name)));
        }
    }

    /// An element without content.
    pub fn empty(&mut self, name: &'static str, attributes: &[(&str, &str)]) {
        self.write(Event::Empty(element(name, attributes)));
    }

    /// An element that holds only text.
    pub fn text_element(&mut self, name: &'static str, text: &str) {
        self.text_element_with(name, &[], text);
    }

    /// An element with attributes that holds only text.
    pub fn text_element_with(&mut self, name: &'static str, attributes: &[(&str, &str)], text: &str) {
        self.write(Event::Start(element(name, attributes)));
        self.write(Event::Text(BytesText::new(&allowed_in_xml(text))));
        self.write(Event::End(BytesEnd::new(name)));
    }

    /// Closes the open elements and returns the text.
    pub fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        let mut bytes = self.writer.into_inner();
        bytes.push(b'\n');
        String::from_utf8(bytes).expect("only strings were written")
    }

    fn write(&mut self, event: Event<'_>) {
        self.writer.write_event(event).expect("memory accepts every write");
    }
}

impl Default for XmlDocument {
    fn default() -> Self {
        Self::new()
    }
}

fn element<'a>(name: &'a str, attributes: &[(&str, &str)]) -> BytesStart<'a> {
    let mut start = BytesStart::new(name);
    for (key, value) in attributes {
        start.push_attribute((*key, allowed_in_xml(value).as_str()));
    }
    start
}

/// Replaces characters that XML 1.0 cannot represent even escaped (most control characters) by U+FFFD.
pub fn allowed_in_xml(value: &str) -> String {
    let allowed =
        |c: char| !matches!(c, '\0'..='\x08' | '\x0b' | '\x0c' | '\x0e'..='\x1f' | '\u{fffe}' | '\u{ffff}');
    value.chars().map(|c| if allowed(c) { c } else { '\u{fffd}' }).collect()
}
