-- Indexes that removals and lists need. A row is removed only when no row refers to it: without an index on the referring
-- column every removal reads the whole table. IF NOT EXISTS: whoever cannot stop writing for the seconds that a large table
-- takes creates them before, one by one (see "Upgrade" in docs/operations.md).

CREATE INDEX IF NOT EXISTS artifacts_of_job ON artifacts (job_id);
CREATE INDEX IF NOT EXISTS idempotency_of_job ON idempotency (job_id);
CREATE INDEX IF NOT EXISTS jobs_retried ON jobs (retry_of) WHERE retry_of IS NOT NULL;

-- Lists, by state and by what their rows belong to. The tenant comes first, so that none is mistaken for the list of all.
CREATE INDEX IF NOT EXISTS scenes_present ON scenes (tenant_id, id DESC) WHERE state <> 'deleted';
CREATE INDEX IF NOT EXISTS scenes_by_state ON scenes (tenant_id, state, id DESC);
CREATE INDEX IF NOT EXISTS batches_by_state ON batches (tenant_id, state, id DESC);
CREATE INDEX IF NOT EXISTS datasets_by_state ON datasets (tenant_id, state, id DESC);
CREATE INDEX IF NOT EXISTS recordings_by_state ON recordings (tenant_id, state, id DESC);
CREATE INDEX IF NOT EXISTS recordings_of_scene ON recordings (tenant_id, scene_id, id DESC);
CREATE INDEX IF NOT EXISTS datasets_by_name ON datasets (tenant_id, name, id DESC);
CREATE INDEX IF NOT EXISTS jobs_by_scene ON jobs (tenant_id, scene_id, id DESC);
CREATE INDEX IF NOT EXISTS scenes_by_parent ON scenes (tenant_id, parent_id, id DESC) WHERE parent_id IS NOT NULL;

-- What operators and sweeps look for.
CREATE INDEX IF NOT EXISTS jobs_crashed ON jobs (id DESC) WHERE failure_code = 'worker_crashed';
CREATE INDEX IF NOT EXISTS scenes_quarantined ON scenes (updated_at) WHERE failure_code = 'quarantined';
