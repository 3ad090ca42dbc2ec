-- The whole schema. Times are milliseconds since 1970 from the database's clock; JSON columns hold text.

CREATE TABLE scenes (
    id              TEXT PRIMARY KEY,
    tenant_id       TEXT NOT NULL DEFAULT 'default',
    parent_id       TEXT REFERENCES scenes (id),
    state           TEXT NOT NULL CHECK (state IN ('pending', 'ready', 'failed', 'deleted')),
    verdict         TEXT CHECK (verdict IN ('pass', 'quarantine')),
    failure_code    TEXT,
    failure_message TEXT,
    request         TEXT NOT NULL,            -- versioned SceneRequest
    labels          TEXT NOT NULL DEFAULT '{}',
    summary         TEXT,                     -- what the pipeline says about the finished scene
    metrics         TEXT,
    created_at      INTEGER NOT NULL,
    updated_at      INTEGER NOT NULL,
    expires_at      INTEGER
) STRICT;
CREATE INDEX scenes_listing ON scenes (tenant_id, id DESC);
CREATE INDEX scenes_children ON scenes (parent_id) WHERE parent_id IS NOT NULL;

CREATE TABLE jobs (
    id              TEXT PRIMARY KEY,
    tenant_id       TEXT NOT NULL DEFAULT 'default',
    kind            TEXT NOT NULL,
    scene_id        TEXT REFERENCES scenes (id),
    batch_id        TEXT,
    retry_of        TEXT REFERENCES jobs (id),
    from_stage      TEXT,                     -- from this stage on, finished work is not reused
    salt            TEXT,                     -- what makes those keys new
    priority        INTEGER NOT NULL DEFAULT 0,
    state           TEXT NOT NULL
        CHECK (state IN ('queued', 'running', 'cancelling', 'succeeded', 'failed', 'cancelled')),
    attempt         INTEGER NOT NULL DEFAULT 0,   -- claims since the last new checkpoint
    not_before      INTEGER NOT NULL DEFAULT 0,
    owner           TEXT,
    epoch           INTEGER NOT NULL DEFAULT 0,
    lease_until     INTEGER,
    next_seq        INTEGER NOT NULL DEFAULT 1,   -- of its events
    failure_class   TEXT,
    failure_code    TEXT,
    failure_message TEXT,
    created_at      INTEGER NOT NULL,
    started_at      INTEGER,
    finished_at     INTEGER
) STRICT;
CREATE INDEX jobs_queue ON jobs (priority DESC, id) WHERE state = 'queued';
CREATE INDEX jobs_leased ON jobs (lease_until) WHERE state IN ('running', 'cancelling');
CREATE INDEX jobs_of_scene ON jobs (scene_id, id DESC);

CREATE TABLE events (
    job_id TEXT NOT NULL REFERENCES jobs (id),
    seq    INTEGER NOT NULL,
    at     INTEGER NOT NULL,
    kind   TEXT NOT NULL,
    data   TEXT NOT NULL,
    PRIMARY KEY (job_id, seq)
) STRICT, WITHOUT ROWID;

-- A finished stage, shared by every job of the tenant that asks for the same key.
CREATE TABLE checkpoints (
    tenant_id  TEXT NOT NULL,
    key        TEXT NOT NULL,
    stage      TEXT NOT NULL,
    version    INTEGER NOT NULL,
    instance   TEXT NOT NULL DEFAULT '',
    output     TEXT NOT NULL,                 -- digest of the blob with the stage's output
    artifacts  TEXT NOT NULL,                 -- what it put, as JSON
    elapsed_ms INTEGER NOT NULL,
    created_at INTEGER NOT NULL,
    PRIMARY KEY (tenant_id, key)
) STRICT, WITHOUT ROWID;

-- What one job did, stage by stage.
CREATE TABLE stages (
    job_id     TEXT NOT NULL REFERENCES jobs (id),
    stage      TEXT NOT NULL,
    instance   TEXT NOT NULL DEFAULT '',
    key        TEXT NOT NULL,
    state      TEXT NOT NULL CHECK (state IN ('running', 'finished')),
    cached     INTEGER NOT NULL DEFAULT 0,
    epoch      INTEGER NOT NULL,
    runs       INTEGER NOT NULL DEFAULT 0,    -- how often this job started computing it
    elapsed_ms INTEGER,
    started_at INTEGER NOT NULL,
    PRIMARY KEY (job_id, stage, instance)
) STRICT, WITHOUT ROWID;

CREATE TABLE artifacts (
    scene_id   TEXT NOT NULL REFERENCES scenes (id),
    name       TEXT NOT NULL,
    stage      TEXT NOT NULL,
    job_id     TEXT NOT NULL REFERENCES jobs (id),
    digest     TEXT NOT NULL,
    media_type TEXT NOT NULL,
    size       INTEGER NOT NULL,
    created_at INTEGER NOT NULL,
    PRIMARY KEY (scene_id, name)
) STRICT, WITHOUT ROWID;

-- The finished bundle, file by file, and its archives by format ('all' comes from the pipeline).
CREATE TABLE bundle_files (
    scene_id   TEXT NOT NULL REFERENCES scenes (id),
    path       TEXT NOT NULL,
    digest     TEXT NOT NULL,
    media_type TEXT NOT NULL,
    size       INTEGER NOT NULL,
    PRIMARY KEY (scene_id, path)
) STRICT, WITHOUT ROWID;

CREATE TABLE bundle_archives (
    scene_id TEXT NOT NULL REFERENCES scenes (id),
    format   TEXT NOT NULL,
    digest   TEXT NOT NULL,
    size     INTEGER NOT NULL,
    PRIMARY KEY (scene_id, format)
) STRICT, WITHOUT ROWID;

CREATE TABLE idempotency (
    tenant_id   TEXT NOT NULL,
    key         TEXT NOT NULL,
    body_digest TEXT NOT NULL,
    scene_id    TEXT NOT NULL REFERENCES scenes (id),
    job_id      TEXT NOT NULL REFERENCES jobs (id),
    expires_at  INTEGER NOT NULL,
    PRIMARY KEY (tenant_id, key)
) STRICT, WITHOUT ROWID;
CREATE INDEX idempotency_expiry ON idempotency (expires_at);
