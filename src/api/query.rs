//! Query parameters: a typed extractor, and the types of the parameters that several routes have.

use crate::problem::{Problem, ProblemType};
use crate::schemas::in_place;
use crate::schemas::values::{LABEL_PATTERN, MAX_INTEGER};
use axum::extract::FromRequestParts;
use axum::extract::Query;
use axum::http::request::Parts;
use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use uuid::Uuid;

use scene::TenantId;
use scene::id::InvalidId;
use scene::labels::is_label;

/// The parameters of a query as a struct, which should deny unknown fields. A parameter that is unknown, repeated or
/// invalid gives the problem `invalid_parameter`.
pub struct Parameters<T>(pub T);

impl<T: DeserializeOwned, S: Sync> FromRequestParts<S> for Parameters<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Problem> {
        match Query::try_from_uri(&parts.uri) {
            Ok(Query(parameters)) => Ok(Self(parameters)),
            Err(rejection) => {
                // The source names the parameter; the rejection itself repeats it behind a fixed sentence.
                let reason = std::error::Error::source(&rejection)
                    .map_or_else(|| rejection.body_text(), ToString::to_string);
                Err(invalid_parameter(&reason))
            }
        }
    }
}

/// No parameters: a query with any is refused, so that nothing is enqueued for one who meant something else.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NoParameters {}

/// The refusal of a query of which a parameter will not do.
pub fn invalid_parameter(reason: &str) -> Problem {
    let detail = format!("query parameters: {reason}");
    Problem::new(ProblemType::MalformedRequest, "invalid_parameter", detail)
}

/// Number of items of a page, 1 to 200; 50 if absent.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(try_from = "String")]
pub struct PageSize(u32);

impl PageSize {
    pub fn get(self) -> u32 {
        self.0
    }

    /// Rows to read for a page: one more than it has, which tells whether another page follows.
    pub fn rows_to_read(self) -> u32 {
        self.0 + 1
    }

    /// The page of [`Self::rows_to_read`] rows; `token_after` is the token of the page behind a row.
    pub fn page_of<T>(self, mut rows: Vec<T>, token_after: impl FnOnce(&T) -> Option<PageToken>) -> Page<T> {
        let size = self.0 as usize;
        let is_last = rows.len() <= size;
        rows.truncate(size);
        let token = rows.last().filter(|_| !is_last).and_then(token_after);
        Page { rows, next_page_token: token.map(|token| token.to_string()) }
    }
}

impl Default for PageSize {
    fn default() -> Self {
        Self(50)
    }
}

impl TryFrom<String> for PageSize {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let size = text.parse().ok().filter(|size| (1..=200).contains(size));
        size.map(Self).ok_or("must be a whole number from 1 to 200")
    }
}

/// The rows of a page of a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Page<T> {
    pub rows: Vec<T>,
    /// `None` on the last page.
    pub next_page_token: Option<String>,
}

/// Opaque token that continues a list after the row with this id. The contract states its form exactly: 128 bits.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(try_from = "String")]
pub struct PageToken(Uuid);

impl PageToken {
    /// The token of the page after the row with this id; ids of the store are UUIDs.
    pub fn after(id: &str) -> Option<Self> {
        Uuid::parse_str(id).ok().map(Self)
    }

    /// The last id of the page before.
    pub fn last_id<T: TryFrom<String>>(self) -> Option<T> {
        T::try_from(self.0.to_string()).ok()
    }
}

impl std::fmt::Display for PageToken {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&URL_SAFE_NO_PAD.encode(self.0))
    }
}

impl TryFrom<String> for PageToken {
    type Error = &'static str;

    fn try_from(token: String) -> Result<Self, Self::Error> {
        let bytes = URL_SAFE_NO_PAD.decode(token).ok();
        bytes
            .and_then(|bytes| Uuid::from_slice(&bytes).ok())
            .map(Self)
            .ok_or("take it from `next_page_token` of the page before, unchanged")
    }
}

/// Id of a scene that a list is filtered by.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(try_from = "String")]
pub struct IdFilter(Uuid);

impl IdFilter {
    /// The id as the store writes it.
    pub fn id<T: TryFrom<String>>(self) -> Option<T> {
        T::try_from(self.0.to_string()).ok()
    }
}

impl TryFrom<String> for IdFilter {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        // Of the forms of a UUID the contract has only the one with hyphens.
        let hyphenated = text.len() == 36;
        let id = hyphenated.then(|| Uuid::parse_str(&text).ok()).flatten();
        id.map(Self).ok_or("must be an id, a UUID such as 0192f3a4-5b6c-7d8e-9fa0-b1c2d3e4f5a6")
    }
}

/// The tenant that an administrator asks about.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(try_from = "String")]
pub struct TenantFilter(TenantId);

impl TenantFilter {
    pub fn id(self) -> TenantId {
        self.0
    }
}

impl TryFrom<String> for TenantFilter {
    type Error = InvalidId;

    fn try_from(text: String) -> Result<Self, InvalidId> {
        text.parse().map(Self)
    }
}

/// A label that scenes must have, `key:value`.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(try_from = "String")]
pub struct LabelFilter {
    pub key: String,
    pub value: String,
}

impl TryFrom<String> for LabelFilter {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let (key, value) = text
            .split_once(':')
            .filter(|(key, value)| is_label(key, value))
            .ok_or("must be `key:value`, with a key and a value that labels may have")?;
        Ok(Self { key: key.to_owned(), value: value.to_owned() })
    }
}

/// Words that a text must have: 1 to 8 with spaces between them, of 200 characters together.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(try_from = "String")]
pub struct TextFilter(Vec<String>);

impl TextFilter {
    pub fn words(self) -> Vec<String> {
        self.0
    }
}

impl TryFrom<String> for TextFilter {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
        let fits =
            (1..=8).contains(&words.len()) && text.chars().count() <= 200 && !text.contains(char::is_control);
        fits.then_some(Self(words)).ok_or("must be 1 to 8 words, with at most 200 characters together")
    }
}

/// A category of the catalog.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(try_from = "String")]
pub struct CategoryFilter(String);

impl CategoryFilter {
    pub fn name(self) -> String {
        self.0
    }
}

impl TryFrom<String> for CategoryFilter {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let fits = (1..=100).contains(&text.chars().count()) && !text.contains(char::is_control);
        fits.then_some(Self(text)).ok_or("must be the name of a category, such as mug")
    }
}

/// Number of objects, 0 to 10,000.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(try_from = "String")]
pub struct ObjectCount(i64);

impl ObjectCount {
    pub fn get(self) -> i64 {
        self.0
    }
}

impl TryFrom<String> for ObjectCount {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let count = text.parse().ok().filter(|count| (0..=10_000).contains(count));
        count.map(Self).ok_or("must be a whole number from 0 to 10000")
    }
}

/// Sequence number of an event, 0 to 2^53 - 1.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(try_from = "String")]
pub struct Sequence(pub i64);

impl TryFrom<String> for Sequence {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let sequence = text.parse().ok().filter(|sequence| (0..1 << 53).contains(sequence));
        sequence.map(Self).ok_or("must be the `seq` of an event")
    }
}

/// One to eight words, none of which has control characters.
const WORDS_PATTERN: &str = r"^ *[^\s\x00-\x1F\x7F-\x9F]+( +[^\s\x00-\x1F\x7F-\x9F]+){0,7} *$";

/// A time in RFC 3339, such as `2026-01-31T12:00:00Z`.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(try_from = "String")]
pub struct Time(jiff::Timestamp);

impl Time {
    /// Milliseconds since 1970.
    pub fn as_ms(self) -> i64 {
        self.0.as_millisecond()
    }
}

impl TryFrom<String> for Time {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.parse().map(Self).map_err(|_| "must be a time such as 2026-01-31T12:00:00Z")
    }
}

in_place! {
    PageSize { "type": "integer", "minimum": 1, "maximum": 200, "default": 50 }
    PageToken {
        "description": "`next_page_token` of the page before.",
        "type": "string",
        "pattern": "^[A-Za-z0-9_-]{21}[AQgw]$",
    }
    IdFilter { "type": "string", "format": "uuid" }
    TenantFilter {
        "description": "The operator may name any; others their own one, which is the usual one.",
        "type": "string",
        "pattern": "^[A-Za-z0-9_-]{1,64}$",
    }
    LabelFilter {
        "description": "`key:value`",
        "type": "string",
        "pattern": LABEL_PATTERN,
        "examples": ["project:demo"],
    }
    TextFilter { "type": "string", "minLength": 1, "maxLength": 200, "pattern": WORDS_PATTERN, "examples": ["red mug"] }
    CategoryFilter {
        "type": "string",
        "minLength": 1,
        "maxLength": 100,
        "pattern": "^[^\\x00-\\x1F\\x7F-\\x9F]*$",
        "examples": ["mug"],
    }
    ObjectCount { "type": "integer", "minimum": 0, "maximum": 10_000 }
    Sequence { "type": "integer", "format": "int64", "minimum": 0, "maximum": MAX_INTEGER, "default": 0 }
    Time { "type": "string", "format": "date-time", "examples": ["2026-01-31T12:00:00Z"] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Default, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields, default)]
    struct Example {
        label: Option<LabelFilter>,
        page_size: PageSize,
        page_token: Option<PageToken>,
        created_after: Option<Time>,
        scene: Option<IdFilter>,
        q: Option<TextFilter>,
        category: Option<CategoryFilter>,
        min_objects: Option<ObjectCount>,
    }

    async fn parse(query: &str) -> Result<Example, String> {
        let request = axum::http::Request::get(format!("/scenes?{query}")).body(()).expect("a request");
        let extracted = Parameters::from_request_parts(&mut request.into_parts().0, &()).await;
        extracted.map(|Parameters(example)| example).map_err(|problem| problem.detail)
    }

    #[tokio::test]
    async fn parameters_are_decoded_and_typed() {
        let parsed =
            parse("label=a%3Ab+c&page_size=7&created_after=2000-02-29T00:00:00Z").await.expect("valid");
        assert_eq!(parsed.label, Some(LabelFilter { key: "a".to_owned(), value: "b c".to_owned() }));
        assert_eq!((parsed.page_size.get(), parsed.page_token), (7, None));
        assert_eq!(parsed.created_after.map(Time::as_ms), Some(951_782_400_000));
        assert_eq!(parse("").await, Ok(Example::default()));
    }

    #[tokio::test]
    async fn invalid_parameters_are_named() {
        for (query, named) in [
            ("colour=red", "colour"),
            ("page_size=7&page_size=8", "page_size"),
            ("page_size=0", "from 1 to 200"),
            ("page_token=Li4vLi4vbG9jaw", "next_page_token"),
            ("label=nocolon", "key:value"),
            ("label=:value", "key:value"),
            ("label=key:%07", "key:value"),
            ("scene=none", "a UUID"),
            ("scene=0192f3a45b6c7d8e9fa0b1c2d3e4f5a6", "a UUID"),
            ("created_after=2001-02-29T00:00:00Z", "2026-01-31T12:00:00Z"),
            ("created_after=yesterday", "2026-01-31T12:00:00Z"),
            ("q=+", "1 to 8 words"),
            ("q=a+b+c+d+e+f+g+h+i", "1 to 8 words"),
            ("category=", "such as mug"),
            ("min_objects=-1", "from 0 to 10000"),
            ("min_objects=1.5", "from 0 to 10000"),
        ] {
            let detail = parse(query).await.expect_err(query);
            assert!(detail.contains(named), "{query}: {detail}");
        }
    }

    #[test]
    fn page_tokens_are_read_again() {
        let id = "0190a3b0-0000-7000-8000-000000000001";
        let token = PageToken::after(id).expect("an id");
        assert_eq!(token.to_string().len(), 22);
        assert_eq!(PageToken::try_from(token.to_string()), Ok(token));
        assert_eq!(token.last_id::<String>().as_deref(), Some(id));
        // The last character holds two bits of the id and four zeros.
        assert!(PageToken::try_from("AZCjsAAAcACAAAAAAAAAAB".to_owned()).is_err());
    }

    #[test]
    fn only_a_page_that_another_one_follows_has_a_token() {
        let size = PageSize::try_from("2".to_owned()).expect("a size");
        assert_eq!(size.rows_to_read(), 3);
        let token_after = |row: &u32| PageToken::after(&Uuid::from_u128((*row).into()).to_string());
        for count in 0..=2 {
            let rows: Vec<u32> = (0..count).collect();
            let page = size.page_of(rows.clone(), token_after);
            assert_eq!(page, Page { rows, next_page_token: None });
        }
        let page = size.page_of(vec![7, 8, 9], token_after);
        let next_page_token = token_after(&8).map(|token| token.to_string());
        assert_eq!(page, Page { rows: vec![7, 8], next_page_token });
    }
}
