-- Datasets: frozen sets of finished scenes. A row is one freeze; what it made is a version of the dataset with its name.

CREATE TABLE datasets (
    id              TEXT PRIMARY KEY,
    tenant_id       TEXT NOT NULL,
    name            TEXT NOT NULL,
    version         INTEGER,                     -- NULL until it is frozen
    state           TEXT NOT NULL CHECK (state IN ('queued', 'running', 'finished', 'failed')),
    request         TEXT NOT NULL,               -- versioned, JSON
    digest          TEXT,                        -- of the manifest, as dataset.json states it
    summary         TEXT,                        -- JSON: counts, selection, changes
    failure_code    TEXT,
    failure_message TEXT,
    verify_state    TEXT CHECK (verify_state IN ('queued', 'running', 'finished')),
    verification    TEXT,                        -- JSON: what was found last
    steps_done      INTEGER NOT NULL DEFAULT 0,  -- of the work in progress
    steps_all       INTEGER NOT NULL DEFAULT 0,
    owner           TEXT,
    epoch           INTEGER NOT NULL DEFAULT 0,
    lease_until     INTEGER NOT NULL DEFAULT 0,
    attempt         INTEGER NOT NULL DEFAULT 0,  -- claims of the work in progress
    idempotency_key TEXT,
    body_digest     TEXT NOT NULL,
    created_at      INTEGER NOT NULL,
    finished_at     INTEGER
) STRICT;
CREATE UNIQUE INDEX datasets_by_key ON datasets (tenant_id, idempotency_key) WHERE idempotency_key IS NOT NULL;
-- Freezes of one name follow each other, so that every version has another number.
CREATE UNIQUE INDEX datasets_freezing ON datasets (tenant_id, name) WHERE state = 'running';
CREATE INDEX datasets_listing ON datasets (tenant_id, id DESC);
CREATE INDEX datasets_of_name ON datasets (tenant_id, name, version DESC);
CREATE INDEX datasets_waiting ON datasets (id)
    WHERE state IN ('queued', 'running') OR verify_state IN ('queued', 'running');

-- The files of a version; their bytes are blobs.
CREATE TABLE dataset_files (
    dataset_id TEXT NOT NULL REFERENCES datasets (id),
    path       TEXT NOT NULL,
    digest     TEXT NOT NULL,
    size       INTEGER NOT NULL,
    media_type TEXT NOT NULL,
    PRIMARY KEY (dataset_id, path)
) STRICT, WITHOUT ROWID;
