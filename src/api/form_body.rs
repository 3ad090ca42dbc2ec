//! Multipart bodies: the image and its depths as files, and the request as JSON.

use std::sync::{Arc, Mutex};

use axum::body::Body;
use axum::extract::{FromRequest, Multipart, Request};
use axum::http::StatusCode;
use axum::http::request::Parts;
use bytes::Bytes;

use super::body::{BodyReader, ReceivedBody};
use super::body_memory::Reservation;
use super::extract::TenantApi;
use super::json_body::parse_apart;
use super::scene_body::SceneBody;
use crate::problem::{Problem, ProblemType};

/// Content of a form, and the memory of all its fields.
pub struct Form {
    pub request: Option<SceneBody>,
    pub image: Option<Bytes>,
    pub depth: Option<Bytes>,
    pub memory: Reservation,
}

/// Reads a form whose fields are `image`, `depth` and `request`, each at most once.
///
/// # Errors
///
/// A [`Problem`] where the body does not arrive within the limits, is no form, or has other fields.
pub async fn read(api: &TenantApi, parts: Parts, body: Body) -> Result<Form, Problem> {
    let source = FormSource::new(BodyReader::new(api, &parts, body, api.settings.max_body_bytes));
    let request = Request::from_parts(parts, source.body());
    let mut fields = Multipart::from_request(request, &())
        .await
        .map_err(|error| source.problem(error.status(), error.body_text()))?;
    let (mut request, mut image, mut depth) = (None, None, None);
    loop {
        let field = fields.next_field().await.map_err(|e| source.problem(e.status(), e.body_text()))?;
        let Some(field) = field else { break };
        let name = field.name().unwrap_or_default().to_owned();
        let bytes = field.bytes().await.map_err(|e| source.problem(e.status(), e.body_text()))?;
        let is_repeated = match name.as_str() {
            "image" => image.replace(bytes).is_some(),
            "depth" => depth.replace(bytes).is_some(),
            "request" => {
                let received = ReceivedBody { bytes: bytes.into(), memory: api.body_memory.reservation() };
                // The reader's reservation covers the value, which is no larger than its JSON.
                let (body, _) = parse_apart(api, &api.tenant_id, received).await?;
                request.replace(body).is_some()
            }
            _ => {
                let shown: String = name.chars().take(40).collect();
                return Err(Problem::new(
                    ProblemType::InvalidRequest,
                    "unknown_field",
                    format!("the form's fields are `image`, `depth` and `request`; {shown:?} is not known"),
                ));
            }
        };
        if is_repeated {
            return Err(Problem::new(
                ProblemType::InvalidRequest,
                "repeated_field",
                format!("the form's field {name:?} comes twice; send it once"),
            ));
        }
    }
    Ok(Form { request, image, depth, memory: source.take_memory().await })
}

/// The reader of the body, and the reason where it refused: the parser of forms passes on neither.
struct FormSource {
    reader: Arc<tokio::sync::Mutex<BodyReader>>,
    refusal: Arc<Mutex<Option<Problem>>>,
}

impl FormSource {
    fn new(reader: BodyReader) -> Self {
        Self { reader: Arc::new(reader.into()), refusal: Arc::default() }
    }

    fn body(&self) -> Body {
        let source = (self.reader.clone(), self.refusal.clone());
        Body::from_stream(futures::stream::try_unfold(source, |(reader, refusal)| async move {
            let next = reader.lock().await.next().await;
            match next {
                Ok(next) => Ok(next.map(|bytes| (bytes, (reader, refusal)))),
                Err(problem) => {
                    *refusal.lock().expect("no code panics while it holds this lock") = Some(problem);
                    Err(std::io::Error::other("refused"))
                }
            }
        }))
    }

    /// Reason why the form ended early: the reader's, or the parser's.
    fn problem(&self, status: StatusCode, text: String) -> Problem {
        let refusal = self.refusal.lock().expect("no code panics while it holds this lock").take();
        refusal.unwrap_or_else(|| match status {
            StatusCode::PAYLOAD_TOO_LARGE => {
                Problem::new(ProblemType::PayloadTooLarge, "body_too_large", "send a smaller image")
            }
            _ => Problem::new(ProblemType::MalformedRequest, "malformed_multipart", text),
        })
    }

    async fn take_memory(&self) -> Reservation {
        self.reader.lock().await.take_memory()
    }
}
