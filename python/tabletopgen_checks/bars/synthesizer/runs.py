"""Runs both programs in turn on the same objects, and has tests/judges/layouts.py judge what they placed."""

import json
import shutil
import subprocess
import time
from dataclasses import dataclass, field
from pathlib import Path

from tabletopgen_checks.edits.runs import Edited, called, edit
from tabletopgen_checks.judges.judging import finish_setup, start_setup
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import JUDGES
from tabletopgen_checks.scene.scene import rotation
from tabletopgen_checks.virtual_environment import environment_of

LAYOUTS, OBJECTS, FIRST_SEED = 20, 10, 1
# No layout begins later: with the judges, the bar is done within ten minutes.
LIMIT_S = 420
# The package, and the packages that its placing spends its time in.
PINS = ["scene-synthesizer==1.15.0", "trimesh==5.2.0", "python-fcl==0.7.0.11", "numpy==2.4.6", "scipy==1.17.1",
        "shapely==2.2.0", "mapbox_earcut==2.1.0", "networkx==3.6.1"]
# Ten objects each, all of them on the table itself; used in turn.
TEXTS = [
    "A desk with exactly a laptop, a mug, a book, a stapler, an apple, a candle, a notebook, a bowl, a tissue box and a "
    "water bottle and nothing else",
    "A kitchen table with exactly a cutting board, a frying pan, a kettle, a jar, a bowl, two lemons, a plate, a milk "
    "carton and a pepper mill and nothing else",
    "A round table with exactly two plates, two mugs, a teapot, a vase, an orange, a book, a salt shaker and a wine bottle "
    "and nothing else",
]
UPRIGHT, STABLE = "scene-synthesizer, upright", "scene-synthesizer, stable poses"
EDIT, GENERATE = "tabletopgen edit", "tabletopgen generate"
WAYS = (UPRIGHT, STABLE, EDIT, GENERATE)


@dataclass
class Run:
    """One layout by one program. Seconds are CPU time; the program that also makes the objects has no time of placing
    alone."""

    way: str
    seed: int
    process_s: float
    place_s: float | None
    # Name to `world_from_object`, a 4x4 matrix, of what was placed.
    poses: dict
    # What tests/judges/layouts.py says.
    findings: dict = field(default_factory=dict)


def placements(binary: Path, target: Path, folder: Path, layouts: int) -> list:
    """All runs with their findings, of fewer layouts where the time is up. The judges start when all times are
    taken."""
    setup = start_setup(target / "judges")
    python = environment_of(target, "synthesizer", PINS) / "bin/python"
    finish_setup(setup)
    # Once before: the first run does not pay for files that are not in memory yet.
    stopped_by_failure(called(synthesizer_command(python, None, "upright", 0)))
    shutil.rmtree(folder, ignore_errors=True)
    found, asked, start = [], [], time.monotonic()
    for seed in range(FIRST_SEED, FIRST_SEED + layouts):
        if time.monotonic() - start > LIMIT_S:
            print(f"{seed - FIRST_SEED} of {layouts} layouts in {LIMIT_S} s; the others are left out", flush=True)
            break
        bundle = folder / f"scene_{seed}"
        runs = runs_of(binary, python, bundle, TEXTS[(seed - FIRST_SEED) % len(TEXTS)], seed)
        shown = ", ".join(f"{run.way} {run.place_s or run.process_s:.2f} s" for run in runs)
        print(f"[{seed - FIRST_SEED + 1}/{layouts}] {shown}", flush=True)
        found += runs
        asked += [{"bundle": str(bundle), "world_from_object": run.poses} for run in runs]
    for run, findings in zip(found, judged(target / "judges", asked, folder / "layouts.json")):
        run.findings = findings
    shutil.rmtree(folder)
    return found


def runs_of(binary: Path, python: Path, bundle: Path, text: str, seed: int) -> list:
    """The scene of a text; then the other ways on its objects, the programs in turn."""
    bundle.parent.mkdir(parents=True, exist_ok=True)
    asked = ["--text", text, "--seed", str(seed), "--out", str(bundle), "--json", "--threads", "1"]
    made = called([str(binary), "generate", *asked])
    if made.exit_code not in (0, 3):
        stopped_by_failure(made)
    poses = poses_of(bundle)
    if len(poses) != OBJECTS:
        raise Problem(f"{text!r} gave {len(poses)} objects, not {OBJECTS}: {', '.join(poses)}")
    upright = synthesized(python, bundle, "upright", seed)
    moves, out = moves_of(poses), bundle.with_name(f"{bundle.name}_edited")
    predicted = edit(binary, bundle, moves, seed, out, threads=1, options=("--dry-run",))
    stable = synthesized(python, bundle, "stable", seed)
    moved = edit(binary, bundle, moves, seed, out, threads=1)
    # A refused edit has placed nothing.
    rearranged = poses_of(out) if moved.exit_code in (0, 3) else {}
    shutil.rmtree(out, ignore_errors=True)
    return [
        Run(UPRIGHT, seed, *upright),
        Run(STABLE, seed, *stable),
        Run(EDIT, seed, moved.cpu_s, predicted.cpu_s, rearranged),
        Run(GENERATE, seed, made.cpu_s, None, poses),
    ]


def moves_of(names) -> list:
    """Operations that put every object anywhere on the table, one after the other."""
    return [{"op": "move", "target": name, "where": {"relation": "on", "target": "table"}} for name in names]


def synthesized(python: Path, bundle: Path, poses: str, seed: int) -> tuple:
    """CPU seconds of the process and of placing, and the poses."""
    done = called(synthesizer_command(python, bundle, poses, seed))
    stopped_by_failure(done)
    return done.cpu_s, done.document["cpu_s"]["place"], done.document["world_from_object"]


def synthesizer_command(python: Path, bundle: Path | None, poses: str, seed: int) -> list:
    """Without a bundle the process ends after its imports."""
    program = Path(__file__).with_name("place.py")
    options = ["--bundle", str(bundle)] if bundle else []
    return ["env", "OPENBLAS_NUM_THREADS=1", str(python), str(program), "--poses", poses, "--seed", str(seed), *options]


def stopped_by_failure(done: Edited):
    if done.exit_code != 0:
        why = done.message() or "\n".join(done.errors.splitlines()[-5:])
        raise Problem(f"`{' '.join(done.command)}` ended with {done.exit_code}: {why}")


def poses_of(bundle: Path) -> dict:
    scene = json.loads((bundle / "scene.json").read_text(encoding="utf-8"))
    return {instance["name"]: matrix(instance["translation_m"], instance["rotation_xyzw"]) for instance in scene["instances"]}


def matrix(translation_m, rotation_xyzw) -> list:
    """Rows of the 4x4 matrix of a pose."""
    return [[*row, part] for row, part in zip(rotation(rotation_xyzw), translation_m)] + [[0.0, 0.0, 0.0, 1.0]]


def judged(environment: Path, layouts: list, path: Path) -> list:
    path.write_text(json.dumps(layouts), encoding="utf-8")
    command = [str(environment / "bin/python"), str(JUDGES / "layouts.py"), str(path)]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode != 0:
        raise Problem(f"tests/judges/layouts.py did not run:\n{run.stderr.strip()[-2000:]}")
    return json.loads(run.stdout)
