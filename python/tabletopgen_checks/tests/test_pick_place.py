"""The bar of picks and places: what counts as solved, and its section of the page."""

import unittest

from tabletopgen_checks.bars.page import with_section
from tabletopgen_checks.bars.pick_place import MIN_SCENES, summary


def motion(problem, kind, **changed):
    usual = {
        "problem": problem, "kind": kind, "obstacles": 40, "solved": True, "is_padded": True, "plan_s": 0.001,
        "total_s": 0.002, "path_is_free": True, "motion_is_free": True, "solvable": True, "detail": None,
    }
    return {**usual, **changed}


def both(problem, **changed):
    return [motion(problem, "transit"), motion(problem, "carry", **changed)]


def found(lines, wanted=1):
    scenes = [{"scene": 7, "lines": lines}] + [{"scene": 8 + k, "lines": []} for k in range(MIN_SCENES - 1)]
    [(_, value, _, holds)], text = summary(scenes, wanted)
    return value, holds, text


class PickAndPlaceTest(unittest.TestCase):
    def test_what_can_be_solved_and_is_not_is_missed(self):
        lines = both("a/table") + both("b/table", solved=False, path_is_free=False, detail="no path")
        value, holds, text = found(lines)
        self.assertEqual((value, holds), ("50.0 % of 2", False))
        self.assertIn("scene 7, b/table, carry: no path", text)

    def test_what_nothing_solves_is_not_counted(self):
        value, holds, text = found(both("a/table") + both("b/table", solved=False, solvable=False))
        self.assertEqual((value, holds), ("100.0 % of 1", True))

    def test_a_path_or_motion_that_touches_something_is_missed(self):
        for name in ("path_is_free", "motion_is_free"):
            value, holds, _ = found(both("a/table", **{name: False, "solvable": False}))
            self.assertEqual((value, holds), ("0.0 % of 1", False))

    def test_no_problem_holds_no_bar(self):
        value, holds, text = found([{"object": "a", "support": None, "no_problem": "too_heavy"}])
        self.assertEqual((value, holds), ("0.0 % of 0", False))
        self.assertIn("too_heavy 1", text)

    def test_too_few_hold_no_bar(self):
        value, holds, text = found(both("a/table"), wanted=2)
        self.assertEqual((value, holds), ("100.0 % of 1", False))
        self.assertIn("Too few for the bar, which wants 2", text)

    def test_a_section_is_replaced_or_comes_last(self):
        page = "# Robots\n\nlead\n\n## One\n\nold\n\n## Two\n\nkept\n"
        self.assertEqual(with_section(page, "One", "new"), "# Robots\n\nlead\n\n## One\n\nnew\n\n## Two\n\nkept\n")
        self.assertTrue(with_section(page, "Three", "new").endswith("## Two\n\nkept\n\n## Three\n\nnew\n"))


if __name__ == "__main__":
    unittest.main()
