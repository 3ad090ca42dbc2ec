"""Cluttered tables: twenty texts of 25 objects each, dropped with three densities; certified, and at rest in MuJoCo.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.clutter [--program PROGRAM] [--count 20] [--seed 1]

The objects are drawn from the catalog's categories that a gripper can hold, each at most once in a text. MuJoCo judges
the MJCF as in `certified`: a body is at rest if it moves, turns and overlaps as little in five seconds as the
certificate demands of itself. CPU seconds are those of a whole `generate`; the second and third density of a text find
the stages up to `resolve` of the first, so only the first has the time of a whole scene.
"""

import json
import random
import shutil
import statistics
from dataclasses import dataclass, field
from pathlib import Path

from tabletopgen_checks.bars.page import SCENES_OF_TEXTS, arguments, percent, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.catalog import entries
from tabletopgen_checks.judges.judging import finish_setup, judge, start_setup
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.scene.generation import generate

DEPENDS_ON = (*SCENES_OF_TEXTS, "tests/judges/mjcf.py", "tests/judges/rest.py")
DENSITIES = (0.2, 0.5, 0.8)
OBJECTS = 25
COUNT = 20
LARGEST_M = 0.3
BAR = 0.95
VOWELS = "aeiou"


@dataclass
class Made:
    """One scene, as far as there is one."""

    name: str
    density: float
    wrong: list
    objects: int = 0
    dropped: int = 0
    set_down: int = 0
    stable: int = 0
    movable: int = 0
    contacts: float = 0.0
    touching: int = 0
    covered: float = 0.0
    hidden: float = 0.0
    cpu_s: float = 0.0
    stage_s: float = 0.0
    complaints: list = field(default_factory=list)

    @property
    def is_certified(self) -> bool:
        return self.objects > 0 and not self.wrong


def main() -> bool:
    given = arguments(__doc__, program="", count=COUNT, seed=1)
    binary = Path(given.program).resolve() if given.program else given.binary
    environment = given.target_dir / "judges"
    finish_setup(start_setup(environment))
    made, whole_cpu_s = [], []
    for index, text in enumerate(texts(given.count, given.seed)):
        folder = given.work / "clutter" / f"text-{index + 1}"
        for density in DENSITIES:
            scene = measured(binary, environment, folder, text, index + given.seed, density)
            print(f"{scene.name} at {density}: {'; '.join(scene.wrong) or 'certified'}", flush=True)
            if density == DENSITIES[0] and scene.objects:
                whole_cpu_s.append(scene.cpu_s)
            made.append(scene)
        # Sixty bundles would fill gigabytes.
        shutil.rmtree(folder / "data", ignore_errors=True)
    body, holds = page(made, whole_cpu_s)
    write("clutter", "Cluttered tables", body, DEPENDS_ON)
    return holds


def texts(count: int, seed: int) -> list:
    """Texts of 25 objects of different categories."""
    labels = sorted({entry["label"] for entry in entries() if is_small(entry)})
    chance = random.Random(seed)
    return [text(chance.sample(labels, OBJECTS)) for _ in range(count)]


def is_small(entry: dict) -> bool:
    """Whether a gripper can hold it, and it is no stand-in."""
    if entry.get("group") == "stand_in" or "graspable" not in entry.get("affordances", ()):
        return False
    return max(entry["size"]["high_m"]) <= LARGEST_M


def text(labels: list) -> str:
    names = [f"{'an' if label[0].lower() in VOWELS else 'a'} {label}" for label in labels]
    return f"A table with {OBJECTS} objects: {', '.join(names[:-1])} and {names[-1]}"


def measured(binary, environment, folder, text, seed, density) -> Made:
    bundle = folder / f"density-{density}"
    scene = Made(folder.name, density, [])
    try:
        run = generate(binary, bundle, text, seed, data=folder / "data", more=["--clutter", str(density)])
    except Problem as problem:
        scene.wrong = [str(problem).splitlines()[-1].strip()]
        return scene
    report = json.loads((bundle / "report.json").read_text(encoding="utf-8"))
    scene.wrong = [reason["sentence"] for reason in report["reasons"]]
    found = report["clutter"]
    placements = [one["placement"] for one in found["objects"]]
    scene.objects, scene.cpu_s = len(placements), run.cpu_s
    scene.dropped, scene.set_down = placements.count("dropped"), placements.count("set_down")
    scene.contacts, scene.touching = found["mean_contacts"], found["touching"]
    scene.covered, scene.hidden = found["covered_share"], found["hidden_share"]
    stages = [stage for stage in run.printed["stages"] if stage["stage"] == "clutter"]
    scene.stage_s = sum(stage["work_ms"] for stage in stages) / 1000.0
    verdict = judge(environment, [bundle], dss_bar=0.0, only=["mjcf"])["bundles"][str(bundle.resolve())]["mjcf"]
    scene.stable = verdict["facts"].get("stable", 0)
    scene.movable = verdict["facts"].get("movable", scene.objects)
    scene.complaints = verdict["complaints"]
    return scene


def page(made: list, whole_cpu_s: list):
    """(the page, whether the bars hold)."""
    certified = sum(scene.is_certified for scene in made) / max(len(made), 1)
    stable, movable = sum(scene.stable for scene in made), sum(scene.movable for scene in made)
    rest = stable / movable if movable else 0.0
    whole = f"{statistics.median(whole_cpu_s):.1f}" if whole_cpu_s else "-"
    bars = [
        ["Certified", f"{percent(certified)} of {len(made)}", percent(BAR, 0), said(certified >= BAR)],
        ["At rest in MuJoCo", f"{percent(rest)} of {movable}", percent(BAR, 0), said(rest >= BAR)],
        ["CPU seconds of a scene, median", whole, "no bar", "holds"],
    ]
    columns = ["density", "scenes", "certified", "at rest in MuJoCo", "dropped", "set down upright", "contacts per object",
               "touch another", "covered share", "hidden by a quarter", "stage, s, median and most"]
    rows = [row(density, [scene for scene in made if scene.density == density]) for density in DENSITIES]
    notes = [f"- {scene.name} at {scene.density}: {words}" for scene in made for words in scene.wrong + scene.complaints]
    body = (
        f"{len(made)} scenes: each text with the densities {', '.join(map(str, DENSITIES))}.\n\n"
        + table(["", "found", "bar", ""], bars) + "\n\n" + table(columns, rows)
        + ("\n\nWhat failed:\n\n" + "\n".join(notes) if notes else "")
    )
    return body, certified >= BAR and rest >= BAR


def said(holds: bool) -> str:
    return "holds" if holds else "DOES NOT HOLD"


def row(density: float, scenes: list) -> list:
    there = [scene for scene in scenes if scene.objects]
    if not there:
        return [density, len(scenes)] + ["-"] * 9

    def mean(of):
        return sum(of(scene) for scene in there) / len(there)

    objects, movable = sum(scene.objects for scene in there), sum(scene.movable for scene in there)
    stage_s = sorted(scene.stage_s for scene in there)
    return [
        density, len(scenes), percent(sum(scene.is_certified for scene in scenes) / len(scenes)),
        percent(sum(scene.stable for scene in there) / movable if movable else 0.0),
        f"{sum(scene.dropped for scene in there)} of {objects}", sum(scene.set_down for scene in there),
        f"{mean(lambda scene: scene.contacts):.2f}", percent(sum(scene.touching for scene in there) / objects),
        percent(mean(lambda scene: scene.covered)), percent(mean(lambda scene: scene.hidden)),
        f"{statistics.median(stage_s):.1f}, {stage_s[-1]:.1f}",
    ]


if __name__ == "__main__":
    run(main)
