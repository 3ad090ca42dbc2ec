-- Datasets, batches and recordings can be deleted, and labels of scenes changed. No scene ever had an expiry.

ALTER TABLE datasets ADD COLUMN deleted_at INTEGER;                          -- NULL = it is there
ALTER TABLE batches ADD COLUMN deleted_at INTEGER;
ALTER TABLE batches ADD COLUMN deletes_scenes INTEGER NOT NULL DEFAULT 0;    -- its scenes are deleted with it
ALTER TABLE recordings ADD COLUMN deleted_at INTEGER;

-- What sweeps look for: rows that are deleted, and rows whose time may be over.
CREATE INDEX datasets_deleted ON datasets (deleted_at, id) WHERE deleted_at IS NOT NULL;
CREATE INDEX batches_deleted ON batches (deleted_at, id) WHERE deleted_at IS NOT NULL;
CREATE INDEX recordings_deleted ON recordings (deleted_at, id) WHERE deleted_at IS NOT NULL;
CREATE INDEX datasets_failed ON datasets (finished_at) WHERE state = 'failed' AND deleted_at IS NULL;
CREATE INDEX batches_ended ON batches (finished_at) WHERE state IN ('finished', 'cancelled') AND deleted_at IS NULL;
CREATE INDEX recordings_failed ON recordings (finished_at) WHERE state IN ('failed', 'cancelled') AND deleted_at IS NULL;

-- Lists have no deleted rows.
DROP INDEX datasets_listing;
DROP INDEX datasets_by_state;
DROP INDEX datasets_by_name;
DROP INDEX batches_listing;
DROP INDEX batches_by_state;
DROP INDEX recordings_listing;
DROP INDEX recordings_by_state;
DROP INDEX recordings_of_scene;
CREATE INDEX datasets_listing ON datasets (tenant_id, id DESC) WHERE deleted_at IS NULL;
CREATE INDEX datasets_by_state ON datasets (tenant_id, state, id DESC) WHERE deleted_at IS NULL;
CREATE INDEX datasets_by_name ON datasets (tenant_id, name, id DESC) WHERE deleted_at IS NULL;
CREATE INDEX batches_listing ON batches (tenant_id, id DESC) WHERE deleted_at IS NULL;
CREATE INDEX batches_by_state ON batches (tenant_id, state, id DESC) WHERE deleted_at IS NULL;
CREATE INDEX recordings_listing ON recordings (tenant_id, id DESC) WHERE deleted_at IS NULL;
CREATE INDEX recordings_by_state ON recordings (tenant_id, state, id DESC) WHERE deleted_at IS NULL;
CREATE INDEX recordings_of_scene ON recordings (tenant_id, scene_id, id DESC) WHERE deleted_at IS NULL;

-- Labels that are changed are found as those that a scene begins with.
CREATE TRIGGER scenes_change_labels AFTER UPDATE OF labels ON scenes WHEN OLD.labels <> NEW.labels
BEGIN
    DELETE FROM scene_labels WHERE scene_id = NEW.id;
    INSERT INTO scene_labels (tenant_id, key, value, scene_id)
        SELECT NEW.tenant_id, label.key, label.value, NEW.id FROM json_each(NEW.labels) AS label;
END;

DROP INDEX scenes_expiry;
ALTER TABLE scenes DROP COLUMN expires_at;
