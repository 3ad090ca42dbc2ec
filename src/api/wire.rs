//! Rows as clients see them, and the small formats of the wire: times, page tokens, query parameters.

use std::collections::BTreeMap;

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use serde::Serialize;
use serde_json::Value;
use uuid::Uuid;

use super::error::{Problem, ProblemType};
pub use super::spending::SpendingView;
use scene::{JobId, SceneId};
use store::artifacts::ArtifactRow;
use store::events::Event;
use store::jobs::{JobRow, StageRow};
use store::scenes::SceneRow;

/// A scene with its newest job.
#[derive(Serialize)]
pub struct SceneView {
    pub id: SceneId,
    pub state: &'static str,
    pub verdict: Option<String>,
    pub failure: Option<FailureView>,
    pub parent: Option<SceneId>,
    pub seed: Value,
    pub request: Value,
    pub labels: BTreeMap<String, String>,
    pub metrics: Option<Value>,
    pub summary: Option<Value>,
    pub created_at: String,
    pub updated_at: String,
    pub job: Option<JobView>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stages: Option<Vec<StageView>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub artifacts: Option<Vec<ArtifactView>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spending: Option<SpendingView>,
    pub links: SceneLinks,
}

#[derive(Serialize)]
pub struct SceneLinks {
    #[serde(rename = "self")]
    pub this: String,
    pub bundle: String,
    pub artifacts: String,
    pub events: Option<String>,
}

impl SceneView {
    pub fn new(scene: SceneRow, job: Option<JobRow>) -> Self {
        let this = format!("/scenes/{}", scene.id);
        Self {
            links: SceneLinks {
                bundle: format!("{this}/bundle"),
                artifacts: format!("{this}/artifacts"),
                events: job.as_ref().map(|job| format!("/jobs/{}/events", job.id)),
                this,
            },
            id: scene.id,
            state: scene.state.as_str(),
            verdict: scene.verdict,
            failure: FailureView::new(None, scene.failure_code, scene.failure_message),
            parent: scene.parent_id,
            seed: scene.request.get("seed").cloned().unwrap_or_default(),
            request: scene.request,
            labels: scene.labels,
            metrics: scene.metrics,
            summary: scene.summary,
            created_at: timestamp(scene.created_at_ms),
            updated_at: timestamp(scene.updated_at_ms),
            job: job.map(JobView::new),
            stages: None,
            artifacts: None,
            spending: None,
        }
    }
}

#[derive(Serialize)]
pub struct FailureView {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<String>,
    pub code: String,
    pub message: String,
}

impl FailureView {
    fn new(class: Option<String>, code: Option<String>, message: Option<String>) -> Option<Self> {
        code.map(|code| Self { class, code, message: message.unwrap_or_default() })
    }
}

#[derive(Serialize)]
pub struct JobView {
    pub id: JobId,
    pub kind: &'static str,
    pub state: &'static str,
    pub scene_id: Option<SceneId>,
    pub retry_of: Option<JobId>,
    pub from_stage: Option<String>,
    pub attempt: i64,
    pub failure: Option<FailureView>,
    pub created_at: String,
    pub started_at: Option<String>,
    pub finished_at: Option<String>,
    pub links: JobLinks,
}

#[derive(Serialize)]
pub struct JobLinks {
    #[serde(rename = "self")]
    pub this: String,
    pub events: String,
    pub stages: String,
    pub scene: Option<String>,
}

impl JobView {
    pub fn new(job: JobRow) -> Self {
        let this = format!("/jobs/{}", job.id);
        Self {
            links: JobLinks {
                events: format!("{this}/events"),
                stages: format!("{this}/stages"),
                scene: job.scene_id.as_ref().map(|id| format!("/scenes/{id}")),
                this,
            },
            id: job.id,
            kind: job.kind.as_str(),
            state: job.state.as_str(),
            scene_id: job.scene_id,
            retry_of: job.retry_of,
            from_stage: job.from_stage,
            attempt: job.attempt,
            failure: FailureView::new(job.failure_class, job.failure_code, job.failure_message),
            created_at: timestamp(job.created_at_ms),
            started_at: job.started_at_ms.map(timestamp),
            finished_at: job.finished_at_ms.map(timestamp),
        }
    }
}

#[derive(Serialize)]
pub struct StageView {
    pub stage: String,
    /// Absent when the stage works on the whole scene.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub instance: String,
    pub state: String,
    pub cached: bool,
    pub runs: i64,
    pub elapsed_ms: Option<i64>,
    pub started_at: String,
}

impl StageView {
    pub fn new(row: StageRow) -> Self {
        Self {
            stage: row.stage,
            instance: row.instance,
            state: row.state,
            cached: row.cached,
            runs: row.runs,
            elapsed_ms: row.elapsed_ms,
            started_at: timestamp(row.started_at_ms),
        }
    }
}

#[derive(Serialize)]
pub struct ArtifactView {
    pub name: String,
    pub stage: String,
    pub media_type: String,
    pub size: u64,
    pub sha256: String,
    pub url: String,
}

impl ArtifactView {
    pub fn new(scene_id: &SceneId, row: ArtifactRow) -> Self {
        Self {
            url: format!("/scenes/{scene_id}/artifacts/{}", row.file.name),
            name: row.file.name,
            stage: row.stage,
            media_type: row.file.media_type,
            size: row.file.size,
            sha256: row.file.digest.to_string(),
        }
    }
}

#[derive(Serialize)]
pub struct EventView {
    pub seq: i64,
    pub at: String,
    pub kind: String,
    pub data: Value,
}

impl EventView {
    pub fn new(event: Event) -> Self {
        Self { seq: event.seq, at: timestamp(event.at_ms), kind: event.kind, data: event.data }
    }
}

/// RFC 3339 in UTC with milliseconds, of milliseconds since 1970.
pub fn timestamp(ms: i64) -> String {
    let (seconds, millis) = (ms.div_euclid(1000), ms.rem_euclid(1000));
    let (days, second_of_day) = (seconds.div_euclid(86_400), seconds.rem_euclid(86_400));
    // Civil date from days since 1970 (H. Hinnant, "chrono-compatible low-level date algorithms"):
    // years begin in March, so the leap day comes last; eras are 400 years.
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted.div_euclid(146_097), shifted.rem_euclid(146_097));
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    let (hour, minute, second) = (second_of_day / 3600, second_of_day / 60 % 60, second_of_day % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{millis:03}Z")
}

/// Milliseconds since 1970 of `YYYY-MM-DDThh:mm:ss[.fff]Z`.
pub fn parse_timestamp(text: &str) -> Option<i64> {
    let text = text.strip_suffix('Z')?;
    let (date, time) = text.split_once('T')?;
    let number = |part: &str, digits: usize| -> Option<i64> {
        (part.len() == digits && part.bytes().all(|b| b.is_ascii_digit())).then(|| part.parse().ok())?
    };
    let mut date = date.split('-');
    let (year, month, day) = (number(date.next()?, 4)?, number(date.next()?, 2)?, number(date.next()?, 2)?);
    let (time, fraction) = time.split_once('.').unwrap_or((time, "0"));
    let mut time = time.split(':');
    let (hour, minute, second) =
        (number(time.next()?, 2)?, number(time.next()?, 2)?, number(time.next()?, 2)?);
    if date.next().is_some() || time.next().is_some() || hour > 23 || minute > 59 || second > 59 {
        return None;
    }
    let millis = number(&format!("{:0<3}", fraction.get(..fraction.len().min(3))?), 3)?;
    let shifted_year = year - i64::from(month <= 2);
    let (era, year_of_era) = (shifted_year.div_euclid(400), shifted_year.rem_euclid(400));
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let days =
        era * 146_097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719_468;
    let ms = ((days * 24 + hour) * 60 + minute) * 60_000 + second * 1000 + millis;
    // Refuses the 31st of June and the like: they do not come back.
    timestamp(ms).starts_with(&format!("{year:04}-{month:02}-{day:02}T")).then_some(ms)
}

/// Opaque token that continues a list after the scene `id`.
pub fn page_token(id: &SceneId) -> String {
    URL_SAFE_NO_PAD.encode(id.as_str())
}

/// The id a page token stands for.
pub fn parse_page_token(token: &str) -> Result<SceneId, Problem> {
    URL_SAFE_NO_PAD
        .decode(token)
        .ok()
        .and_then(|bytes| String::from_utf8(bytes).ok())
        .filter(|id| Uuid::parse_str(id).is_ok())
        .and_then(|id| SceneId::try_from(id).ok())
        .ok_or_else(|| {
            parameter("page_token", "take it from `next_page_token` of the page before, unchanged")
        })
}

/// A query parameter that will not do.
pub fn parameter(name: &str, advice: &str) -> Problem {
    Problem::new(
        ProblemType::MalformedRequest,
        "invalid_parameter",
        format!("query parameter {name}: {advice}"),
    )
}

/// `page_size` within 1..=200, 50 when absent.
pub fn page_size(given: Option<&str>) -> Result<u32, Problem> {
    let Some(text) = given else { return Ok(50) };
    let size = text.parse().ok().filter(|size| (1..=200).contains(size));
    size.ok_or_else(|| parameter("page_size", "must be a whole number from 1 to 200"))
}

/// The query's parameters, each known and given once.
pub fn query(raw: Option<&str>, known: &[&str]) -> Result<BTreeMap<String, String>, Problem> {
    let mut parameters = BTreeMap::new();
    for (name, value) in form_pairs(raw.unwrap_or_default()) {
        let shown: String = name.chars().take(40).collect();
        if !known.contains(&name.as_str()) {
            let advice = match known {
                [] => "is not known; this path takes none".to_owned(),
                _ => format!("is not known; this path takes {}", known.join(", ")),
            };
            return Err(parameter(&shown, &advice));
        }
        if parameters.insert(name, value).is_some() {
            return Err(parameter(&shown, "is given twice"));
        }
    }
    Ok(parameters)
}

/// `a=b&c=d` with percent decoding; invalid UTF-8 is replaced.
fn form_pairs(raw: &str) -> Vec<(String, String)> {
    let decode = |text: &str| {
        let bytes = text.as_bytes();
        let mut decoded = Vec::with_capacity(bytes.len());
        let mut index = 0;
        while index < bytes.len() {
            let hex = bytes
                .get(index + 1..index + 3)
                .and_then(|hex| std::str::from_utf8(hex).ok())
                .filter(|hex| hex.bytes().all(|b| b.is_ascii_hexdigit()))
                .and_then(|hex| u8::from_str_radix(hex, 16).ok());
            match (bytes[index], hex) {
                (b'%', Some(byte)) => {
                    decoded.push(byte);
                    index += 2;
                }
                (b'+', _) => decoded.push(b' '),
                (byte, _) => decoded.push(byte),
            }
            index += 1;
        }
        String::from_utf8_lossy(&decoded).into_owned()
    };
    raw.split('&')
        .filter(|pair| !pair.is_empty())
        .map(|pair| pair.split_once('=').unwrap_or((pair, "")))
        .map(|(name, value)| (decode(name), decode(value)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_known_days() {
        assert_eq!(timestamp(0), "1970-01-01T00:00:00.000Z");
        assert_eq!(timestamp(951_782_400_000), "2000-02-29T00:00:00.000Z");
        assert_eq!(timestamp(1_763_722_805_042), "2025-11-21T11:00:05.042Z");
        assert_eq!(timestamp(-1), "1969-12-31T23:59:59.999Z");
        for ms in [0, 951_782_400_000, 1_763_722_805_042, 4_102_444_799_999] {
            assert_eq!(parse_timestamp(&timestamp(ms)), Some(ms));
        }
        assert_eq!(parse_timestamp("2000-02-29T00:00:00Z"), Some(951_782_400_000));
        for bad in ["2001-02-29T00:00:00Z", "2000-13-01T00:00:00Z", "yesterday", "2000-01-01", "", "TZ"] {
            assert_eq!(parse_timestamp(bad), None, "{bad}");
        }
    }

    #[test]
    fn queries_are_decoded_and_strangers_refused() {
        let known = ["label", "state"];
        let parsed = query(Some("label=a%3Ab+c&state=ready"), &known).expect("parses");
        assert_eq!(parsed["label"], "a:b c");
        assert!(query(Some("colour=red"), &known).is_err());
        assert!(query(Some("state=a&state=b"), &known).is_err());
        assert_eq!(query(Some("label=%zz%"), &known).expect("parses")["label"], "%zz%");
        assert!(parse_page_token("Li4vLi4vbG9jaw").is_err());
    }
}
