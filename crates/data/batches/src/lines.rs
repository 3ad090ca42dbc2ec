//! Requests as JSON lines, read one at a time.
//!
//! Each line is `{"custom_id": "...", "body": {...}}`. A line that will not do is an error with its number, and reading
//! goes on with the next. Memory is bounded by the longest line that is allowed; longer lines are skipped unread.

use std::io::{BufRead, ErrorKind};

use super::json_error;
use super::output::OutputError;
use super::request::BatchRequest;

/// Longest line that is read, bytes.
pub const MAX_LINE_BYTES: usize = 1 << 20;

/// A line of the file that is not empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// From 1.
    pub number: u64,
    pub content: Result<BatchRequest, LineError>,
}

/// A line that is no request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineError {
    /// The name of the request, where it can be read.
    pub custom_id: Option<String>,
    pub error: Box<OutputError>,
}

/// Reads requests from a text.
#[derive(Debug)]
pub struct LineReader<R> {
    source: R,
    number: u64,
    buffer: Vec<u8>,
}

impl<R: BufRead> LineReader<R> {
    pub fn new(source: R) -> Self {
        Self { source, number: 0, buffer: Vec::new() }
    }

    /// Reads the next line into the buffer: `None` at the end of the text, `false` if the line is too long.
    fn fill(&mut self) -> std::io::Result<Option<bool>> {
        self.buffer.clear();
        let (mut has_begun, mut fits) = (false, true);
        loop {
            let available = match self.source.fill_buf() {
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                available => available?,
            };
            if available.is_empty() {
                return Ok(has_begun.then_some(fits));
            }
            has_begun = true;
            let end = available.iter().position(|byte| *byte == b'\n');
            let part = &available[..end.unwrap_or(available.len())];
            fits &= self.buffer.len() + part.len() <= MAX_LINE_BYTES;
            if fits {
                self.buffer.extend_from_slice(part);
            }
            let used = part.len() + usize::from(end.is_some());
            self.source.consume(used);
            if end.is_some() {
                return Ok(Some(fits));
            }
        }
    }
}

impl<R: BufRead> Iterator for LineReader<R> {
    /// An error of the reader ends the text.
    type Item = std::io::Result<Line>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let fits = match self.fill() {
                Ok(fits) => fits?,
                Err(error) => return Some(Err(error)),
            };
            self.number += 1;
            let number = self.number;
            if !fits {
                let message = format!("the line is longer than {MAX_LINE_BYTES} bytes");
                let error = OutputError::new("line_too_long", message).on_line(number);
                let content = Err(LineError { custom_id: None, error: Box::new(error) });
                return Some(Ok(Line { number, content }));
            }
            // Some editors begin a file with a byte order mark.
            let text = self.buffer.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&self.buffer);
            if !text.trim_ascii().is_empty() {
                return Some(Ok(Line { number, content: request(text, number) }));
            }
        }
    }
}

/// Objects within a line.
const OBJECTS: [&str; 5] =
    ["/body", "/body/image", "/body/options", "/body/options/table", "/body/options/metric_anchor"];

/// The request of one line.
fn request(text: &[u8], number: u64) -> Result<BatchRequest, LineError> {
    let parsed: Result<BatchRequest, _> = json_error::parse(text, &OBJECTS);
    match parsed {
        Ok(request) => match request.violations().into_iter().next() {
            None => Ok(request),
            Some(violation) => {
                let error = OutputError::new("invalid_request", violation.detail).on_line(number);
                let custom_id = Some(request.custom_id);
                Err(LineError { custom_id, error: Box::new(error.at(violation.pointer)) })
            }
        },
        Err(found) => {
            let code = if found.is_malformed { "malformed_json" } else { "invalid_request" };
            let error = OutputError {
                column: (found.column > 0).then_some(found.column as u64),
                ..OutputError::new(code, found.detail).on_line(number)
            };
            let error = if found.is_malformed { error } else { error.at(found.pointer) };
            Err(LineError { custom_id: custom_id(text), error: Box::new(error) })
        }
    }
}

/// The name of a request that is wrong elsewhere.
fn custom_id(text: &[u8]) -> Option<String> {
    let value: serde_json::Value = serde_json::from_slice(text).ok()?;
    value["custom_id"].as_str().map(|name| name.chars().take(64).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &[u8]) -> Vec<Line> {
        LineReader::new(text).map(|line| line.expect("no error of the reader")).collect()
    }

    #[test]
    fn lines_are_requests_with_their_numbers() {
        let text = "\u{feff}{\"custom_id\":\"a\",\"body\":{\"text\":\"a mug\",\"seed\":7}}\r\n\n  \n\
                    {\"body\":{\"text\":\"two cups\",\"labels\":{\"k\":\"v\"}},\"custom_id\":\"b\"}";
        let lines = read(text.as_bytes());
        let read: Vec<_> =
            lines.iter().map(|line| (line.number, line.content.as_ref().expect("fits"))).collect();
        assert_eq!(read.len(), 2);
        assert_eq!((read[0].0, read[0].1.custom_id.as_str(), read[0].1.body.seed), (1, "a", Some(7)));
        assert_eq!((read[1].0, read[1].1.custom_id.as_str()), (4, "b"));
        assert_eq!(read[1].1.body.labels["k"], "v");
        assert!(read_is_empty(b"") && read_is_empty(b"\n\n"));
    }

    fn read_is_empty(text: &[u8]) -> bool {
        read(text).is_empty()
    }

    #[test]
    fn a_wrong_line_states_its_place_and_the_others_are_read() {
        let good = r#"{"custom_id":"good","body":{"text":"a mug"}}"#;
        /// Line, code, column, pointer, words of the message.
        type Case = (&'static str, &'static str, Option<u64>, Option<&'static str>, &'static str);
        let cases: [Case; 12] = [
            (r#"{"custom_id":"a","body":{"text":"a mug"}"#, "malformed_json", Some(40), None, "EOF"),
            (r#"{"custom_id":"a" "body":{}}"#, "malformed_json", Some(18), None, "expected"),
            (r#"{"custom_id":"a","body":{"text":"a mug"}} x"#, "malformed_json", Some(43), None, "trailing"),
            ("nonsense", "malformed_json", Some(2), None, "expected"),
            (r#"{"custom_id":"a"}"#, "invalid_request", Some(17), Some(""), "must have `body`"),
            (r#"{"body":{"text":"a mug"}}"#, "invalid_request", Some(25), Some(""), "must have `custom_id`"),
            (r#"["a"]"#, "invalid_request", Some(1), Some(""), "not a list"),
            (
                r#"{"custom_id":"a","body":{"txet":"a mug"}}"#,
                "invalid_request",
                Some(31),
                Some("/body/txet"),
                "`text`",
            ),
            (
                r#"{"custom_id":"a","body":{"text":7}}"#,
                "invalid_request",
                Some(33),
                Some("/body/text"),
                "must be a string, not integer `7`",
            ),
            (
                r#"{"custom_id":"a","body":{"text":"a mug","options":{"max_objects":"3"}}}"#,
                "invalid_request",
                Some(68),
                Some("/body/options/max_objects"),
                "must be a whole number",
            ),
            (
                r#"{"custom_id":"a","body":{"text":"a mug","options":{"max_objects":99}}}"#,
                "invalid_request",
                None,
                Some("/body/options/max_objects"),
                "from 1 to 64",
            ),
            (
                r#"{"custom_id":"a b","body":{"text":"a mug"}}"#,
                "invalid_request",
                None,
                Some("/custom_id"),
                "A-Z",
            ),
        ];
        for (wrong, code, column, pointer, says) in cases {
            let lines = read(format!("{good}\n{wrong}\n{good}\n").as_bytes());
            assert_eq!(lines.len(), 3, "{wrong}");
            assert!(lines[0].content.is_ok() && lines[2].content.is_ok(), "{wrong}");
            let error = &lines[1].content.as_ref().expect_err(wrong).error;
            assert_eq!((error.line, error.code.as_str()), (Some(2), code), "{wrong}: {error:?}");
            assert_eq!((error.column, error.pointer.as_deref()), (column, pointer), "{wrong}: {error:?}");
            assert!(error.message.contains(says), "{wrong}: {}", error.message);
        }
    }

    #[test]
    fn the_name_of_a_wrong_request_is_kept_where_it_can_be_read() {
        let name = |line: &str| read(line.as_bytes())[0].content.clone().expect_err("wrong").custom_id;
        assert_eq!(name(r#"{"custom_id":"a","body":{"seed":"x"}}"#).as_deref(), Some("a"));
        assert_eq!(name(r#"{"custom_id":"a","body":"#), None);
    }

    #[test]
    fn a_line_that_is_too_long_is_skipped() {
        let mut text = vec![b'x'; 3 * MAX_LINE_BYTES];
        text.extend_from_slice(b"\n{\"custom_id\":\"a\",\"body\":{\"text\":\"a mug\"}}\n");
        let mut reader = LineReader::new(std::io::BufReader::with_capacity(4096, text.as_slice()));
        let first = reader.next().expect("a line").expect("read");
        assert_eq!(first.content.expect_err("too long").error.code, "line_too_long");
        assert!(reader.buffer.capacity() <= 2 * MAX_LINE_BYTES);
        let second = reader.next().expect("a line").expect("read");
        assert_eq!((second.number, second.content.expect("fits").custom_id.as_str()), (2, "a"));
        assert!(reader.next().is_none());
    }

    #[test]
    fn bytes_that_are_no_text_are_an_error_of_their_line() {
        let lines = read(b"{\"custom_id\":\"a\",\"body\":{\"text\":\"\xff\"}}\n");
        assert_eq!(lines[0].content.as_ref().expect_err("no UTF-8").error.line, Some(1));
    }
}
