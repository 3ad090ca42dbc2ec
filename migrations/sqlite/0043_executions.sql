-- Executions of tasks are jobs, whose answers are kept for a time. The job has the id of the execution.

CREATE TABLE executions (
    job_id     TEXT PRIMARY KEY REFERENCES jobs (id),
    tenant_id  TEXT NOT NULL,
    scene_id   TEXT NOT NULL,
    request    TEXT NOT NULL,      -- versioned, JSON
    bundle     TEXT NOT NULL,      -- blob of the scene's archive, kept until there is an answer or a failure
    answer     TEXT,               -- blob of the answer
    media_type TEXT,               -- of the answer
    size       INTEGER             -- of the answer, bytes
) STRICT, WITHOUT ROWID;
-- Which executions have ended long ago.
CREATE INDEX jobs_executed ON jobs (finished_at) WHERE kind = 'execute_task';
-- Waiting jobs by kind: how many scenes wait.
CREATE INDEX jobs_waiting ON jobs (kind, tenant_id) WHERE state = 'queued';
