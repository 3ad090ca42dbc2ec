-- Recordings: demonstrations of tasks in a finished scene, recorded as a dataset. Processes take attempts of a recording by
-- number; when enough have succeeded, one of them assembles the dataset.

CREATE TABLE recordings (
    id              TEXT COLLATE "C" PRIMARY KEY,
    tenant_id       TEXT COLLATE "C" NOT NULL,
    scene_id        TEXT COLLATE "C" NOT NULL,
    state           TEXT COLLATE "C" NOT NULL CHECK (state IN ('queued', 'running', 'finished', 'failed', 'cancelled')),
    request         TEXT COLLATE "C" NOT NULL,  -- versioned, JSON
    bundle          TEXT COLLATE "C" NOT NULL,  -- blob of the scene's archive, kept while the recording is not ended
    wanted          BIGINT NOT NULL,                -- attempts that succeed
    max_attempts    BIGINT NOT NULL,
    identity        TEXT COLLATE "C",           -- of what attempts depend on; NULL until the first process knows
    restarts        BIGINT NOT NULL DEFAULT 0,      -- how often all attempts were dropped for another identity
    begun           BIGINT NOT NULL DEFAULT 0,      -- attempts with a row: the next number
    made            BIGINT NOT NULL DEFAULT 0,      -- attempts with an outcome
    successes       BIGINT NOT NULL DEFAULT 0,
    summary         TEXT COLLATE "C",           -- JSON, once ended
    failure_code    TEXT COLLATE "C",
    failure_message TEXT COLLATE "C",
    owner           TEXT COLLATE "C",           -- of the process that assembles
    token           TEXT COLLATE "C",           -- of its claim
    lease_until     BIGINT NOT NULL DEFAULT 0,
    tries           BIGINT NOT NULL DEFAULT 0,      -- claims of the assembling
    idempotency_key TEXT COLLATE "C",
    body_digest     TEXT COLLATE "C" NOT NULL,
    created_at      BIGINT NOT NULL,
    started_at      BIGINT,
    finished_at     BIGINT
);
CREATE UNIQUE INDEX recordings_by_key ON recordings (tenant_id, idempotency_key) WHERE idempotency_key IS NOT NULL;
CREATE INDEX recordings_listing ON recordings (tenant_id, id DESC);
CREATE INDEX recordings_waiting ON recordings (id) WHERE state IN ('queued', 'running');

-- Attempts of recordings that are not ended. A row without an outcome is being made.
CREATE TABLE recording_attempts (
    recording_id TEXT COLLATE "C" NOT NULL REFERENCES recordings (id),
    number       BIGINT NOT NULL,
    owner        TEXT COLLATE "C" NOT NULL,
    token        TEXT COLLATE "C" NOT NULL,
    lease_until  BIGINT NOT NULL,
    tries        BIGINT NOT NULL,
    outcome      TEXT COLLATE "C",
    detail       TEXT COLLATE "C",
    unit         TEXT COLLATE "C",              -- blob of the episode, if it is recorded
    made_at      BIGINT,
    PRIMARY KEY (recording_id, number)
);
CREATE INDEX recording_attempts_open ON recording_attempts (recording_id, number) WHERE outcome IS NULL;

-- A format of a dataset: one tar archive, cut into parts that are blobs.
CREATE TABLE recording_archives (
    recording_id TEXT COLLATE "C" NOT NULL REFERENCES recordings (id),
    format       TEXT COLLATE "C" NOT NULL,
    digest       TEXT COLLATE "C",              -- of the archive; NULL until it is complete
    size         BIGINT NOT NULL,
    files        BIGINT NOT NULL,
    parts        TEXT COLLATE "C" NOT NULL,     -- JSON: digest and size of each
    PRIMARY KEY (recording_id, format)
);

-- The files of a dataset: where they are in the archive of their format.
CREATE TABLE recording_files (
    recording_id TEXT COLLATE "C" NOT NULL REFERENCES recordings (id),
    place        BIGINT NOT NULL,         -- in the list of all files
    path         TEXT COLLATE "C" NOT NULL,     -- begins with the format
    digest       TEXT COLLATE "C" NOT NULL,
    start        BIGINT NOT NULL,         -- of its bytes in the archive
    size         BIGINT NOT NULL,
    PRIMARY KEY (recording_id, place)
);
CREATE UNIQUE INDEX recording_files_by_path ON recording_files (recording_id, path);
