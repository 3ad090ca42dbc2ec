"""Findings of several runs of the judges as one, and programs in the background."""

import contextlib
import io
import sys
import time
import unittest
from pathlib import Path

from tabletopgen_checks.judges.judging import merged
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.processes import BackgroundProgram


def findings(name, accepted=True, movable=10, stable=10, left_out=()):
    verdict = {"accepted": accepted, "complaints": [], "facts": {"movable": movable, "stable": stable}}
    return {"accepted": accepted, "dss_mujoco": 1.0, "left_out": dict.fromkeys(left_out, "no packages"),
            "bundles": {name: {"mjcf": verdict}}}


class Merged(unittest.TestCase):
    def test_bodies_of_all_bundles_count_together(self):
        for stable, accepted in ((10, True), (9, True), (8, False)):
            found = merged([findings("a"), findings("b", stable=stable)], 0.95)
            self.assertEqual((found["accepted"], found["dss_mujoco"]), (accepted, (10 + stable) / 20), stable)

    def test_one_rejection_rejects(self):
        found = merged([findings("a"), findings("b", accepted=False)], 0.95)
        self.assertFalse(found["accepted"])
        self.assertEqual(list(found["bundles"]), ["a", "b"])

    def test_what_was_left_out_is_listed(self):
        found = merged([findings("a", left_out=["bullet"]), findings("b")], 0.95)
        self.assertEqual(found["left_out"], {"bullet": "no packages"})

    def test_bundles_without_the_judge_of_mujoco(self):
        empty = {"accepted": True, "dss_mujoco": 1.0, "left_out": {}, "bundles": {"a": {}}}
        self.assertEqual(merged([empty], 0.95)["dss_mujoco"], 1.0)


class InTheBackground(unittest.TestCase):
    def run_beside(self, code):
        beside, shown = BackgroundProgram(), io.StringIO()
        beside.start([sys.executable, "-c", code], Path("."))
        with contextlib.redirect_stdout(shown):
            printed = beside.finish()
        self.assertEqual(printed, shown.getvalue())
        return printed

    def test_words_are_shown_when_it_is_waited_for(self):
        code = "import sys; print('out', flush=True); print('err', file=sys.stderr)"
        self.assertEqual(self.run_beside(code), "out\nerr\n")

    def test_a_failure_is_a_problem(self):
        with self.assertRaisesRegex(Problem, "exit code 3"):
            self.run_beside("raise SystemExit(3)")
        with self.assertRaisesRegex(Problem, "not started"):
            BackgroundProgram().finish()

    def test_stopped_programs_are_gone(self):
        beside = BackgroundProgram()
        beside.stop()
        beside.start([sys.executable, "-c", "import time; time.sleep(600)"], Path("."))
        beside.stop()
        self.assertFalse(beside.is_running())

    def test_what_failed_is_known_before_it_is_waited_for(self):
        beside = BackgroundProgram()
        self.assertFalse(beside.has_failed())
        beside.start([sys.executable, "-c", "raise SystemExit(3)"], Path("."))
        while beside.is_running():
            time.sleep(0.01)
        self.assertTrue(beside.has_failed())


if __name__ == "__main__":
    unittest.main()
