-- Freezing and verifying a dataset are jobs: one queue, one lease, one set of rules for all background work.

-- What a job works on, if it is no scene.
ALTER TABLE jobs ADD COLUMN dataset_id TEXT REFERENCES datasets (id);
-- Of the jobs of a tenant with the same key one runs at a time, in the order of their ids.
ALTER TABLE jobs ADD COLUMN exclusive_key TEXT;
CREATE INDEX jobs_of_dataset ON jobs (dataset_id, id DESC) WHERE dataset_id IS NOT NULL;
CREATE INDEX jobs_exclusive ON jobs (tenant_id, exclusive_key, id)
    WHERE exclusive_key IS NOT NULL AND state IN ('queued', 'running', 'cancelling');
CREATE UNIQUE INDEX jobs_of_key ON jobs (tenant_id, exclusive_key)
    WHERE exclusive_key IS NOT NULL AND state IN ('running', 'cancelling');

-- The newest job of a dataset: its freeze, or its last verification.
ALTER TABLE datasets ADD COLUMN job_id TEXT;

-- Work that waits or is in progress becomes a job with the id of its dataset, and begins again where it was.
INSERT INTO jobs (id, tenant_id, kind, dataset_id, exclusive_key, state, attempt, not_before, created_at, rank_at,
                  shared_deaths, lone_deaths)
    SELECT id, tenant_id, CASE WHEN state = 'finished' THEN 'verify_dataset' ELSE 'freeze_dataset' END, id,
           CASE WHEN state = 'finished' THEN NULL ELSE 'dataset ' || name END, 'queued',
           CASE WHEN owner IS NOT NULL AND attempt > 0 THEN attempt - 1 ELSE attempt END, not_before, created_at, created_at,
           shared_deaths, lone_deaths
    FROM datasets WHERE state IN ('queued', 'running') OR verify_state IN ('queued', 'running');
UPDATE datasets SET job_id = id WHERE state IN ('queued', 'running') OR verify_state IN ('queued', 'running');
UPDATE datasets SET state = 'queued' WHERE state = 'running';
UPDATE datasets SET verify_state = 'queued' WHERE verify_state = 'running';

DROP INDEX datasets_freezing;
DROP INDEX datasets_waiting;
DROP INDEX datasets_of_owner;
ALTER TABLE datasets DROP COLUMN owner;
ALTER TABLE datasets DROP COLUMN epoch;
ALTER TABLE datasets DROP COLUMN lease_until;
ALTER TABLE datasets DROP COLUMN attempt;
ALTER TABLE datasets DROP COLUMN not_before;
ALTER TABLE datasets DROP COLUMN shared_deaths;
ALTER TABLE datasets DROP COLUMN lone_deaths;
ALTER TABLE datasets DROP COLUMN was_beside;
ALTER TABLE datasets DROP COLUMN reserved_by;
ALTER TABLE datasets DROP COLUMN reserved_until;
