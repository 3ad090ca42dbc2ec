//! Base64 text of an image in a JSON body: alone, or as a data URI (RFC 2397).

use std::borrow::Cow;
use std::fmt;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use imaging::codec::media_type_of;
use serde::de::{Deserialize, Deserializer, Error, Visitor};

/// The bytes of a file in base64, decoded while the text is read, so that the text is never copied.
#[derive(Clone, Debug)]
pub struct Base64Image(pub Bytes);

impl<'de> Deserialize<'de> for Base64Image {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_str(Base64Visitor)
    }
}

struct Base64Visitor;

impl Visitor<'_> for Base64Visitor {
    type Value = Base64Image;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a string")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Base64Image, E> {
        decode(text).map(Base64Image).map_err(E::custom)
    }
}

/// Reason why a text is not the file of an image.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DataUriError {
    #[error("is a data URI without data; write `data:image/png;base64,` before the base64")]
    NoData,
    #[error("is a data URI without `;base64`; encode the file's bytes as base64")]
    NotDeclaredBase64,
    #[error("is no base64; encode the file's bytes with padding")]
    NotBase64,
    #[error(
        "declares {declared:?}, but its bytes are {actual}; correct the media type, or send the base64 alone"
    )]
    OtherMediaType { declared: String, actual: &'static str },
}

/// The bytes of a text. Line breaks within base64 are skipped. A media type of an image must be that of the bytes.
///
/// # Errors
///
/// [`DataUriError`] for a text that is no base64, or whose media type is not that of the bytes.
pub fn decode(text: &str) -> Result<Bytes, DataUriError> {
    let text = text.trim();
    let is_uri = text.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"));
    let (declared, data) = if is_uri { split_uri(&text[5..])? } else { (String::new(), text) };
    let compact: Cow<'_, str> = match data.bytes().any(|byte| byte.is_ascii_whitespace()) {
        true => data.chars().filter(|c| !c.is_ascii_whitespace()).collect::<String>().into(),
        false => data.into(),
    };
    let bytes = STANDARD.decode(compact.as_bytes()).map(Bytes::from).map_err(|_| DataUriError::NotBase64)?;
    match media_type_of(&bytes) {
        Some(actual) if contradicts(&declared, actual) => {
            Err(DataUriError::OtherMediaType { declared, actual })
        }
        _ => Ok(bytes),
    }
}

/// The media type in lower case and the base64 text of a data URI without its scheme.
fn split_uri(rest: &str) -> Result<(String, &str), DataUriError> {
    let (head, data) = rest.split_once(',').ok_or(DataUriError::NoData)?;
    let mut parameters = head.split(';').map(str::trim);
    let media_type: String = parameters.next().unwrap_or_default().chars().take(80).collect();
    if !parameters.any(|parameter| parameter.eq_ignore_ascii_case("base64")) {
        return Err(DataUriError::NotDeclaredBase64);
    }
    Ok((media_type.to_ascii_lowercase(), data))
}

/// Whether a declared media type names another kind of file. None, and that of any bytes, name no kind.
fn contradicts(declared: &str, actual: &str) -> bool {
    let declared = if declared == "image/jpg" { "image/jpeg" } else { declared };
    !matches!(declared, "" | "application/octet-stream" | "image/*") && declared != actual
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_and_data_uris_give_their_bytes_or_say_what_is_wrong() {
        let png = imaging::codec::encode_png(&imaging::Image::filled(3, 2, [1, 2, 3, 255]));
        let base64 = STANDARD.encode(&png);
        let (first, second) = base64.split_at(20);
        for accepted in [
            base64.clone(),
            format!(" {base64}\n"),
            format!("{first}\r\n{second}"),
            format!("data:image/png;base64,{base64}"),
            format!("DATA:Image/PNG;name=table.png;BASE64, {base64}"),
            format!("data:;base64,{base64}"),
            format!("data:application/octet-stream;base64,{base64}"),
        ] {
            let shown = &accepted[..accepted.len().min(50)];
            assert_eq!(decode(&accepted).as_deref(), Ok(&png[..]), "{shown}");
        }
        for (refused, detail) in [
            ("%%%".to_owned(), "is no base64"),
            (format!("data:image/png,{base64}"), "without `;base64`"),
            ("data:image/png;base64".to_owned(), "without data"),
            ("data:image/png;base64,%%%".to_owned(), "is no base64"),
            (
                format!("data:image/jpeg;base64,{base64}"),
                "declares \"image/jpeg\", but its bytes are image/png",
            ),
            (
                format!("data:image/gif;base64,{base64}"),
                "declares \"image/gif\", but its bytes are image/png",
            ),
            (
                format!("data:text/html;base64,{base64}"),
                "declares \"text/html\", but its bytes are image/png",
            ),
        ] {
            let message = decode(&refused).expect_err("is refused").to_string();
            assert!(message.contains(detail), "{message}");
        }
        // What is no accepted image is refused by its bytes, whatever it declares.
        assert!(decode(&format!("data:image/png;base64,{}", STANDARD.encode("GIF89a"))).is_ok());
    }
}
