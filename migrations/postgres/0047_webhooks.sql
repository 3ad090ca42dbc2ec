-- Addresses of tenants that events are sent to, and the messages for them.

CREATE TABLE webhooks (
    id                    TEXT COLLATE "C" PRIMARY KEY,
    tenant_id             TEXT COLLATE "C" NOT NULL,
    url                   TEXT COLLATE "C" NOT NULL,
    description           TEXT COLLATE "C" NOT NULL,
    events                TEXT COLLATE "C" NOT NULL,               -- words with spaces between them; empty = all
    secret                TEXT COLLATE "C" NOT NULL,               -- signs messages, so that it is kept as it is
    previous_secret       TEXT COLLATE "C",
    previous_secret_until BIGINT,
    disabled_reason       TEXT COLLATE "C",                        -- NULL = enabled
    failed_in_a_row       BIGINT NOT NULL DEFAULT 0,  -- deliveries whose last attempt failed
    leased_until          BIGINT NOT NULL DEFAULT 0,  -- by the process that sends to it
    created_at            BIGINT NOT NULL,
    updated_at            BIGINT NOT NULL
);
CREATE INDEX webhooks_of_tenant ON webhooks (tenant_id, id);
-- Whose turn it is.
CREATE INDEX webhooks_enabled ON webhooks (leased_until, id) WHERE disabled_reason IS NULL;

-- A row is written in the transaction of the change that it tells of. It refers to its webhook by name alone: no job waits
-- for, or fails with, the deletion of a webhook.
CREATE TABLE deliveries (
    id          TEXT COLLATE "C" PRIMARY KEY,            -- the same in every attempt
    tenant_id   TEXT COLLATE "C" NOT NULL,
    webhook_id  TEXT COLLATE "C" NOT NULL,
    event       TEXT COLLATE "C" NOT NULL,
    payload     TEXT COLLATE "C" NOT NULL,               -- JSON, as it is signed and sent
    state       TEXT COLLATE "C" NOT NULL,               -- waiting, delivered or failed
    attempts    BIGINT NOT NULL DEFAULT 0,  -- begun
    next_at     BIGINT NOT NULL,
    created_at  BIGINT NOT NULL,
    tried_at    BIGINT,                     -- the end of the last attempt, as the columns after it
    status      BIGINT,                     -- of the answer
    error       TEXT COLLATE "C",
    duration_ms BIGINT
);
CREATE INDEX deliveries_of_webhook ON deliveries (webhook_id, id);
CREATE INDEX deliveries_waiting ON deliveries (webhook_id, next_at, id) WHERE state = 'waiting';
CREATE INDEX deliveries_by_age ON deliveries (created_at);
