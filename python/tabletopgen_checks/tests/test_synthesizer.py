"""The comparison with scene-synthesizer: what is asked of the programs, poses, and the page."""

import math
import unittest
from pathlib import Path
from unittest import mock

from tabletopgen_checks.bars.synthesizer import report, runs
from tabletopgen_checks.bars.synthesizer.runs import EDIT, GENERATE, OBJECTS, STABLE, UPRIGHT, WAYS, Run
from tabletopgen_checks.repository import SCRIPTS

NAMES = [f"mug_{k}" for k in range(OBJECTS)]


def one(way, seed=1, place_s: float | None = 1.0, process_s=2.0, names=NAMES, colliding=(), resting=None, moved_mm=0.1, depth_mm=0.0):
    findings = {
        "colliding": list(colliding),
        "at_rest": list(names if resting is None else resting),
        "moved_mm": {name: moved_mm for name in names},
        "hull_depth_mm": depth_mm,
    }
    return Run(way, seed, process_s, place_s, {name: [] for name in names}, findings)


def all_ways(**changed):
    return [one(way, **changed.get(way, {})) for way in WAYS]


class Requests(unittest.TestCase):
    def test_every_object_is_moved_on_the_table(self):
        self.assertEqual(
            runs.moves_of({"mug_1": [], "book_1": []}),
            [
                {"op": "move", "target": "mug_1", "where": {"relation": "on", "target": "table"}},
                {"op": "move", "target": "book_1", "where": {"relation": "on", "target": "table"}},
            ],
        )

    def test_without_a_bundle_the_package_is_only_imported(self):
        self.assertNotIn("--bundle", runs.synthesizer_command(Path("python"), None, "upright", 0))
        command = runs.synthesizer_command(Path("python"), Path("desk"), "stable", 7)
        self.assertEqual(command[-6:], ["--poses", "stable", "--seed", "7", "--bundle", "desk"])

    def test_a_quarter_turn_takes_x_to_y(self):
        half = math.sqrt(0.5)
        found = runs.matrix([1.0, 2.0, 3.0], [0.0, 0.0, half, half])
        wanted = [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]
        for row, right in zip(found, wanted):
            for part, number in zip(row, right):
                self.assertAlmostEqual(part, number)


class Time(unittest.TestCase):
    def placements(self, seconds_per_layout):
        """With programs that only let time pass; the layouts that were made."""
        clock, made = [0.0], []

        def runs_of(binary, python, bundle, text, seed):
            clock[0] += seconds_per_layout
            made.append((seed, text))
            return [one(way, seed) for way in WAYS]

        def judged(environment, layouts, path):
            return [{"number": number} for number in range(len(layouts))]

        stubs = {"runs_of": runs_of, "judged": judged}
        stubs |= {name: mock.DEFAULT for name in ("start_setup", "finish_setup", "environment_of", "called",
                                                  "stopped_by_failure", "shutil")}
        with mock.patch.multiple(runs, **stubs), mock.patch.object(runs.time, "monotonic", lambda: clock[0]):
            found = runs.placements(SCRIPTS, SCRIPTS, SCRIPTS, 4)
        return made, found

    def test_texts_take_turns_and_findings_keep_their_order(self):
        made, found = self.placements(1.0)
        self.assertEqual([seed for seed, _ in made], [1, 2, 3, 4])
        self.assertEqual([text for _, text in made], [*runs.TEXTS, runs.TEXTS[0]])
        self.assertEqual([run.findings["number"] for run in found], list(range(4 * len(WAYS))))

    def test_no_layout_begins_when_the_time_is_up(self):
        made, found = self.placements(0.6 * runs.LIMIT_S)
        self.assertEqual((len(made), len(found)), (2, 2 * len(WAYS)))


class Bars(unittest.TestCase):
    def missed(self, **changed):
        return [what for what, _, _, holds in report.bars_of(all_ways(**changed)) if not holds]

    def test_all_hold_where_all_is_well(self):
        self.assertEqual(self.missed(), [])

    def test_a_collision_an_object_less_and_one_that_falls_are_missed(self):
        self.assertEqual(self.missed(**{EDIT: {"colliding": [["a", "b", 2.0]]}}), [f"{EDIT}: colliding pairs"])
        self.assertEqual(self.missed(**{GENERATE: {"resting": NAMES[1:]}}), [f"{GENERATE}: at rest"])
        # A refused edit.
        self.assertEqual(self.missed(**{EDIT: {"names": []}}), [f"{EDIT}: objects placed", f"{EDIT}: at rest"])

    def test_the_bar_of_rest_is_the_better_of_the_peer(self):
        both = {UPRIGHT: {"resting": NAMES[1:]}, EDIT: {"resting": NAMES[1:]}, GENERATE: {"resting": NAMES[1:]}}
        self.assertEqual(self.missed(**both), [f"{EDIT}: at rest", f"{GENERATE}: at rest"])
        self.assertEqual(self.missed(**both, **{STABLE: {"resting": NAMES[2:]}}), [])

    def test_what_the_peer_does_wrong_is_not_our_fault(self):
        self.assertEqual(self.missed(**{UPRIGHT: {"names": [], "colliding": [["a", "b", 9.0]]}}), [])


class Page(unittest.TestCase):
    def test_a_row_has_medians_ranges_and_sums(self):
        found = [
            one(EDIT, 1, place_s=1.0, process_s=4.0, moved_mm=0.25, depth_mm=0.5),
            one(EDIT, 2, place_s=3.0, process_s=5.0, moved_mm=1.75, colliding=[["a", "b", 2.0]]),
            one(EDIT, 3, place_s=2.0, process_s=9.0, names=[], depth_mm=0.25),
        ]
        self.assertEqual(
            report.row(EDIT, found),
            [EDIT, "2.00", "1.00 to 3.00", "5.00", "4.00 to 9.00", "20 of 30", 1, "0.50", "66.7 %", "1.00", "1.75"],
        )

    def test_what_has_no_time_of_placing_shows_none(self):
        self.assertEqual(report.row(GENERATE, [one(GENERATE, place_s=None)])[1:3], ["-", "-"])

    def test_the_page_has_every_way_and_tells_whether_the_bars_hold(self):
        pages = []
        with mock.patch.object(report, "write", lambda *page: pages.append(page)):
            self.assertTrue(report.write_page(all_ways()))
            self.assertFalse(report.write_page(all_ways(**{EDIT: {"names": NAMES[1:]}})))
        self.assertEqual([name for name, *_ in pages], ["synthesizer", "synthesizer"])
        for way in WAYS:
            self.assertIn(f"| {way} | ", pages[0][2])
        self.assertNotIn("DOES NOT HOLD", pages[0][2])
        self.assertIn(f"| {EDIT}: objects placed | 9 | 10 | DOES NOT HOLD |", pages[1][2])
        self.assertNotIn("{", pages[0][2])


if __name__ == "__main__":
    unittest.main()
