//! Operations of the tag `webhooks`.

use super::super::operation::Operation;
use crate::api::webhooks::{DeliveryPage, DeliveryView, WebhookList, WebhookView};

/// `POST /webhooks`.
pub fn create_webhook(operation: &mut Operation<'_>) {
    operation.is("webhooks", "createWebhook", "Have events sent to an address. The answer shows the secret.");
    operation.explain(
        "Each event is one POST with a `WebhookMessage` as JSON and the headers `webhook-id`, `webhook-timestamp` and \
         `webhook-signature` of Standard Webhooks. A status 2xx accepts it; 410 disables the webhook; after any other answer it \
         is sent again, for about three days, with the same `webhook-id`. Messages may come twice, and in any order.",
    );
    operation.answers::<WebhookView>(201, "The webhook with its secret.");
    operation.tags();
    links(operation, "$response.body#/id");
    operation.refuses(&[409]);
}

/// `GET /webhooks`.
pub fn list_webhooks(operation: &mut Operation<'_>) {
    operation.is("webhooks", "listWebhooks", "Webhooks without their secrets, newest first.");
    operation.answers::<WebhookList>(200, "All of them.");
    operation.links("first", "getWebhook", &[("webhook_id", "$response.body#/webhooks/0/id")]);
}

/// `GET /webhooks/{webhook_id}`.
pub fn get_webhook(operation: &mut Operation<'_>) {
    operation.is("webhooks", "getWebhook", "A webhook without its secret.");
    operation.answers::<WebhookView>(200, "The webhook.");
    operation.tags();
    links(operation, "$response.body#/id");
}

/// `PATCH /webhooks/{webhook_id}`.
pub fn change_webhook(operation: &mut Operation<'_>) {
    operation.is("webhooks", "changeWebhook", "Change address, description, events or state of a webhook.");
    operation.answers::<WebhookView>(200, "The webhook after that.");
    operation.tags();
}

/// `DELETE /webhooks/{webhook_id}`.
pub fn delete_webhook(operation: &mut Operation<'_>) {
    operation.is("webhooks", "deleteWebhook", "Delete a webhook. Nothing more is sent to it.");
    operation.answers_nothing(204, "It is gone.");
}

/// `POST /webhooks/{webhook_id}/secret`.
pub fn renew_webhook_secret(operation: &mut Operation<'_>) {
    operation.is(
        "webhooks",
        "renewWebhookSecret",
        "Make a new secret. The answer is the only place that shows it.",
    );
    operation
        .explain("For 24 hours messages have two signatures, by the new secret and by the one before it.");
    operation.answers::<WebhookView>(200, "The webhook with its new secret.");
    operation.tags();
}

/// `POST /webhooks/{webhook_id}/test`.
pub fn test_webhook(operation: &mut Operation<'_>) {
    operation.is("webhooks", "testWebhook", "Send the event `webhook.test`.");
    operation.answers::<DeliveryView>(202, "The delivery, which is due now.");
    replay_link(operation, "$response.body#/id");
    operation.refuses(&[409]);
}

/// `GET /webhooks/{webhook_id}/deliveries`.
pub fn list_deliveries(operation: &mut Operation<'_>) {
    operation.is("webhooks", "listDeliveries", "Messages of a webhook with their attempts, newest first.");
    operation.answers::<DeliveryPage>(200, "A page.");
    replay_link(operation, "$response.body#/deliveries/0/id");
}

/// `POST /webhooks/{webhook_id}/deliveries/{delivery_id}/replay`.
pub fn replay_delivery(operation: &mut Operation<'_>) {
    operation.is("webhooks", "replayDelivery", "Send a message again, with the same `webhook-id`.");
    operation.answers::<DeliveryView>(202, "The delivery, which is due now.");
    operation.refuses(&[409]);
}

fn links(operation: &mut Operation<'_>, id: &str) {
    for (name, operation_id) in [
        ("self", "getWebhook"),
        ("change", "changeWebhook"),
        ("deletion", "deleteWebhook"),
        ("secret", "renewWebhookSecret"),
        ("test", "testWebhook"),
        ("deliveries", "listDeliveries"),
    ] {
        operation.links(name, operation_id, &[("webhook_id", id)]);
    }
}

fn replay_link(operation: &mut Operation<'_>, id: &str) {
    let parameters = [("webhook_id", "$request.path.webhook_id"), ("delivery_id", id)];
    operation.links("replay", "replayDelivery", &parameters);
}
