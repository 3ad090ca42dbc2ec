//! Checks of a request by the configuration: whether its settings and its robot will do, and how the configured parser
//! reads its text.

use serde_json::Value;

use super::App;
use crate::config::open_settings::typed_schema;
use crate::problem::FieldError;
use embedded::analyst;
use remote::settings::AnalystProvider;
use scene::SceneRequest;
use scene::request::RequestOptions;
use scene::text_account::TextAccount;

impl App {
    /// Violations of a request of which only the configuration knows: settings in `options.set`, and unknown robots.
    pub fn violations(&self, request: &SceneRequest) -> Vec<FieldError> {
        let mut errors: Vec<FieldError> = unknown_robot(&request.options).into_iter().collect();
        if !request.options.set.is_empty() {
            let wrong =
                self.resolved.with(&request.options.set).err().map_or_else(Vec::new, |errors| errors.0);
            let place = |key: &str| format!("/options/set/{}", key.replace('~', "~0").replace('/', "~1"));
            errors.extend(wrong.into_iter().map(|error| FieldError::new(place(&error.key), error.detail)));
        }
        errors
    }

    /// A JSON schema of the settings that requests may change, with their types and the values of this process.
    pub fn settings_schema(&self) -> Value {
        typed_schema(&self.resolved)
    }

    /// The account of a request's text by the embedded parser, without making a scene; `None` for an image, and where a
    /// remote model reads texts.
    ///
    /// # Errors
    ///
    /// That of the field `/text`.
    pub fn account(&self, request: &SceneRequest) -> Result<Option<TextAccount>, FieldError> {
        let analysts = &self.config().providers.analyst;
        let is_embedded = analysts.iter().all(|provider| *provider == AnalystProvider::Embedded);
        let Some(text) = request.input.text().filter(|_| is_embedded) else { return Ok(None) };
        let described = analyst::describe(text, request.seed, &request.options, &self.config().analyst);
        let account = described.map(|description| Some(description.account()));
        account.map_err(|error| FieldError::new("/text", error.to_string()))
    }
}

fn unknown_robot(options: &RequestOptions) -> Option<FieldError> {
    let name = options.robot.as_deref()?;
    let known: Vec<&str> = robot::model::library::names().collect();
    let detail = || format!("must be one of {}, not {name:?}", known.join(", "));
    (!known.contains(&name)).then(|| FieldError::new("/options/robot", detail()))
}
