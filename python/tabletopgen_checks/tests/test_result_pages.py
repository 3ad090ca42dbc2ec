"""Pages of results name what they were measured at and what they depend on, and their age is listed."""

import importlib
import re
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from tabletopgen_checks import fuzz, result_pages
from tabletopgen_checks.bars import page
from tabletopgen_checks.repository import PYTHON, RESULTS, ROOT
from tabletopgen_checks.result_pages import Measurement, dependency_line, measurements, split

BARS = PYTHON / "tabletopgen_checks" / "bars"
PATHS = ("crates/method/physics", "src/pipeline")
TEXT = """# A page

`make bars` at
commit 0123456789ab with uncommitted changes on 2026-11-23, 2 cores. The grammar of commit 7654321 was worse.

## One

At commit abcdef0 on 2026-11-24, and at commit abcdef1 on 2026-11-22.

## Two

No commit.
"""


def depends_on(bar: str) -> tuple:
    """What the module of a bar declares."""
    return importlib.import_module(f"tabletopgen_checks.bars.{bar}").DEPENDS_ON


class Pages(unittest.TestCase):
    def test_every_page_names_a_commit_a_day_and_paths_that_exist(self):
        pages = sorted(RESULTS.glob("*.md"))
        self.assertTrue(pages)
        for path in pages:
            text, paths = split(path.read_text(encoding="utf-8"))
            with self.subTest(page=path.name):
                self.assertTrue(measurements(path.name, text), 'the page has to state "at commit COMMIT on DAY"')
                self.assertTrue(paths, f"the last line of the page has to be like: {dependency_line(PATHS)}")
                self.assertEqual([name for name in paths if not (ROOT / name).exists()], [], "no such paths")

    def test_the_line_of_a_page_is_that_of_its_bar(self):
        bars = {path.stem: depends_on(path.stem) for path in RESULTS.glob("*.md")
                if (BARS / f"{path.stem}.py").exists() or (BARS / path.stem).is_dir()}
        self.assertIn("kill", bars)
        for name, paths in {**bars, "fuzz": fuzz.DEPENDS_ON}.items():
            with self.subTest(page=name):
                self.assertEqual(split((RESULTS / f"{name}.md").read_text(encoding="utf-8"))[1], list(paths))
        line = (RESULTS / "decompose.md").read_text(encoding="utf-8").splitlines()[-1]
        self.assertIn(line, (ROOT / "benches" / "decompose_beside_coacd.py").read_text(encoding="utf-8"))

    def test_every_bar_depends_on_paths_that_exist(self):
        found = re.search(r"^BARS \?= (.*)$", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
        for bar in found[1].split() if found else self.fail("the Makefile names no bars"):
            with self.subTest(bar=bar):
                self.assertEqual([name for name in depends_on(bar) if not (ROOT / name).exists()], [])


class Reading(unittest.TestCase):
    def test_each_section_names_what_it_was_measured_at(self):
        self.assertEqual(measurements("a.md", TEXT), [
            Measurement("a.md", "", "0123456789ab", "2026-11-23"),
            Measurement("a.md", "One", "abcdef0", "2026-11-24"),
            Measurement("a.md", "One", "abcdef1", "2026-11-22"),
        ])

    def test_the_line_at_the_foot_is_read_back(self):
        self.assertEqual(split(f"{TEXT}\n{dependency_line(PATHS)}\n"), (TEXT, list(PATHS)))
        self.assertEqual(split(f"{dependency_line(PATHS)}\n\n{TEXT}")[1], [])

    def test_a_section_is_written_above_the_foot(self):
        with tempfile.TemporaryDirectory() as folder:
            with (
                mock.patch.multiple(page, RESULTS=Path(folder), ROOT=Path(folder), measured_commit=lambda: "abcdef0"),
                mock.patch("builtins.print"),
            ):
                page.write("bar", "A bar", "body", PATHS)
                for heading in ("One", "Two", "One"):
                    page.write_section("bar", heading, "part", PATHS)
            text, paths = split((Path(folder) / "bar.md").read_text(encoding="utf-8"))
        self.assertEqual(paths, list(PATHS))
        self.assertNotIn("Depends on", text)
        self.assertEqual(re.findall("^#.*", text, re.MULTILINE), ["# A bar", "## One", "## Two"])


class Listing(unittest.TestCase):
    # Two commits since the one that is known; a file was moved into a folder that the page depends on.
    ANSWERS = {"rev-list": "2", "diff": "3\t1\t\0src/old.rs\0src/pipeline/new.rs\0-\t-\tsrc/pipeline/a.png\x007\t0\tsrc/pipeline.rs\0"}

    def listed(self, shallow: str) -> list:
        def git(*words):
            if words[:2] == ("rev-parse", "--verify"):
                return "" if "abcdef1" in words[-1] else "known"
            return self.ANSWERS.get(words[0], shallow)

        for function in (result_pages.is_known, result_pages.files_changed):
            function.cache_clear()
            self.addCleanup(function.cache_clear)
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "a.md").write_text(f"{TEXT}\n{dependency_line(PATHS)}\n", encoding="utf-8")
            with mock.patch.object(result_pages, "RESULTS", Path(folder)), mock.patch.object(result_pages, "git", git):
                return result_pages.listing().splitlines()

    def test_the_oldest_of_each_section_comes_first(self):
        lines = self.listed("false")
        self.assertEqual(lines[1].split("  ")[0], "a.md")
        self.assertRegex(lines[1], r"One +abcdef1, oldest of 2 +2026-11-22 +not in this clone$")
        self.assertRegex(lines[2], r"0123456789ab +2026-11-23 +2 +4$")
        self.assertIn("no history here has this commit", lines[-1])

    def test_a_shallow_clone_is_named(self):
        self.assertIn("shallow clone; `git fetch --unshallow`", self.listed("true")[-1])


if __name__ == "__main__":
    unittest.main()
