-- Deaths and failures of background work, by the rules of jobs: who is blamed, who runs alone, and who waits.

-- Work on a dataset does not start earlier; set by the delay after a death or a failed attempt.
ALTER TABLE datasets ADD COLUMN not_before BIGINT NOT NULL DEFAULT 0;
-- Deaths of its process since its last progress: beside other work, and alone.
ALTER TABLE datasets ADD COLUMN shared_deaths BIGINT NOT NULL DEFAULT 0;
ALTER TABLE datasets ADD COLUMN lone_deaths BIGINT NOT NULL DEFAULT 0;
ALTER TABLE datasets ADD COLUMN was_beside BIGINT NOT NULL DEFAULT 0;       -- other work of its owner was rescued
-- A process that finishes its other work to do this alone, and until when that counts.
ALTER TABLE datasets ADD COLUMN reserved_by TEXT COLLATE "C";
ALTER TABLE datasets ADD COLUMN reserved_until BIGINT NOT NULL DEFAULT 0;
CREATE INDEX datasets_of_owner ON datasets (owner) WHERE state = 'running' OR verify_state = 'running';

-- The same of recordings; a process that dies costs a recording one death, however many of its attempts it was making.
ALTER TABLE recordings ADD COLUMN not_before BIGINT NOT NULL DEFAULT 0;
ALTER TABLE recordings ADD COLUMN shared_deaths BIGINT NOT NULL DEFAULT 0;
ALTER TABLE recordings ADD COLUMN lone_deaths BIGINT NOT NULL DEFAULT 0;
ALTER TABLE recordings ADD COLUMN was_beside BIGINT NOT NULL DEFAULT 0;     -- of the process that assembles
ALTER TABLE recordings ADD COLUMN reserved_by TEXT COLLATE "C";
ALTER TABLE recordings ADD COLUMN reserved_until BIGINT NOT NULL DEFAULT 0;
ALTER TABLE recording_attempts ADD COLUMN was_beside BIGINT NOT NULL DEFAULT 0;
CREATE INDEX recordings_of_owner ON recordings (owner) WHERE owner IS NOT NULL;
CREATE INDEX recording_attempts_of_owner ON recording_attempts (owner) WHERE outcome IS NULL;
