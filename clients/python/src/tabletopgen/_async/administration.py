"""Keys, the record of changes, webhooks and the queue of a server."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from datetime import datetime
from typing import Any, Literal

from tabletopgen import models
from tabletopgen._async.connection import AsyncConnection
from tabletopgen._async.webhook import AsyncWebhook
from tabletopgen._requests import delete, get, given, post

Scope = Literal["read", "submit", "delete", "operate", "admin"]


class AsyncAdministration:
    """The part of the client that is for administrators and operators, and what the server says of itself."""

    _connection: AsyncConnection

    # The server

    async def version(self) -> models.Version:
        """Name and version of the server's program."""
        return await self._connection.ask(get("/version"), models.Version)

    async def session(self) -> models.Session:
        """The principal of the key, with tenant and scopes, and what the server accepts."""
        return await self._connection.ask(get("/session"), models.Session)

    async def queue(self) -> models.Queue:
        """What waits and what runs, and where."""
        return await self._connection.ask(get("/queue"), models.Queue)

    async def catalog(self) -> list[models.Category]:
        """The categories of objects that scenes are made of."""
        return (await self._connection.ask(get("/catalog"), models.Catalog)).categories

    async def robots(self) -> list[models.Robot]:
        """The robots that tasks are done with."""
        return (await self._connection.ask(get("/robots"), models.RobotList)).robots

    async def settings_schema(self) -> dict[str, Any]:
        """A JSON schema of the fields and options of `generate`, with ranges, meanings and this server's defaults."""
        schema: dict[str, Any] = (await self._connection.send(get("/settings/schema"))).json()
        return schema

    def events(self, after: int | None = None, timeout_secs: float | None = None) -> AsyncIterator[models.TenantEvent]:
        """Events of all jobs and recordings as they happen, without an end: those with a `seq` larger than `after`, or
        those to come. Raises `WaitTimeoutError` after `timeout_secs`."""
        return self._connection.events("/events", models.TenantEvent, lambda event: False, after, timeout_secs)

    # Keys and the record of changes

    async def create_key(
        self, name: str, scopes: Sequence[Scope], *, expires_in_secs: int | None = None, tenant: str | None = None
    ) -> models.Key:
        """A new key: `key` of the answer is its secret, which is shown this once. Operators may name a tenant."""
        body = given(name=name, scopes=scopes, expires_in_s=expires_in_secs, tenant=tenant)
        return await self._connection.ask(post("/keys", body), models.Key)

    def keys(self, *, tenant: str | None = None) -> AsyncIterator[models.Key]:
        """Keys without their secrets, newest first; those that are revoked or have expired, too."""
        parse = models.KeyPage.model_validate_json
        return self._connection.pages("/keys", parse, lambda page: page.keys, {"tenant": tenant})

    async def revoke_key(self, key: models.Key | str, *, tenant: str | None = None) -> None:
        """Revokes a key, or the one with this UUID, and ends its sessions; revoking twice is fine."""
        name = key if isinstance(key, str) else key.id
        await self._connection.send(delete(f"/keys/{name}", {"tenant": tenant}))

    def audit(self, *, since: datetime | None = None, tenant: str | None = None) -> AsyncIterator[models.AuditEntry]:
        """The record of changes, newest first."""
        parse = models.AuditPage.model_validate_json
        return self._connection.pages("/audit", parse, lambda page: page.entries, {"since": since, "tenant": tenant})

    # Webhooks

    async def create_webhook(self, url: str, *, events: Sequence[str] | None = None, description: str | None = None) -> AsyncWebhook:
        """Has events sent to an address, all of them where none are named; `secret` of the webhook verifies them."""
        body = given(url=url, events=events, description=description)
        return await AsyncWebhook._asked(self._connection, post("/webhooks", body))

    async def webhook(self, webhook_id: str) -> AsyncWebhook:
        """The webhook with this UUID."""
        return await AsyncWebhook._of(self._connection, webhook_id)

    async def webhooks(self) -> list[AsyncWebhook]:
        """All webhooks, newest first."""
        found = await self._connection.ask(get("/webhooks"), models.WebhookList)
        return [AsyncWebhook(self._connection, webhook) for webhook in found.webhooks]
