"""Finished scenes by a program that stands for `tabletopgen`: what is counted, what is kept, what is tried again."""

import contextlib
import io
import sys
import tempfile
import unittest
from pathlib import Path

from tabletopgen_checks.language.scene_maker import SceneMaker, SceneText
from tabletopgen_checks.problem import Problem

# Makes a scene of one mug; the text says what goes wrong. Counts its runs in the file beside it.
PROGRAM = '''#!{python}
import json, pathlib, sys, time
with open({runs!r}, "a") as runs:
    runs.write("run\\n")
asked = dict(zip(sys.argv[2::2], sys.argv[3::2]))
text, out = asked["--text"], pathlib.Path(asked["--out"])
if text == "no scene":
    print(json.dumps({{"failure": {{"message": "nothing stands"}}}}))
    sys.exit(1)
out.mkdir(parents=True)
mug = {{"name": "mug_1", "label": "mug", "category": "mug", "translation_m": [0, 0, 0], "rotation_xyzw": [0, 0, 0, 1],
       "yaw_rad": 0, "symmetry_order": 0, "size_m": [0.1, 0.1, 0.1], "mass_kg": 0.3, "friction": {{}},
       "center_of_mass_m": [0, 0, 0.05], "support": {{"parent": "table", "relation": "on"}}}}
table = {{"shape": "round", "outline_m": [[-0.5, -0.3], [0.5, 0.3]], "size_m": [1, 0.6, 0.7]}}
scene = {{"table": table, "instances": [] if text == "empty" else [mug], "text": {{"unmet": []}}}}
(out / "scene.json").write_text("?" if text == "no JSON" else json.dumps(scene))
(out / "report.json").write_text("{{}}")
verdict = "quarantine" if text == "quarantine" else "pass"
print(json.dumps({{"verdict": verdict, "reasons": ["it falls"] if verdict != "pass" else []}}))
sys.exit(3 if verdict != "pass" else 0)
'''
MUG = {"description": {"table": {}, "objects": [
    {"id": "mug_1", "label": "mug", "category": "mug", "requested": True, "size_m": [0.1, 0.1, 0.1]}
]}}


def wanted(text):
    return SceneText(text.replace(" ", "_"), text, 1, MUG)


class Scenes(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = Path(self.folder.name)
        self.runs = self.path / "runs"
        self.binary = self.path / "program"
        self.binary.write_text(PROGRAM.format(python=sys.executable, runs=str(self.runs)), encoding="utf-8")
        self.binary.chmod(0o755)

    def make(self, *texts):
        self.shown = io.StringIO()
        with contextlib.redirect_stdout(self.shown):
            return SceneMaker(self.binary, self.path / "work").make([wanted(text) for text in texts])

    def count(self):
        return len(self.runs.read_text().splitlines())

    def test_every_text_is_a_scene_or_a_failure_with_its_reason(self):
        found = self.make("a mug", "no scene", "no JSON", "quarantine", "empty")
        said = {name: one.complaints(lambda view: []) for name, one in found.items()}
        self.assertEqual(said["a_mug"], [])
        self.assertIn("nothing stands", said["no_scene"][0])
        self.assertIn("JSONDecodeError", said["no_JSON"][0])
        self.assertEqual(said["quarantine"], ["quarantine: it falls"])
        self.assertEqual(said["empty"], ["mug_1 is not in the scene"])
        tells = {name for name, one in found.items() if one.tells()}
        self.assertEqual(tells, {"no_scene", "no_JSON", "quarantine"})
        self.assertIn("[5/5]", self.shown.getvalue())

    def test_measures_that_break_off_are_complaints(self):
        def of_view(view):
            return view.bodies["fork_1"]

        self.assertIn("KeyError", self.make("a mug")["a_mug"].complaints(of_view)[0])

    def test_scenes_are_kept_and_failures_are_tried_again(self):
        self.make("a mug", "no scene")
        self.assertEqual(self.count(), 2)
        found = self.make("a mug", "no scene")
        self.assertEqual(self.count(), 3)
        self.assertTrue(found["a_mug"].certified)
        self.assertGreater(found["a_mug"].cpu_s, 0)

    def test_another_program_starts_anew(self):
        self.make("a mug")
        self.binary.write_text(self.binary.read_text() + "\n# another\n")
        self.make("a mug")
        self.assertEqual(self.count(), 2)
        self.assertEqual(len(list((self.path / "work").iterdir())), 1)

    def test_the_lesser_of_two_times_counts(self):
        self.make("a mug")
        maker = SceneMaker(self.binary, self.path / "work")
        record = maker.recorded(wanted("a mug"))
        assert record is not None
        maker.keep(wanted("a mug"), dict(record, cpu_s=1e6))
        self.assertLess(maker.again(wanted("a mug")).cpu_s or 1e6, 1e6)
        maker.keep(wanted("a mug"), dict(record, cpu_s=1e-6))
        self.assertEqual(maker.again(wanted("a mug")).cpu_s, 1e-6)

    def test_a_missing_program_is_a_problem(self):
        with self.assertRaisesRegex(Problem, "make build"):
            SceneMaker(self.path / "none", self.path / "work")


if __name__ == "__main__":
    unittest.main()
