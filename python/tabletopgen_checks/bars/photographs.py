"""Annotated photographs: what of them is in their scenes, what it is called, and what carries it.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.photographs [--target-dir target] \\
        [--images ../shared/photographs] [--half both]

The folder has images and an `annotations.json`: by file name `objects`, each with a `label`, its box (`bbox_px`), and
the label of what carries it (`on`, "table" for the top). It is no part of the program. An object counts as found where
the box of an object of the scene overlaps its box by one half (intersection over union). A name is right where
`photograph_names.json` has its category for the label. Half of the images, drawn at random, is for work; what is chosen
on them is scored on the other half.
"""

import json
import random
import statistics
from pathlib import Path

from tabletopgen_checks.bars.page import SCENES_OF_IMAGES, arguments, percent, table, write
from tabletopgen_checks.bars.references import matches
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import ROOT
from tabletopgen_checks.scene.generation import generate

DEPENDS_ON = SCENES_OF_IMAGES
NAMES = Path(__file__).with_name("photograph_names.json")
SEED_OF_HALVES = 58
#: Promises: recall, precision, share of found objects that have a name, of names that are right, of carried objects
#: that have the right support.
PROMISED = 0.75, 0.8, 0.5, 0.85, 0.8


def main() -> bool:
    given = arguments(__doc__, images=ROOT.parent / "shared" / "photographs", half="both")
    listed = given.images / "annotations.json"
    if not listed.is_file():
        raise Problem(f"there are no annotated images: {listed} is missing; name their folder with --images")
    annotated, right = (json.loads(path.read_text("utf-8")) for path in (listed, NAMES))
    for_work = set(random.Random(SEED_OF_HALVES).sample(sorted(annotated), len(annotated) // 2))
    halves = {"work": sorted(for_work), "held": sorted(set(annotated) - for_work)}
    if given.half not in (*halves, "both"):
        raise Problem(f"--half {given.half} is none of work, held and both")
    parts, held = [], True
    for half, names in halves.items():
        if given.half in (half, "both"):
            seen = [Photograph(name, annotated[name]["objects"], right, given) for name in names]
            text, holds = part(half, seen)
            parts.append(text)
            held = held and holds
    write("photographs", "Photographs", "\n\n".join(parts), DEPENDS_ON)
    return held


def part(half, seen):
    """The section of one half, and whether all promises hold."""
    def total(what):
        return sum(getattr(one, what) for one in seen)
    def share(part, whole):
        return total(part) / max(total(whole), 1)
    shares = [
        ("Recall at box overlap 0.5", "found", "objects"),
        ("Precision", "found", "read"),
        ("Found objects with a name", "named", "found"),
        ("Names that are right", "rightly_named", "named"),
        ("Carried objects with the right support, of those found with it", "rightly_carried", "carried"),
    ]
    bars = [
        [what, f"{total(a)} of {total(b)}", percent(share(a, b)), percent(promised, 0), share(a, b) >= promised]
        for (what, a, b), promised in zip(shares, PROMISED)
    ]
    refused = sum(one.verdict == "refused" for one in seen)
    bars.append(["Images that are refused", f"{refused} of {len(seen)}", "", "none", refused == 0])
    text = (
        f"## {'Images for work' if half == 'work' else 'Held images'}\n\n"
        + table(["", "", "measured", "promised", ""], [[*bar, "holds" if holds else "**missed**"] for *bar, holds in bars])
        + "\n\n"
        + table(
            ["image", "objects", "found", "read", "named", "rightly", "carried", "rightly", "verdict", "seconds", "reason"],
            [one.row() for one in seen],
        )
        + f"\n\nMedian time of an image: {statistics.median(one.seconds for one in seen):.1f} s."
    )
    return text, all(bar[-1] for bar in bars)


class Photograph:
    """An image, its annotations and the scene that was made of it."""

    def __init__(self, name, objects, right, given):
        self.name, self.objects = Path(name).stem, len(objects)
        self.read = self.found = self.named = self.rightly_named = self.carried = self.rightly_carried = 0
        self.verdict, self.reason, self.seconds = "refused", "", 0.0
        folder = given.work / "photographs" / self.name
        print(f"{self.name} ...", flush=True)
        try:
            made = generate(given.binary, folder, given.images / name, seed=1)
        except Problem as problem:
            # Without the path of the image, which is that of a machine.
            self.reason = str(problem).splitlines()[-1].split(" gave no scene: ")[-1].strip()
            return
        self.seconds = made.seconds
        scene, report = (json.loads((folder / file).read_text("utf-8")) for file in ("scene.json", "report.json"))
        self.verdict = report["verdict"]
        self.reason = "; ".join(reason["sentence"] for reason in report["reasons"][:2])
        instances = scene["instances"]
        self.read = len(instances)
        pairs = matches([one["bbox_px"] for one in objects], [instance["image"]["bbox_px"] for instance in instances])
        self.found = len(pairs)
        instance_of = {objects[j]["label"]: instances[k]["name"] for j, k in pairs.items()}
        for j, k in pairs.items():
            annotated, instance = objects[j], instances[k]
            if instance["category"] != "object":
                self.named += 1
                self.rightly_named += instance["category"] in right[annotated["label"]]
            if annotated["on"] != "table" and annotated["on"] in instance_of:
                self.carried += 1
                self.rightly_carried += instance["support"]["parent"] == instance_of[annotated["on"]]

    def row(self):
        return [
            self.name, self.objects, self.found, self.read, self.named, self.rightly_named, self.carried, self.rightly_carried,
            self.verdict, f"{self.seconds:.1f}", self.reason,
        ]


if __name__ == "__main__":
    run(main)
