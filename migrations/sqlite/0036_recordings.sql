-- Recordings: demonstrations of tasks in a finished scene, recorded as a dataset. Processes take attempts of a recording by
-- number; when enough have succeeded, one of them assembles the dataset.

CREATE TABLE recordings (
    id              TEXT PRIMARY KEY,
    tenant_id       TEXT NOT NULL,
    scene_id        TEXT NOT NULL,
    state           TEXT NOT NULL CHECK (state IN ('queued', 'running', 'finished', 'failed', 'cancelled')),
    request         TEXT NOT NULL,  -- versioned, JSON
    bundle          TEXT NOT NULL,  -- blob of the scene's archive, kept while the recording is not ended
    wanted          INTEGER NOT NULL,                -- attempts that succeed
    max_attempts    INTEGER NOT NULL,
    identity        TEXT,           -- of what attempts depend on; NULL until the first process knows
    restarts        INTEGER NOT NULL DEFAULT 0,      -- how often all attempts were dropped for another identity
    begun           INTEGER NOT NULL DEFAULT 0,      -- attempts with a row: the next number
    made            INTEGER NOT NULL DEFAULT 0,      -- attempts with an outcome
    successes       INTEGER NOT NULL DEFAULT 0,
    summary         TEXT,           -- JSON, once ended
    failure_code    TEXT,
    failure_message TEXT,
    owner           TEXT,           -- of the process that assembles
    token           TEXT,           -- of its claim
    lease_until     INTEGER NOT NULL DEFAULT 0,
    tries           INTEGER NOT NULL DEFAULT 0,      -- claims of the assembling
    idempotency_key TEXT,
    body_digest     TEXT NOT NULL,
    created_at      INTEGER NOT NULL,
    started_at      INTEGER,
    finished_at     INTEGER
) STRICT;
CREATE UNIQUE INDEX recordings_by_key ON recordings (tenant_id, idempotency_key) WHERE idempotency_key IS NOT NULL;
CREATE INDEX recordings_listing ON recordings (tenant_id, id DESC);
CREATE INDEX recordings_waiting ON recordings (id) WHERE state IN ('queued', 'running');

-- Attempts of recordings that are not ended. A row without an outcome is being made.
CREATE TABLE recording_attempts (
    recording_id TEXT NOT NULL REFERENCES recordings (id),
    number       INTEGER NOT NULL,
    owner        TEXT NOT NULL,
    token        TEXT NOT NULL,
    lease_until  INTEGER NOT NULL,
    tries        INTEGER NOT NULL,
    outcome      TEXT,
    detail       TEXT,
    unit         TEXT,              -- blob of the episode, if it is recorded
    made_at      INTEGER,
    PRIMARY KEY (recording_id, number)
) STRICT, WITHOUT ROWID;
CREATE INDEX recording_attempts_open ON recording_attempts (recording_id, number) WHERE outcome IS NULL;

-- A format of a dataset: one tar archive, cut into parts that are blobs.
CREATE TABLE recording_archives (
    recording_id TEXT NOT NULL REFERENCES recordings (id),
    format       TEXT NOT NULL,
    digest       TEXT,              -- of the archive; NULL until it is complete
    size         INTEGER NOT NULL,
    files        INTEGER NOT NULL,
    parts        TEXT NOT NULL,     -- JSON: digest and size of each
    PRIMARY KEY (recording_id, format)
) STRICT, WITHOUT ROWID;

-- The files of a dataset: where they are in the archive of their format.
CREATE TABLE recording_files (
    recording_id TEXT NOT NULL REFERENCES recordings (id),
    place        INTEGER NOT NULL,         -- in the list of all files
    path         TEXT NOT NULL,     -- begins with the format
    digest       TEXT NOT NULL,
    start        INTEGER NOT NULL,         -- of its bytes in the archive
    size         INTEGER NOT NULL,
    PRIMARY KEY (recording_id, place)
) STRICT, WITHOUT ROWID;
CREATE UNIQUE INDEX recording_files_by_path ON recording_files (recording_id, path);
