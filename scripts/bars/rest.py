"""Forty scenes rest in every simulator that is promised, by the lines of the bundle's README.

    PYTHONPATH=scripts python3 -m bars.rest [--target-dir target] [--simulators "MuJoCo 3.3.0;..."] [--scenes 40]
        [--program target/debug/tabletopgen]

Each program has an environment of its own with pinned packages (`scripts/programs.py`); Genesis brings PyTorch, so all
take 12 GB of disk. Who judges is tests/judges/rest.py.
"""

import shutil
import statistics
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from bars.page import arguments, table, write
from bars.run import run
from judging import finish_setup, start_setup
from resting import make, make_environments, rest, simulators, wishes, words
from server import Problem

AT_ONCE = 2
SCENES = 40
COLUMNS = [
    "program", "scenes that rest", "objects", "worst object", "moved, mm", "turned, degrees", "deepest pair", "mm",
    "step, ms", "CPU s per simulated s, median", "most",
]


def main() -> bool:
    given = arguments(__doc__.splitlines()[0], simulators="", scenes=SCENES, program="")
    judges = given.target_dir / "judges"
    finish_setup(start_setup(judges))
    asked = [name.strip() for name in given.simulators.split(";") if name.strip()]
    chosen = [one for one in simulators() if not asked or one["name"] in asked]
    if len(chosen) < len(asked):
        raise Problem(f"not all of {asked} are in tests/judges/rest_programs.toml")
    make_environments(judges, chosen)
    folder = given.work / "rest"
    shutil.rmtree(folder, ignore_errors=True)
    wanted = wishes()[: given.scenes]
    binary = Path(given.program).resolve() if given.program else given.binary
    made = [make(binary, wish, folder) for wish in wanted]
    for wish, (_, wrong) in zip(wanted, made):
        print(f"{wish.name}: {'; '.join(wrong) or 'certified'}", flush=True)
    bundles = [bundle for bundle, _ in made if bundle]
    with ThreadPoolExecutor(AT_ONCE) as pool:
        found = dict(zip([one["name"] for one in chosen], pool.map(lambda one: told(judges, one["name"], bundles), chosen)))
    body, held = page(wanted, made, found)
    if not asked and len(wanted) == SCENES:
        write("rest", "Rest in every simulator", body)
    else:
        print(body, flush=True)
    return held


def told(judges, program, bundles) -> list:
    found = []
    for one in rest(judges, program, bundles):
        if not one["holds"]:
            print(f"  {program}: {Path(one['bundle']).name}: {words(one)}", flush=True)
        found.append(one)
    print(f"{program}: {sum(one['holds'] for one in found)} of {len(found)}", flush=True)
    return found


def page(wanted, made, found) -> tuple:
    """(text, whether all hold)."""
    wrong = [f"- {wish.name}: {'; '.join(reasons)}" for wish, (_, reasons) in zip(wanted, made) if reasons]
    rows = [row(name, of) for name, of in found.items()]
    falls = [
        f"- {name}, {Path(one['bundle']).name}: {words(one)}"
        for name, of in found.items() for one in of if not one["holds"]
    ]
    scenes = [[wish.name, wish.kind, wish.seed, wish.text] for wish in wanted]
    text = (
        "Each scene is loaded by the lines of its bundle's README and simulated for five seconds. It rests where no object "
        "is farther from its pose in `scene.json` than a quarter of its smallest side or turned by more than 2 degrees, and "
        "no pair is deeper in each other at the end than a quarter of the thinner one's smallest side or 2 mm. The worst "
        "object is the one nearest to its limit, or farthest beyond. Pinocchio only loads.\n\n" + table(COLUMNS, rows)
    )
    for title, lines in (("Not certified", wrong), ("What does not rest", falls)):
        text += f"\n\n## {title}\n\n" + "\n".join(lines) if lines else ""
    text += "\n\n## Scenes\n\n" + table(["scene", "kind", "seed", "text"], scenes)
    return text, not wrong and not falls


def row(program: str, found: list) -> list:
    moved = max(found, key=lambda one: one["worst_share"], default=None)
    deep = max(found, key=lambda one: one["deepest_share"], default=None)
    costs = [one["cpu_s_per_s"] for one in found if one["step_s"]]
    held = f"{sum(one['holds'] for one in found)} of {len(found)}"
    objects = f"{sum(one['held'] for one in found)} of {sum(one['objects'] for one in found)}"
    if not costs:
        return [program, held, objects] + ["-"] * 8
    of = lambda one, name: f"{one[name]} ({Path(one['bundle']).name})"
    return [
        program, held, objects, of(moved, "worst"), f"{moved['moved_mm']:.2f}", f"{moved['turned_deg']:.2f}",
        of(deep, "deepest"), f"{deep['depth_mm']:.2f}", f"{1e3 * max(one['step_s'] for one in found):.1f}",
        f"{statistics.median(costs):.2f}", f"{max(costs):.2f}",
    ]


if __name__ == "__main__":
    run(main)
