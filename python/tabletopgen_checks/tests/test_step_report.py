"""Whether steps stop at the first that fails, and steps of another run are counted."""

import contextlib
import io
import unittest
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.step_report import StepReport


def fails():
    raise Problem("no room")


def interrupted():
    raise KeyboardInterrupt


STEPS = {"one": lambda: "as it should be", "two": fails, "three": interrupted, "four": lambda: "reached"}


def run(*names):
    """The report of some steps and what they printed."""
    report, shown = StepReport(Path(".")), io.StringIO()
    with contextlib.redirect_stdout(shown):
        report.run(STEPS, names)
        report.summarize("make test")
    return report, shown.getvalue()


class Steps(unittest.TestCase):
    def test_all_that_pass(self):
        report, printed = run("one", "four")
        self.assertFalse(report.is_failed)
        self.assertIn("== one: as it should be (0 s)\n", printed)
        self.assertIn("make test: all passed in 0.0 min (one: as it should be; four: reached)\n", printed)

    def test_none_is_begun_after_one_that_failed(self):
        for name, words in (("two", "FAILED"), ("three", "interrupted")):
            report, printed = run("one", name, "four")
            self.assertTrue(report.is_failed)
            self.assertNotIn("== four", printed)
            self.assertIn(f"make test: FAILED in 0.0 min (one: as it should be; {name}: {words})\n", printed)
        self.assertIn("== two FAILED: no room\n", run("two")[1])

    def test_a_full_disk_is_named(self):
        for free_mb, is_full in ((12, True), (5000, False)):
            disk = SimpleNamespace(free=free_mb * 10**6)
            with mock.patch("shutil.disk_usage", return_value=disk):
                self.assertEqual("is full, 12 MB are left" in run("two")[1], is_full)

    def test_steps_of_another_run_are_counted(self):
        report = StepReport(Path("."))
        report.take_over("== a\nnoise\n== a: 3 scenes (of 3) (61 s)\n== b\n== b FAILED: no room\n   61 s  a\n")
        self.assertEqual(report.sentences, ["a: 3 scenes (of 3)"])
        self.assertEqual(report.seconds, {"a": 61.0})


if __name__ == "__main__":
    unittest.main()
