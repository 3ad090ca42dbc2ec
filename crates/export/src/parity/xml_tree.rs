//! A small tree of XML elements, enough to ask for children and attributes.

use quick_xml::XmlVersion;
use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::{BytesStart, Event};

use super::ReadResult;

/// An element with its attributes, child elements and own text.
#[derive(Clone, Debug, Default)]
pub struct Element {
    pub name: String,
    attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
    /// As written, the white space between children included.
    pub text: String,
}

impl Element {
    /// The document's root element.
    pub fn parse(text: &str) -> ReadResult<Element> {
        let mut reader = quick_xml::Reader::from_str(text);
        let mut open = vec![Element::default()];
        loop {
            match reader.read_event().map_err(|error| error.to_string())? {
                Event::Start(start) => open.push(Element::of(&start)?),
                Event::Empty(start) => {
                    let element = Element::of(&start)?;
                    open.last_mut().ok_or("an element outside the root")?.children.push(element);
                }
                Event::End(_) => {
                    let element = open.pop().ok_or("an end without a start")?;
                    open.last_mut().ok_or("an end without a start")?.children.push(element);
                }
                Event::Text(text) => {
                    open.last_mut().ok_or("text outside the root")?.text.push_str(&text.xml10_content());
                }
                Event::GeneralRef(entity) => {
                    let text = &mut open.last_mut().ok_or("text outside the root")?.text;
                    match entity.resolve_char_ref().map_err(|error| error.to_string())? {
                        Some(character) => text.push(character),
                        None => text.push_str(
                            resolve_predefined_entity(&entity).ok_or_else(|| format!("&{};", &*entity))?,
                        ),
                    }
                }
                Event::Eof => break,
                _ => {}
            }
        }
        let document = open.pop().unwrap_or_default();
        document.children.into_iter().next().ok_or_else(|| "no root element".to_owned())
    }

    fn of(start: &BytesStart<'_>) -> ReadResult<Element> {
        let mut element = Element { name: start.name().0.to_owned(), ..Element::default() };
        for attribute in start.attributes() {
            let attribute = attribute.map_err(|error| error.to_string())?;
            let value =
                attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|error| error.to_string())?;
            element.attributes.push((attribute.key.0.to_owned(), value.into_owned()));
        }
        Ok(element)
    }

    /// Children of that name.
    pub fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Element> + 'a {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// The first child of that name.
    pub fn child(&self, name: &str) -> ReadResult<&Element> {
        self.children
            .iter()
            .find(|child| child.name == name)
            .ok_or_else(|| format!("<{}> has no <{name}>", self.name))
    }

    /// An attribute that must be there.
    pub fn attribute(&self, name: &str) -> ReadResult<&str> {
        self.optional(name).ok_or_else(|| format!("<{}> has no attribute {name}", self.name))
    }

    /// An attribute.
    pub fn optional(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// The element's text as one number.
    pub fn text_number(&self) -> ReadResult<f64> {
        self.text.trim().parse().map_err(|_| format!("{:?} in <{}> is no number", self.text, self.name))
    }

    /// An attribute that is one number.
    pub fn number(&self, name: &str) -> ReadResult<f64> {
        let text = self.attribute(name)?;
        text.parse().map_err(|_| format!("{text:?} is no number"))
    }
}
