//! The check of a webhook, and its change by a JSON merge patch (RFC 7396): fields that it names change, the others
//! stay.

use super::App;
use crate::problem::{FieldError, Problem};
use http_client::AddressError;
use scene::{TenantId, WebhookId};
use store::Store;
use store::webhooks::{ChangeOutcome, EventType, NewWebhook, WebhookRow};

/// Longest address and description, characters.
pub const MAX_URL_CHARS: usize = 2000;
pub const MAX_DESCRIPTION_CHARS: usize = 255;

/// A change of a webhook; what is `None` stays.
#[derive(Clone, Debug, Default)]
pub struct WebhookChange {
    pub url: Option<String>,
    pub description: Option<String>,
    pub events: Option<Vec<EventType>>,
    pub is_enabled: Option<bool>,
}

impl App {
    /// Checks a webhook: its address may be sent to, unless its host turns out to have a private one.
    ///
    /// # Errors
    ///
    /// A [`Problem`] with the fields that will not do.
    pub fn check_webhook(&self, webhook: &NewWebhook) -> Result<(), Problem> {
        let NewWebhook { url, description, events, .. } = webhook;
        let mut errors = Vec::new();
        if url.chars().count() > MAX_URL_CHARS {
            errors.push(FieldError::new("/url", format!("must have at most {MAX_URL_CHARS} characters")));
        } else if let Err(error) = self.config().webhooks.addresses().check(url) {
            errors.push(FieldError::new("/url", correction(&error)));
        }
        if description.chars().count() > MAX_DESCRIPTION_CHARS || description.chars().any(char::is_control) {
            let detail = format!(
                "must have at most {MAX_DESCRIPTION_CHARS} characters, none of them a control character"
            );
            errors.push(FieldError::new("/description", detail));
        }
        if events.len() > EventType::ALL.len() {
            errors.push(FieldError::new("/events", "must not have more events than there are".to_owned()));
        }
        if errors.is_empty() { Ok(()) } else { Err(Problem::invalid(errors)) }
    }

    /// Changes a webhook if `is_expected` holds of it; the webhook after that. Changes at the same time follow each
    /// other.
    ///
    /// # Errors
    ///
    /// A [`Problem`]: 404 without a webhook, 412 for one that is not as expected, 422 for one that may not be.
    pub async fn change_webhook(
        &self,
        store: &Store,
        tenant_id: &TenantId,
        id: &WebhookId,
        change: &WebhookChange,
        is_expected: impl Fn(&WebhookRow) -> bool,
    ) -> Result<WebhookRow, Problem> {
        loop {
            let read = store.webhook(tenant_id, id).await?;
            let read = read.ok_or_else(|| Problem::not_found("webhook", id.as_str()))?;
            let WebhookChange { url, description, events, is_enabled } = change.clone();
            let new = NewWebhook {
                tenant_id: tenant_id.clone(),
                url: url.unwrap_or_else(|| read.url.clone()),
                description: description.unwrap_or_else(|| read.description.clone()),
                events: events.unwrap_or_else(|| read.events.clone()),
            };
            self.check_webhook(&new)?;
            // A precondition is about a request that would be accepted without it (RFC 9110, section 13.2.1).
            if !is_expected(&read) {
                return Err(Problem::no_longer_matches("webhook", "webhook_changed"));
            }
            let is_enabled = is_enabled.unwrap_or(read.disabled_reason.is_none());
            let is_same = (&new.url, &new.description, &new.events, is_enabled)
                == (&read.url, &read.description, &read.events, read.disabled_reason.is_none());
            if is_same {
                return Ok(read);
            }
            // Where it differs, another change was faster; each turn of this loop stands for one that was.
            match store.change_webhook(tenant_id, read, new, is_enabled).await? {
                ChangeOutcome::Changed(webhook) => return Ok(webhook),
                ChangeOutcome::Differs => {}
            }
        }
    }
}

fn correction(error: &AddressError) -> &'static str {
    match error {
        AddressError::NotHttps(_) => {
            "must be https; only the operator of the server can allow plain HTTP, by the host in webhooks.hosts"
        }
        AddressError::Private { .. } => {
            "must be an address of the public internet; only the operator of the server can allow another one, by the host \
             in webhooks.hosts"
        }
        AddressError::Credentials(_) => "must have no name and no password; messages are signed instead",
        AddressError::NoUrl(_) | AddressError::NoAddress(_) => {
            "must be a URL with a host, such as https://example.org/hook"
        }
    }
}
