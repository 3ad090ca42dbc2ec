//! One operation of the contract: what the extractors of its handler say of the request, and what its text says of the
//! answers.

use std::collections::BTreeSet;
use std::sync::Arc;

use axum::Extension;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, Method};
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value, json};

use super::apply_rules;
use crate::api::Api;
use crate::api::access::Access;
use crate::api::enqueue::SubmissionOptions;
use crate::api::extract::{JsonBody, JsonRequest, OptionalJsonBody, PathId, PathName, ResourceId, TenantApi};
use crate::api::idempotency::IdempotencyKey;
use crate::api::query::Parameters;
use crate::api::serve::connection::Connection;
use crate::api::session::{GivenKey, LoginBody};
use crate::schemas::values::{Bytes, MAX_INTEGER};
use scene::json_schema::not_null;

/// Statuses of refusals that every operation may have.
const COMMON_REFUSALS: [u16; 5] = [400, 403, 421, 429, 503];
/// Statuses of refusals of a body.
const REFUSALS_OF_BODIES: [u16; 4] = [408, 413, 415, 422];
/// Statuses with a time after which the request may be sent again.
const BUSY: [u16; 3] = [429, 503, 507];

/// An operation that is being described.
pub struct Operation<'a> {
    /// Names of the parameters of the path.
    path_names: Vec<&'a str>,
    /// Schemas of what is read.
    read: &'a mut SchemaGenerator,
    /// Schemas of what is answered.
    written: &'a mut SchemaGenerator,
    facts: Map<String, Value>,
    parameters: Vec<Value>,
    bodies: Map<String, Value>,
    is_body_required: bool,
    responses: Map<String, Value>,
    last_status: String,
    refusals: BTreeSet<u16>,
}

impl<'a> Operation<'a> {
    /// An operation with a path, of which nothing else is known.
    pub fn new(path: &'a str, read: &'a mut SchemaGenerator, written: &'a mut SchemaGenerator) -> Self {
        let names = path.split('/').filter_map(|part| part.strip_prefix('{')?.strip_suffix('}'));
        Self {
            path_names: names.map(|name| name.trim_start_matches('*')).collect(),
            read,
            written,
            facts: Map::new(),
            parameters: Vec::new(),
            bodies: Map::new(),
            is_body_required: true,
            responses: Map::new(),
            last_status: String::new(),
            refusals: COMMON_REFUSALS.into(),
        }
    }

    /// Tag, id and summary of the operation.
    pub fn is(&mut self, tag: &str, id: &str, summary: &str) {
        self.facts.insert("tags".to_owned(), json!([tag]));
        self.facts.insert("operationId".to_owned(), id.into());
        self.facts.insert("summary".to_owned(), summary.into());
    }

    /// Id of the operation, once it has one.
    pub fn id(&self) -> &str {
        self.facts.get("operationId").and_then(Value::as_str).unwrap_or_default()
    }

    /// Credentials that it takes, and the scope that they need.
    pub fn guards(&mut self, access: Access) {
        let security = match access {
            Access::Public => json!([]),
            Access::Known => credentials(&[]),
            Access::Scope(scope) => credentials(&[scope.as_str()]),
        };
        self.facts.insert("security".to_owned(), security);
        if access != Access::Public {
            self.refuses(&[401]);
        }
    }

    /// The last answer sets or removes the cookie of a session.
    pub fn sets_cookie(&mut self) {
        self.gives("Set-Cookie", "SetCookie");
    }

    /// A description beyond the summary.
    pub fn explain(&mut self, description: &str) {
        self.facts.insert("description".to_owned(), description.into());
    }

    /// A body of a media type.
    pub fn reads<T: JsonSchema>(&mut self, media_type: &str) {
        let schema = self.read.subschema_for::<T>();
        self.bodies.insert(media_type.to_owned(), json!({ "schema": schema }));
        self.refusals.extend(REFUSALS_OF_BODIES);
    }

    /// An example of the body.
    pub fn shows(&mut self, media_type: &str, example: &str) {
        let value: Value = serde_json::from_str(example).unwrap_or_default();
        self.bodies[media_type]["examples"] = json!({ "example": { "value": value } });
    }

    /// Media types of parts of a form.
    pub fn encodes(&mut self, media_type: &str, parts: &[(&str, &str)]) {
        let parts = parts.iter().map(|(name, kind)| ((*name).to_owned(), json!({ "contentType": kind })));
        self.bodies[media_type]["encoding"] = parts.collect::<Map<_, _>>().into();
    }

    /// Names a type that lines of a file have.
    pub fn mentions<T: JsonSchema, A: JsonSchema>(&mut self) {
        self.read.subschema_for::<T>();
        self.written.subschema_for::<A>();
    }

    /// An answer as JSON.
    pub fn answers<T: JsonSchema>(&mut self, status: u16, description: &str) {
        self.answers_in::<T>(status, description, "application/json");
    }

    /// An answer of a type in another form.
    pub fn answers_in<T: JsonSchema>(&mut self, status: u16, description: &str, media_type: &str) {
        let schema = self.written.subschema_for::<T>();
        self.answers_as(status, description, media_type, &json!(schema));
    }

    /// An answer of another media type.
    fn answers_as(&mut self, status: u16, description: &str, media_type: &str, schema: &Value) {
        let content = match schema {
            Value::Null => json!({}),
            schema => json!({ "schema": schema }),
        };
        self.answers_nothing(status, description);
        let known = &mut self.last_response()["content"][media_type];
        if known.is_null() {
            *known = content;
        }
    }

    /// A stream of events as the answer.
    pub fn streams(&mut self, description: &str, event: &str) {
        let text = format!("`id` is the `seq`, `event` the `kind`, `data` {event} as JSON.");
        let schema = json!({ "type": "string", "description": text });
        self.answers_as(200, description, "text/event-stream", &schema);
    }

    /// A file as the answer, of some media types.
    pub fn answers_file(&mut self, status: u16, description: &str, media_types: &[&str]) {
        for media_type in media_types {
            // Documents and pages are files, too, whose bytes clients read as they are.
            let schema = match *media_type {
                "application/json" => Value::Null,
                text if text.starts_with("text/") => json!({ "type": "string" }),
                _ => json!(self.written.subschema_for::<Bytes>()),
            };
            self.answers_as(status, description, media_type, &schema);
        }
    }

    /// An answer without a body.
    pub fn answers_nothing(&mut self, status: u16, description: &str) {
        self.last_status = status.to_string();
        let response = self.responses.entry(self.last_status.clone()).or_insert_with(|| json!({}));
        response["description"] = description.into();
    }

    /// A file that clients may have already, that is sent in ranges, and that the bucket may send.
    pub fn downloads(&mut self, description: &str, media_types: &[&str]) {
        self.header("If-None-Match", "", &json!({ "type": "string" }));
        self.header(
            "Range",
            "One range of bytes.",
            &json!({ "type": "string", "examples": ["bytes=0-1023"] }),
        );
        // Generated clients read the first media type alone.
        let media_types = [&["application/octet-stream"], media_types].concat();
        self.answers_file(200, description, &media_types);
        self.gives("ETag", "ETag");
        self.answers_file(206, "Part of it.", &media_types);
        self.gives("ETag", "ETag");
        self.gives("Content-Range", "ContentRange");
        self.answers_nothing(304, "The client has it already.");
        self.answers_nothing(
            307,
            "An address of the bucket, which sends the bytes for a limited time, where \
             the server is configured so.",
        );
        self.locates();
        self.refuses(&[416]);
    }

    /// The last answer has an address.
    pub fn locates(&mut self) {
        self.gives("Location", "Location");
    }

    /// The last answer says how long it waited.
    pub fn applies_preference(&mut self) {
        self.gives("Preference-Applied", "PreferenceApplied");
    }

    /// The last answer has a tag, by which a change says what it was made for.
    pub fn tags(&mut self) {
        self.gives("ETag", "ETag");
    }

    fn gives(&mut self, header: &str, component: &str) {
        self.last_response()["headers"][header] =
            json!({ "$ref": format!("#/components/headers/{component}") });
    }

    /// An operation that the last answer leads to, with the sources of its parameters.
    pub fn links(&mut self, name: &str, operation_id: &str, parameters: &[(&str, &str)]) {
        let parameters: Map<String, Value> =
            parameters.iter().map(|(name, source)| ((*name).to_owned(), (*source).into())).collect();
        self.last_response()["links"][name] =
            json!({ "operationId": operation_id, "parameters": parameters });
    }

    /// A header by which a stream of events goes on.
    pub fn resumes(&mut self) {
        self.header(
            "Last-Event-ID",
            "For streams: go on after this `seq`. Nothing is lost or repeated across reconnects and restarts.",
            &json!({ "type": "integer", "format": "int64", "minimum": 0, "maximum": MAX_INTEGER }),
        );
    }

    /// Further statuses of refusals.
    pub fn refuses(&mut self, statuses: &[u16]) {
        self.refusals.extend(statuses);
    }

    /// A header of the request.
    pub fn header(&mut self, name: &str, description: &str, schema: &Value) {
        self.parameter("header", name, false, description, schema);
    }

    /// The description, the schema and an example of a parameter of the path.
    pub fn path_parameter<T: JsonSchema>(&mut self, name: &str, description: &str, example: &str) {
        let mut schema = json!(self.read.subschema_for::<T>());
        if !example.is_empty() {
            schema["examples"] = json!([example]);
        }
        self.parameters.retain(|parameter| parameter["name"] != name);
        self.parameter("path", name, true, description, &schema);
    }

    fn parameter(&mut self, place: &str, name: &str, is_required: bool, description: &str, schema: &Value) {
        let mut parameter = json!({ "name": name, "in": place });
        if is_required {
            parameter["required"] = true.into();
        }
        if !description.is_empty() {
            parameter["description"] = description.into();
        }
        parameter["schema"] = schema.clone();
        self.parameters.push(parameter);
    }

    fn last_response(&mut self) -> &mut Value {
        &mut self.responses[&self.last_status]
    }

    /// The operation as a document.
    pub fn into_document(mut self) -> Value {
        for status in self.refusals {
            let component = if BUSY.contains(&status) { "Busy" } else { "Problem" };
            let refusal = json!({ "$ref": format!("#/components/responses/{component}") });
            self.responses.insert(status.to_string(), refusal);
        }
        self.responses.sort_keys();
        self.responses.insert("default".to_owned(), json!({ "$ref": "#/components/responses/Problem" }));
        if !self.parameters.is_empty() {
            self.facts.insert("parameters".to_owned(), self.parameters.into());
        }
        if !self.bodies.is_empty() {
            let body = json!({ "required": self.is_body_required, "content": self.bodies });
            self.facts.insert("requestBody".to_owned(), body);
        }
        self.facts.insert("responses".to_owned(), self.responses.into());
        self.facts.into()
    }
}

/// Alternatives; the last one is a server that needs no credentials.
fn credentials(scopes: &[&str]) -> Value {
    json!([{ "key": scopes }, { "session": scopes }, {}])
}

/// Description of a request by an extractor.
pub trait Describe {
    fn describe(_: &mut Operation<'_>) {}
}

impl Describe for TenantApi {}
impl Describe for State<Api> {}
impl Describe for Method {}
impl Describe for HeaderMap {}
impl Describe for Option<Extension<Arc<Connection>>> {}
impl Describe for Request {}

impl<T: ResourceId> Describe for PathId<T> {
    fn describe(operation: &mut Operation<'_>) {
        let name = operation.path_names.first().copied().unwrap_or_default();
        operation.parameter("path", name, true, "", &json!({ "type": "string", "format": "uuid" }));
        operation.refuses(&[404]);
    }
}

impl Describe for PathName {
    fn describe(operation: &mut Operation<'_>) {
        let name = operation.path_names.last().copied().unwrap_or_default();
        operation.parameter("path", name, true, "", &json!({ "type": "string", "minLength": 1 }));
    }
}

impl<T: JsonSchema> Describe for Parameters<T> {
    fn describe(operation: &mut Operation<'_>) {
        let mut schema = json!(T::json_schema(operation.read));
        apply_rules(&mut schema, false);
        let fields = schema.get_mut("properties").and_then(Value::as_object_mut);
        for (name, field) in fields.into_iter().flatten() {
            not_null(field);
            let described = field.as_object_mut().and_then(|field| field.shift_remove("description"));
            let description = described.as_ref().and_then(Value::as_str).unwrap_or_default();
            operation.parameter("query", name, false, description, field);
        }
    }
}

impl Describe for SubmissionOptions {
    fn describe(operation: &mut Operation<'_>) {
        IdempotencyKey::describe(operation);
        operation.header(
            "Prefer",
            "`wait=N` answers when the job has ended, or after N seconds (at most 60).",
            &json!({ "type": "string", "examples": ["wait=5"] }),
        );
    }
}

impl Describe for IdempotencyKey {
    fn describe(operation: &mut Operation<'_>) {
        operation.header(
            "Idempotency-Key",
            "The same key with the same body (within 24 hours) makes one scene, however often it is sent. Each kind of \
             operation has keys of its own. A key of another form, and several headers, are refused with 400 by \
             every route.",
            &json!({ "type": "string", "minLength": 1, "maxLength": 255, "pattern": "^[!-~]+$" }),
        );
    }
}

impl<T: JsonRequest> Describe for JsonBody<T> {
    fn describe(operation: &mut Operation<'_>) {
        operation.reads::<T::Schema>("application/json");
        operation.shows("application/json", T::EXAMPLE);
    }
}

impl Describe for GivenKey {
    fn describe(operation: &mut Operation<'_>) {
        JsonBody::<LoginBody>::describe(operation);
    }
}

impl<T: JsonRequest> Describe for OptionalJsonBody<T> {
    fn describe(operation: &mut Operation<'_>) {
        operation.is_body_required = false;
        operation.reads::<T::Schema>("application/json");
        operation.shows("application/json", T::EXAMPLE);
    }
}

/// A handler whose extractors describe the request.
pub trait DescribedHandler<Inputs> {
    /// Describes the request.
    fn describe(operation: &mut Operation<'_>);
}

macro_rules! described {
    ($($input:ident)*) => {
        impl<F, R, $($input: Describe),*> DescribedHandler<($($input,)*)> for F
        where
            F: Fn($($input),*) -> R,
        {
            fn describe(_operation: &mut Operation<'_>) {
                $($input::describe(_operation);)*
            }
        }
    };
}

described!();
described!(A);
described!(A B);
described!(A B C);
described!(A B C D);
described!(A B C D E);
described!(A B C D E G);
