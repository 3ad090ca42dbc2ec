-- One order of the events of all jobs and recordings of a tenant.
--
-- An event is written without a position, so that transactions do not wait for each other to number their events. Whoever
-- reads the events of a tenant numbers those that were committed meanwhile: one transaction at a time, which holds the row of
-- the counter. Positions therefore become visible in their order, on databases with many writers, too.

CREATE TABLE event_counter (
    id   INTEGER PRIMARY KEY CHECK (id = 1),
    last INTEGER NOT NULL                      -- the greatest position
) STRICT;

ALTER TABLE events ADD COLUMN position INTEGER;            -- NULL until it is numbered
ALTER TABLE events ADD COLUMN tenant_id TEXT;              -- set with the position
ALTER TABLE recording_events ADD COLUMN position INTEGER;
ALTER TABLE recording_events ADD COLUMN tenant_id TEXT;

-- Events so far: by job, then by recording, each in its order.
UPDATE events SET position = numbered.position, tenant_id = numbered.tenant_id
    FROM (SELECT events.job_id, events.seq, jobs.tenant_id,
                 ROW_NUMBER() OVER (ORDER BY events.job_id, events.seq) AS position
          FROM events JOIN jobs ON jobs.id = events.job_id) AS numbered
    WHERE events.job_id = numbered.job_id AND events.seq = numbered.seq;
UPDATE recording_events SET position = numbered.position, tenant_id = numbered.tenant_id
    FROM (SELECT recording_events.recording_id, recording_events.seq, recordings.tenant_id,
                 (SELECT COUNT(*) FROM events)
                     + ROW_NUMBER() OVER (ORDER BY recording_events.recording_id, recording_events.seq) AS position
          FROM recording_events JOIN recordings ON recordings.id = recording_events.recording_id) AS numbered
    WHERE recording_events.recording_id = numbered.recording_id AND recording_events.seq = numbered.seq;
INSERT INTO event_counter (id, last)
    SELECT 1, (SELECT COUNT(*) FROM events) + (SELECT COUNT(*) FROM recording_events);

CREATE INDEX events_unnumbered ON events (job_id, seq) WHERE position IS NULL;
CREATE INDEX recording_events_unnumbered ON recording_events (recording_id, seq) WHERE position IS NULL;
CREATE UNIQUE INDEX events_of_tenant ON events (tenant_id, position) WHERE position IS NOT NULL;
CREATE UNIQUE INDEX recording_events_of_tenant ON recording_events (tenant_id, position) WHERE position IS NOT NULL;
