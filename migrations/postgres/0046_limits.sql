-- Limits of tenants, recipes whose requests become rows a few at a time, and keys of clients by the kind of operation.

-- Limits of one tenant that differ from those of the settings; NULL = as in the settings, 0 = none.
CREATE TABLE tenant_limits (
    tenant_id              TEXT COLLATE "C" PRIMARY KEY,
    bytes                  BIGINT,
    waiting_jobs           BIGINT,
    running_jobs           BIGINT,
    submissions_per_minute BIGINT,
    micro_usd_per_month    BIGINT,
    batch_requests         BIGINT,
    changed_at             BIGINT NOT NULL
);

-- Until when the submissions of a tenant are used up, microseconds since 1970: each moves it on by its share of a minute.
CREATE TABLE tenant_paces (
    tenant_id TEXT COLLATE "C" PRIMARY KEY,
    used_up   BIGINT NOT NULL
);

-- What the calls of a tenant have cost or may cost, by the month (UTC) in which they began. The rows of calls go with their
-- scenes; these stay. Triggers fill it, so that no process can forget to.
CREATE TABLE tenant_spending (
    tenant_id TEXT COLLATE "C" NOT NULL,
    month     TEXT COLLATE "C" NOT NULL,       -- 2026-01
    micro_usd BIGINT NOT NULL,
    PRIMARY KEY (tenant_id, month)
);
CREATE FUNCTION note_spending() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
    of_month TEXT := to_char(to_timestamp(NEW.started_at / 1000.0) AT TIME ZONE 'UTC', 'YYYY-MM');
    added    BIGINT := COALESCE(NEW.settled_micro_usd, NEW.reserved_micro_usd);
BEGIN
    IF TG_OP = 'UPDATE' THEN
        added := added - COALESCE(OLD.settled_micro_usd, OLD.reserved_micro_usd);
        IF added = 0 THEN
            RETURN NULL;
        END IF;
    END IF;
    INSERT INTO tenant_spending AS spending (tenant_id, month, micro_usd) VALUES (NEW.tenant_id, of_month, added)
        ON CONFLICT (tenant_id, month) DO UPDATE SET micro_usd = spending.micro_usd + excluded.micro_usd;
    RETURN NULL;
END
$$;
-- The triggers lock the table, so that no call begins between them and the calls that are added up then.
CREATE TRIGGER calls_are_spent AFTER INSERT OR UPDATE OF settled_micro_usd ON calls
    FOR EACH ROW EXECUTE FUNCTION note_spending();
INSERT INTO tenant_spending (tenant_id, month, micro_usd)
    SELECT tenant_id, to_char(to_timestamp(started_at / 1000.0) AT TIME ZONE 'UTC', 'YYYY-MM'),
           SUM(COALESCE(settled_micro_usd, reserved_micro_usd))
    FROM calls GROUP BY 1, 2;

-- The requests of a batch that have no rows yet: those of its recipe from a number on.
CREATE TABLE batch_recipes (
    batch_id    TEXT COLLATE "C" PRIMARY KEY REFERENCES batches (id) ON DELETE CASCADE,
    recipe      TEXT NOT NULL,     -- JSON, as it was submitted
    first_place BIGINT NOT NULL,  -- of the first request without a row
    pending     BIGINT NOT NULL,  -- how many of them are to be computed
    duplicate   BIGINT NOT NULL,
    invalid     BIGINT NOT NULL,
    is_stopped  BIGINT NOT NULL DEFAULT 0  -- 1 = its batch was cancelled
);

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
