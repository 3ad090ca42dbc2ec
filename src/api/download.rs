//! Immutable bytes on their way out: strong `ETag` (the digest), `If-None-Match`, single ranges,
//! streamed from the store.

use std::ops::Range;

use axum::body::Body;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};

use super::Api;
use super::error::{Problem, ProblemType};
use store::Digest;

/// What to send.
pub struct Download<'a> {
    pub digest: &'a Digest,
    /// Bytes.
    pub size: u64,
    pub media_type: &'a str,
    /// Suggested name; `None` shows it in place.
    pub file_name: Option<String>,
}

/// The response to a request with these headers.
pub async fn respond(api: &Api, headers: &HeaderMap, what: Download<'_>) -> Result<Response, Problem> {
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
    set(header::CONTENT_TYPE, what.media_type);
    // Model output and user text may be in there; a browser must not run it.
    set(header::CONTENT_SECURITY_POLICY, "sandbox; default-src 'none'");
    if let Some(name) = &what.file_name {
        set(header::CONTENT_DISPOSITION, &format!("attachment; filename=\"{name}\""));
    }
    if matches(headers, header::IF_NONE_MATCH, &etag) {
        fields.remove(header::CONTENT_TYPE);
        return Ok((StatusCode::NOT_MODIFIED, fields).into_response());
    }
    let wanted = headers.get(header::RANGE).and_then(|range| range.to_str().ok());
    let still_same = !headers.contains_key(header::IF_RANGE) || matches(headers, header::IF_RANGE, &etag);
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
            return Ok(response);
        }
    };
    let Some(stream) = api.store.blobs().stream(what.digest, range.clone()).await? else {
        return Err(Problem::new(
            ProblemType::Internal,
            "stored_data_missing",
            "the stored bytes are gone; retry the scene's job to make them again",
        ));
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
    Ok((status, fields, Body::from_stream(stream)).into_response())
}

/// Whether a list of entity tags holds `etag` (compared weakly) or `*`.
fn matches(headers: &HeaderMap, name: header::HeaderName, etag: &str) -> bool {
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
