-- An answer is paid for when it comes, and its stage may die before it is done: what was answered is kept beside the call, so
-- that whoever runs the stage again asks nothing twice.

ALTER TABLE calls ADD COLUMN answer_file TEXT COLLATE "C";      -- digest of the blob with the answer; NULL = none, or not to be used again
