-- Calls of remote models, and the money set aside for them. Money is whole millionths of a US dollar.

-- The most that all calls for a scene may cost together; NULL = nothing was agreed, so nothing may be spent.
ALTER TABLE scenes ADD COLUMN budget_micro_usd INTEGER;

-- One row a try. It is committed before anything is sent; while `outcome` is NULL the call is under way.
CREATE TABLE calls (
    id                 INTEGER PRIMARY KEY,
    tenant_id          TEXT NOT NULL,
    scene_id           TEXT NOT NULL REFERENCES scenes (id),
    job_id             TEXT NOT NULL REFERENCES jobs (id),
    epoch              INTEGER NOT NULL,      -- of the job's lease
    stage              TEXT NOT NULL,
    instance           TEXT NOT NULL DEFAULT '',
    port               TEXT NOT NULL,
    provider           TEXT NOT NULL,
    model              TEXT NOT NULL,
    endpoint           TEXT NOT NULL,         -- without secrets and queries
    operation          TEXT NOT NULL,
    request_digest     TEXT NOT NULL,         -- of everything sent but secrets
    idempotency_key    TEXT NOT NULL,         -- the same for every try of a question in a stage of a job
    attempt            INTEGER NOT NULL,
    reserved_micro_usd INTEGER NOT NULL CHECK (reserved_micro_usd >= 0),
    settled_micro_usd  INTEGER CHECK (settled_micro_usd >= 0),
    outcome            TEXT,                  -- 'answered', 'outcome_unknown', or the code of a failure
    sent_bytes         INTEGER NOT NULL,
    received_bytes     INTEGER,
    input_tokens       INTEGER,
    output_tokens      INTEGER,
    started_at         INTEGER NOT NULL,
    finished_at        INTEGER,
    CHECK ((outcome IS NULL) = (settled_micro_usd IS NULL))
) STRICT;
CREATE INDEX calls_of_scene ON calls (scene_id, id);
CREATE INDEX calls_under_way ON calls (job_id) WHERE outcome IS NULL;
CREATE INDEX calls_by_key ON calls (job_id, idempotency_key);
