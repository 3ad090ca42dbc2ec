"""A hundred sentences: nothing collides, everything stands and rests, where it was asked for; every asset is accepted.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.certified [--target-dir target] [--count 100]

Who judges: Manifold and FCL for collisions of the GLB meshes, MuJoCo the MJCF and PyBullet the URDFs at rest,
simready-validate and NVIDIA's and OpenUSD's validators the USD files.
"""

import json
import shutil
import statistics

from tabletopgen_checks.bars.page import SCENES_OF_TEXTS, arguments, percent, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.judges.judging import JUDGE_NAMES, complaints, finish_setup, judge, start_setup
from tabletopgen_checks.language.certified_sentences import COUNT, certified_sentences
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.scene.generation import generate
from tabletopgen_checks.scene.scene import read_scene

DEPENDS_ON = (
    *SCENES_OF_TEXTS, "python/tabletopgen_checks/language/certified_sentences.py",
    "python/tabletopgen_checks/scene/relations.py", "tests/judges/bullet.py", "tests/judges/collisions.py",
    "tests/judges/mjcf.py", "tests/judges/usd.py",
)
# The README's examples are the business of the sentences.
JUDGES = [name for name in JUDGE_NAMES if name != "readme"]
MUJOCO_BAR = 0.99
MEDIAN_BAR_M, HIGH_BAR_M = 0.003, 0.015


def main() -> bool:
    given = arguments(__doc__, count=COUNT)
    environment = given.target_dir / "judges"
    finish_setup(start_setup(environment))
    found = Totals()
    for sentence in certified_sentences(given.count):
        folder = given.work / "certified" / sentence.name
        found.add(sentence, *measured(given.binary, environment, sentence, folder))
        # A hundred bundles would fill gigabytes; one with nothing wrong is not needed any more.
        if not found.rows[-1][-1]:
            shutil.rmtree(folder, ignore_errors=True)
    write("certified", "A hundred sentences, certified", found.page(), DEPENDS_ON)
    return found.held()


def measured(binary, environment, sentence, folder):
    """(report.json, verdicts by judge, what is wrong); without a scene the first two are None."""
    print(f"{sentence.name} ({sentence.objects} objects) ...", flush=True)
    try:
        generate(binary, folder, sentence.text, sentence.seed)
    except Problem as problem:
        return None, None, [str(problem).splitlines()[-1].strip()]
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    findings = judge(environment, [folder], dss_bar=0.0, only=JUDGES)
    wrong = sentence.complaints(read_scene(folder)) + [reason["sentence"] for reason in report["reasons"]]
    wrong += complaints(findings, folder)
    verdicts = findings["bundles"][str(folder.resolve())]
    for words in wrong:
        print(f"  - {words}", flush=True)
    return report, verdicts, wrong + [f"resolve: {line}" for line in report["resolve"]["log"]]


class Totals:
    """Counts over all scenes."""

    def __init__(self):
        self.rows, self.notes, self.asked = [], [], []
        self.scenes = self.colliding_scenes = self.colliding = self.pairs = self.failed = 0
        self.rest = {"mjcf": [0, 0], "bullet": [0, 0]}
        self.certified = {"ss": [0, 0], "dss_aligned": [0, 0], "dss_shipped": [0, 0]}
        self.moved_m, self.assets, self.refused = [], 0, 0
        self.files = self.file_errors = 0

    def add(self, sentence, report, verdicts, wrong):
        self.asked.append(f"- {sentence.name} (seed {sentence.seed}): {sentence.text}")
        self.notes += [f"- {sentence.name}: {words}" for words in wrong]
        if report is None:
            self.failed += 1
            self.colliding_scenes += 1
            self.rows.append([sentence.name, sentence.objects] + ["-"] * 6 + ["no scene"])
            return
        self.scenes += 1
        facts = {name: verdict["facts"] for name, verdict in verdicts.items()}
        self.pairs += facts["collisions"].get("pairs", 0)
        self.colliding += facts["collisions"].get("colliding", 0)
        self.colliding_scenes += not verdicts["collisions"]["accepted"]
        for judge_name, counts in self.rest.items():
            counts[0] += facts[judge_name].get("stable", 0)
            counts[1] += facts[judge_name].get("movable", sentence.objects)
        objects = len(report["objects"])
        for metric, counts in self.certified.items():
            counts[0] += report["metrics"][metric] * objects
            counts[1] += objects
        moved = sorted(o["moved"]["from_aligned"]["distance_m"] for o in report["objects"])
        self.moved_m += moved
        self.assets += facts["robotics_prop"].get("assets", 0)
        self.refused += facts["robotics_prop"].get("refused", 0)
        self.files += facts["robotics_prop"].get("files", 0)
        self.file_errors += facts["robotics_prop"].get("rule_errors", 0) + facts["usd"].get("validator_errors", 0)
        # What resolve did is listed, and no failure.
        failures = [words for words in wrong if not words.startswith("resolve: ")]
        self.failed += bool(failures)
        self.rows.append([
            sentence.name,
            objects,
            report["metrics"]["col_s"] > 0 and "yes" or "no",
            "yes" if facts["collisions"].get("colliding") else "no",
            percent(report["metrics"]["ss"]),
            percent(report["metrics"]["dss_aligned"]),
            f"{facts['mjcf'].get('stable', 0)} and {facts['bullet'].get('stable', 0)}",
            f"{1e3 * moved[-1]:.1f}",
            "; ".join(failures[:3]),
        ])

    def shares(self) -> dict:
        def of(counts):
            return counts[0] / counts[1] if counts[1] else 0.0
        return {name: of(counts) for name, counts in {**self.rest, **self.certified}.items()}

    def displacement_m(self):
        """(median, 95th percentile)."""
        if len(self.moved_m) < 2:
            return float("inf"), float("inf")
        return statistics.median(self.moved_m), statistics.quantiles(self.moved_m, n=20)[18]

    def held(self) -> bool:
        return all(holds for *_, holds in self.bars())

    def bars(self) -> list:
        """(what, found, bar, whether it holds)."""
        shares, (median_m, high_m) = self.shares(), self.displacement_m()
        total = len(self.rows)
        col_o = self.colliding / self.pairs if self.pairs else 1.0
        col_s = self.colliding_scenes / total if total else 1.0
        return [
            ("Scenes that keep every promise", f"{total - self.failed} of {total}", "all", not self.failed),
            ("Col_S, by Manifold and FCL", percent(col_s, 2), "0.00 %", not self.colliding_scenes),
            (f"Col_O of {self.pairs} pairs", percent(col_o, 2), "0.00 %", not self.colliding),
            ("SS, by the certificate", percent(shares["ss"], 2), "100 %", shares["ss"] == 1.0),
            ("At rest in MuJoCo, from the MJCF", percent(shares["mjcf"], 2), "99 %", shares["mjcf"] >= MUJOCO_BAR),
            ("At rest in PyBullet, from the URDFs", percent(shares["bullet"], 2), "not promised", True),
            ("DSS shipped, by the certificate", percent(shares["dss_shipped"], 2), "no bar", True),
            ("DSS aligned, by the certificate", percent(shares["dss_aligned"], 2), "no bar", True),
            ("Displacement by resolve and settle, median", f"{1e3 * median_m:.2f} mm", "3 mm", median_m < MEDIAN_BAR_M),
            ("Displacement, 95th percentile", f"{1e3 * high_m:.2f} mm", "15 mm", high_m < HIGH_BAR_M),
            (
                "Assets that meet Robotics-Prop 4.0.0, every required feature",
                f"{self.assets - self.refused} of {self.assets}", "all", self.assets > 0 and not self.refused,
            ),
            (
                f"Errors of OpenUSD's validators and NVIDIA's rules in {self.files} USD files",
                f"{self.file_errors}", "0", self.files > 0 and not self.file_errors,
            ),
        ]

    def page(self) -> str:
        bars = [[what, found, bar, "holds" if holds else "DOES NOT HOLD"] for what, found, bar, holds in self.bars()]
        columns = ["scene", "objects", "collides, own", "collides, judged", "SS", "DSS aligned",
                   "at rest in MuJoCo and PyBullet", "moved most, mm", "wrong"]
        objects = sum(row[1] for row in self.rows)
        notes = "\n".join(self.notes)
        return (
            f"{len(self.rows)} scenes with {objects} objects asked for. An object that is missing, or not where the sentence "
            "says (`python/tabletopgen_checks/scene/relations.py` states when), fails its scene.\n\n"
            + table(["", "found", "bar", ""], bars) + "\n\n" + table(columns, self.rows)
            + (f"\n\n{notes}" if notes else "") + "\n\nThe sentences:\n\n" + "\n".join(self.asked)
        )


if __name__ == "__main__":
    run(main)
