//! Multipart forms (RFC 7578). Equal parts give equal bytes: the boundary is a digest of the parts.

use bytes::Bytes;
use sha2::{Digest as _, Sha256};

/// A form under construction.
#[derive(Clone, Debug, Default)]
pub struct Form {
    parts: Vec<(String, Bytes)>,
}

impl Form {
    /// A field of text. `name` is a plain word.
    pub fn text(mut self, name: &str, value: &str) -> Self {
        let head = format!("Content-Disposition: form-data; name=\"{name}\"\r\n\r\n");
        self.parts.push((head, Bytes::copy_from_slice(value.as_bytes())));
        self
    }

    /// A file. `name` and `file_name` are plain words.
    pub fn file(mut self, name: &str, file_name: &str, content_type: &str, bytes: Bytes) -> Self {
        let head = format!(
            "Content-Disposition: form-data; name=\"{name}\"; filename=\"{file_name}\"\r\n\
             Content-Type: {content_type}\r\n\r\n"
        );
        self.parts.push((head, bytes));
        self
    }

    /// The content type with the boundary, and the body.
    pub fn encoded(&self) -> (String, Bytes) {
        let mut digest = Sha256::new();
        for (head, bytes) in &self.parts {
            digest.update((head.len() as u64).to_le_bytes());
            digest.update(head);
            digest.update((bytes.len() as u64).to_le_bytes());
            digest.update(bytes);
        }
        let digest = runtime::digest::hex(&digest.finalize()[..16]);
        let boundary = format!("part-{digest}");
        let mut body = Vec::new();
        for (head, bytes) in &self.parts {
            body.extend_from_slice(format!("--{boundary}\r\n{head}").as_bytes());
            body.extend_from_slice(bytes);
            body.extend_from_slice(b"\r\n");
        }
        body.extend_from_slice(format!("--{boundary}--\r\n").as_bytes());
        (format!("multipart/form-data; boundary={boundary}"), body.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoded_form_follows_rfc_7578() {
        let png = Bytes::from_static(b"\x89PNG\r\n\x1a\n--part-");
        let form = Form::default().text("model", "m").file("image[]", "0.png", "image/png", png);
        let (content_type, body) = form.encoded();
        let boundary = content_type.strip_prefix("multipart/form-data; boundary=").expect("is a form");
        let expected = format!(
            "--{boundary}\r\nContent-Disposition: form-data; name=\"model\"\r\n\r\nm\r\n--{boundary}\r\n\
             Content-Disposition: form-data; name=\"image[]\"; filename=\"0.png\"\r\nContent-Type: image/png\r\n\r\n\
             PNG\r\n\x1a\n--part-\r\n--{boundary}--\r\n"
        );
        let mut expected = expected.into_bytes();
        let at = expected.windows(3).position(|window| window == b"PNG").expect("is there");
        expected.insert(at, 0x89);
        assert_eq!(body, expected);
        assert_eq!(form.encoded(), (content_type, body));
        assert_ne!(Form::default().text("model", "n").encoded().0, form.encoded().0);
    }
}
