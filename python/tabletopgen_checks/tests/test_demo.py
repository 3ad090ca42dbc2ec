"""`make demo` on Python 3.9, and without a Python."""

import ast
import json
import re
import tempfile
import unittest
import zipfile
from pathlib import Path

from tabletopgen_checks import demo
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import PYTHON, ROOT
from tabletopgen_checks.scene.unpacking import unpack
from tabletopgen_checks.tests.machine import Machine

# A stand-in for the program that tells what it was asked for.
TELLS = '#!/bin/sh\nfor word in "$@"; do echo "<$word>"; done\n'


class OldPython(unittest.TestCase):
    def modules_of(self, program: str) -> set:
        """The modules of this package that a program imports, each read as Python 3.9."""
        left, seen = [f"tabletopgen_checks.{program}"], set()
        while left:
            module = left.pop()
            if module in seen:
                continue
            seen.add(module)
            path = PYTHON / f"{module.replace('.', '/')}.py"
            tree = ast.parse(path.read_text(encoding="utf-8"), str(path), feature_version=(3, 9))
            for node in ast.walk(tree):
                names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
                names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
                self.assertNotIn("tomllib", names, f"{module} imports what Python 3.11 brought")
                left += [name for name in names if name.startswith("tabletopgen_checks.")]
        return {module.removeprefix("tabletopgen_checks.") for module in seen}

    def test_what_the_demo_runs_is_python_3_9(self):
        self.assertEqual(self.modules_of("demo"), {"demo", "problem", "repository", "scene.unpacking", "service.server"})

    def test_what_the_fuzzer_runs_is_python_3_9(self):
        self.assertEqual(self.modules_of("fuzz"), {"fuzz", "bars.page", "repository", "result_pages"})

    def test_what_the_s3_server_of_the_tests_runs_is_python_3_9(self):
        needed = {"problem", "processes", "repository", "service.postgres", "service.s3", "virtual_environment"}
        self.assertEqual(self.modules_of("service.s3"), needed)


class Unpacking(unittest.TestCase):
    def test_an_earlier_bundle_is_replaced_and_files_of_others_are_not(self):
        with tempfile.TemporaryDirectory() as home:
            archive, folder = Path(home) / "scene.zip", Path(home) / "scene"
            manifest = json.dumps({"files": [{"path": "scene.json"}]})
            with zipfile.ZipFile(archive, "w") as bundle:
                bundle.writestr("scene-1/manifest.json", manifest)
                bundle.writestr("scene-1/scene.json", "{}")
            for _ in range(2):
                unpack(archive, folder)
            self.assertEqual(sorted(path.name for path in folder.iterdir()), ["manifest.json", "scene.json"])
            (folder / "notes.txt").write_text("mine", encoding="utf-8")
            with self.assertRaises(Problem) as refused:
                unpack(archive, folder)
            self.assertIn("notes.txt", str(refused.exception))
            self.assertEqual((folder / "notes.txt").read_text(encoding="utf-8"), "mine")


class WithoutPython(unittest.TestCase):
    def setUp(self):
        self.machine = self.enterContext(Machine())

    def test_both_demos_make_the_same_scenes(self):
        binary = self.machine.program("tabletopgen", TELLS)
        code, words, errors = self.machine.run("demo.sh", binary, "away")
        self.assertEqual((code, errors), (0, ""))
        asked = re.findall(r"<generate>\n((?:<.*>\n?)+)", words)
        image = ROOT / "docs/demo_table.png"
        wanted = [["--text", demo.TEXT, "sentence"], ["--image", str(image), "image"]]
        for (option, value, name), shown in zip(wanted, asked):
            expected = (option, value, "--seed", "7", "--out", f"away/{name}", "--force")
            self.assertEqual(shown.split("\n")[:-1], [f"<{w}>" for w in expected])
        self.assertEqual(len(asked), 2)
        self.assertTrue(image.is_file())
        self.assertIn("see away/sentence/preview and away/image/preview", words)

    def test_a_scene_that_did_not_come_ends_it(self):
        binary = self.machine.program("tabletopgen", "#!/bin/sh\nexit 3\n")
        code, words, errors = self.machine.run("demo.sh", binary, "away")
        self.assertEqual((code, errors), (1, "the demo did not finish: no scene came of the sentence; see above"))
        self.assertNotIn("done", words)


if __name__ == "__main__":
    unittest.main()
