-- Facts that scenes are filtered and counted by. The database computes them, so that no process can forget to, and scenes of
-- earlier versions have them, too.

-- Text, image, edit or variant.
ALTER TABLE scenes ADD COLUMN kind TEXT
    GENERATED ALWAYS AS (json_extract(request, '$.input.kind')) VIRTUAL;
-- The text of the request, or the instruction of an edit.
ALTER TABLE scenes ADD COLUMN request_text TEXT
    GENERATED ALWAYS AS (json_extract(request, '$.input.text')) VIRTUAL;
-- Their number, once the scene is finished.
ALTER TABLE scenes ADD COLUMN objects INTEGER
    GENERATED ALWAYS AS (json_extract(summary, '$.objects')) VIRTUAL;

-- The lists of before, with the facts behind what they are sorted by: they are filtered and counted without their rows.
DROP INDEX scenes_present;
DROP INDEX scenes_by_state;
CREATE INDEX scenes_present ON scenes (tenant_id, id DESC, state, verdict, kind, objects) WHERE state <> 'deleted';
CREATE INDEX scenes_by_state ON scenes (tenant_id, state, id DESC, verdict, kind, objects);

-- Categories of the objects of finished scenes, one a row.
CREATE TABLE scene_categories (
    tenant_id TEXT NOT NULL,
    category  TEXT NOT NULL,
    scene_id  TEXT NOT NULL REFERENCES scenes (id) ON DELETE CASCADE,
    PRIMARY KEY (tenant_id, category, scene_id)
) STRICT, WITHOUT ROWID;
CREATE INDEX scene_categories_of_scene ON scene_categories (scene_id);
-- Summaries of earlier versions have no list of categories, and those of texts what was understood of the text.
INSERT INTO scene_categories (tenant_id, category, scene_id)
    SELECT DISTINCT scenes.tenant_id, json_extract(part.value, '$.category'), scenes.id
    FROM scenes, json_each(scenes.summary, '$.text.understood') AS part
    WHERE json_extract(part.value, '$.kind') = 'object' AND json_extract(part.value, '$.category') IS NOT NULL;
CREATE TRIGGER scenes_have_categories AFTER UPDATE OF summary ON scenes WHEN NEW.summary IS NOT OLD.summary
BEGIN
    DELETE FROM scene_categories WHERE scene_id = NEW.id;
    INSERT INTO scene_categories (tenant_id, category, scene_id)
        SELECT DISTINCT NEW.tenant_id, category.value, NEW.id
        FROM json_each(NEW.summary, '$.categories') AS category;
END;
