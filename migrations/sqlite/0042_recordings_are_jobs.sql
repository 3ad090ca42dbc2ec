-- The attempts of a recording, and the assembling of its dataset, are jobs.

ALTER TABLE jobs ADD COLUMN recording_id TEXT REFERENCES recordings (id);
-- Of an attempt, within its recording.
ALTER TABLE jobs ADD COLUMN attempt_number INTEGER;
CREATE INDEX jobs_of_recording ON jobs (recording_id, id DESC) WHERE recording_id IS NOT NULL;

-- Attempts that are not made become jobs; a recording that has none gets the job of its next step.
INSERT INTO jobs (id, tenant_id, kind, recording_id, attempt_number, state, created_at, rank_at)
    SELECT recordings.id || '-' || recording_attempts.number, recordings.tenant_id, 'record_attempt', recordings.id,
           recording_attempts.number, 'queued', recordings.created_at, recordings.created_at
    FROM recordings JOIN recording_attempts ON recording_attempts.recording_id = recordings.id
    WHERE recordings.state IN ('queued', 'running') AND recording_attempts.outcome IS NULL;
INSERT INTO jobs (id, tenant_id, kind, recording_id, state, created_at, rank_at)
    SELECT id || '-assembly', tenant_id, 'assemble_recording', id, 'queued', created_at, created_at
    FROM recordings
    WHERE state IN ('queued', 'running') AND made = begun AND (successes >= wanted OR begun >= max_attempts);
INSERT INTO jobs (id, tenant_id, kind, recording_id, attempt_number, state, created_at, rank_at)
    SELECT id || '-' || begun, tenant_id, 'record_attempt', id, begun, 'queued', created_at, created_at
    FROM recordings
    WHERE state IN ('queued', 'running') AND made = begun AND successes < wanted AND begun < max_attempts;
UPDATE recordings SET begun = begun + 1
    WHERE state IN ('queued', 'running') AND made = begun AND successes < wanted AND begun < max_attempts;

-- A row of an attempt is what came of it; `outcome` is NULL while an attempt whose episode was lost is made again.
DELETE FROM recording_attempts WHERE outcome IS NULL;
-- How often the episode of the attempt was lost.
ALTER TABLE recording_attempts ADD COLUMN losses INTEGER NOT NULL DEFAULT 0;
DROP INDEX recording_attempts_open;
DROP INDEX recording_attempts_of_owner;
ALTER TABLE recording_attempts DROP COLUMN owner;
ALTER TABLE recording_attempts DROP COLUMN token;
ALTER TABLE recording_attempts DROP COLUMN lease_until;
ALTER TABLE recording_attempts DROP COLUMN tries;
ALTER TABLE recording_attempts DROP COLUMN was_beside;
ALTER TABLE recording_attempts DROP COLUMN not_before;

DROP INDEX recordings_of_owner;
ALTER TABLE recordings DROP COLUMN owner;
ALTER TABLE recordings DROP COLUMN token;
ALTER TABLE recordings DROP COLUMN lease_until;
ALTER TABLE recordings DROP COLUMN tries;
ALTER TABLE recordings DROP COLUMN not_before;
ALTER TABLE recordings DROP COLUMN shared_deaths;
ALTER TABLE recordings DROP COLUMN lone_deaths;
ALTER TABLE recordings DROP COLUMN was_beside;
ALTER TABLE recordings DROP COLUMN reserved_by;
ALTER TABLE recordings DROP COLUMN reserved_until;
