-- Retention: what of a scene was removed already, and indexes for those who search for what to remove.

ALTER TABLE scenes ADD COLUMN stripped_at INTEGER;   -- when artifacts and checkpoints were removed; NULL = they are there
CREATE INDEX scenes_to_strip ON scenes (updated_at) WHERE stripped_at IS NULL;
CREATE INDEX scenes_deleted ON scenes (updated_at) WHERE state = 'deleted';
CREATE INDEX scenes_expiry ON scenes (expires_at) WHERE expires_at IS NOT NULL;
CREATE INDEX stages_by_key ON stages (key);
CREATE INDEX idempotency_of_scene ON idempotency (scene_id);

-- Regular work that one process at a time does for all.
CREATE TABLE upkeep (
    name    TEXT PRIMARY KEY,
    next_at INTEGER NOT NULL
) STRICT;
