-- Facts that scenes are filtered and counted by. The database computes them, so that no process can forget to, and scenes of
-- earlier versions have them, too.

-- Text, image, edit or variant.
ALTER TABLE scenes ADD COLUMN kind TEXT COLLATE "C"
    GENERATED ALWAYS AS (request::json #>> '{input,kind}') STORED;
-- The text of the request, or the instruction of an edit.
ALTER TABLE scenes ADD COLUMN request_text TEXT
    GENERATED ALWAYS AS (request::json #>> '{input,text}') STORED;
-- Their number, once the scene is finished.
ALTER TABLE scenes ADD COLUMN objects BIGINT
    GENERATED ALWAYS AS (CAST(summary::json ->> 'objects' AS BIGINT)) STORED;

-- The lists of before, with the facts behind what they are sorted by: they are filtered and counted without their rows.
DROP INDEX scenes_present;
DROP INDEX scenes_by_state;
CREATE INDEX scenes_present ON scenes (tenant_id, id DESC, state, verdict, kind, objects) WHERE state <> 'deleted';
CREATE INDEX scenes_by_state ON scenes (tenant_id, state, id DESC, verdict, kind, objects);

-- Categories of the objects of finished scenes, one a row.
CREATE TABLE scene_categories (
    tenant_id TEXT COLLATE "C" NOT NULL,
    category  TEXT COLLATE "C" NOT NULL,
    scene_id  TEXT COLLATE "C" NOT NULL REFERENCES scenes (id) ON DELETE CASCADE,
    PRIMARY KEY (tenant_id, category, scene_id)
);
CREATE INDEX scene_categories_of_scene ON scene_categories (scene_id, category);
CREATE FUNCTION note_categories() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    DELETE FROM scene_categories WHERE scene_id = NEW.id;
    INSERT INTO scene_categories (tenant_id, category, scene_id)
        SELECT DISTINCT NEW.tenant_id, category.value, NEW.id
        FROM json_array_elements_text(COALESCE(NEW.summary::json -> 'categories', '[]'::json)) AS category;
    RETURN NULL;
END
$$;
-- The trigger locks the table, so that no scene is finished between it and the scenes that are read then.
CREATE TRIGGER scenes_have_categories AFTER UPDATE OF summary ON scenes
    FOR EACH ROW WHEN (NEW.summary IS DISTINCT FROM OLD.summary) EXECUTE FUNCTION note_categories();
-- Summaries of earlier versions have no list of categories, and those of texts what was understood of the text.
INSERT INTO scene_categories (tenant_id, category, scene_id)
    SELECT DISTINCT scenes.tenant_id, part ->> 'category', scenes.id
    FROM scenes, json_array_elements(CASE json_typeof(summary::json #> '{text,understood}')
                                     WHEN 'array' THEN summary::json #> '{text,understood}' END) AS part
    WHERE part ->> 'kind' = 'object' AND part ->> 'category' IS NOT NULL;
