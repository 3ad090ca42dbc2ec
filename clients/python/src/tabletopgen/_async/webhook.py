"""An address that events of the server are sent to."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from typing import Literal

from typing_extensions import Self

from tabletopgen import models
from tabletopgen._async.resource import AsyncResource
from tabletopgen._requests import escaped, given, patch, post


class AsyncWebhook(AsyncResource[models.Webhook]):
    """A webhook, which is `enabled` or `disabled`."""

    _paths, _model = "/webhooks", models.Webhook

    @property
    def secret(self) -> str | None:
        """The secret for `webhooks.verify`, where this object has just been made or `rotate_secret` was called."""
        return self.data.secret

    async def change(
        self,
        *,
        url: str | None = None,
        description: str | None = None,
        events: Sequence[str] | None = None,
        state: Literal["enabled", "disabled"] | None = None,
    ) -> Self:
        """Changes what is given; no `events` at all, `[]`, are all of them. One that is enabled again sends what has
        waited."""
        return await self._changed(patch(self._path, given(url=url, description=description, events=events, state=state)))

    async def rotate_secret(self) -> Self:
        """Makes a new `secret`. For 24 hours messages are signed by the one before it, too."""
        return await self._changed(post(f"{self._path}/secret"))

    async def test(self) -> models.Delivery:
        """Has the event `webhook.test` sent."""
        return await self._connection.ask(post(f"{self._path}/test"), models.Delivery)

    def deliveries(self, state: Literal["waiting", "delivered", "failed"] | None = None) -> AsyncIterator[models.Delivery]:
        """Messages with their attempts, newest first."""
        parse = models.DeliveryPage.model_validate_json
        return self._connection.pages(f"{self._path}/deliveries", parse, lambda page: page.deliveries, {"state": state})

    async def replay(self, delivery: models.Delivery | str) -> models.Delivery:
        """Has a message sent again, with the same `webhook-id`, by which receivers drop those that they have."""
        name = delivery if isinstance(delivery, str) else delivery.id
        return await self._connection.ask(post(f"{self._path}/deliveries/{escaped(name)}/replay"), models.Delivery)

    async def delete(self) -> None:
        """Deletes the webhook; nothing more is sent to it."""
        await self._deleted()
