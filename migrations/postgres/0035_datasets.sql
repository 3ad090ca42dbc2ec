-- Datasets: frozen sets of finished scenes. A row is one freeze; what it made is a version of the dataset with its name.

CREATE TABLE datasets (
    id              TEXT COLLATE "C" PRIMARY KEY,
    tenant_id       TEXT COLLATE "C" NOT NULL,
    name            TEXT COLLATE "C" NOT NULL,
    version         BIGINT,                     -- NULL until it is frozen
    state           TEXT COLLATE "C" NOT NULL CHECK (state IN ('queued', 'running', 'finished', 'failed')),
    request         TEXT COLLATE "C" NOT NULL,               -- versioned, JSON
    digest          TEXT COLLATE "C",                        -- of the manifest, as dataset.json states it
    summary         TEXT COLLATE "C",                        -- JSON: counts, selection, changes
    failure_code    TEXT COLLATE "C",
    failure_message TEXT COLLATE "C",
    verify_state    TEXT COLLATE "C" CHECK (verify_state IN ('queued', 'running', 'finished')),
    verification    TEXT COLLATE "C",                        -- JSON: what was found last
    steps_done      BIGINT NOT NULL DEFAULT 0,  -- of the work in progress
    steps_all       BIGINT NOT NULL DEFAULT 0,
    owner           TEXT COLLATE "C",
    epoch           BIGINT NOT NULL DEFAULT 0,
    lease_until     BIGINT NOT NULL DEFAULT 0,
    attempt         BIGINT NOT NULL DEFAULT 0,  -- claims of the work in progress
    idempotency_key TEXT COLLATE "C",
    body_digest     TEXT COLLATE "C" NOT NULL,
    created_at      BIGINT NOT NULL,
    finished_at     BIGINT
);
CREATE UNIQUE INDEX datasets_by_key ON datasets (tenant_id, idempotency_key) WHERE idempotency_key IS NOT NULL;
-- Freezes of one name follow each other, so that every version has another number.
CREATE UNIQUE INDEX datasets_freezing ON datasets (tenant_id, name) WHERE state = 'running';
CREATE INDEX datasets_listing ON datasets (tenant_id, id DESC);
CREATE INDEX datasets_of_name ON datasets (tenant_id, name, version DESC);
CREATE INDEX datasets_waiting ON datasets (id)
    WHERE state IN ('queued', 'running') OR verify_state IN ('queued', 'running');

-- The files of a version; their bytes are blobs.
CREATE TABLE dataset_files (
    dataset_id TEXT COLLATE "C" NOT NULL REFERENCES datasets (id),
    path       TEXT COLLATE "C" NOT NULL,
    digest     TEXT COLLATE "C" NOT NULL,
    size       BIGINT NOT NULL,
    media_type TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (dataset_id, path)
);
