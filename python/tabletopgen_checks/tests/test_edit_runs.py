"""Generated edits, the program that carries them out, and the page of the bar."""

import json
import sys
import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace

from tabletopgen_checks.bars import editing as bar
from tabletopgen_checks.edits.cases import Case, cases
from tabletopgen_checks.edits.comparison import Operation
from tabletopgen_checks.edits.operations import PLANS
from tabletopgen_checks.edits.parents import Parent
from tabletopgen_checks.edits.refused import REFUSED
from tabletopgen_checks.edits.runs import NO_ROOM, RIGHT, WRONG, Edited, Judged, edit, judged, refusal_complaints
from tabletopgen_checks.edits.runs import REFUSED as REFUSED_AS_IT_MUST
from tabletopgen_checks.scene.scene import Scene, read_scene
from tabletopgen_checks.tests.made_up_scenes import MUG, PLATE, body, cup, scene


class Refusals(unittest.TestCase):
    REMOVE = Operation({"op": "remove", "target": "the giraffe"})
    CASE = Case("edit_000", "p", 1, [REMOVE], "unknown object", ("giraffe",))

    def found(self, exit_code=5, **failure):
        refusal = {"kind": "unknown_object", "message": "no giraffe is there", "exit_code": 5} | failure
        return refusal_complaints(Edited(exit_code, {"failure": refusal}, "", 0.0, []), self.CASE, Path("/nowhere"))

    def test_a_refusal_names_its_reason(self):
        self.assertEqual(self.found(), [])
        self.assertNotEqual(self.found(message="no such object"), [])
        self.assertNotEqual(self.found(message=""), [])
        self.assertNotEqual(self.found(exit_code=1), [])

    def test_a_refusal_writes_no_scene(self):
        with tempfile.TemporaryDirectory() as home:
            (Path(home) / "scene.json").write_text("{}", encoding="utf-8")
            done = Edited(5, {"failure": {"message": "no giraffe", "exit_code": 5}}, "", 0.0, [])
            self.assertEqual(refusal_complaints(done, self.CASE, Path(home)), ["a refused edit wrote a scene"])


# Stands in for the program: labels are changed, a label "never" is refused, and everything else is left undone.
PROGRAM = """#!{python}
import json, pathlib, shutil, sys
given = dict(zip(sys.argv[2::2], sys.argv[3::2]))
operations = json.load(open(given["--operations"]))
out = pathlib.Path(given["--out"])
if any(one.get("label") == "never" for one in operations):
    print(json.dumps({{"failure": {{"kind": "no_room", "message": "the table is full", "exit_code": 5}}}}))
    sys.exit(5)
shutil.copytree(given["--bundle"], out)
scene, report = (json.loads((out / name).read_text()) for name in ("scene.json", "report.json"))
scene["request"]["input"] = {{"kind": "edit", "parent": scene["id"], "operations": operations}}
for one in operations:
    for instance in scene["instances"]:
        if instance["name"] == one.get("target") and "label" in one:
            instance["label"] = one["label"]
(out / "scene.json").write_text(json.dumps(scene))
print(json.dumps(report))
"""


def write_bundle(folder: Path, source: Scene):
    folder.mkdir(parents=True)
    for name, content in (("scene.json", source.scene), ("report.json", source.report)):
        (folder / name).write_text(json.dumps(content), encoding="utf-8")
    for body_of in source.bodies.values():
        place = folder / "urdf" / body_of.name
        place.mkdir(parents=True)
        for number, hull in enumerate(body_of.local_hulls):
            words = "".join(f"v {x} {y} {z}\n" for x, y, z in hull)
            (place / f"hull_{number:02}.obj").write_text(words, encoding="utf-8")


class Runs(unittest.TestCase):
    def setUp(self):
        self.home = tempfile.TemporaryDirectory()
        self.addCleanup(self.home.cleanup)
        self.folder = Path(self.home.name)
        self.program = self.folder / "tabletopgen"
        self.program.write_text(PROGRAM.format(python=sys.executable), encoding="utf-8")
        self.program.chmod(0o755)
        write_bundle(self.folder / "p", scene(MUG, PLATE))
        self.parent = Parent("p", self.folder / "p", read_scene(self.folder / "p"), {})

    def outcome(self, *operations, refused="", names=()):
        case = Case("c", "p", 1, list(operations), refused, names)
        return judged(self.program, self.parent, case, self.folder / "out")

    def relabel(self, label):
        return Operation({"op": "relabel", "target": "mug_1", "label": label}, ["mug_1"])

    def test_edits_that_do_what_they_state_are_right(self):
        found = self.outcome(self.relabel("cup"))
        self.assertEqual((found.outcome, found.words), (RIGHT, []))

    def test_edits_that_do_not_are_wrong(self):
        move = Operation({"op": "move", "target": "mug_1", "where": {"relation": "at_right"}}, ["mug_1"])
        found = self.outcome(move)
        self.assertEqual(found.outcome, WRONG)
        self.assertEqual(found.words, ["operation 1 (move): mug_1 is not at_right the table"])

    def test_refusals_are_right_where_they_must_be(self):
        self.assertEqual(self.outcome(self.relabel("never"), refused="x", names=("full",)).outcome, REFUSED_AS_IT_MUST)
        self.assertEqual(self.outcome(self.relabel("cup"), refused="x").outcome, WRONG)

    def test_refusals_of_what_is_possible_are_wrong_and_name_the_operation(self):
        found = self.outcome(self.relabel("cup"), self.relabel("never"), Operation({"op": "tidy"}))
        self.assertEqual(found.outcome, WRONG)
        self.assertIn("operation 2 (relabel) is possible", found.words[-1])

    def test_the_cpu_time_is_that_of_the_command(self):
        self.assertGreater(edit(self.program, self.parent.folder, [], 1, self.folder / "out" / "x").cpu_s, 0.0)


class Generator(unittest.TestCase):
    def setUp(self):
        # Wide enough for all sorts of edits.
        container, hulls = cup("mug_1", -0.45, 0.2)
        bodies = [container, body("mug_2", -0.2, 0.2), body("book_1", 0.1, 0.2, size=(0.15, 0.2, 0.03)),
                  body("book_2", 0.4, 0.15, size=(0.15, 0.22, 0.03)), body("apple_1", 0.4, 0.15, 0.03, parent="book_2",
                  size=(0.07, 0.07, 0.07)), body("laptop_1", -0.3, -0.1, size=(0.33, 0.28, 0.22)),
                  body("notebook_1", 0.2, -0.15, size=(0.15, 0.2, 0.015))]
        self.parent = Parent("p", Path("p"), scene(*bodies, hulls={"mug_1": hulls}), {"mug_1": "red", "mug_2": "blue"})
        self.every = cases([self.parent], 400, 1)

    def test_the_seed_decides_everything(self):
        self.assertEqual([one.wire() for one in cases([self.parent], 400, 1)], [one.wire() for one in self.every])
        self.assertNotEqual([one.wire() for one in cases([self.parent], 400, 2)], [one.wire() for one in self.every])

    def test_everything_is_asked_for_often(self):
        singles = [one.kind() for one in self.every if not one.refused]
        for kind in PLANS:
            self.assertGreaterEqual(singles.count(kind), 10, kind)
        refused = [one.refused for one in self.every if one.refused]
        self.assertAlmostEqual(len(refused) / len(self.every), 0.15, delta=0.03)
        self.assertEqual(set(refused), set(REFUSED))
        self.assertTrue(all(len(one.operations) in (1, 5) for one in self.every))
        self.assertGreater(sum(one.kind() == "chain" for one in self.every), 40)

    def test_phrases_fit_one_object(self):
        words = {wire.get("target") for one in self.every for wire in one.wire() if not one.refused}
        for phrase in ("the red mug", "the first book from the left", "the second mug from the left", "the laptop"):
            self.assertIn(phrase, words)
        self.assertNotIn("the mug", words)

    def test_targets_are_there_or_added(self):
        for one in self.every:
            for index, operation in enumerate(one.operations):
                for name in operation.targets + operation.references:
                    known = int(name[1:]) < index if name.startswith("+") else name in self.parent.scene.bodies
                    self.assertTrue(known, (one.wire(), name))


class Page(unittest.TestCase):
    def test_wrong_edits_break_the_bar_and_are_listed(self):
        case = Case("edit_000", "p", 7, [Operation({"op": "tidy"})])
        right, wrong = Judged(case, RIGHT), Judged(case, WRONG, ["mug_1 vanished"])
        parents = [SimpleNamespace(is_image=False)]
        self.assertTrue(all(bar[3] for bar in bar.edit_bars([right], 1)))
        self.assertFalse(all(bar[3] for bar in bar.edit_bars([right, wrong], 2)))
        page = bar.edits_page([right, wrong, Judged(case, NO_ROOM, ["refused: full"])], parents)
        self.assertIn("| tidy | 3 | 1 | 0 | 1 | 1 |", page)
        self.assertIn("mug_1 vanished", page)
        self.assertIn('`{"op": "tidy"}`', page)

    def test_operations_that_are_rare_break_the_bar(self):
        found = [Judged(Case("x", "p", 1, [Operation({"op": kind})] * 10), RIGHT) for kind in PLANS]
        self.assertTrue(all(bar[3] for bar in bar.edit_bars(found, 200)))
        found[3].case.operations.pop()
        self.assertFalse(all(bar[3] for bar in bar.edit_bars(found, 200)))

    def test_the_worst_ratio_counts(self):
        costs = {"full run": [10.0, 11.0, 9.0]} | dict.fromkeys(bar.SINGLE_EDITS, [2.0, 2.0, 2.0])
        self.assertTrue(bar.cost_bar(costs)[3])
        self.assertFalse(bar.cost_bar(costs | {"move": [2.5, 2.5, 2.5]})[3])
        self.assertIn("| move | 2.00 |", bar.costs_page(costs))


if __name__ == "__main__":
    unittest.main()
