"""Compares the planner of crate `robot` with VAMP on the 700 MotionBenchMaker problems of the Panda.

    PYTHONPATH=python python -m tabletopgen_checks.robots.planning_bar [--folder target/robot_planning] \\
        [--repeats 15] [--rounds 3]

It downloads the source package `vamp-planner` and the headers of Eigen from PyPI into the folder, builds VAMP with its
own compiler flags, builds the example `plan_problems`, and lets both solve all problems in turn on one core. Needs
g++, cargo and pip. The bar:

- at least 699 of the 700 problems are solved,
- VAMP's own check calls every path valid,
- in each set the median times of planning, and of planning and simplification, are not above those of VAMP,
- the sum of the path lengths in each set is at most 1.05 of VAMP's.

It exits with 1 if the bar is missed. A time is the shortest of all repeats of all rounds; the rounds alternate.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

from tabletopgen_checks.repository import ROOT
from tabletopgen_checks.virtual_environment import environment_of

VERSION = "0.6.4"
# Those of cmake/CompilerSettings.cmake of the package, for GCC on x86-64.
FLAGS = (
    "-std=c++17 -O3 -march=native -mavx2 -fno-math-errno -fno-signed-zeros -fno-trapping-math -fno-rounding-math "
    "-ffp-contract=fast -fassociative-math -Wno-ignored-attributes"
).split()
MAX_COST_SHARE = 1.05
MIN_SOLVED = 699


def run(*command, **options):
    return subprocess.run([str(part) for part in command], check=True, **options)


def fetch(folder: Path):
    """The unpacked package and the headers of Eigen."""
    package, eigen = folder / f"vamp_planner-{VERSION}", folder / "eigen"
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "-q"]
    if not package.exists():
        run(*pip, "download", "--no-deps", "--no-binary", ":all:", "-d", folder, f"vamp-planner=={VERSION}")
        with tarfile.open(folder / f"vamp_planner-{VERSION}.tar.gz") as tar:
            tar.extractall(folder, filter="data")
    if not eigen.exists():
        run(*pip, "download", "--no-deps", "-d", folder, "cmeel-eigen")
        with zipfile.ZipFile(next(folder.glob("cmeel_eigen-*.whl"))) as archive:
            archive.extractall(eigen)
    return package, next(eigen.glob("**/include/eigen3"))


def build(folder: Path, package: Path, eigen: Path):
    """The programs of VAMP and of the crate."""
    shim, vamp = Path(__file__).with_name("planning_vamp"), folder / "vamp"
    includes = ["-I", shim, "-I", package / "src" / "impl", "-isystem", eigen]
    if not vamp.exists() or vamp.stat().st_mtime < (shim / "main.cpp").stat().st_mtime:
        run("g++", *FLAGS, *includes, shim / "main.cpp", "-o", vamp)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    run("cargo", "build", "-q", "--release", "-p", "tabletopgen-robot", "--example", "plan_problems",
        "--target-dir", target, cwd=ROOT)
    return vamp, target / "release" / "examples" / "plan_problems"


def compete(folder: Path, vamp: Path, ours: Path, repeats: int, rounds: int):
    """The best results of both: VAMP's by problem as numbers, and ours as entries of the solution file."""
    core = ["taskset", "-c", str(max(os.sched_getaffinity(0)))]
    theirs, best = [], []
    for _ in range(rounds):
        lines = run(*core, vamp, "plan", folder / "problems.txt", repeats, capture_output=True, text=True).stdout
        rows = [[float(word) for word in line.split()] for line in lines.splitlines()]
        run(*core, ours, folder / "problems.json", folder / "solutions.json", repeats)
        solutions = json.loads((folder / "solutions.json").read_text())
        if not best:
            theirs, best = rows, solutions
        for kept, row in zip(theirs, rows):
            kept[1], kept[2] = min(kept[1], row[1]), min(kept[2], row[2])
        for kept, solution in zip(best, solutions):
            for key in ("plan_us", "total_us"):
                kept[key] = min(kept[key], solution[key])
    return theirs, best


def valid_paths(folder: Path, vamp: Path, solutions: list) -> list:
    """Whether VAMP calls each path valid."""
    words = [" ".join([str(len(s["path"]))] + [repr(p) for q in s["path"] for p in q]) for s in solutions]
    (folder / "paths.txt").write_text("\n".join(words) + "\n")
    answer = run(vamp, "check", folder / "problems.txt", folder / "paths.txt", capture_output=True, text=True)
    return [line == "1" for line in answer.stdout.split()]


def judge(theirs: list, solutions: list, valid: list) -> list:
    """Prints a table and answers what misses the bar."""
    missed = []
    solved = [s["outcome"] == "solved" for s in solutions]
    invalid = [s["name"] for s, ok, done in zip(solutions, valid, solved) if done and not ok]
    print(f"solved {sum(solved)} of {len(solved)}; VAMP {sum(row[0] == 1 for row in theirs)}")
    print(f"failures: {[(s['name'], s['outcome']) for s in solutions if s['outcome'] != 'solved']}")
    print(f"paths that VAMP calls invalid: {invalid}")
    if sum(solved) < MIN_SOLVED:
        missed.append("too few problems are solved")
    if invalid:
        missed.append("some paths are invalid")
    print("| set | plan µs | VAMP | plan + simplify µs | VAMP | length share |\n|---|---|---|---|---|---|")
    for name in sorted({s["set"] for s in solutions}):
        both = [(r, s) for r, s, ok in zip(theirs, solutions, solved) if ok and r[0] == 1 and s["set"] == name]
        plan, total = (statistics.median(s[key] for _, s in both) for key in ("plan_us", "total_us"))
        their_plan, their_total = (statistics.median(r[column] / 1e3 for r, _ in both) for column in (1, 2))
        share = sum(s["length"] for _, s in both) / sum(r[4] for r, _ in both)
        print(f"| {name} | {plan:.1f} | {their_plan:.1f} | {total:.1f} | {their_total:.1f} | {share:.3f} |")
        if plan > their_plan or total > their_total:
            missed.append(f"{name} takes longer")
        if share > MAX_COST_SHARE:
            missed.append(f"the paths of {name} are longer")
    return missed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=ROOT / "target" / "robot_planning")
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--example", type=Path, help="the built example, instead of building it")
    options = parser.parse_args()
    folder = options.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    package, eigen = fetch(folder)
    python = environment_of(folder, "environment", ["pyyaml==6.0.3"]) / "bin/python"
    run(python, "-m", "tabletopgen_checks.robots.planning_problems", package, folder)
    if options.example:
        vamp, ours = folder / "vamp", options.example
    else:
        vamp, ours = build(folder, package, eigen)
    theirs, solutions = compete(folder, vamp, ours, options.repeats, options.rounds)
    missed = judge(theirs, solutions, valid_paths(folder, vamp, solutions))
    for line in missed:
        print(f"missed: {line}")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
