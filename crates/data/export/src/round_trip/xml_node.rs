//! Queries on XML elements that report what is missing.

use roxmltree::{Document, ExpandedName, Node};

use super::{ReadError, ReadResult};

/// Parses a document. Unclosed elements, duplicate attributes, undeclared prefixes and DTDs are errors.
pub fn parse(text: &str) -> ReadResult<Document<'_>> {
    Ok(Document::parse(text)?)
}

/// Queries for child elements and attributes that must exist. Plain names belong to no namespace.
pub trait XmlNode<'a, 'input: 'a> {
    /// Child elements of that name.
    fn all<'n>(self, name: impl Into<ExpandedName<'n, 'n>>) -> impl Iterator<Item = Node<'a, 'input>>;

    /// The first child element of that name.
    fn child<'n>(self, name: impl Into<ExpandedName<'n, 'n>>) -> ReadResult<Node<'a, 'input>>;

    /// An attribute that must exist.
    fn required(self, name: &str) -> ReadResult<&'a str>;

    /// An attribute that is one number.
    fn number(self, name: &str) -> ReadResult<f64>;

    /// The element's own text, including the white space between its children.
    fn content(self) -> String;

    /// The element's text as one number.
    fn text_number(self) -> ReadResult<f64>;
}

impl<'a, 'input: 'a> XmlNode<'a, 'input> for Node<'a, 'input> {
    fn all<'n>(self, name: impl Into<ExpandedName<'n, 'n>>) -> impl Iterator<Item = Node<'a, 'input>> {
        let name = name.into();
        self.children().filter(move |child| child.is_element() && child.tag_name() == name)
    }

    fn child<'n>(self, name: impl Into<ExpandedName<'n, 'n>>) -> ReadResult<Node<'a, 'input>> {
        let name = name.into();
        let child = self.all(name).next();
        child.ok_or_else(|| ReadError::lacks(tag(self), format!("<{}>", name.name())))
    }

    fn required(self, name: &str) -> ReadResult<&'a str> {
        self.attribute(name).ok_or_else(|| ReadError::lacks(tag(self), format!("attribute {name}")))
    }

    fn number(self, name: &str) -> ReadResult<f64> {
        let text = self.required(name)?;
        text.parse().map_err(|_| ReadError::not_a("number", text))
    }

    fn content(self) -> String {
        self.children().filter(Node::is_text).filter_map(|text| text.text()).collect()
    }

    fn text_number(self) -> ReadResult<f64> {
        let text = self.content();
        let element = self.tag_name().name();
        text.trim().parse().map_err(|_| ReadError::ElementNotNumber { element: element.to_owned(), text })
    }
}

fn tag(element: Node<'_, '_>) -> String {
    format!("<{}>", element.tag_name().name())
}
