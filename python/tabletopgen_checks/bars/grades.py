"""Hero images of two programs in a random order, graded by readers without knowledge of the program.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.grades --before OLD_PROGRAM --part images [--images FOLDER]
    PYTHONPATH=python python3 -m tabletopgen_checks.bars.grades --part page [--images FOLDER]

The first call makes the scene of each line of `tests/words/graded_texts.txt` with both programs, and writes their hero
images as `images/001.png` and so on, `images/texts.tsv` with the text of each, `rubric.md` for the readers, and
`key.json`, which they do not see. Each reader writes `grades_NAME.tsv` with the columns image, fidelity,
recognizability, layout and light, separated by tabs. The second call writes the page from all grades.
"""

import csv
import json
import random
import shutil
import subprocess
from pathlib import Path
from statistics import mean

from tabletopgen_checks.bars.page import SCENES_OF_TEXTS, arguments, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import ROOT

DEPENDS_ON = (*SCENES_OF_TEXTS, "tests/words/graded_texts.txt")
TEXTS = ROOT / "tests" / "words" / "graded_texts.txt"
ASPECTS = ("fidelity", "recognizability", "layout", "light")
# The first with which a scene is made; a text can find no room.
SEEDS = (1, 2, 3)
BAR_MEAN, BAR_LOWEST = 5.0, 4.0
RUBRIC = """# Rubric

Grade each image by itself, 1 to 7, from the image and the text it was made of.

| aspect | 1 | 4 | 7 |
| --- | --- | --- | --- |
| fidelity | primitive shapes in flat colors | clearly rendered, materials plausible | as a photograph of a product |
| recognizability | none of the objects can be named | most can be named at a glance | all can, with details of their kind |
| layout | objects anywhere, or not what the text asks | as asked, arranged like goods on a shelf | as people leave what they use |
| light | flat, floating objects, no contact | shadows ground the objects | as in a real room |
"""


def main() -> bool:
    given = arguments(__doc__, before="", part="images", images="")
    folder = Path(given.images).resolve() if given.images else given.work / "grades"
    if given.part == "images":
        if not given.before:
            raise Problem("there is no program to compare with: give its path as --before")
        return make_images(folder, Path(given.before).resolve(), given.binary)
    body, holds = page(folder)
    write("grades", "Grades of images by readers", body, DEPENDS_ON)
    return holds


def make_images(folder: Path, before: Path, now: Path) -> bool:
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "images").mkdir(parents=True)
    texts = TEXTS.read_text(encoding="utf-8").splitlines()
    shown = [(program, text) for text in texts for program in ("before", "now")]
    random.Random(1).shuffle(shown)
    key, lines = {}, ["image\ttext"]
    for number, (program, text) in enumerate(shown, 1):
        out = folder / "scene"
        binary = before if program == "before" else now
        seed = next((seed for seed in SEEDS if generated(binary, text, seed, out)), None)
        if seed is None:
            raise Problem(f"{program}: no image of {text!r} with any of the seeds {SEEDS}")
        (out / "preview" / "hero.png").rename(folder / "images" / f"{number:03}.png")
        shutil.rmtree(out)
        key[f"{number:03}"] = {"program": program, "text": text, "seed": seed}
        lines.append(f"{number:03}\t{text}")
        print(f"{number} of {len(shown)}", flush=True)
    (folder / "images" / "texts.tsv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / "rubric.md").write_text(RUBRIC, encoding="utf-8")
    (folder / "key.json").write_text(json.dumps(key, indent=1), encoding="utf-8")
    return True


def generated(binary: Path, text: str, seed: int, out: Path) -> bool:
    """Whether a scene of the text was made, certified or not."""
    command = [str(binary), "generate", "--text", text, "--seed", str(seed), "--out", str(out), "--force", "--quiet"]
    subprocess.run(command, capture_output=True)
    return (out / "preview" / "hero.png").exists()


def page(folder: Path) -> tuple:
    key = json.loads((folder / "key.json").read_text(encoding="utf-8"))
    readers = {path.stem.removeprefix("grades_"): grades(path) for path in sorted(folder.glob("grades_*.tsv"))}
    if len(readers) < 2:
        raise Problem(f"{folder} has the grades of {len(readers)} readers: two at the least read the images")
    for name, given in readers.items():
        if set(given) != set(key):
            raise Problem(f"reader {name} graded {len(given)} of {len(key)} images")
    rows = []
    for program in ("before", "now"):
        of = [image for image, one in key.items() if one["program"] == program]
        for name, given in readers.items():
            means = [mean(given[image][k] for image in of) for k in range(len(ASPECTS))]
            rows.append([program, name, *(f"{one:.2f}" for one in means)])
    both = {image: [mean(given[image][k] for given in readers.values()) for k in range(4)] for image in key}
    now = [image for image, one in key.items() if one["program"] == "now"]
    fidelity, layout = (mean(both[image][k] for image in now) for k in (0, 2))
    lowest = min(min(both[image][0], both[image][2]) for image in now)
    holds = min(fidelity, layout) >= BAR_MEAN and lowest >= BAR_LOWEST
    each = [
        [text, *(cell(both, key, text, program) for program in ("before", "now"))]
        for text in dict.fromkeys(one["text"] for one in key.values())
    ]
    body = (
        f"{len(now)} texts, both programs, {len(readers)} readers who saw the images in a random order without their "
        f"program. Fidelity {fidelity:.2f} and layout {layout:.2f} now ({BAR_MEAN} promised), the lowest mean of a scene "
        f"{lowest:.1f} ({BAR_LOWEST} promised): {'holds' if holds else 'does not hold'}.\n\n"
        "![Each text twice, before at the left and now at the right](grades.webp)\n\n"
        + table(["program", "reader", *ASPECTS], rows)
        + f"\n\n{RUBRIC.replace('# Rubric', '## Rubric')}\n## Each scene\n\nMeans of the readers: {', '.join(ASPECTS)}.\n\n"
        + table(["text", "before", "now"], each)
    )
    return body, holds


def cell(both: dict, key: dict, text: str, program: str) -> str:
    image = next(image for image, one in key.items() if one["text"] == text and one["program"] == program)
    return ", ".join(f"{one:.1f}" for one in both[image])


def grades(path: Path) -> dict:
    with path.open(encoding="utf-8", newline="") as file:
        return {
            row["image"]: [float(row[aspect]) for aspect in ASPECTS] for row in csv.DictReader(file, delimiter="\t")
        }


if __name__ == "__main__":
    run(main)
