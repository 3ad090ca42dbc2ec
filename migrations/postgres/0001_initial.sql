-- The whole schema. Times are milliseconds since 1970 from the database's clock; JSON columns hold text.

CREATE TABLE scenes (
    id              TEXT COLLATE "C" PRIMARY KEY,
    tenant_id       TEXT COLLATE "C" NOT NULL DEFAULT 'default',
    parent_id       TEXT COLLATE "C" REFERENCES scenes (id),
    state           TEXT COLLATE "C" NOT NULL CHECK (state IN ('pending', 'ready', 'failed', 'deleted')),
    verdict         TEXT COLLATE "C" CHECK (verdict IN ('pass', 'quarantine')),
    failure_code    TEXT COLLATE "C",
    failure_message TEXT COLLATE "C",
    request         TEXT COLLATE "C" NOT NULL,            -- versioned SceneRequest
    labels          TEXT COLLATE "C" NOT NULL DEFAULT '{}',
    summary         TEXT COLLATE "C",                     -- what the pipeline says about the finished scene
    metrics         TEXT COLLATE "C",
    created_at      BIGINT NOT NULL,
    updated_at      BIGINT NOT NULL,
    expires_at      BIGINT
);
CREATE INDEX scenes_listing ON scenes (tenant_id, id DESC);
CREATE INDEX scenes_children ON scenes (parent_id) WHERE parent_id IS NOT NULL;

CREATE TABLE jobs (
    id              TEXT COLLATE "C" PRIMARY KEY,
    tenant_id       TEXT COLLATE "C" NOT NULL DEFAULT 'default',
    kind            TEXT COLLATE "C" NOT NULL,
    scene_id        TEXT COLLATE "C" REFERENCES scenes (id),
    batch_id        TEXT COLLATE "C",
    retry_of        TEXT COLLATE "C" REFERENCES jobs (id),
    from_stage      TEXT COLLATE "C",                     -- from this stage on, finished work is not reused
    salt            TEXT COLLATE "C",                     -- what makes those keys new
    priority        BIGINT NOT NULL DEFAULT 0,
    state           TEXT COLLATE "C" NOT NULL
        CHECK (state IN ('queued', 'running', 'cancelling', 'succeeded', 'failed', 'cancelled')),
    attempt         BIGINT NOT NULL DEFAULT 0,   -- claims since the last new checkpoint
    not_before      BIGINT NOT NULL DEFAULT 0,
    owner           TEXT COLLATE "C",
    epoch           BIGINT NOT NULL DEFAULT 0,
    lease_until     BIGINT,
    next_seq        BIGINT NOT NULL DEFAULT 1,   -- of its events
    failure_class   TEXT COLLATE "C",
    failure_code    TEXT COLLATE "C",
    failure_message TEXT COLLATE "C",
    created_at      BIGINT NOT NULL,
    started_at      BIGINT,
    finished_at     BIGINT
);
CREATE INDEX jobs_queue ON jobs (priority DESC, id) WHERE state = 'queued';
CREATE INDEX jobs_leased ON jobs (lease_until) WHERE state IN ('running', 'cancelling');
CREATE INDEX jobs_of_scene ON jobs (scene_id, id DESC);

CREATE TABLE events (
    job_id TEXT COLLATE "C" NOT NULL REFERENCES jobs (id),
    seq    BIGINT NOT NULL,
    at     BIGINT NOT NULL,
    kind   TEXT COLLATE "C" NOT NULL,
    data   TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (job_id, seq)
);

-- A finished stage, shared by every job of the tenant that asks for the same key.
CREATE TABLE checkpoints (
    tenant_id  TEXT COLLATE "C" NOT NULL,
    key        TEXT COLLATE "C" NOT NULL,
    stage      TEXT COLLATE "C" NOT NULL,
    version    BIGINT NOT NULL,
    instance   TEXT COLLATE "C" NOT NULL DEFAULT '',
    output     TEXT COLLATE "C" NOT NULL,                 -- digest of the blob with the stage's output
    artifacts  TEXT COLLATE "C" NOT NULL,                 -- what it put, as JSON
    elapsed_ms BIGINT NOT NULL,
    created_at BIGINT NOT NULL,
    PRIMARY KEY (tenant_id, key)
);

-- What one job did, stage by stage.
CREATE TABLE stages (
    job_id     TEXT COLLATE "C" NOT NULL REFERENCES jobs (id),
    stage      TEXT COLLATE "C" NOT NULL,
    instance   TEXT COLLATE "C" NOT NULL DEFAULT '',
    key        TEXT COLLATE "C" NOT NULL,
    state      TEXT COLLATE "C" NOT NULL CHECK (state IN ('running', 'finished')),
    cached     BIGINT NOT NULL DEFAULT 0,
    epoch      BIGINT NOT NULL,
    runs       BIGINT NOT NULL DEFAULT 0,    -- how often this job started computing it
    elapsed_ms BIGINT,
    started_at BIGINT NOT NULL,
    PRIMARY KEY (job_id, stage, instance)
);

CREATE TABLE artifacts (
    scene_id   TEXT COLLATE "C" NOT NULL REFERENCES scenes (id),
    name       TEXT COLLATE "C" NOT NULL,
    stage      TEXT COLLATE "C" NOT NULL,
    job_id     TEXT COLLATE "C" NOT NULL REFERENCES jobs (id),
    digest     TEXT COLLATE "C" NOT NULL,
    media_type TEXT COLLATE "C" NOT NULL,
    size       BIGINT NOT NULL,
    created_at BIGINT NOT NULL,
    PRIMARY KEY (scene_id, name)
);

-- The finished bundle, file by file, and its archives by format ('all' comes from the pipeline).
CREATE TABLE bundle_files (
    scene_id   TEXT COLLATE "C" NOT NULL REFERENCES scenes (id),
    path       TEXT COLLATE "C" NOT NULL,
    digest     TEXT COLLATE "C" NOT NULL,
    media_type TEXT COLLATE "C" NOT NULL,
    size       BIGINT NOT NULL,
    PRIMARY KEY (scene_id, path)
);

CREATE TABLE bundle_archives (
    scene_id TEXT COLLATE "C" NOT NULL REFERENCES scenes (id),
    format   TEXT COLLATE "C" NOT NULL,
    digest   TEXT COLLATE "C" NOT NULL,
    size     BIGINT NOT NULL,
    PRIMARY KEY (scene_id, format)
);

CREATE TABLE idempotency (
    tenant_id   TEXT COLLATE "C" NOT NULL,
    key         TEXT COLLATE "C" NOT NULL,
    body_digest TEXT COLLATE "C" NOT NULL,
    scene_id    TEXT COLLATE "C" NOT NULL REFERENCES scenes (id),
    job_id      TEXT COLLATE "C" NOT NULL REFERENCES jobs (id),
    expires_at  BIGINT NOT NULL,
    PRIMARY KEY (tenant_id, key)
);
CREATE INDEX idempotency_expiry ON idempotency (expires_at);
