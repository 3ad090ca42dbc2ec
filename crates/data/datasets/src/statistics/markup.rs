//! Writer of HTML and SVG that is well-formed XML. Every text and attribute is escaped.

/// A page under construction. Elements are closed in the order they were opened.
#[derive(Default)]
pub struct Markup {
    text: String,
    open: Vec<&'static str>,
}

impl Markup {
    /// Opens an element.
    pub fn open(&mut self, tag: &'static str, attributes: &[(&str, &str)]) {
        self.start(tag, attributes);
        self.text.push('>');
        self.open.push(tag);
    }

    /// Closes the innermost open element.
    pub fn close(&mut self) {
        if let Some(tag) = self.open.pop() {
            self.text.push_str("</");
            self.text.push_str(tag);
            self.text.push_str(">\n");
        }
    }

    /// An element without content.
    pub fn void(&mut self, tag: &'static str, attributes: &[(&str, &str)]) {
        self.start(tag, attributes);
        self.text.push_str(" />\n");
    }

    /// An element that holds only text.
    pub fn leaf(&mut self, tag: &'static str, attributes: &[(&str, &str)], text: &str) {
        self.open(tag, attributes);
        push_escaped(&mut self.text, text);
        self.close();
    }

    /// A table; columns behind the first hold numbers.
    pub fn table(&mut self, head: &[&str], rows: &[Vec<String>]) {
        let class = |column: usize| if column == 0 { "words" } else { "n" };
        self.open("table", &[]);
        self.open("thead", &[]);
        self.open("tr", &[]);
        for (column, title) in head.iter().enumerate() {
            self.leaf("th", &[("scope", "col"), ("class", class(column))], title);
        }
        self.close();
        self.close();
        self.open("tbody", &[]);
        for row in rows {
            self.open("tr", &[]);
            for (column, cell) in row.iter().enumerate() {
                self.leaf("td", &[("class", class(column))], cell);
            }
            self.close();
        }
        self.close();
        self.close();
    }

    /// A style sheet of this program, which is not escaped.
    pub fn style(&mut self, sheet: &'static str) {
        self.text.push_str("<style>\n");
        self.text.push_str(sheet);
        self.text.push_str("</style>\n");
    }

    /// Closes the open elements and returns the text.
    pub fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        self.text
    }

    fn start(&mut self, tag: &str, attributes: &[(&str, &str)]) {
        self.text.push('<');
        self.text.push_str(tag);
        for (name, value) in attributes {
            self.text.push(' ');
            self.text.push_str(name);
            self.text.push_str("=\"");
            push_escaped(&mut self.text, value);
            self.text.push('"');
        }
    }
}

/// Appends escaped text. Characters that are invalid in HTML or XML become U+FFFD.
fn push_escaped(page: &mut String, text: &str) {
    for c in text.chars() {
        match c {
            '&' => page.push_str("&amp;"),
            '<' => page.push_str("&lt;"),
            '>' => page.push_str("&gt;"),
            '"' => page.push_str("&quot;"),
            '\'' => page.push_str("&#39;"),
            '\u{fffe}' | '\u{ffff}' => page.push('\u{fffd}'),
            c if c.is_control() => page.push('\u{fffd}'),
            c => page.push(c),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_and_attributes_are_escaped() {
        let mut page = Markup::default();
        page.leaf("p", &[("title", "a\"b")], "</p><script>&'\u{7}");
        let expected = "<p title=\"a&quot;b\">&lt;/p&gt;&lt;script&gt;&amp;&#39;\u{fffd}</p>\n";
        assert_eq!(page.finish(), expected);
    }
}
