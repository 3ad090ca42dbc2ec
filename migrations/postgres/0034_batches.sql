-- Batches: many requests for scenes that are submitted together and put into the queue a few at a time.

CREATE TABLE batches (
    id               TEXT COLLATE "C" PRIMARY KEY,
    tenant_id        TEXT COLLATE "C" NOT NULL,
    name             TEXT COLLATE "C" NOT NULL DEFAULT '',
    -- While it is 'receiving', its items are being stored and no query of clients finds it.
    state            TEXT COLLATE "C" NOT NULL CHECK (state IN ('receiving', 'running', 'cancelling', 'finished', 'cancelled')),
    budget_micro_usd BIGINT,                     -- of all items together; NULL = only each item's own
    spent_micro_usd  BIGINT NOT NULL DEFAULT 0,  -- by items that have ended
    idempotency_key  TEXT COLLATE "C",
    body_digest      TEXT COLLATE "C" NOT NULL,
    created_at       BIGINT NOT NULL,
    started_at       BIGINT NOT NULL,            -- of the present run; a retry begins another one
    finished_at      BIGINT
);
CREATE UNIQUE INDEX batches_by_key ON batches (tenant_id, idempotency_key)
    WHERE idempotency_key IS NOT NULL AND state <> 'receiving';
CREATE INDEX batches_listing ON batches (tenant_id, id DESC);
CREATE INDEX batches_active ON batches (id) WHERE state IN ('running', 'cancelling');
CREATE INDEX batches_receiving ON batches (created_at) WHERE state = 'receiving';

-- One request. `submitted`: it has a scene and a job, whose states say the rest until the item is settled. Scene and job are no
-- references: the item outlives a deleted scene.
CREATE TABLE batch_items (
    batch_id         TEXT COLLATE "C" NOT NULL REFERENCES batches (id),
    place            BIGINT NOT NULL,            -- line of the body, or number of the request of a recipe, from 1
    custom_id        TEXT COLLATE "C",                        -- NULL = the line has no name that can be read
    state            TEXT COLLATE "C" NOT NULL CHECK (state IN ('pending', 'submitted', 'succeeded', 'failed', 'quarantined',
                                                    'cancelled', 'duplicate', 'invalid')),
    request          TEXT COLLATE "C",                        -- versioned SceneRequest; NULL = never computed
    labels           TEXT COLLATE "C" NOT NULL DEFAULT '{}',
    budget_micro_usd BIGINT NOT NULL DEFAULT 0,  -- what it asks for at most
    spent_micro_usd  BIGINT NOT NULL DEFAULT 0,  -- when it was settled last
    duplicate_of     TEXT COLLATE "C",                        -- custom_id of the first request for the same scene
    scene_id         TEXT COLLATE "C",
    job_id           TEXT COLLATE "C",                        -- its newest
    error            TEXT COLLATE "C",                        -- JSON
    cpu_ms           BIGINT NOT NULL DEFAULT 0,
    attempts         BIGINT NOT NULL DEFAULT 0,
    settled_at       BIGINT,
    PRIMARY KEY (batch_id, place)
);
CREATE INDEX batch_items_by_state ON batch_items (batch_id, state, place);
CREATE INDEX batch_items_of_scene ON batch_items (scene_id) WHERE scene_id IS NOT NULL;
CREATE INDEX batch_items_settled ON batch_items (batch_id, settled_at) WHERE settled_at IS NOT NULL;

CREATE INDEX jobs_of_batch ON jobs (batch_id, id DESC) WHERE batch_id IS NOT NULL;
