-- Fair turns, schedules, deaths of processes, stage keys in progress, and the switch that pauses claiming.

-- Version of the stored request: a worker claims no job whose request it cannot read.
ALTER TABLE jobs ADD COLUMN request_version BIGINT NOT NULL DEFAULT 1;
-- Place in its tenant's queue: the time of submission (or `not_before`), moved by the priority; NULL = created_at.
ALTER TABLE jobs ADD COLUMN rank_at BIGINT;
ALTER TABLE jobs ADD COLUMN deadline_at BIGINT;
ALTER TABLE jobs ADD COLUMN claimed_at BIGINT;                           -- its newest claim
-- Deaths of its process since the last new checkpoint: beside other jobs, and alone.
ALTER TABLE jobs ADD COLUMN shared_deaths BIGINT NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN lone_deaths BIGINT NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN was_beside BIGINT NOT NULL DEFAULT 0;        -- another job of its owner was rescued
-- A worker that finishes its other jobs to run this one alone, and until when that counts.
ALTER TABLE jobs ADD COLUMN reserved_by TEXT;
ALTER TABLE jobs ADD COLUMN reserved_until BIGINT NOT NULL DEFAULT 0;

CREATE INDEX jobs_turns ON jobs (tenant_id, (COALESCE(rank_at, created_at)), id) WHERE state = 'queued';
CREATE INDEX jobs_alone ON jobs ((COALESCE(rank_at, created_at)), id) WHERE state = 'queued' AND shared_deaths + lone_deaths >= 2;
CREATE INDEX jobs_deadlines ON jobs (deadline_at) WHERE state = 'queued';
CREATE INDEX jobs_claimed ON jobs (tenant_id, claimed_at);
CREATE INDEX jobs_of_owner ON jobs (owner) WHERE state IN ('running', 'cancelling');
CREATE INDEX jobs_active ON jobs (tenant_id) WHERE state IN ('running', 'cancelling');

-- Stage keys in progress. A claim counts while its job holds the lease of that epoch.
CREATE TABLE stage_claims (
    tenant_id  TEXT NOT NULL,
    key        TEXT NOT NULL,
    job_id     TEXT NOT NULL REFERENCES jobs (id),
    epoch      BIGINT NOT NULL,
    claimed_at BIGINT NOT NULL,
    PRIMARY KEY (tenant_id, key)
);
CREATE INDEX stage_claims_of_job ON stage_claims (job_id);

-- Settings that operators change while processes run. `claiming` = 'paused': workers take no new jobs.
CREATE TABLE switches (
    name       TEXT PRIMARY KEY,
    value      TEXT NOT NULL,
    reason     TEXT NOT NULL DEFAULT '',
    changed_at BIGINT NOT NULL
);
