"""Picks and places planned among the real hulls of generated scenes: a part of the bar `robot`.

`tabletopgen-lab pick-place` makes the problems of a scene and plans them as an execution does. A pick and place is two
motions: from home to before the grasp, and with the object from where it was raised to above its place. A motion is
solved if the planner has a path and a motion along it, and the exact check finds both free. What is not solved, but has
a path that anything else found within ten seconds, is missed.
"""

import hashlib
import json
import statistics
from collections import Counter
from pathlib import Path

from tabletopgen_checks.bars.page import percent, table
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.processes import run_alone
from tabletopgen_checks.repository import lab_beside

HEADING = "Picks and places planned"
BAR = 0.98
MIN_SCENES = 30
# Picks and places of one scene, and scenes that are measured before they are counted.
MAX_PER_SCENE, BATCH = 8, 10
# So many motions may each take ten seconds of other planners, and a few more.
SCENE_S = 900


def plan_scene(lab: Path, bundle: Path, seed: int, max_problems: int, robot: str = "panda") -> list:
    """The lines that `tabletopgen-lab pick-place` prints of one scene."""
    words = ["pick-place", "--bundle", bundle, "--robot", robot, "--seed", seed, "--max-problems", max_problems]
    command = [str(lab), *map(str, words)]
    ran = run_alone(command, SCENE_S, {"RAYON_NUM_THREADS": "1", "PATH": "/usr/bin:/bin"})
    if ran.exit_code != 0:
        raise Problem(f"{' '.join(command)}: {ran.stderr[-500:]}")
    return [json.loads(line) for line in ran.stdout.splitlines()]


def motions_of(lines: list) -> list:
    return [line for line in lines if "kind" in line]


def is_solved(motion: dict) -> bool:
    return motion["solved"] and motion["path_is_free"] and motion["motion_is_free"]


def is_counted(motion: dict) -> bool:
    """What the planner says it has solved is counted, also where nothing has a free path."""
    return motion["solvable"] or motion["solved"]


def measure(bench, sentences: list, wanted: int) -> tuple:
    """Bars and text about at least `wanted` picks and places in at least 30 scenes."""
    lab = lab_beside(bench.binary)
    with lab.open("rb") as program:
        digest = hashlib.file_digest(program, "sha256").hexdigest()[:12]
    folder = bench.folder / "pick_place" / digest
    folder.mkdir(parents=True, exist_ok=True)

    def work(number: int) -> list:
        path = folder / f"scene_{number:03}.json"
        if path.is_file():
            lines = json.loads(path.read_text(encoding="utf-8"))
        else:
            sentence = sentences[number]
            bundle = bench.scene(f"scene_{number:03}", sentence.text, sentence.seed)
            bench.expect_time()
            lines = plan_scene(lab, bundle, number, MAX_PER_SCENE)
            written = path.with_suffix(".part")
            written.write_text(json.dumps(lines), encoding="utf-8")
            written.rename(path)
        motions = motions_of(lines)
        missed = sum(is_counted(one) and not is_solved(one) for one in motions)
        return [{"outcome": f"{len(motions)} motions, {missed} missed", "scene": number, "lines": lines}]

    scenes, numbers = [], iter(range(len(sentences)))
    while len(scenes) < MIN_SCENES or len(pairs(scenes)) < wanted:
        batch = [number for number, _ in zip(numbers, range(BATCH))]
        found = [record for records in bench.each("picks and places of scene", batch, work) for record in records]
        scenes += [record for record in found if "lines" in record]
        if not batch or not any("lines" in record for record in found):
            break
    return summary(scenes, wanted)


def pairs(scenes: list) -> dict:
    """The motions of each pick and place."""
    found = {}
    for scene in scenes:
        for motion in motions_of(scene["lines"]):
            found.setdefault((scene["scene"], motion["problem"]), []).append(motion)
    return found


def summary(scenes: list, wanted: int) -> tuple:
    """Bars and text. Where fewer than `wanted` picks and places were measured the bar does not hold, whatever their
    share."""
    both = pairs(scenes)
    is_enough = len(both) >= wanted and len(scenes) >= MIN_SCENES
    groups = {
        "empty hand, to the grasp": [[m] for motions in both.values() for m in motions if m["kind"] == "transit"],
        "with the object, to its place": [[m] for motions in both.values() for m in motions if m["kind"] == "carry"],
        "pick and place: both": list(both.values()),
    }
    counts = {name: counted(group) for name, group in groups.items()}
    solved, solvable = counts["pick and place: both"][:2]
    share = solved / solvable if solvable else 0.0
    what = "Picks and places that are planned, of those that can be"
    bars = [(what, f"{percent(share)} of {solvable}", BAR, is_enough and share >= BAR)]
    rows = []
    for name, group in groups.items():
        solved, solvable = counts[name]
        seconds = sorted(sum(motion["total_s"] for motion in motions) for motions in group)
        rows.append([
            name, len(group), solvable, solved, percent(solved / solvable if solvable else 0.0), len(group) - solvable,
            sum(all(motion["is_padded"] for motion in motions) for motions in group), *times(seconds),
        ])
    columns = ["", "problems", "solvable", "solved", "share", "not known to be solvable", "full distance kept",
               "median ms", "p95 ms", "longest ms"]
    obstacles = [motion["obstacles"] for motions in both.values() for motion in motions]
    text = [
        f"{len(both)} picks and places in {len(scenes)} generated scenes by the Panda, among "
        f"{statistics.median(obstacles) if obstacles else 0:.0f} hulls (median; at most {max(obstacles, default=0)}). "
        "Grasps are candidates by geometry, places are random. Solved is what the planner of executions has with its own "
        "limits, with a free path and a free motion by the exact check; solvable is also what anything else solves within "
        "ten seconds. A time is that of planner and time law.",
        table(columns, rows),
    ]
    if not is_enough:
        text.insert(0, f"Too few for the bar, which wants {wanted} in {MIN_SCENES} scenes.")
    reasons = Counter(line["no_problem"] for scene in scenes for line in scene["lines"] if "no_problem" in line)
    if reasons:
        listed = ", ".join(f"{reason} {count}" for reason, count in reasons.most_common())
        text.append(f"What gave no problem, by object and place: {listed}.")
    missed = [
        f"- scene {scene}, {problem}, {motion['kind']}: {motion['detail']}"
        for (scene, problem), motions in both.items()
        for motion in motions
        if not is_solved(motion)
    ]
    if missed:
        text.append("What was not solved:\n\n" + "\n".join(missed))
    return bars, "\n\n".join(text)


def counted(group: list) -> tuple:
    """How many of these motions, or pairs of motions, are solved, and how many are counted."""
    possible = [motions for motions in group if all(map(is_counted, motions))]
    return sum(all(map(is_solved, motions)) for motions in possible), len(possible)


def times(seconds: list) -> list:
    if not seconds:
        return ["-", "-", "-"]
    p95 = seconds[min(len(seconds) - 1, int(0.95 * len(seconds)))]
    return [f"{1e3 * value:.1f}" for value in (statistics.median(seconds), p95, seconds[-1])]
