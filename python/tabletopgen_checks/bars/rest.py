"""Forty scenes rest in every simulator in which that is promised, by the lines of the bundle's README. Those in which
it is not (`not_promised` in tests/judges/rest_programs.toml) are measured too and fail nothing.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.rest [--target-dir target] \\
        [--simulators "MuJoCo 3.3.0;..."] [--scenes 40]
        [--program target/debug/tabletopgen]

Each program has an environment of its own with pinned packages (`tabletopgen_checks.judges.programs`); Genesis brings
PyTorch, so all take 12 GB of disk. Who judges is tests/judges/rest.py.

What was measured is kept in bars/rest of the target directory for as long as the program, the scenes and the judge are
the same. A run measures what is missing, so an interrupted one goes on; `--simulators` measures only those named, and
the page has what the earlier runs found of the others.
"""

import hashlib
import json
import shutil
import statistics
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tabletopgen_checks.bars.page import arguments, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.judges.judging import finish_setup, start_setup
from tabletopgen_checks.judges.resting import make, make_environments, rest, rest_scenes, simulators, words
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import JUDGES

DEPENDS_ON = (
    "config/catalog", "config/default.toml", "crates/base/catalog", "crates/models/embedded/src/layout",
    "crates/models/embedded/src/layout.rs", "crates/data/export", "crates/base/geometry", "crates/method/physics",
    "src/pipeline/resolve", "src/pipeline/resolve.rs", "tests/judges/rest.py", "tests/judges/rest_lines.mjs",
    "tests/judges/rest_lines.py", "tests/judges/rest_programs.toml", "tests/judges/rest_scenes.toml",
)
AT_ONCE = 2
SCENES = 40
COLUMNS = [
    "program", "promised", "scenes that rest", "objects", "worst object", "moved, mm", "turned, degrees", "deepest pair", "mm",
    "step, ms", "CPU s per simulated s, median", "most",
]
JUDGE = ("rest.py", "rest_lines.py", "rest_lines.mjs", "rest_scenes.toml", "rest_programs.toml")


def main() -> bool:
    given = arguments(__doc__, simulators="", scenes=SCENES, program="")
    judges = given.target_dir / "judges"
    finish_setup(start_setup(judges))
    every = [one["name"] for one in simulators()]
    asked = [name.strip() for name in given.simulators.split(";") if name.strip()] or every
    if unknown := [name for name in asked if name not in every]:
        raise Problem(f"{unknown} are not in tests/judges/rest_programs.toml; there are {every}")
    make_environments(judges, [one for one in simulators() if one["name"] in asked])
    kept = FindingCache(given.work / "rest", Path(given.program).resolve() if given.program else given.binary)
    wanted = rest_scenes()[: given.scenes]
    made = [kept.scene(scene) for scene in wanted]
    for scene, (_, wrong) in zip(wanted, made):
        print(f"{scene.name}: {'; '.join(wrong) or 'certified'}", flush=True)
    bundles = [bundle for bundle, _ in made if bundle]
    with ThreadPoolExecutor(AT_ONCE) as pool:
        list(pool.map(lambda name: measure(judges, name, bundles, kept), asked))
    body, held = page(wanted, made, {name: kept.found(name, bundles) for name in every})
    if len(wanted) == SCENES:
        write("rest", "Rest in every simulator", body, DEPENDS_ON)
    else:
        print(body, flush=True)
    return held


class FindingCache:
    """Scenes and findings of a program, in a folder that is emptied where the program, the scenes or the judge are
    others."""

    def __init__(self, folder: Path, binary: Path):
        self.folder, self.binary = folder, binary
        whole = hashlib.sha256(binary.read_bytes())
        for name in JUDGE:
            whole.update((JUDGES / name).read_bytes())
        stamp, key = folder / "key", whole.hexdigest()
        if not stamp.is_file() or stamp.read_text(encoding="utf-8") != key:
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            stamp.write_text(key, encoding="utf-8")

    def scene(self, asked) -> tuple:
        """(the bundle, what is wrong with it), as `make` tells it."""
        record = self.folder / f"{asked.name}.json"
        if not record.is_file():
            bundle, wrong = make(self.binary, asked, self.folder)
            record.write_text(json.dumps([bool(bundle), wrong]), encoding="utf-8")
        is_there, wrong = json.loads(record.read_text(encoding="utf-8"))
        return (self.folder / asked.name if is_there else None), wrong

    def found(self, program: str, bundles: list) -> list:
        """What is known of these bundles in a program."""
        path = self.path(program)
        lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() else []
        by_scene = {Path(one["bundle"]).name: one for one in map(json.loads, lines)}
        return [by_scene[bundle.name] for bundle in bundles if bundle.name in by_scene]

    def add(self, program: str, record: dict):
        with self.path(program).open("a", encoding="utf-8") as file:
            file.write(json.dumps(record) + "\n")

    def path(self, program: str) -> Path:
        return self.folder / f"{program}.jsonl"


def measure(judges, program, bundles, kept):
    """Measures what is not known yet."""
    known = {Path(one["bundle"]).name for one in kept.found(program, bundles)}
    missing = [bundle for bundle in bundles if bundle.name not in known]
    for one in rest(judges, program, missing) if missing else ():
        if not one["holds"]:
            print(f"  {program}: {Path(one['bundle']).name}: {words(one)}", flush=True)
        kept.add(program, one)
    found = kept.found(program, bundles)
    print(f"{program}: {sum(one['holds'] for one in found)} of {len(found)}", flush=True)


def page(wanted, made, found) -> tuple:
    """(text, whether all hold)."""
    wrong = [f"- {asked.name}: {'; '.join(reasons)}" for asked, (_, reasons) in zip(wanted, made) if reasons]
    count = sum(bundle is not None for bundle, _ in made)
    why_not = {one["name"]: one["not_promised"] for one in simulators() if "not_promised" in one}
    rows = [row(name, "no" if name in why_not else "yes", of) for name, of in found.items() if of]
    missing = [f"- {name}: {count - len(of)} of {count} scenes" for name, of in found.items() if len(of) < count]
    falls = {
        name: [f"- {name}, {Path(one['bundle']).name}: {words(one)}" for one in of if not one["holds"]]
        for name, of in found.items()
    }
    broken = any(falls[name] or len(found[name]) < count for name in found if name not in why_not)
    scenes = [[asked.name, asked.kind, asked.seed, asked.text] for asked in wanted]
    others = ", ".join(f"{one['turn_deg']} in {one['name']}" for one in simulators() if "turn_deg" in one)
    text = (
        "Each scene is loaded by the lines of its bundle's README and simulated for five seconds. It rests where no object "
        "is farther from its pose in `scene.json` than a quarter of its smallest side or turned by more than 2 degrees "
        f"({others}), and "
        "no pair is deeper in each other at the end than a quarter of the thinner one's smallest side or 2 mm. The worst "
        "object is the one nearest to its limit, or farthest beyond. Pinocchio only loads.\n\n" + table(COLUMNS, rows)
    )
    not_promised = [f"- {name}: {why}" for name, why in why_not.items()]
    fallen = [line for lines in falls.values() for line in lines]
    for title, lines in (
        ("Where rest is not promised", not_promised), ("Not certified", wrong), ("What does not rest", fallen),
        ("Not measured", missing),
    ):
        text += f"\n\n## {title}\n\n" + "\n".join(lines) if lines else ""
    text += "\n\n## Scenes\n\n" + table(["scene", "kind", "seed", "text"], scenes)
    return text, not wrong and not broken


def row(program: str, promised: str, found: list) -> list:
    costs = [one["cpu_s_per_s"] for one in found if one["step_s"]]
    held = f"{sum(one['holds'] for one in found)} of {len(found)}"
    objects = f"{sum(one['held'] for one in found)} of {sum(one['objects'] for one in found)}"
    if not costs:
        return [program, promised, held, objects] + ["-"] * 8
    moved = max(found, key=lambda one: one["worst_share"])
    deep = max(found, key=lambda one: one["deepest_share"])
    def of(one, name):
        return f"{one[name]} ({Path(one['bundle']).name})"
    return [
        program, promised, held, objects, of(moved, "worst"), f"{moved['moved_mm']:.2f}", f"{moved['turned_deg']:.2f}",
        of(deep, "deepest"), f"{deep['depth_mm']:.2f}", f"{1e3 * max(one['step_s'] for one in found):.1f}",
        f"{statistics.median(costs):.2f}", f"{max(costs):.2f}",
    ]


if __name__ == "__main__":
    run(main)
