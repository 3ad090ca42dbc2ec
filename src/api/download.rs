//! Immutable bytes on their way out: strong `ETag` (the digest), `If-None-Match`, single ranges,
//! streamed from the store, or sent by the bucket that a redirect names. Bytes that are gone or damaged have no
//! response; their scene makes them again.

use std::ops::Range;

use axum::body::Body;
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;

use super::Api;
use super::pieces::{self, Piece};
use crate::problem::{Problem, ProblemType};
use store::Digest;

/// Content of a download, and its headers.
pub struct Download<'a> {
    pub digest: &'a Digest,
    /// Bytes.
    pub size: u64,
    pub media_type: &'a str,
    /// Suggested name; `None` shows it in place.
    pub file_name: Option<String>,
    pub content: Content,
}

/// Place of the bytes.
pub enum Content {
    /// In the blob with the digest.
    Stored,
    Memory(Bytes),
    /// In several pieces, whose digest the caller knows.
    Pieces(Vec<Piece>),
    /// In pieces, from this byte of theirs on.
    Within(Vec<Piece>, u64),
}

/// The response to a request with this method and these headers; `None` if the stored bytes are missing or damaged.
pub async fn respond(
    api: &Api,
    method: &Method,
    headers: &HeaderMap,
    what: Download<'_>,
) -> Result<Option<Response>, Problem> {
    let etag = format!("\"{}\"", what.digest);
    let mut fields = HeaderMap::new();
    let mut set = |name: header::HeaderName, value: &str| {
        if let Ok(value) = HeaderValue::from_str(value) {
            fields.insert(name, value);
        }
    };
    set(header::ETAG, &etag);
    set(header::CACHE_CONTROL, "private, no-cache");
    set(header::ACCEPT_RANGES, "bytes");
    set(header::CONTENT_TYPE, served_as(headers, what.media_type));
    // Model output and user text may be in there; a browser must not run it.
    set(header::CONTENT_SECURITY_POLICY, "sandbox; default-src 'none'");
    let disposition = what.file_name.as_ref().map(|name| format!("attachment; filename=\"{name}\""));
    if let Some(disposition) = &disposition {
        set(header::CONTENT_DISPOSITION, disposition);
    }
    if has_tag(headers, header::IF_NONE_MATCH, &etag) {
        fields.remove(header::CONTENT_TYPE);
        return Ok(Some((StatusCode::NOT_MODIFIED, fields).into_response()));
    }
    // The address is signed for GET.
    if method == Method::GET && matches!(what.content, Content::Stored) && !is_part_of_page(headers) {
        let address =
            api.store.blobs().presigned(what.digest, what.media_type, disposition.as_deref()).await?;
        if let Some(Ok(address)) = address.map(|address| HeaderValue::from_str(&address)) {
            let fields = [
                (header::LOCATION, address),
                // The address ends; a client that asks again gets another.
                (header::CACHE_CONTROL, HeaderValue::from_static("private, no-store")),
            ];
            return Ok(Some((StatusCode::TEMPORARY_REDIRECT, fields).into_response()));
        }
    }
    let wanted = headers.get(header::RANGE).and_then(|range| range.to_str().ok());
    let still_same = !headers.contains_key(header::IF_RANGE) || has_tag(headers, header::IF_RANGE, &etag);
    let range = match wanted.filter(|_| still_same).map(|text| parse_range(text, what.size)) {
        None | Some(Wanted::Everything) => None,
        Some(Wanted::Part(range)) => Some(range),
        Some(Wanted::Outside) => {
            let mut response = Problem::new(
                ProblemType::RangeNotSatisfiable,
                "range_not_satisfiable",
                format!("there are {} bytes", what.size),
            )
            .into_response();
            if let Ok(value) = HeaderValue::from_str(&format!("bytes */{}", what.size)) {
                response.headers_mut().insert(header::CONTENT_RANGE, value);
            }
            return Ok(Some(response));
        }
    };
    let body = match what.content {
        Content::Memory(bytes) => Body::from(match &range {
            Some(range) => bytes.slice(range.start as usize..range.end as usize),
            None => bytes,
        }),
        Content::Pieces(pieces) => {
            pieces::body(api.store.clone(), pieces, range.clone().unwrap_or(0..what.size))
        }
        Content::Within(pieces, start) => {
            let part = range.clone().unwrap_or(0..what.size);
            pieces::body(api.store.clone(), pieces, start + part.start..start + part.end)
        }
        Content::Stored => match api.store.blobs().stream(what.digest, range.clone()).await? {
            Some(stream) => Body::from_stream(stream),
            None => return Ok(None),
        },
    };
    let (status, length) = match &range {
        Some(range) => (StatusCode::PARTIAL_CONTENT, range.end - range.start),
        None => (StatusCode::OK, what.size),
    };
    fields.insert(header::CONTENT_LENGTH, HeaderValue::from(length));
    if let Some(range) = &range
        && let Ok(value) =
            HeaderValue::from_str(&format!("bytes {}-{}/{}", range.start, range.end - 1, what.size))
    {
        fields.insert(header::CONTENT_RANGE, value);
    }
    Ok(Some((status, fields, body).into_response()))
}

/// Whether a page of this server loads the bytes into itself, which its policy lets it do from this server alone. Links
/// that it follows may lead to the bucket.
fn is_part_of_page(headers: &HeaderMap) -> bool {
    let is =
        |name: &str, value: &str| headers.get(name).is_some_and(|field| field.as_bytes() == value.as_bytes());
    is("sec-fetch-site", "same-origin") && !is("sec-fetch-mode", "navigate")
}

/// The media type of bytes of `media_type` for a client with these headers: `application/octet-stream` where it accepts
/// that and not the type itself, as generated clients do; else the type.
pub fn served_as<'a>(headers: &HeaderMap, media_type: &'a str) -> &'a str {
    const ANY_BYTES: &str = "application/octet-stream";
    let group = media_type.split('/').next().unwrap_or_default();
    let lists = headers.get_all(header::ACCEPT).into_iter().filter_map(|value| value.to_str().ok());
    let (mut itself, mut any_bytes) = (false, false);
    for range in lists.flat_map(|list| list.split(',')) {
        let range = range.split(';').next().unwrap_or_default().trim().to_ascii_lowercase();
        let is_group = range.strip_suffix("/*").is_some_and(|wanted| wanted == "*" || wanted == group);
        itself |= is_group || media_type.split(';').next() == Some(range.as_str());
        any_bytes |= range == ANY_BYTES;
    }
    if any_bytes && !itself { ANY_BYTES } else { media_type }
}

/// Whether a list of entity tags holds `etag` (compared weakly) or `*`.
pub(super) fn has_tag(headers: &HeaderMap, name: header::HeaderName, etag: &str) -> bool {
    let lists = headers.get_all(name).into_iter().filter_map(|value| value.to_str().ok());
    lists
        .flat_map(|list| list.split(','))
        .map(|tag| tag.trim())
        .any(|tag| tag == "*" || tag.strip_prefix("W/").unwrap_or(tag) == etag)
}

#[derive(Debug, PartialEq)]
enum Wanted {
    Everything,
    Part(Range<u64>),
    Outside,
}

/// One range of bytes; several, other units and nonsense are answered with everything, as RFC 9110 allows.
fn parse_range(text: &str, size: u64) -> Wanted {
    let Some(spec) = text.strip_prefix("bytes=") else { return Wanted::Everything };
    let Some((first, last)) = spec.trim().split_once('-') else { return Wanted::Everything };
    let number = |text: &str| text.bytes().all(|b| b.is_ascii_digit()).then(|| text.parse::<u64>().ok())?;
    match (first, last) {
        ("", last) => match number(last) {
            Some(0) => Wanted::Outside,
            Some(_) if size == 0 => Wanted::Outside,
            Some(count) => Wanted::Part(size.saturating_sub(count)..size),
            None => Wanted::Everything,
        },
        (first, "") => match number(first) {
            Some(first) if first < size => Wanted::Part(first..size),
            Some(_) => Wanted::Outside,
            None => Wanted::Everything,
        },
        (first, last) => match (number(first), number(last)) {
            (Some(first), Some(last)) if first > last => Wanted::Everything,
            (Some(first), Some(_)) if first >= size => Wanted::Outside,
            (Some(first), Some(last)) => Wanted::Part(first..last.saturating_add(1).min(size)),
            _ => Wanted::Everything,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_served_in_their_media_type_unless_any_bytes_are_wanted() {
        for (accept, expected) in [
            (None, "image/png"),
            (Some("*/*"), "image/png"),
            (Some("image/png"), "image/png"),
            (Some("application/octet-stream, image/*;q=0.1"), "image/png"),
            (Some("text/html"), "image/png"),
            (Some("application/octet-stream"), "application/octet-stream"),
            (Some("text/html, Application/Octet-Stream;q=0.5"), "application/octet-stream"),
        ] {
            let mut headers = HeaderMap::new();
            if let Some(accept) = accept {
                headers.insert(header::ACCEPT, HeaderValue::from_static(accept));
            }
            assert_eq!(served_as(&headers, "image/png"), expected, "{accept:?}");
        }
    }

    #[test]
    fn what_a_page_loads_into_itself_comes_from_this_server() {
        for (site, mode, expected) in [
            ("same-origin", "no-cors", true),
            ("same-origin", "cors", true),
            ("same-origin", "navigate", false),
            ("none", "navigate", false),
            ("", "", false),
        ] {
            let fields = [("sec-fetch-site", site), ("sec-fetch-mode", mode)];
            let fields = fields.into_iter().filter(|(_, value)| !value.is_empty());
            let headers = fields.map(|(name, value)| {
                (header::HeaderName::from_static(name), HeaderValue::from_static(value))
            });
            assert_eq!(is_part_of_page(&HeaderMap::from_iter(headers)), expected, "{site} {mode}");
        }
    }

    #[test]
    fn ranges_as_rfc_9110_has_them() {
        assert_eq!(parse_range("bytes=0-3", 10), Wanted::Part(0..4));
        assert_eq!(parse_range("bytes=8-99", 10), Wanted::Part(8..10));
        assert_eq!(parse_range("bytes=4-", 10), Wanted::Part(4..10));
        assert_eq!(parse_range("bytes=-3", 10), Wanted::Part(7..10));
        assert_eq!(parse_range("bytes=-30", 10), Wanted::Part(0..10));
        assert_eq!(parse_range("bytes=10-", 10), Wanted::Outside);
        assert_eq!(parse_range("bytes=-0", 10), Wanted::Outside);
        for all in ["bytes=5-2", "bytes=0-1,4-5", "lines=1-2", "bytes=a-b", "bytes=", "bytes=--1"] {
            assert_eq!(parse_range(all, 10), Wanted::Everything, "{all}");
        }
        assert_eq!(parse_range("bytes=0-18446744073709551615", 10), Wanted::Part(0..10));
    }
}
