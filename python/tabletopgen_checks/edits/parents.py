"""The scenes that the bar of edits starts from: twenty texts, and synthetic images of the split that trains nothing.

The texts have 3 to 12 objects: rectangular and round tables, containers, trays, stacks, two of a label, round objects.
"""

import json
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from tabletopgen_checks.language import words
from tabletopgen_checks.language.description import Described
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import WORDS
from tabletopgen_checks.scene.colors import BASIC, is_color
from tabletopgen_checks.scene.generation import generate
from tabletopgen_checks.scene.scene import Scene, read_scene

TEXTS = (WORDS / "edited.txt").read_text(encoding="utf-8").splitlines()
SEED = 340
IMAGES = 20
# Images whose scene is no use for edits are passed over; so many are tried in all.
TRIED_IMAGES = 50
IMAGE_PX = 512
MIN_OBJECTS = 3


@dataclass
class Parent:
    """A finished scene to edit, and the color that its text states of an object."""

    name: str
    folder: Path
    scene: Scene
    colors: dict
    is_image: bool = False


def text_parents(lab: Path, binary: Path, folder: Path, count: int = len(TEXTS)) -> list:
    """Certified scenes of the first texts; one that is quarantined is made once more with another seed."""
    texts = TEXTS[:count]
    found = []
    for number, text in enumerate(texts):
        print(f"scene {number + 1} of {len(texts)}: {text}", flush=True)
        for seed in (SEED + number, SEED + number + len(TEXTS)):
            out = made(binary, folder / f"text_{number:02}", text, seed)
            scene = read_scene(out)
            if scene.report["verdict"] == "pass":
                outcome = words.parse(lab, [text], seed)[0]
                found.append(Parent(out.name, out, scene, stated_colors(outcome)))
                break
        else:
            raise Problem(f"no certified scene of {text!r}: {out}")
    return found


def stated_colors(outcome: dict) -> dict:
    """Name to color word, of the colors that the text states."""
    if "description" not in outcome:
        return {}
    found = {}
    for item in Described(outcome["description"]).objects:
        words_of = [word for word in BASIC if item.color and is_color(item.color, word)]
        if len(words_of) == 1:
            found[item.name] = words_of[0]
    return found


def image_parents(lab: Path, binary: Path, folder: Path, count: int = IMAGES) -> list:
    """Certified scenes of synthetic images with three objects and more."""
    found, passed_over = [], []
    for number in range(TRIED_IMAGES):
        if len(found) >= count:
            break
        image = synthesized(lab, folder / "images", number)
        print(f"image scene {len(found) + 1} of {count}: {image}", flush=True)
        try:
            out = made(binary, folder / f"image_{number:02}", image, SEED + number)
        except Problem as problem:
            passed_over.append(f"image {number}: {str(problem).splitlines()[-1]}")
            continue
        scene = read_scene(out)
        if scene.report["verdict"] == "pass" and len(scene.bodies) >= MIN_OBJECTS:
            found.append(Parent(out.name, out, scene, {}, is_image=True))
        else:
            passed_over.append(f"image {number}: {scene.report['verdict']}, {len(scene.bodies)} objects")
    if len(found) < count:
        reasons = "; ".join(passed_over)
        raise Problem(f"{len(found)} of {TRIED_IMAGES} images gave a certified scene, {count} are needed: {reasons}")
    return found


def made(binary: Path, out: Path, source, seed: int) -> Path:
    """The folder of a scene; one that an interrupted run of the same program left is kept."""
    # Beside the bundle, of which every file is listed in its manifest.
    mark = out.with_name(f"{out.name}.made.json")
    stamp = {"source": str(source), "seed": seed, "program": program_stamp(binary)}
    if out.is_dir() and mark.is_file() and json.loads(mark.read_text(encoding="utf-8")) == stamp:
        return out
    generate(binary, out, source, seed)
    mark.write_text(json.dumps(stamp), encoding="utf-8")
    return out


def program_stamp(binary: Path) -> str:
    stat = binary.stat()
    return f"{stat.st_size} {stat.st_mtime_ns}"


def synthesized(lab: Path, folder: Path, number: int) -> Path:
    image = folder / "test" / f"{number:06}" / "image.jpg"
    if not image.is_file():
        command = [str(lab), "synthesize", "--split", "test", "--count", "1", "--first", str(number), "--size-px",
                   str(IMAGE_PX), "--out", str(folder)]
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode != 0:
            shutil.rmtree(image.parent, ignore_errors=True)
            raise Problem(f"`{' '.join(command)}` failed: {run.stderr.strip()[-500:]}")
    return image
