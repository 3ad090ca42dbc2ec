"""A few scenes of `make bars BARS=rest` in a few of its programs, for `make test`."""

import shutil
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tabletopgen_checks.judges.resting import make, make_environments, rest, rest_scenes, simulators, words
from tabletopgen_checks.problem import Problem

# MuJoCo 3.3.0 has no packages for later Pythons.
LAST_OF_OLD_MUJOCO = (3, 13)


def check(binary: Path, folder: Path, judges: Path) -> str:
    shutil.rmtree(folder, ignore_errors=True)
    chosen = [one for one in simulators(sample=True) if "environment" not in one or sys.version_info[:2] <= LAST_OF_OLD_MUJOCO]
    make_environments(judges, chosen)
    bundles = []
    for scene in rest_scenes(sample=True):
        bundle, wrong = make(binary, scene, folder)
        if wrong:
            raise Problem(f"{scene.name}: {'; '.join(wrong)}")
        bundles.append(bundle)
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lambda one: list(rest(judges, one["name"], bundles)), chosen))
    findings = [one for of_program in found for one in of_program]
    wrong = [f"{Path(one['bundle']).name} in {one['program']}: {words(one)}" for one in findings if not one["holds"]]
    if wrong:
        raise Problem("; ".join(wrong))
    worst = max(findings, key=lambda one: one["worst_share"])
    return (
        f"{len(bundles)} scenes rest in {len(chosen)} programs; nearest to its limit is {worst['worst']} in "
        f"{worst['program']} with {100 * worst['worst_share']:.0f} % of it"
    )
