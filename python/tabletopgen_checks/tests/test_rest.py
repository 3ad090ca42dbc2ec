"""Examples of a README that run for longer, what counts as rest, and the page of the bar."""

import ast
import importlib.util
import tempfile
import unittest
from pathlib import Path

from tabletopgen_checks.bars import categories, rest
from tabletopgen_checks.judges.programs import known
from tabletopgen_checks.judges.resting import RestScene, rest_scenes, simulators, words
from tabletopgen_checks.repository import JUDGES, ROOT

SPECIFICATION = importlib.util.spec_from_file_location("rest_lines", JUDGES / "rest_lines.py")
assert SPECIFICATION is not None and SPECIFICATION.loader is not None
rest_lines = importlib.util.module_from_spec(SPECIFICATION)
SPECIFICATION.loader.exec_module(rest_lines)

STEPPING = """
from types import SimpleNamespace
model = SimpleNamespace(opt=SimpleNamespace(timestep=0.01))
body = SimpleNamespace(xpos=[0.0, 0.0, 0.0], xquat=[1.0, 0.0, 0.0, 0.0])
data = SimpleNamespace(body=lambda name: body, time=0.0)
for _ in range(7):
    body.xpos[0] += 1.0
    data.time += 0.01
print("what stands behind the loop does not run")
raise SystemExit(1)
"""
ADVANCING = """
class Simulator:
    def AdvanceTo(self, seconds):
        times.append(seconds)
times = []
simulator = Simulator()
simulator.AdvanceTo(1.0)
"""


def finding(**more):
    return {
        "bundle": "/scenes/tower", "program": "MuJoCo 3.3.0", "holds": True, "failure": "", "objects": 5, "held": 5,
        "worst": "cube_5", "worst_share": 0.5, "moved_mm": 5.0, "turned_deg": 0.1, "deepest": "cube_1 and cube_2",
        "deepest_share": 0.2, "depth_mm": 0.4, "cpu_s_per_s": 0.1, "step_s": 0.002, **more,
    }


class Lines(unittest.TestCase):
    def test_the_loop_of_steps_runs_for_the_seconds_asked_for(self):
        before, steps = rest_lines.parts(STEPPING)
        given = {}
        exec(compile(before, "README.md", "exec"), given)
        found = rest_lines.simulated(rest_lines.Mujoco, steps, given, 5.0, ["mug"])
        self.assertEqual(found["poses"]["mug"], [500.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        self.assertAlmostEqual(found["simulated_s"], 5.0)

    def test_a_simulation_that_began_anew_is_no_rest(self):
        before, steps = rest_lines.parts(STEPPING.replace("data.time += 0.01", "data.time = 0.0"))
        given = {}
        exec(compile(before, "README.md", "exec"), given)
        with self.assertRaisesRegex(RuntimeError, "diverged"):
            rest_lines.simulated(rest_lines.Mujoco, steps, given, 5.0, ["mug"])

    def test_drake_advances_to_the_seconds_asked_for(self):
        before, steps = rest_lines.parts(ADVANCING)
        given = {}
        exec(compile(before, "README.md", "exec"), given)
        rest_lines.run(steps, given, 1000, 0.005)
        self.assertEqual(given["times"], [5.0])

    def test_an_example_without_steps_runs_whole(self):
        before, steps = rest_lines.parts("for name in range(len('abc')):\n    pass\n")
        self.assertIsNone(steps)
        self.assertEqual(len(before.body), 1)

    def test_the_step_of_newton_is_read_from_its_call(self):
        loop = ast.parse("for _ in range(100):\n    solver.step(state, after, control, None, 1 / 500)\n").body[0]
        self.assertAlmostEqual(rest_lines.Newton.step_s({}, loop), 0.002)


class Data(unittest.TestCase):
    def test_forty_scenes_of_seven_kinds_have_names_of_their_own(self):
        self.assertEqual(len({scene.name for scene in rest_scenes()}), rest.SCENES)
        self.assertEqual(len({scene.kind for scene in rest_scenes()}), 7)
        self.assertEqual(len(rest_scenes(sample=True)), 3)

    def test_every_program_has_a_reader_and_an_environment(self):
        readers = {*rest_lines.READERS, "load", "javascript"}
        for one in simulators():
            self.assertIn(one["reader"], readers)
            self.assertTrue("environment" not in one or one["environment"] in known(), one["name"])


class Page(unittest.TestCase):
    def test_what_does_not_rest_is_named_and_fails_the_bar(self):
        wanted, made = [RestScene("tower", "stack", 1, "A tower")], [(Path("/scenes/tower"), [])]
        text, held = rest.page(wanted, made, {"MuJoCo 3.3.0": [finding()]})
        self.assertTrue(held)
        self.assertIn("| MuJoCo 3.3.0 | yes | 1 of 1 | 5 of 5 | cube_5 (tower) | 5.00 | 0.10 |", text)
        fallen = finding(holds=False, held=4, worst_share=27.0, moved_mm=270.0, turned_deg=90.0)
        text, held = rest.page(wanted, made, {"MuJoCo 3.3.0": [fallen]})
        self.assertFalse(held)
        self.assertIn("- MuJoCo 3.3.0, tower: cube_5 moves 270.00 mm and turns 90.00 degrees", text)

    def test_a_program_that_was_not_run_is_named_and_fails_the_bar(self):
        wanted, made = [RestScene("tower", "stack", 1, "A tower")], [(Path("/scenes/tower"), [])]
        text, held = rest.page(wanted, made, {"MuJoCo 3.3.0": [finding()], "Drake": []})
        self.assertFalse(held)
        self.assertIn("## Not measured\n\n- Drake: 1 of 1 scenes", text)

    def test_where_rest_is_not_promised_the_page_says_why_and_the_bundle_too(self):
        why_not = {one["name"]: one for one in simulators() if "not_promised" in one}
        self.assertTrue(why_not)
        wanted, made = [RestScene("tower", "stack", 1, "A tower")], [(Path("/scenes/tower"), [])]
        fallen = finding(holds=False, held=4, worst_share=10.0, moved_mm=270.0, turned_deg=90.0)
        for name, one in why_not.items():
            text, held = rest.page(wanted, made, {"MuJoCo 3.3.0": [finding()], name: [fallen]})
            self.assertTrue(held)
            self.assertIn(f"- {name}: {one['not_promised']}", text)
            self.assertIn(f"- {name}, tower: cube_5 moves 270.00 mm and turns 90.00 degrees", text)
        readme = (ROOT / "crates/data/export/src/readme_template.md").read_text(encoding="utf-8")
        sections = {part.split("\n")[0].split(" (")[0]: part for part in readme.split("\n## ")[1:]}
        stated_by = {heading for heading, part in sections.items() if "Rest is not promised" in " ".join(part.split())}
        self.assertEqual(stated_by, {one["heading"] for one in why_not.values()})

    def test_findings_are_kept_for_as_long_as_the_program_is_the_same(self):
        with tempfile.TemporaryDirectory() as folder:
            program, kept = Path(folder) / "program", Path(folder) / "rest"
            bundles = [kept / "tower", kept / "coins"]
            program.write_text("one", encoding="utf-8")
            rest.FindingCache(kept, program).add("MuJoCo 3.3.0", finding())
            found = rest.FindingCache(kept, program).found("MuJoCo 3.3.0", bundles)
            self.assertEqual([one["bundle"] for one in found], ["/scenes/tower"])
            program.write_text("another", encoding="utf-8")
            self.assertEqual(rest.FindingCache(kept, program).found("MuJoCo 3.3.0", bundles), [])

    def test_a_scene_that_is_not_certified_fails_the_bar(self):
        _, held = rest.page([RestScene("tower", "stack", 1, "A tower")], [(None, ["no room"])], {})
        self.assertFalse(held)

    def test_a_program_that_fails_tells_its_last_words(self):
        self.assertEqual(words(finding(holds=False, failure="ImportError:\n no module")), "ImportError: no module")
        sunk = words(finding(holds=False, deepest_share=2.0, depth_mm=4.0))
        self.assertEqual(sunk, "cube_1 and cube_2 4.00 mm deep in each other")


class Categories(unittest.TestCase):
    def test_every_category_is_asked_for_alone(self):
        alone = [name for name, part, _ in categories.texts(categories.categories()) if part == "alone"]
        self.assertEqual(len(alone), len(set(alone)))
        self.assertEqual(len(alone), 1531)

    def test_containers_get_what_fits_and_long_objects(self):
        asked = {(name, part): text for name, part, text in categories.texts(categories.categories())}
        self.assertEqual(asked["bowl", "in"], "a bowl with an apple in it")
        self.assertEqual(asked["jar", "long"], "a jar with three paintbrushes in it")
        self.assertEqual(asked["pizza", "plate"], "a pizza on a plate")
        self.assertEqual(asked["tongs", "alone"], "tongs")


if __name__ == "__main__":
    unittest.main()
