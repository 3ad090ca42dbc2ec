-- Indexes of the lists of jobs. Each serves one state, so that none of them is mistaken for the queue's; queued jobs are the
-- newest ones anyway. Jobs that succeeded also tell how long jobs take.

CREATE INDEX jobs_listing ON jobs (tenant_id, id DESC);
CREATE INDEX jobs_running ON jobs (tenant_id, id DESC) WHERE state = 'running';
CREATE INDEX jobs_cancelling ON jobs (tenant_id, id DESC) WHERE state = 'cancelling';
CREATE INDEX jobs_succeeded ON jobs (tenant_id, id DESC) WHERE state = 'succeeded';
CREATE INDEX jobs_failed ON jobs (tenant_id, id DESC) WHERE state = 'failed';
CREATE INDEX jobs_cancelled ON jobs (tenant_id, id DESC) WHERE state = 'cancelled';
CREATE INDEX jobs_retries ON jobs (tenant_id, id DESC) WHERE kind = 'retry';
