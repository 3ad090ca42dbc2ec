-- Events of recordings, numbered 1, 2, 3, ... within the recording. Each is written with the change that it tells of.
-- Recordings from before have events of their later changes only.

CREATE TABLE recording_events (
    recording_id TEXT COLLATE "C" NOT NULL REFERENCES recordings (id),
    seq          BIGINT NOT NULL,
    at           BIGINT NOT NULL,
    kind         TEXT COLLATE "C" NOT NULL,
    data         TEXT COLLATE "C" NOT NULL,     -- JSON
    PRIMARY KEY (recording_id, seq)
);
