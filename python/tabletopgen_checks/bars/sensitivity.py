"""Planted weaknesses of a policy: whether an analysis of rollouts names each, and a search for scenes finds it.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.sensitivity [--target-dir target] [--starts 30] [--scenes 100]

A scene is generated and recolored. `tabletopgen episodes` records `starts` episodes of one task in each color with a
wide randomization. The policies of clients/python/tests/planted_policies.py repeat recorded actions, and do nothing in
low light, for masses above a threshold, for one color, or by chance. `python -m tabletopgen.env` runs each from all
starts, says which factors explain its failures, and searches for scenes in which it fails. What was made is kept below
the target directory for the same program; unlike that, results are those of the package as it is.
"""

import hashlib
import json
import os
from pathlib import Path

from tabletopgen_checks.bars.page import arguments, percent, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.client import CLIENT
from tabletopgen_checks.processes import output_of
from tabletopgen_checks.virtual_environment import environment_of, pins_in

DEPENDS_ON = (
    "clients/python/src/tabletopgen/env", "clients/python/tests/planted_policies.py", "config/robots",
    "crates/data/demonstrations", "crates/data/export", "crates/method/manipulation", "crates/method/physics",
    "crates/method/robot", "src/pipeline/edit",
)
PACKAGES = ("gymnasium", "httpx", "matplotlib", "mujoco", "pillow", "pyarrow", "pydantic", "scikit-learn")
SENTENCE, SCENE_SEED = "A small table with a can, a plate and a sponge", 3
TASK = "put the can on the plate"
# Of the can; as it is, it is green.
COLORS = ("as it is", "red", "blue", "yellow")
# Of the first color; equal seeds would draw equal starts.
FIRST_SEED, SEARCH_SEED = 1, 0
# Other objects and other materials are in no environment.
RANDOMIZED = ("--randomize", "wide", "--amplitude", "added_distractors=0", "--amplitude", "object_material=0",
              "--amplitude", "table_material=0")
# Episodes of the recorder last for seven seconds.
LIMIT_S = 15
# Scenes within which each weakness is found. A search gets so many at a time, and some more to shrink what it found.
WITHIN = 100
STEP, SHRINKING = 5, 5
# Policies, the factor that decides, and the axis and value of the search that reach it.
PLANTED = {"dark": ("light_brightness", "light_intensity"), "heavy": ("mass_kg", "mass_factor"), "red": ("moved_color", "color")}
WORDS = {"dark": "light below 0.5", "heavy": "mass above 0.5 kg", "red": "a red object", "chance": "3 of 10 starts, by chance"}


def main() -> bool:
    given = arguments(__doc__, starts=30, scenes=100)
    with given.binary.open("rb") as program:
        folder = given.work / "sensitivity" / hashlib.file_digest(program, "sha256").hexdigest()[:12]
    pins = [pin for pin in pins_in(CLIENT / "requirements.txt") if pin.split("==")[0] in PACKAGES]
    bench = Bench(given, folder, environment_of(given.target_dir, "sensitivity", pins) / "bin" / "python")
    scene, environments = bench.scene(), bench.environments()
    analyses = {name: bench.analysis(name, environments) for name in WORDS}
    searches = {name: bench.search(name, environments[0], scene) for name in PLANTED}
    named = [analyses[name]["named"][:1] == [factor] for name, (factor, _) in PLANTED.items()]
    chance = not analyses["chance"]["named"]
    found = [found_at(searches[name], axis) for name, (_, axis) in PLANTED.items()]
    bars = [
        ["Planted weaknesses named first", f"{sum(named)} of {len(named)}", "all", held(all(named))],
        ["Factors named of failures by chance", len(analyses["chance"]["named"]), "0", held(chance)],
        ["Most scenes until a planted weakness is found", max((one or WITHIN + 1) for one in found), WITHIN,
         held(all(one and one <= WITHIN for one in found))],
    ]
    body = [
        table(["", "found", "bar", ""], bars),
        f"\"{TASK}\" in a scene of the sentence \"{SENTENCE}\", seed {SCENE_SEED}, by the Panda. The policies repeat the recorded "
        "actions, but for starts with their weakness, where they do nothing. Each reads what decides from the simulation at the "
        "start; the analysis and the search know only whether it failed.",
        "## Sensitivity",
        f"{given.starts} starts in each of {len(COLORS)} scenes, which differ in the color of the can ({', '.join(COLORS)}). "
        "Randomization is `wide`, without added objects and other materials. Light is that of MuJoCo's lamp, 0.6 in a scene as it is.",
        table(["fails for", "failures", "named first", "split", "likely thresholds", "explained", "chance", "others named"],
              [analysis_row(name, analyses[name]) for name in WORDS]),
        "*Chance* is the share of 999 shuffles of outcomes in which any factor explains as much. Other named factors are "
        "those that follow the first, or cannot be distinguished from it in these episodes, unless they are called separate.",
        table(["fails for", "log loss, held out", "of the share alone", "area under the curve, held out", "best model"],
              [model_row(name, analyses[name]) for name in WORDS]),
        "## Search",
        f"{given.scenes} scenes at most for each policy, by 12 axes, one episode in each. A search ends {SHRINKING} scenes after the "
        "planted axis was found, in which the change is shrunk.",
        table(["fails for", "scenes", "first failure", "found alone", "fails at", "holds just below", "planted at", "refused", "s a scene"],
              [search_row(name, searches[name], bench.took_s[name]) for name in PLANTED]),
        "*First failure* is the number of the first scene in which the policy failed, counted from 1, and *found alone* of the first in "
        "which the planted axis was all that was changed. Values are factors of what the scene has; the can is 0.4216 kg. Seconds are by "
        "the clock, beside whatever else the machine did.",
        "Other axes on which a failure was found: " + "; ".join(others_in(name, searches[name]) for name in PLANTED)
        + ". A larger can is a heavier one.",
    ]
    write("sensitivity", "Sensitivity and counterexamples", "\n\n".join(body), DEPENDS_ON)
    return all(row[-1] == "holds" for row in bars)


class Bench:
    """Runs the package on scenes that are kept in a folder."""

    def __init__(self, given, folder: Path, python: Path):
        self.given, self.folder, self.python = given, folder, python
        self.took_s: dict = {}
        folder.mkdir(parents=True, exist_ok=True)
        path = f"{given.binary.parent}{os.pathsep}{os.environ['PATH']}"
        self.variables = os.environ | {"PATH": path, "PYTHONPATH": str(CLIENT / "src")}

    def scene(self, color: str = COLORS[0]) -> Path:
        """The folder of a bundle."""
        out = self.folder / color.replace(" ", "_") / "scene"
        if out.exists():
            return out
        if color == COLORS[0]:
            output_of(self.given.binary, "generate", "--text", SENTENCE, "--seed", SCENE_SEED, "--out", out, "--quiet")
        else:
            recolor = json.dumps([{"op": "recolor", "target": "soda_can_1", "color": color}])
            output_of(self.given.binary, "edit", "--bundle", self.scene(), "--operations", recolor, "--seed", 0, "--out", out, "--quiet")
        return out

    def environments(self) -> list:
        """The folder of an environment in each color, with recorded episodes beside it."""
        found = []
        for place, color in enumerate(COLORS):
            scene = self.scene(color)
            episodes, out = scene.with_name("episodes"), scene.with_name("environment")
            if not episodes.exists():
                words = ["episodes", "--bundle", scene, "--task", TASK, "--count", self.given.starts, "--seed", FIRST_SEED + place,
                         *RANDOMIZED]
                output_of(self.given.binary, *words, "--cameras", "none", "--format", "parquet-png", "--out", episodes, "--quiet")
            if not out.exists():
                self.env("prepare", out, "--scene", scene, "--task", TASK, "--dataset", episodes)
            found.append(out)
        return found

    def analysis(self, name: str, environments: list) -> dict:
        """The content of `sensitivity.json` of a policy."""
        place = self.folder / f"rollout_{name}_{package_digest()}"
        self.env("rollout", *environments, "--policy", policy(name), *ACTS, "--out", place)
        self.env("sensitivity", place, "--out", place / "sensitivity")
        return json.loads((place / "sensitivity" / "sensitivity.json").read_text(encoding="utf-8"))

    def search(self, name: str, environment: Path, scene: Path) -> dict:
        """The content of `counterexamples.json` of a policy, with the records of scenes in their order. It ends some
        scenes after the planted axis was found, which shrink the change.
        """
        place, found, budget = self.folder / f"search_{name}_{package_digest()}", None, 0
        search: dict = {}
        while budget < self.given.scenes and not found:
            budget = min(budget + STEP, self.given.scenes)
            search = self.searched(name, environment, scene, place, budget)
            found = found_at(search, PLANTED[name][1])
        budget = min((found or budget) + SHRINKING, self.given.scenes)
        return search if budget <= search["scenes"] else self.searched(name, environment, scene, place, budget)

    def searched(self, name: str, environment: Path, scene: Path, place: Path, budget: int) -> dict:
        """A search with so many scenes, which continues the one before."""
        words = ["counterexamples", environment, "--scene", scene, "--policy", policy(name), *ACTS]
        self.env(*words, "--seed", SEARCH_SEED, "--scenes", budget, "--out", place)
        records = [json.loads(line) for line in (place / "scenes.jsonl").read_text(encoding="utf-8").splitlines()]
        self.took_s[name] = sum(record["wall_s"] for record in records) / len(records)
        print(f"{name}: {len(records)} scenes, {self.took_s[name]:.1f} s each", flush=True)
        return {**json.loads((place / "counterexamples.json").read_text(encoding="utf-8")), "records": records}

    def env(self, *words) -> str:
        return output_of(self.python, "-m", "tabletopgen.env", *words, environment=self.variables)


ACTS = ("--no-images", "--max-duration", LIMIT_S)


def policy(name: str) -> str:
    return f"{CLIENT / 'tests' / 'planted_policies.py'}:{name}"


def package_digest() -> str:
    """Of the code that decides rollouts and searches, so that no older result is taken for its own. Analyses are made
    anew each time.
    """
    files = sorted(path for path in (CLIENT / "src" / "tabletopgen" / "env").glob("*.py") if not path.name.startswith("sensitivity"))
    files += [CLIENT / "src" / "tabletopgen" / "env" / "sensitivity_table.py", CLIENT / "tests" / "planted_policies.py"]
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()[:8]


def found_at(search: dict, axis: str):
    """The number of scenes until one fails in which that axis alone was changed; `None` if none does."""
    places = [place for place, one in enumerate(search["records"], 1) if list(one["change"]) == [axis] and one["outcome"] == "fails"]
    return places[0] if places else None


def first_failure(search: dict):
    return next((place for place, one in enumerate(search["records"], 1) if one["outcome"] == "fails"), "none")


def analysis_row(name: str, found: dict) -> list:
    failures = found["overall"]["episodes"] - found["overall"]["successes"]
    counts = f"{failures} of {found['overall']['episodes']}"
    if not found["named"]:
        best = found["factors"][0]
        nearest = f"none ({best['name']} is nearest)"
        return [WORDS[name], counts, nearest, "", "", percent(best["explained"], 0), f"{best['corrected']:.3f}", "none"]
    rows = {row["name"]: row for row in found["factors"]}
    best = rows[found["named"][0]]
    split = best["split"]
    likely = "{:.3g} to {:.3g}".format(*split["about_as_good"]) if "threshold" in split else ""
    others = ", ".join(f"{other} ({rows[other].get('relation', 'not compared')})" for other in found["named"][1:]) or "none"
    return [WORDS[name], counts, best["name"], f"{split['threshold']:.3g}" if "threshold" in split else split["word"], likely,
            percent(best["explained"], 0), f"{best['corrected']:.3f}", others]


def model_row(name: str, found: dict) -> list:
    model = found["model"]
    if model is None:
        return [WORDS[name], "too few failures", "", "", ""]
    best = next(one for one in model["models"] if one["kind"] == model["best"])
    return [WORDS[name], f"{best['log_loss']:.3f}", f"{model['base_log_loss']:.3f}", f"{best['auc']:.3f}", best["kind"]]


def search_row(name: str, search: dict, took_s: float) -> list:
    found = found_at(search, PLANTED[name][1])
    smallest = search["smallest"].get(PLANTED[name][1])
    planted = {"dark": "0.8333", "heavy": "1.186", "red": "red"}[name]
    at, below = (value(smallest["value"]), value(smallest.get("holds_at", ""))) if smallest else ("not found", "")
    refused = search["outcomes"]["refused"] + search["outcomes"]["undone"]
    return [WORDS[name], search["scenes"], first_failure(search), found or "not found", at, below, planted, refused, f"{took_s:.1f}"]


def others_in(name: str, search: dict) -> str:
    others = [f"{axis} {value(found['value'])}" for axis, found in search["smallest"].items() if axis != PLANTED[name][1]]
    return f"for {WORDS[name]}, {', '.join(others) or 'none'}"


def value(found) -> str:
    return found if isinstance(found, str) else f"{found:.4g}"


def held(holds: bool) -> str:
    return "holds" if holds else "DOES NOT HOLD"


if __name__ == "__main__":
    run(main)
