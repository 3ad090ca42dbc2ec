//! Writer of HTML that is also well-formed XML. Every text and attribute is escaped.

/// A page under construction. Elements are closed in the order they were opened.
#[derive(Default)]
pub struct Html {
    text: String,
    open: Vec<&'static str>,
}

/// Content of a table cell.
pub enum Cell {
    /// Text of this program.
    Words(String),
    /// Text of a user or a model, isolated from the text direction of its surroundings (`<bdi>`).
    UserText(String),
    Number(String),
    /// A number that failed its check.
    Bad(String),
    /// Whether a check passed.
    Mark(bool),
    /// A name that links to a body's row.
    Body(String),
}

impl Html {
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
            self.text.push('>');
            if !matches!(tag, "span" | "bdi" | "code" | "td" | "th" | "b" | "text" | "title" | "a") {
                self.text.push('\n');
            }
        }
    }

    /// An element that never has content (`img`, `meta`, `rect`).
    pub fn void(&mut self, tag: &'static str, attributes: &[(&str, &str)]) {
        self.start(tag, attributes);
        self.text.push_str(" />");
    }

    /// Text inside the innermost open element.
    pub fn text(&mut self, text: &str) {
        push_escaped(&mut self.text, text);
    }

    /// An element that holds only text.
    pub fn leaf(&mut self, tag: &'static str, attributes: &[(&str, &str)], text: &str) {
        self.open(tag, attributes);
        self.text(text);
        self.close();
    }

    /// Text of a user or a model.
    pub fn user_text(&mut self, text: &str) {
        self.leaf("bdi", &[], text);
    }

    /// A style sheet of this program. It is not escaped, so it must not contain text of users or models.
    pub fn style(&mut self, sheet: &'static str) {
        self.text.push_str("<style>\n");
        self.text.push_str(sheet);
        self.text.push_str("</style>\n");
    }

    /// A table.
    pub fn table(&mut self, class: &str, head: &[&str], rows: Vec<Vec<Cell>>) {
        self.open("div", &[("class", "scroll")]);
        self.open("table", &[("class", class)]);
        self.open("thead", &[]);
        self.open("tr", &[]);
        for (column, title) in head.iter().enumerate() {
            let first = rows.first().and_then(|row| row.get(column));
            self.heading(title, matches!(first, Some(Cell::Number(_) | Cell::Bad(_))));
        }
        self.close();
        self.close();
        self.open("tbody", &[]);
        for row in rows {
            self.open("tr", &[]);
            row.into_iter().for_each(|cell| self.cell(cell));
            self.close();
        }
        (0..3).for_each(|_| self.close());
    }

    /// The title of a column, right-aligned above numbers.
    pub fn heading(&mut self, title: &str, numbers: bool) {
        let class = if numbers { "n" } else { "words" };
        self.leaf("th", &[("scope", "col"), ("class", class)], title);
    }

    /// Closes the open elements and returns the text.
    pub fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        self.text
    }

    fn cell(&mut self, cell: Cell) {
        match cell {
            Cell::Words(words) => self.leaf("td", &[], &words),
            Cell::UserText(words) => {
                self.open("td", &[("class", "told")]);
                self.user_text(&words);
                self.close();
            }
            Cell::Number(number) => self.leaf("td", &[("class", "n")], &number),
            Cell::Bad(number) => self.leaf("td", &[("class", "n bad")], &number),
            Cell::Mark(true) => self.leaf("td", &[("class", "mark good")], "✓ pass"),
            Cell::Mark(false) => self.leaf("td", &[("class", "mark bad")], "✗ fail"),
            Cell::Body(name) => {
                self.open("td", &[]);
                self.leaf("a", &[("href", &format!("#{name}"))], &name);
                self.close();
            }
        }
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
            '\r' => page.push_str("&#13;"),
            '\n' | '\t' => page.push(c),
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
    fn user_text_is_escaped() {
        let mut page = Html::default();
        page.open("p", &[("title", "a\"b<c>&'d")]);
        page.user_text("</p><script>alert(1)</script> ]]> 🍎\u{7}\u{202e}");
        let text = page.finish();
        let expected = "<p title=\"a&quot;b&lt;c&gt;&amp;&#39;d\"><bdi>&lt;/p&gt;&lt;script&gt;alert(1)\
                        &lt;/script&gt; ]]&gt; 🍎\u{fffd}\u{202e}</bdi></p>\n";
        assert_eq!(text, expected);
    }
}
