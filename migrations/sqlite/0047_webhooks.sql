-- Addresses of tenants that events are sent to, and the messages for them.

CREATE TABLE webhooks (
    id                    TEXT PRIMARY KEY,
    tenant_id             TEXT NOT NULL,
    url                   TEXT NOT NULL,
    description           TEXT NOT NULL,
    events                TEXT NOT NULL,               -- words with spaces between them; empty = all
    secret                TEXT NOT NULL,               -- signs messages, so that it is kept as it is
    previous_secret       TEXT,
    previous_secret_until INTEGER,
    disabled_reason       TEXT,                        -- NULL = enabled
    failed_in_a_row       INTEGER NOT NULL DEFAULT 0,  -- deliveries whose last attempt failed
    leased_until          INTEGER NOT NULL DEFAULT 0,  -- by the process that sends to it
    created_at            INTEGER NOT NULL,
    updated_at            INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
CREATE INDEX webhooks_of_tenant ON webhooks (tenant_id, id);
-- Whose turn it is.
CREATE INDEX webhooks_enabled ON webhooks (leased_until, id) WHERE disabled_reason IS NULL;

-- A row is written in the transaction of the change that it tells of. It refers to its webhook by name alone: no job waits
-- for, or fails with, the deletion of a webhook.
CREATE TABLE deliveries (
    id          TEXT PRIMARY KEY,            -- the same in every attempt
    tenant_id   TEXT NOT NULL,
    webhook_id  TEXT NOT NULL,
    event       TEXT NOT NULL,
    payload     TEXT NOT NULL,               -- JSON, as it is signed and sent
    state       TEXT NOT NULL,               -- waiting, delivered or failed
    attempts    INTEGER NOT NULL DEFAULT 0,  -- begun
    next_at     INTEGER NOT NULL,
    created_at  INTEGER NOT NULL,
    tried_at    INTEGER,                     -- the end of the last attempt, as the columns after it
    status      INTEGER,                     -- of the answer
    error       TEXT,
    duration_ms INTEGER
) STRICT, WITHOUT ROWID;
CREATE INDEX deliveries_of_webhook ON deliveries (webhook_id, id);
CREATE INDEX deliveries_waiting ON deliveries (webhook_id, next_at, id) WHERE state = 'waiting';
CREATE INDEX deliveries_by_age ON deliveries (created_at);
