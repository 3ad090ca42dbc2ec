-- Failed work on recordings waits, as that on datasets; and scenes are found by their labels.

-- An attempt of a recording is not begun earlier; set by the delay after a failure.
ALTER TABLE recording_attempts ADD COLUMN not_before INTEGER NOT NULL DEFAULT 0;

-- With the state in front it serves statements without an order, too.
DROP INDEX recordings_waiting;
CREATE INDEX recordings_waiting ON recordings (state, id) WHERE state IN ('queued', 'running');

-- The labels of scenes, one a row. The trigger fills it, so that no process can forget to.
CREATE TABLE scene_labels (
    tenant_id TEXT NOT NULL,
    key       TEXT NOT NULL,
    value     TEXT NOT NULL,
    scene_id  TEXT NOT NULL REFERENCES scenes (id) ON DELETE CASCADE,
    PRIMARY KEY (tenant_id, key, value, scene_id)
) STRICT, WITHOUT ROWID;
INSERT INTO scene_labels (tenant_id, key, value, scene_id)
    SELECT scenes.tenant_id, label.key, label.value, scenes.id FROM scenes, json_each(scenes.labels) AS label;
CREATE INDEX scene_labels_of_scene ON scene_labels (scene_id);
CREATE TRIGGER scenes_have_labels AFTER INSERT ON scenes
BEGIN
    INSERT INTO scene_labels (tenant_id, key, value, scene_id)
        SELECT NEW.tenant_id, label.key, label.value, NEW.id FROM json_each(NEW.labels) AS label;
END;
