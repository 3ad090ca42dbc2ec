"""The judge of edits: every statement with a scene that holds it and one that does not, and every kind of violation."""

import struct
import tempfile
import unittest
import zlib
from pathlib import Path

from tabletopgen_checks.edits.appearance import mean_color, parts
from tabletopgen_checks.edits.comparison import Operation, complaints
from tabletopgen_checks.edits.operations import PLANS
from tabletopgen_checks.scene.relations import holds
from tabletopgen_checks.tests.made_up_scenes import MUG, PLATE, body, changed, scene

# (relation, the first and others that hold it, those that do not, stated distance)
RELATIONS = [
    ("left_of", [body("a_1", -0.3, 0), body("b_1", 0, 0)], [body("a_1", 0.3, 0), body("b_1", 0, 0)], None),
    ("right_of", [body("a_1", 0.3, 0), body("b_1", 0, 0)], [body("a_1", 0.05, 0.02), body("b_1", 0, 0)], None),
    ("in_front_of", [body("a_1", 0, -0.2), body("b_1", 0, 0)], [body("a_1", -0.5, -0.2), body("b_1", 0, 0)], None),
    ("behind", [body("a_1", 0, 0.2), body("b_1", 0, 0)], [body("a_1", 0, -0.2), body("b_1", 0, 0)], None),
    ("left_of", [body("a_1", -0.15, 0), body("b_1", 0, 0)], [body("a_1", -0.17, 0), body("b_1", 0, 0)], 0.05),
    ("next_to", [body("a_1", 0.24, 0), body("b_1", 0, 0)], [body("a_1", 0.26, 0), body("b_1", 0, 0)], None),
    ("next_to", [body("a_1", 0.1, 0), body("b_1", 0, 0)], [body("a_1", 0.08, 0), body("b_1", 0, 0)], None),
    ("between", [body("a_1", 0.02, 0.01), body("b_1", -0.3, 0), body("c_1", 0.3, 0)],
     [body("a_1", 0.2, 0), body("b_1", -0.3, 0), body("c_1", 0.3, 0)], None),
    ("between", [body("a_1", 0, 0), body("b_1", -0.1, 0), body("c_1", 0.1, 0)],
     [body("a_1", 0, 0), body("b_1", -0.09, 0), body("c_1", 0.09, 0)], None),
    ("on", [body("a_1", 0, 0, 0.1), body("b_1", 0, 0)], [body("a_1", 0.1, 0, 0.1), body("b_1", 0, 0)], None),
    ("on", [body("a_1", 0, 0, 0.1), body("b_1", 0, 0)], [body("a_1", 0, 0, 0.12), body("b_1", 0, 0)], None),
    ("stacked_on", [body("a_1", 0, 0, 0.1), body("b_1", 0, 0)], [body("a_1", 0, 0, 0.0), body("b_1", 0, 0)], None),
    ("in", [body("a_1", 0, 0, 0.01), body("b_1", 0, 0)], [body("a_1", 0, 0, 0.1), body("b_1", 0, 0)], None),
    ("on", [body("a_1", 0, 0, 0.01)], [body("a_1", 0, 0, 0.1)], None),
    ("facing", [body("a_1", 0, 0, yaw_deg=90), body("b_1", 0.4, 0)],
     [body("a_1", 0, 0, yaw_deg=75), body("b_1", 0.4, 0)], None),
    ("at_center", [body("a_1", 0.2, 0.1)], [body("a_1", 0.3, 0)], None),
    ("at_left", [body("a_1", -0.2, 0.2)], [body("a_1", 0, 0)], None),
    ("at_front", [body("a_1", 0.5, -0.1)], [body("a_1", 0, 0)], None),
    ("at_back_right", [body("a_1", 0.3, 0.2)], [body("a_1", 0.3, 0)], None),
    ("from_left_edge", [body("a_1", -0.45, 0)], [body("a_1", -0.41, 0)], 0.1),
    ("from_back_edge", [body("a_1", 0, 0.2)], [body("a_1", 0, 0.15)], 0.05),
    ("from_front_edge", [body("a_1", 0, -0.11)], [body("a_1", 0, 0)], None),
]


class Predicates(unittest.TestCase):
    def test_relations_hold_where_they_should_and_only_there(self):
        for kind, right, wrong, stated_m in RELATIONS:
            for posed, expected in ((right, True), (wrong, False)):
                with self.subTest(kind, bodies=[one["translation_m"] for one in posed]):
                    found = scene(*posed)
                    first, *others = [found.bodies[one["name"]] for one in posed]
                    target, second = (others + [None, None])[:2]
                    self.assertEqual(holds(kind, first, found.outline, target, second, stated_m), expected)


# (what, operation, parent, child that is right, child that is wrong)
STATEMENTS = [
    ("add", Operation({"op": "add", "object": "a cup"}, categories=("cup",), count=1), [MUG],
     [MUG, body("cup_1", 0, 0)], [MUG, body("cup_1", -0.3, 0, 0.1, parent="mug_1")]),
    ("add of several", Operation({"op": "add", "object": "a cup", "count": 2}, categories=("cup",), count=2), [MUG],
     [MUG, body("cup_1", 0, 0), body("cup_2", 0.2, 0)], [MUG, body("cup_1", 0, 0)]),
    ("add of another category", Operation({"op": "add", "object": "a cup"}, categories=("cup",), count=1), [MUG],
     [MUG, body("cup_1", 0, 0)], [MUG, body("bowl_1", 0, 0)]),
    ("add at a place", Operation({"op": "add", "object": "a cup", "where": {"relation": "left_of", "target": "mug_1"}},
     references=["mug_1"], categories=("cup",), count=1), [MUG], [MUG, body("cup_1", -0.5, 0)],
     [MUG, body("cup_1", 0, 0)]),
    ("add on", Operation({"op": "add", "object": "a cup", "where": {"relation": "on", "target": "mug_1"}},
     references=["mug_1"], categories=("cup",), count=1), [MUG], [MUG, body("cup_1", -0.3, 0, 0.1, parent="mug_1")],
     [MUG, body("cup_1", -0.3, 0, 0.1)]),
    ("remove", Operation({"op": "remove", "target": "mug_1"}, ["mug_1"]), [MUG, PLATE], [PLATE], [MUG, PLATE]),
    ("remove of one only", Operation({"op": "remove", "target": "mug_1"}, ["mug_1"]), [MUG, PLATE], [PLATE], []),
    ("remove with contents", Operation({"op": "remove", "target": "mug_1", "with_contents": True}, ["mug_1"]),
     [MUG, body("pen_1", -0.3, 0, 0.02, parent="mug_1"), PLATE], [PLATE],
     [body("pen_1", -0.3, 0, 0.02, parent="mug_1"), PLATE]),
    ("replace", Operation({"op": "replace", "target": "mug_1", "object": "a cup"}, ["mug_1"], categories=("cup",),
     count=1), [MUG], [body("cup_1", -0.29, 0)], [body("cup_1", 0.3, 0)]),
    ("replace under the old name", Operation({"op": "replace", "target": "mug_1", "object": "a cup"}, ["mug_1"],
     categories=("cup",), count=1), [MUG], [body("mug_1", -0.3, 0, size=(0.1, 0.1, 0.2), category="cup")], [MUG]),
    ("move to coordinates", Operation({"op": "move", "target": "mug_1", "where": {"position_m": [0.1, 0.1]}},
     ["mug_1"]), [MUG], [body("mug_1", 0.115, 0.1)], [body("mug_1", 0.13, 0.1)]),
    ("move by", Operation({"op": "move", "target": "mug_1", "where": {"offset_m": [0.1, 0.0]}}, ["mug_1"]), [MUG],
     [body("mug_1", -0.2, 0.01)], [body("mug_1", 0.1, 0.0)]),
    ("move with a yaw", Operation({"op": "move", "target": "mug_1", "where": {"position_m": [0, 0], "yaw_rad": 0.5}},
     ["mug_1"]), [MUG], [body("mug_1", 0, 0, yaw_deg=30)], [body("mug_1", 0, 0)]),
    ("move carries", Operation({"op": "move", "target": "mug_1", "where": {"relation": "at_right"}}, ["mug_1"]),
     [MUG, body("pen_1", -0.31, 0, 0.02, parent="mug_1")],
     [body("mug_1", 0.4, 0), body("pen_1", 0.39, 0, 0.02, parent="mug_1")],
     [body("mug_1", 0.4, 0), body("pen_1", -0.31, 0, 0.0)]),
    ("move into", Operation({"op": "move", "target": "mug_1", "where": {"relation": "in", "target": "plate_1"}},
     ["mug_1"], ["plate_1"]), [MUG, PLATE], [body("mug_1", 0.3, 0, 0.02, parent="plate_1", relation="in"), PLATE],
     [MUG, PLATE]),
    ("rotate by", Operation({"op": "rotate", "target": "mug_1", "by_rad": 1.0}, ["mug_1"]), [MUG],
     [body("mug_1", -0.3, 0, yaw_deg=57.3)], [body("mug_1", -0.3, 0, yaw_deg=-57.3)]),
    ("rotate in place", Operation({"op": "rotate", "target": "mug_1", "to_rad": 1.0}, ["mug_1"]), [MUG],
     [body("mug_1", -0.3, 0, yaw_deg=57.3)], [body("mug_1", -0.2, 0, yaw_deg=57.3)]),
    ("rotate toward", Operation({"op": "rotate", "target": "mug_1", "facing": "plate_1"}, ["mug_1"], ["plate_1"]),
     [MUG, PLATE], [body("mug_1", -0.3, 0, yaw_deg=90), PLATE], [body("mug_1", -0.3, 0, yaw_deg=180), PLATE]),
    ("resize", Operation({"op": "resize", "target": "mug_1", "factor": 2.0}, ["mug_1"]), [MUG],
     [body("mug_1", -0.3, 0, size=(0.2, 0.2, 0.2), mass_kg=1.6)], [MUG]),
    ("resize of one axis", Operation({"op": "resize", "target": "mug_1", "factor": 2.0}, ["mug_1"]), [MUG],
     [body("mug_1", -0.3, 0, size=(0.2, 0.2, 0.2), mass_kg=1.6)],
     [body("mug_1", -0.3, 0, size=(0.2, 0.2, 0.1), mass_kg=1.6)]),
    ("place of a resized object", Operation({"op": "resize", "target": "mug_1", "factor": 2.0}, ["mug_1"]), [MUG],
     [body("mug_1", -0.27, 0, size=(0.2, 0.2, 0.2), mass_kg=1.6)],
     [body("mug_1", -0.2, 0, size=(0.2, 0.2, 0.2), mass_kg=1.6)]),
    ("mass of a resized object", Operation({"op": "resize", "target": "mug_1", "factor": 2.0}, ["mug_1"]), [MUG],
     [body("mug_1", -0.3, 0, size=(0.2, 0.2, 0.2), mass_kg=1.6)],
     [body("mug_1", -0.3, 0, size=(0.2, 0.2, 0.2), mass_kg=0.2)]),
    ("new material", Operation({"op": "recolor", "target": "mug_1", "material": "steel"}, ["mug_1"]), [MUG],
     [changed(MUG, mass_kg=0.9)], [MUG]),
    ("relabel", Operation({"op": "relabel", "target": "mug_1", "label": "cup"}, ["mug_1"]), [MUG],
     [changed(MUG, label="cup")], [MUG]),
    ("relabel with another name", Operation({"op": "relabel", "target": "mug_1", "label": "cup"}, ["mug_1"]), [MUG],
     [changed(MUG, label="cup", name="cup_1")], [body("cup_1", 0, 0)]),
    ("stack", Operation({"op": "stack", "targets": ["plate_1", "mug_1"]}, ["plate_1", "mug_1"]), [MUG, PLATE],
     [body("mug_1", 0.3, 0, 0.1, parent="plate_1"), PLATE], [body("plate_1", -0.3, 0, 0.1, parent="mug_1"), MUG]),
    ("stack of a phrase", Operation({"op": "stack", "targets": ["the books"]}, ["book_1", "book_2"]),
     [body("book_1", 0, 0), body("book_2", 0.3, 0, size=(0.2, 0.2, 0.1))],
     [body("book_1", 0.3, 0, 0.1, parent="book_2"), body("book_2", 0.3, 0, size=(0.2, 0.2, 0.1))],
     [body("book_1", 0, 0), body("book_2", 0, 0, 0.1, size=(0.2, 0.2, 0.1), parent="book_1")]),
    ("tidy", Operation({"op": "tidy"}), [body("mug_1", -0.3, 0, yaw_deg=20), PLATE],
     [body("mug_1", -0.3, 0, yaw_deg=90), PLATE], [body("mug_1", -0.3, 0, yaw_deg=20), PLATE]),
    ("tidy apart", Operation({"op": "tidy"}), [MUG, PLATE], [MUG, PLATE], [body("mug_1", 0.198, 0), PLATE]),
    ("clutter", Operation({"op": "clutter", "count": 2}, count=2), [MUG],
     [MUG, body("pen_1", 0, 0), body("cup_1", 0.2, 0)], [MUG, body("pen_1", 0, 0)]),
]

NOTHING = Operation({"op": "relabel", "target": "mug_1", "label": "mug"}, ["mug_1"])
FALL = {"name": "plate_1", "distance_m": 0.05, "angle_rad": 0.0, "cause": "room for the mug"}


class Statements(unittest.TestCase):
    def found(self, operation, parent, child, **more):
        return complaints(scene(*parent), scene(*child, operations=1, **more), [operation])

    def test_what_is_stated_is_demanded(self):
        for what, operation, parent, right, wrong in STATEMENTS:
            with self.subTest(what):
                self.assertEqual(self.found(operation, parent, right), [])
                self.assertNotEqual(self.found(operation, parent, wrong), [])

    def test_every_operation_has_a_case(self):
        covered = {operation.name for _, operation, *_ in STATEMENTS} | {"restyle_table"}
        self.assertEqual(covered, set(PLANS))

    def test_mutations_of_what_is_not_mentioned_are_reported(self):
        turned_plate = body("plate_1", 0.3, 0.0, yaw_deg=0.01)
        for what, plate in [
            ("moved by", body("plate_1", 0.3 + 1e-12, 0.0)),
            ("moved by", turned_plate),
            ("size_m of plate_1", changed(PLATE, size_m=[0.1, 0.1, 0.11])),
            ("the shape of plate_1", changed(PLATE, size_m=[0.1, 0.1, 0.11])),
            ("mass_kg of plate_1", changed(PLATE, mass_kg=0.21)),
            ("friction of plate_1", changed(PLATE, friction={"static": 0.6, "dynamic": 0.4})),
            ("label of plate_1", changed(PLATE, label="dish")),
            ("stands on mug_1", changed(PLATE, support={"parent": "mug_1", "relation": "on"})),
        ]:
            with self.subTest(what):
                self.assertIn(what, "; ".join(self.found(NOTHING, [MUG, PLATE], [MUG, plate])))
        self.assertEqual(self.found(NOTHING, [MUG, PLATE], [MUG]), ["plate_1 vanished"])
        self.assertIn("appeared", self.found(NOTHING, [MUG], [MUG, PLATE])[0])
        self.assertEqual(self.found(NOTHING, [MUG, PLATE], [MUG, PLATE]), [])

    def test_movements_are_permitted_where_they_are_reported_with_their_cause(self):
        child = [MUG, body("plate_1", 0.35, 0.0)]
        self.assertEqual(self.found(NOTHING, [MUG, PLATE], child, moved=[FALL]), [])
        for wrong in ({"cause": " "}, {"distance_m": 0.02}, {"angle_rad": 0.5}, {"name": "mug_1"}):
            self.assertNotEqual(self.found(NOTHING, [MUG, PLATE], child, moved=[FALL | wrong]), [], wrong)

    def test_what_falls_from_a_removed_object_is_reported(self):
        pen = body("pen_1", -0.3, 0, 0.1, parent="mug_1")
        remove = Operation({"op": "remove", "target": "mug_1"}, ["mug_1"])
        fallen = body("pen_1", -0.3, 0)
        printed = {"name": "pen_1", "distance_m": 0.1, "angle_rad": 0.0, "cause": "mug_1 is gone"}
        self.assertEqual(self.found(remove, [MUG, pen], [fallen], moved=[printed]), [])
        self.assertNotEqual(self.found(remove, [MUG, pen], [fallen]), [])

    def test_the_printed_document_agrees_with_the_report(self):
        parent, child = scene(MUG), scene(MUG, operations=1)
        printed = {"verdict": "pass", "metrics": {"col_s": 0.0}, "edit": {"moved": []}}
        self.assertEqual(complaints(parent, child, [NOTHING], printed), [])
        fallen = scene(MUG, body("plate_1", 0.35, 0.0), operations=1, moved=[FALL])
        for account in ({"edit": {"moved": [FALL]}}, {"edit": None, "summary": {"edit": {"moved": [FALL]}}}):
            self.assertEqual(complaints(scene(MUG, PLATE), fallen, [NOTHING], printed | account), [])
        for wrong in ({"verdict": "quarantine"}, {"metrics": {"col_s": 1}}, {"edit": {"moved": [FALL]}}):
            self.assertNotEqual(complaints(parent, child, [NOTHING], printed | wrong), [], wrong)

    def test_certificate_and_lineage_are_demanded(self):
        self.assertNotEqual(self.found(NOTHING, [MUG], [MUG], verdict="quarantine"), [])
        self.assertNotEqual(self.found(NOTHING, [MUG], [MUG], col_s=1), [])
        self.assertNotEqual(complaints(scene(MUG), scene(MUG), [NOTHING]), [])
        self.assertNotEqual(complaints(scene(MUG), scene(MUG, operations=2), [NOTHING]), [])


class Chains(unittest.TestCase):
    MOVE = Operation({"op": "move", "target": "mug_1", "where": {"relation": "at_right"}}, ["mug_1"])
    ADD = Operation({"op": "add", "object": "a cup", "where": {"relation": "at_left"}}, categories=("cup",), count=1)

    def found(self, operations, child):
        return complaints(scene(MUG, PLATE), scene(*child, operations=len(operations)), operations)

    def test_every_operation_is_demanded(self):
        moved, cup_1 = body("mug_1", 0.3, 0.2), body("cup_1", -0.4, 0)
        self.assertEqual(self.found([self.MOVE, self.ADD], [moved, PLATE, cup_1]), [])
        self.assertNotEqual(self.found([self.MOVE, self.ADD], [MUG, PLATE, cup_1]), [])
        self.assertNotEqual(self.found([self.MOVE, self.ADD], [moved, PLATE]), [])

    def test_the_last_word_on_an_object_counts(self):
        again = Operation({"op": "move", "target": "the cup", "where": {"relation": "at_right"}}, ["+0"])
        self.assertEqual(self.found([self.ADD, again], [MUG, PLATE, body("cup_1", 0.4, 0.2)]), [])
        self.assertNotEqual(self.found([self.ADD, again], [MUG, PLATE, body("cup_1", -0.4, 0.2)]), [])

    def test_what_is_added_and_removed_is_not_there(self):
        remove = Operation({"op": "remove", "target": "the cup"}, ["+0"])
        self.assertEqual(self.found([self.ADD, remove], [MUG, PLATE]), [])
        self.assertNotEqual(self.found([self.ADD, remove], [MUG, PLATE, body("cup_1", -0.4, 0)]), [])


def png(color, width=4, height=3, kind=0):
    """An even image; every row is filtered by `kind`, 0 or 2."""
    row = bytes(color) * width
    rows = b"".join(bytes([kind]) + (row if k == 0 or kind == 0 else bytes(len(row))) for k in range(height))
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", head), (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(struct.pack(">I", len(c)) + k + c + b"\0\0\0\0" for k, c in chunks)


class Appearance(unittest.TestCase):
    """A mug of two materials, and a table, in a bundle's MJCF."""

    def setUp(self):
        self.home = tempfile.TemporaryDirectory()
        self.addCleanup(self.home.cleanup)
        self.folder = Path(self.home.name)
        (self.folder / "mjcf/assets").mkdir(parents=True)
        for name, side in (("large", 2.0), ("small", 0.1)):
            words = f"v 0 0 0\nv {side} 0 0\nv 0 {side} 0\nf 1/1 2/2 3/3\n"
            (self.folder / f"mjcf/assets/{name}.obj").write_text(words, encoding="utf-8")
        self.write((200, 10, 20), (0.1, 0.1, 0.9), "oak")

    def write(self, texture, handle, wood):
        (self.folder / "mjcf/assets/glaze.png").write_bytes(png(texture, kind=2))
        geoms = [("mug_1_visual_glaze", "large", "mug_1_glaze"), ("mug_1_visual_handle", "small", "mug_1_handle"),
                 ("table_visual_top", "large", f"table_{wood}")]
        words = "".join(f'<geom name="{n}" mesh="{mesh}" material="{m}"/>' for n, mesh, m in geoms)
        rgba = " ".join(map(str, handle))
        (self.folder / "mjcf/scene.xml").write_text(
            f"""<mujoco><asset><texture name="t" file="glaze.png"/><mesh name="large" file="large.obj"/>
            <mesh name="small" file="small.obj"/><material name="mug_1_glaze" rgba="1 1 1 1" texture="t"/>
            <material name="mug_1_handle" rgba="{rgba} 1"/><material name="table_{wood}" rgba="0.7 0.5 0.3 1"/></asset>
            <worldbody>{words}</worldbody></mujoco>""", encoding="utf-8")

    def found(self, wire, **more):
        operation = Operation(wire, ["mug_1"] if "target" in wire else [])
        child = scene(changed(MUG, **more), operations=1, folder=self.folder)
        return complaints(scene(MUG), child, [operation])

    def test_parts_come_with_area_and_mean_color(self):
        found = parts(self.folder, "mug_1")
        areas = {part.material: round(part.area_m2, 4) for part in found}
        self.assertEqual(areas, {"glaze": 2.0, "handle": 0.005})
        self.assertAlmostEqual(found[0].color[0], 200 / 255)

    def test_rows_of_an_image_are_unfiltered(self):
        for kind in (0, 2):
            path = self.folder / "image.png"
            path.write_bytes(png((255, 0, 51), kind=kind))
            self.assertEqual([round(channel, 3) for channel in mean_color(path)], [1.0, 0.0, 0.2])

    def test_a_color_is_that_of_a_large_part(self):
        self.assertEqual(self.found({"op": "recolor", "target": "mug_1", "color": "red"}), [])
        self.assertNotEqual(self.found({"op": "recolor", "target": "mug_1", "color": "blue"}), [])

    def test_a_color_changes_no_mass_and_no_pose(self):
        wire = {"op": "recolor", "target": "mug_1", "color": "red"}
        self.assertNotEqual(self.found(wire, mass_kg=0.3), [])
        self.assertNotEqual(self.found(wire, translation_m=[-0.3, 1e-9, 0.0]), [])

    def test_the_table_has_its_new_appearance_and_its_old_size(self):
        self.assertEqual(self.found({"op": "restyle_table", "material": "oak"}), [])
        self.assertNotEqual(self.found({"op": "restyle_table", "material": "marble"}), [])
        self.assertEqual(self.found({"op": "restyle_table", "color": "brown"}), [])
        self.assertNotEqual(self.found({"op": "restyle_table", "color": "blue"}), [])
        child = scene(MUG, operations=1, folder=self.folder, shape="round")
        self.assertNotEqual(complaints(scene(MUG), child, [Operation({"op": "restyle_table", "material": "oak"})]), [])


if __name__ == "__main__":
    unittest.main()
