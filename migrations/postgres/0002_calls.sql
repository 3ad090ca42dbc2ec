-- Calls of remote models, and the money set aside for them. Money is whole millionths of a US dollar.

-- The most that all calls for a scene may cost together; NULL = nothing was agreed, so nothing may be spent.
ALTER TABLE scenes ADD COLUMN budget_micro_usd BIGINT;

-- One row a try. It is committed before anything is sent; while `outcome` is NULL the call is under way.
CREATE TABLE calls (
    id                 BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
    tenant_id          TEXT COLLATE "C" NOT NULL,
    scene_id           TEXT COLLATE "C" NOT NULL REFERENCES scenes (id),
    job_id             TEXT COLLATE "C" NOT NULL REFERENCES jobs (id),
    epoch              BIGINT NOT NULL,      -- of the job's lease
    stage              TEXT COLLATE "C" NOT NULL,
    instance           TEXT COLLATE "C" NOT NULL DEFAULT '',
    port               TEXT COLLATE "C" NOT NULL,
    provider           TEXT COLLATE "C" NOT NULL,
    model              TEXT COLLATE "C" NOT NULL,
    endpoint           TEXT COLLATE "C" NOT NULL,         -- without secrets and queries
    operation          TEXT COLLATE "C" NOT NULL,
    request_digest     TEXT COLLATE "C" NOT NULL,         -- of everything sent but secrets
    idempotency_key    TEXT COLLATE "C" NOT NULL,         -- the same for every try of a question in a stage of a job
    attempt            BIGINT NOT NULL,
    reserved_micro_usd BIGINT NOT NULL CHECK (reserved_micro_usd >= 0),
    settled_micro_usd  BIGINT CHECK (settled_micro_usd >= 0),
    outcome            TEXT COLLATE "C",                  -- 'answered', 'outcome_unknown', or the code of a failure
    sent_bytes         BIGINT NOT NULL,
    received_bytes     BIGINT,
    input_tokens       BIGINT,
    output_tokens      BIGINT,
    started_at         BIGINT NOT NULL,
    finished_at        BIGINT,
    CHECK ((outcome IS NULL) = (settled_micro_usd IS NULL))
);
CREATE INDEX calls_of_scene ON calls (scene_id, id);
CREATE INDEX calls_under_way ON calls (job_id) WHERE outcome IS NULL;
CREATE INDEX calls_by_key ON calls (job_id, idempotency_key);
