-- Events of recordings, numbered 1, 2, 3, ... within the recording. Each is written with the change that it tells of.
-- Recordings from before have events of their later changes only.

CREATE TABLE recording_events (
    recording_id TEXT NOT NULL REFERENCES recordings (id),
    seq          INTEGER NOT NULL,
    at           INTEGER NOT NULL,
    kind         TEXT NOT NULL,
    data         TEXT NOT NULL,     -- JSON
    PRIMARY KEY (recording_id, seq)
) STRICT, WITHOUT ROWID;
