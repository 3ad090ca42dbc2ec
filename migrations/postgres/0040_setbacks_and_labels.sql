-- Failed work on recordings waits, as that on datasets; and scenes are found by their labels.

-- An attempt of a recording is not begun earlier; set by the delay after a failure.
ALTER TABLE recording_attempts ADD COLUMN not_before BIGINT NOT NULL DEFAULT 0;

-- With the state in front it serves statements without an order, too.
DROP INDEX recordings_waiting;
CREATE INDEX recordings_waiting ON recordings (state, id) WHERE state IN ('queued', 'running');

-- The labels of scenes, one a row. The trigger fills it, so that no process can forget to.
CREATE TABLE scene_labels (
    tenant_id TEXT COLLATE "C" NOT NULL,
    key       TEXT COLLATE "C" NOT NULL,
    value     TEXT COLLATE "C" NOT NULL,
    scene_id  TEXT COLLATE "C" NOT NULL REFERENCES scenes (id) ON DELETE CASCADE,
    PRIMARY KEY (tenant_id, key, value, scene_id)
);
CREATE FUNCTION note_labels() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    INSERT INTO scene_labels (tenant_id, key, value, scene_id)
        SELECT NEW.tenant_id, label.key, label.value, NEW.id FROM json_each_text(NEW.labels::json) AS label;
    RETURN NULL;
END
$$;
-- The trigger locks the table, so that no scene is submitted between it and the scenes that are read then.
CREATE TRIGGER scenes_have_labels AFTER INSERT ON scenes FOR EACH ROW EXECUTE FUNCTION note_labels();
INSERT INTO scene_labels (tenant_id, key, value, scene_id)
    SELECT scenes.tenant_id, label.key, label.value, scenes.id
    FROM scenes, json_each_text(scenes.labels::json) AS label;
CREATE INDEX scene_labels_of_scene ON scene_labels (scene_id);
