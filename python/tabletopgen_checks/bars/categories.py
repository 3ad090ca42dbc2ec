"""Every category of the catalog alone, in what holds it and on what carries it: three seeds each, all certified.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.categories [--target-dir target] [--seeds 3] [--only petri] \\
        [--part all]
        [--program target/debug/tabletopgen]

`--part sample` makes the few that once failed, as `make test` does. Texts go through `tabletopgen batch`, sixty at a
time, and what passes is deleted.
"""

import json
import re
import shutil
import zipfile
from dataclasses import dataclass
from pathlib import Path

from tabletopgen_checks.bars.batch_of_texts import batch_of_texts
from tabletopgen_checks.bars.page import SCENES_OF_TEXTS, arguments, percent, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.catalog import entries

DEPENDS_ON = SCENES_OF_TEXTS
SEEDS = 3
AT_A_TIME = 60
# Round objects by their diameter in meters: what a container gets, and a tray carries.
CONTENTS = (("an apple", 0.085), ("an egg", 0.06), ("a walnut", 0.042), ("a coin", 0.028))
# What is longer than its container is deep.
LONG = "three paintbrushes"
# Containers that are deeper and narrower than this hold long objects, meters.
DEEP_M, WIDE_M = 0.07, 0.16
# What lies on a plate.
MEALS = ("meal", "dish", "food")
SAMPLE = (
    ("petri_dish", "A petri dish", 7),
    ("pizza_on_plate", "A pizza on a plate", 1),
    ("pizza_on_plate", "A pizza on a plate", 2),
    ("paintbrushes_in_jar", "A jar with three paintbrushes in it", 1),
)


@dataclass(frozen=True)
class SceneRequest:
    name: str
    part: str
    text: str
    seed: int

    @property
    def id(self) -> str:
        return f"{self.part}-{self.name}-{self.seed}"[:64]


def main() -> bool:
    given = arguments(__doc__, seeds=SEEDS, only="", part="all", program="")
    binary = Path(given.program).resolve() if given.program else given.binary
    if given.part == "sample":
        wanted = [SceneRequest(name, "sample", text, seed) for name, text, seed in SAMPLE]
    else:
        wanted = [SceneRequest(*one, seed=seed) for seed in range(1, given.seeds + 1) for one in texts(categories())]
        wanted = [one for one in wanted if given.part in ("all", one.part) and re.search(given.only, one.name)]
    faults = {}
    for start in range(0, len(wanted), AT_A_TIME):
        some = wanted[start : start + AT_A_TIME]
        faults |= made(binary, given.work / "categories", some)
        print(f"{start + len(some)} of {len(wanted)} scenes, {len(faults)} faults", flush=True)
    body = page(wanted, faults)
    if given.part == "all" and not given.only:
        write("categories", "Every category, certified", body, DEPENDS_ON)
    else:
        print(body, flush=True)
    return not faults


def categories() -> list:
    # A stand-in has no word of its own.
    return [one for one in entries() if one["group"] != "stand_in"]


def texts(known: list) -> list:
    """(name, part, text)."""
    asked = [(one["name"], "alone", an(one["label"])) for one in known]
    for one in known:
        label, size_m = an(one["label"]), mean_size_m(one)
        across_m = min(size_m[:2])
        if "container" in one["affordances"]:
            asked.append((one["name"], "in", f"{label} with {content(0.55 * across_m)} in it"))
            if size_m[2] > DEEP_M and across_m < WIDE_M:
                asked.append((one["name"], "long", f"{label} with {LONG} in it"))
        if "support" in one["affordances"]:
            asked.append((one["name"], "on", f"{content(0.7 * across_m)} on {label}"))
        if one["group"] in MEALS:
            asked.append((one["name"], "plate", f"{label} on a plate"))
    return asked


def mean_size_m(one) -> list:
    size = one["size"]
    return [0.5 * (low + high) for low, high in zip(size["low_m"], size["high_m"])]


def content(max_m: float) -> str:
    return next((words for words, across_m in CONTENTS if across_m <= max_m), CONTENTS[-1][0])


def an(label: str) -> str:
    first = label.split(" of ")[0]
    if first.endswith("s") and not first.endswith("ss"):
        return label
    return f"{'an' if label[0].lower() in 'aeiou' else 'a'} {label}"


def made(binary: Path, folder: Path, some: list) -> dict:
    """What is wrong with each of some scenes, by the scene."""
    faults = {}
    for one, (entry, bundle) in zip(some, batch_of_texts(binary, folder, [(one.id, one.text, one.seed) for one in some])):
        words = wrong(entry, bundle)
        if words:
            faults[one] = words
            print(f"  {one.text} (seed {one.seed}): {words}", flush=True)
    shutil.rmtree(folder)
    return faults


def wrong(entry, bundle: Path) -> str:
    if entry is None:
        return "the batch does not tell of it"
    if entry["state"] in ("succeeded", "duplicate"):
        return ""
    if entry["state"] == "quarantined":
        with zipfile.ZipFile(bundle) as archive:
            name = next(name for name in archive.namelist() if name.endswith("report.json"))
            report = json.loads(archive.read(name))
        return "; ".join(f"{reason['code']}: {reason['sentence']}" for reason in report["reasons"])
    return f"{entry['state']}: {entry['error']['code']}: {entry['error']['message']}"


def page(wanted: list, faults: dict) -> str:
    parts = dict.fromkeys(one.part for one in wanted)
    rows = []
    for part in parts:
        of = [one for one in wanted if one.part == part]
        passed = sum(one not in faults for one in of)
        rows.append([part, f"{passed} of {len(of)}", percent(passed / len(of), 2), of[0].text])
    listed = "\n".join(f"- {one.text} (seed {one.seed}): {words}" for one, words in faults.items())
    return table(["part", "certified", "", "such as"], rows) + (f"\n\n{listed}" if listed else "")


if __name__ == "__main__":
    run(main)
