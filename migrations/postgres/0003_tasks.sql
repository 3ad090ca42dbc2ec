-- Vendors that work on a question for minutes answer at once with a job of theirs; these columns keep it, so that whoever
-- comes after a dead worker asks for that job and submits no second one.

ALTER TABLE calls ADD COLUMN task TEXT COLLATE "C";             -- the vendor's id of its job; NULL = answered at once
ALTER TABLE calls ADD COLUMN task_state TEXT COLLATE "C" CHECK (task_state IN ('submitted', 'fetched', 'over'));
ALTER TABLE calls ADD COLUMN task_file TEXT COLLATE "C";        -- digest of the blob with what came of it, once fetched
