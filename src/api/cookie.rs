//! The cookie of a session.
//!
//! Scripts cannot read it, and pages of other sites do not send it. Where the server is reached by https, its name has
//! the prefix `__Host-`, so that neither a page of another host nor one of plain http can set it.

use axum::http::{HeaderMap, HeaderValue, header};

use store::secret::Secret;

/// Form of the cookie of a server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionCookie {
    is_secure: bool,
}

impl SessionCookie {
    /// The form for a server with this public address (`server.public_url`).
    pub fn new(public_url: &str) -> Self {
        Self { is_secure: public_url.starts_with("https://") }
    }

    pub fn name(self) -> &'static str {
        if self.is_secure { "__Host-tt_session" } else { "tt_session" }
    }

    /// The session that a request names.
    pub fn read(self, headers: &HeaderMap) -> Option<Secret> {
        let lists = headers.get_all(header::COOKIE).into_iter().filter_map(|list| list.to_str().ok());
        let mut pairs = lists.flat_map(|list| list.split(';')).filter_map(|pair| pair.trim().split_once('='));
        pairs.find(|(name, _)| *name == self.name()).map(|(_, value)| Secret::given(value))
    }

    /// The header that hands out a session for so many seconds.
    pub fn write(self, session: &Secret, seconds: i64) -> Option<HeaderValue> {
        self.header(session.expose(), seconds)
    }

    /// The header that makes a browser forget its session.
    pub fn remove(self) -> Option<HeaderValue> {
        self.header("", 0)
    }

    fn header(self, value: &str, seconds: i64) -> Option<HeaderValue> {
        let secure = if self.is_secure { "; Secure" } else { "" };
        let text =
            format!("{}={value}; HttpOnly; SameSite=Strict; Path=/; Max-Age={seconds}{secure}", self.name());
        let mut header = HeaderValue::try_from(text).ok()?;
        header.set_sensitive(true);
        Some(header)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cookie_is_read_as_it_was_written() {
        for (url, name, end) in [
            ("", "tt_session", "Max-Age=43200"),
            ("http://scenes.lan", "tt_session", "Max-Age=43200"),
            ("https://scenes.example.org", "__Host-tt_session", "Max-Age=43200; Secure"),
        ] {
            let cookie = SessionCookie::new(url);
            let secret = Secret::new_session().expect("random");
            let written = cookie.write(&secret, 43_200).expect("a header");
            let written = written.to_str().expect("ASCII");
            assert_eq!(
                written,
                format!("{name}={}; HttpOnly; SameSite=Strict; Path=/; {end}", secret.expose())
            );
            let mut headers = HeaderMap::new();
            headers.append(header::COOKIE, "theme=dark; tt_sessions=x".parse().expect("a value"));
            assert_eq!(cookie.read(&headers), None);
            let pair = written.split(';').next().expect("a pair");
            headers.append(header::COOKIE, format!("a=b; {pair}").parse().expect("a value"));
            assert_eq!(cookie.read(&headers), Some(secret));
        }
        let secure = SessionCookie::new("https://a.example");
        let mut headers = HeaderMap::new();
        headers.append(header::COOKIE, "tt_session=x".parse().expect("a value"));
        assert_eq!(secure.read(&headers), None, "a page of plain http can set that one");
    }
}
