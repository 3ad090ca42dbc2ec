"""Variants: each keeps what the text states, passes and stays at rest, and no two are alike.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.variants [--target-dir target] [--parents 8] [--variants 6] \\
        [--seed 34]

Parents are of texts with relations, and of synthetic images. Every axis varies at once. `bars/variants/kept.py` judges
the bundles by code that shares nothing with the program; MuJoCo simulates each for five seconds.
"""

import json
import shutil
import statistics
from pathlib import Path

from tabletopgen_checks.bars.page import arguments, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.bars.variants import DEPENDS_ON
from tabletopgen_checks.bars.variants.diversity import diversity
from tabletopgen_checks.bars.variants.kept import complaints as kept_complaints
from tabletopgen_checks.bars.variants.kept import is_met, relations
from tabletopgen_checks.edits.parents import Parent, image_parents, made
from tabletopgen_checks.edits.runs import called
from tabletopgen_checks.judges.judging import complaints, finish_setup, judge, start_setup
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import lab_beside
from tabletopgen_checks.scene.scene import read_scene

PARENTS, VARIANTS, SEED = 8, 6, 34
# Objects on the table are at least this far from where they are in any other variant, in the mean.
ALIKE_MM = 20.0
TEXTS = [
    "A wooden desk with a laptop, a red mug to the left of the laptop, a notebook in front of it and a lamp at the back",
    "A kitchen table with a bowl with two apples in it, a plate to the right of the bowl, a blue mug and a jar behind it",
    "A dining table with a stack of three plates, a wine bottle next to them, two glasses and a salt shaker",
    "A round wooden table with a vase in the center, two candles, a book at the front and a remote control next to the book",
    "A workbench with a toolbox at the back left, a hammer, a wrench to the right of the hammer and a tape measure",
    "A table with exactly a mug, a book and an apple between them",
]


def main() -> bool:
    given = arguments(__doc__, parents=PARENTS, variants=VARIANTS, seed=SEED)
    environment = given.target_dir / "judges"
    finish_setup(start_setup(environment))
    rows, axes, failed = [], {}, []
    count = checked = 0
    for parent in parents(given):
        folder = given.work / "variants" / parent.name
        variants = made_variants(given.binary, parent, given.variants, given.seed, folder)
        findings = judge(environment, variants, dss_bar=0.0, only=("mjcf", "collisions"))
        scenes = [read_scene(bundle) for bundle in variants]
        wrong = []
        for scene, bundle in zip(scenes, variants):
            reasons = kept_complaints(parent.scene, scene, parent.colors) + complaints(findings, bundle)
            moved = findings["bundles"][str(bundle.resolve())]["mjcf"]["facts"].get("unstable", {})
            reasons += [f"MuJoCo: {name} moves by {mm} mm and {deg} degrees" for name, (mm, deg) in moved.items()]
            wrong += [(bundle.name, words) for words in reasons]
        failed += [(parent.name, *one) for one in wrong]
        stated = [one for one in relations(parent.scene) if is_met(parent.scene, *one)]
        checked += len(stated) * len(scenes)
        count += len(scenes)
        found = diversity(parent.scene, scenes)
        for axis, value in found.items():
            axes.setdefault(axis, []).append(value)
        left = sum(operation["sentence"].startswith("left ") for one in scenes for operation in one.scene["edit"]["operations"])
        rows.append([parent.name, len(parent.scene.bodies), len(stated), len(scenes), len({n for n, _ in wrong}), left,
                     f"{found['nearest pair, mm']:.0f}"])
        print(f"{parent.name}: {len(scenes)} variants, {len(wrong)} complaints", flush=True)
        if not wrong:
            shutil.rmtree(folder)
    nearest = min(axes["nearest pair, mm"])
    varying = [axis for axis, values in axes.items() if statistics.fmean(values) > 0.0]
    bars = [
        [f"Variants of {count} that lose what is stated, collide or move", len({one[:2] for one in failed}), 0,
         "holds" if not failed else "DOES NOT HOLD"],
        ["Nearest two variants of one scene, mm", f"{nearest:.0f}", f"{ALIKE_MM:.0f}",
         "holds" if nearest >= ALIKE_MM else "DOES NOT HOLD"],
        ["Axes that vary", len(varying), len(axes), "holds" if len(varying) == len(axes) else "DOES NOT HOLD"],
    ]
    page = "\n\n".join([
        table(["", "found", "bar", ""], bars),
        f"{checked} stated relations were measured in the variants. *Left out* counts operations for which a scene had no room. "
        "Of two variants, *nearest pair* is the mean distance between the places of the same objects on the table.",
        table(["parent", "objects", "stated relations", "variants", "wrong", "left out", "nearest pair, mm"], rows),
        "Diversity by axis, mean over the parents:",
        table(["axis", "mean", "least parent"],
              [[axis, f"{statistics.fmean(v):.1f}", f"{min(v):.1f}"] for axis, v in axes.items()]),
        *(["What fails:\n\n" + "\n".join(f"- {a}, {b}: {c}" for a, b, c in failed)] if failed else []),
    ])
    write("variants", "Variants", page, DEPENDS_ON)
    return not failed and nearest >= ALIKE_MM and len(varying) == len(axes)


def parents(given) -> list:
    """Three quarters of texts, the others of images."""
    folder = given.work / "variants_parents"
    texts = min(len(TEXTS), (3 * given.parents + 3) // 4)
    found = []
    for number, text in enumerate(TEXTS[:texts]):
        bundle = made(given.binary, folder / f"text_{number + 1}", text, SEED + number)
        scene = read_scene(bundle)
        found.append(Parent(f"text_{number + 1}", bundle, scene, stated_colors(scene)))
    return found + image_parents(lab_beside(given.binary), given.binary, folder, given.parents - texts)


def stated_colors(scene) -> dict:
    """The color that the text states, by object."""
    found = {}
    for part in (scene.scene.get("text") or {}).get("understood", ()):
        if part["kind"] == "property" and part["property"] == "color":
            found |= {name: part["value"] for name in part["objects"]}
    return found


def made_variants(binary: Path, parent, count: int, seed: int, folder: Path) -> list:
    """The bundles of the variants; the program's own complaints stop the bar."""
    shutil.rmtree(folder, ignore_errors=True)
    done = called([str(binary), "variants", "--bundle", str(parent.folder), "--count", str(count), "--seed", str(seed),
                   "--out", str(folder), "--json"])
    bundles = sorted(folder.glob("variant_*"))
    if len(bundles) != count:
        printed = json.dumps(done.document)[-500:] if done.document else ""
        raise Problem(f"{len(bundles)} of {count} variants of {parent.name} were made: {done.errors} {printed}")
    return bundles


if __name__ == "__main__":
    run(main)
