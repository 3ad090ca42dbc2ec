-- Limits of tenants, recipes whose requests become rows a few at a time, and keys of clients by the kind of operation.

-- Limits of one tenant that differ from those of the settings; NULL = as in the settings, 0 = none.
CREATE TABLE tenant_limits (
    tenant_id              TEXT PRIMARY KEY,
    bytes                  INTEGER,
    waiting_jobs           INTEGER,
    running_jobs           INTEGER,
    submissions_per_minute INTEGER,
    micro_usd_per_month    INTEGER,
    batch_requests         INTEGER,
    changed_at             INTEGER NOT NULL
) STRICT, WITHOUT ROWID;

-- Until when the submissions of a tenant are used up, microseconds since 1970: each moves it on by its share of a minute.
CREATE TABLE tenant_paces (
    tenant_id TEXT PRIMARY KEY,
    used_up   INTEGER NOT NULL
) STRICT, WITHOUT ROWID;

-- What the calls of a tenant have cost or may cost, by the month (UTC) in which they began. The rows of calls go with their
-- scenes; these stay. Triggers fill it, so that no process can forget to.
CREATE TABLE tenant_spending (
    tenant_id TEXT NOT NULL,
    month     TEXT NOT NULL,       -- 2026-01
    micro_usd INTEGER NOT NULL,
    PRIMARY KEY (tenant_id, month)
) STRICT, WITHOUT ROWID;
INSERT INTO tenant_spending (tenant_id, month, micro_usd)
    SELECT tenant_id, strftime('%Y-%m', started_at / 1000, 'unixepoch'),
           SUM(COALESCE(settled_micro_usd, reserved_micro_usd))
    FROM calls GROUP BY 1, 2;
CREATE TRIGGER calls_are_spent AFTER INSERT ON calls
BEGIN
    INSERT INTO tenant_spending (tenant_id, month, micro_usd)
        VALUES (NEW.tenant_id, strftime('%Y-%m', NEW.started_at / 1000, 'unixepoch'),
                COALESCE(NEW.settled_micro_usd, NEW.reserved_micro_usd))
        ON CONFLICT (tenant_id, month) DO UPDATE SET micro_usd = micro_usd + excluded.micro_usd;
END;
CREATE TRIGGER calls_are_settled AFTER UPDATE OF settled_micro_usd ON calls
BEGIN
    UPDATE tenant_spending
        SET micro_usd = micro_usd + COALESCE(NEW.settled_micro_usd, NEW.reserved_micro_usd)
                        - COALESCE(OLD.settled_micro_usd, OLD.reserved_micro_usd)
        WHERE tenant_id = NEW.tenant_id AND month = strftime('%Y-%m', NEW.started_at / 1000, 'unixepoch');
END;

-- The requests of a batch that have no rows yet: those of its recipe from a number on.
CREATE TABLE batch_recipes (
    batch_id    TEXT PRIMARY KEY REFERENCES batches (id) ON DELETE CASCADE,
    recipe      TEXT NOT NULL,     -- JSON, as it was submitted
    first_place INTEGER NOT NULL,  -- of the first request without a row
    pending     INTEGER NOT NULL,  -- how many of them are to be computed
    duplicate   INTEGER NOT NULL,
    invalid     INTEGER NOT NULL,
    is_stopped  INTEGER NOT NULL DEFAULT 0  -- 1 = its batch was cancelled
) STRICT, WITHOUT ROWID;

-- The key of a client stands behind its scope and a space, which no key has.
UPDATE idempotency SET key = 'scene ' || key;
UPDATE batches SET idempotency_key = 'batch ' || idempotency_key WHERE idempotency_key IS NOT NULL;
UPDATE datasets SET idempotency_key = 'dataset ' || idempotency_key WHERE idempotency_key IS NOT NULL;
UPDATE recordings SET idempotency_key = 'recording ' || idempotency_key WHERE idempotency_key IS NOT NULL;
ALTER TABLE executions ADD COLUMN idempotency_key TEXT;
ALTER TABLE executions ADD COLUMN body_digest TEXT;
CREATE UNIQUE INDEX executions_by_key ON executions (tenant_id, idempotency_key) WHERE idempotency_key IS NOT NULL;
-- Bytes of the answers of a tenant.
CREATE INDEX executions_answered ON executions (tenant_id) WHERE answer IS NOT NULL;
