//! Writer of indented XML on top of quick-xml. Every value is escaped.

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};

/// A document under construction. Elements are closed in the order they were opened.
pub(super) struct XmlDocument {
    writer: Writer<Vec<u8>>,
    open: Vec<&'static str>,
}

impl XmlDocument {
    pub(super) fn new() -> Self {
        let mut document = Self::fragment();
        document.write(Event::Decl(BytesDecl::new("1.0", Some("utf-8"), None)));
        document
    }

    /// Elements that become a part of another document.
    pub(super) fn fragment() -> Self {
        Self { writer: Writer::new_with_indent(Vec::new(), b' ', 2), open: Vec::new() }
    }

    pub(super) fn comment(&mut self, text: &str) {
        self.write(Event::Comment(BytesText::new(&format!(" {} ", text.replace("--", "-")))));
    }

    pub(super) fn open(&mut self, name: &'static str, attributes: &[(&str, &str)]) {
        self.write(Event::Start(element(name, attributes)));
        self.open.push(name);
    }

    /// Closes the innermost open element.
    pub(super) fn close(&mut self) {
        if let Some(name) = self.open.pop() {
            self.write(Event::End(BytesEnd::new(name)));
        }
    }

    /// Writes an element without content.
    pub(super) fn empty(&mut self, name: &'static str, attributes: &[(&str, &str)]) {
        self.write(Event::Empty(element(name, attributes)));
    }

    /// Closes the open elements and returns the text.
    pub(super) fn finish(mut self) -> String {
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

fn element<'a>(name: &'a str, attributes: &[(&str, &str)]) -> BytesStart<'a> {
    let mut start = BytesStart::new(name);
    for (key, value) in attributes {
        start.push_attribute((*key, *value));
    }
    start
}
