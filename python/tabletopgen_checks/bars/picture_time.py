"""An image with ten objects: how long `generate --image` takes from an empty data directory, and where the time goes.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.picture_time [--target-dir target] [--runs 5]
"""

import json
import statistics
import subprocess

from tabletopgen_checks.bars.page import SCENES_OF_IMAGES, arguments, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import lab_beside
from tabletopgen_checks.scene.generation import generate

DEPENDS_ON = (*SCENES_OF_IMAGES, "crates/dev/lab/src/synthetic_images")
BAR_SECONDS = 10.0
OBJECTS, LONGER_PX = 10, 2300
#: Synthetic images that are searched for one in which so many objects are read, and the most that it may show.
SEARCHED, MAX_OBJECTS = 300, 13


def main() -> bool:
    given = arguments(__doc__, runs=5)
    small, large = given.work / "picture_time" / "small", given.work / "picture_time" / "large"
    synthesize(given.binary, small, 0, SEARCHED, 64)
    truths = [json.loads(path.read_text("utf-8")) for path in sorted(small.glob("validation/*/truth.json"))]
    def has_room(t):
        return t["table"]["is_whole"] and t["width_px"] * 3 == t["height_px"] * 4
    fitting = [t for t in truths if OBJECTS <= len(t["objects"]) <= MAX_OBJECTS and has_room(t)]
    runs = []
    for truth in fitting:
        synthesize(given.binary, large, truth["number"], 1, LONGER_PX)
        image = large / "validation" / f"{truth['number']:06}" / "image.jpg"
        try:
            # The network may refuse one or find few objects in it.
            first = generate(given.binary, given.work / "picture_time" / "scene", image, seed=1)
        except Problem as problem:
            print(f"image {truth['number']}: {problem}", flush=True)
            continue
        read = len(json.loads((first.folder / "scene.json").read_text("utf-8"))["instances"])
        print(f"image {truth['number']}: {read} objects read, {first.seconds:.1f} s", flush=True)
        if read >= OBJECTS:
            runs = [generate(given.binary, first.folder, image, seed=1) for _ in range(given.runs)]
            break
    if not runs:
        raise Problem(f"in none of {len(fitting)} images were {OBJECTS} objects read")
    seconds = sorted(made.seconds for made in runs)
    median = statistics.median(seconds)
    rows = []
    for k, stage in enumerate(runs[0].printed["stages"]):
        wall = [made.printed["stages"][k]["wall_ms"] for made in runs]
        rows.append([stage["stage"], stage["instances"] or "the scene", f"{statistics.median(wall):.0f}", f"{min(wall)} to {max(wall)}"])
    body = (
        f"Median {median:.2f} s over {len(runs)} runs (fastest {seconds[0]:.2f} s, slowest {seconds[-1]:.2f} s), whole process, "
        f"from an empty data directory; the bar is {BAR_SECONDS:.0f} s on two cores.\n\n"
        f"Image {truth['number']} of the validation split of synthetic images, {LONGER_PX} pixels wide, "
        f"{len(truth['objects'])} objects; {read} objects were read in it.\n\n"
        + table(["stage", "works on", "wall ms, median", "wall ms, range"], rows)
    )
    write("picture_time", "Time of one image", body, DEPENDS_ON)
    return median <= BAR_SECONDS


def synthesize(binary, folder, first, count, size_px):
    command = [lab_beside(binary), "synthesize", "--split", "validation", "--first", first, "--count", count]
    command += ["--size-px", size_px, "--out", folder]
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        raise Problem(f"no image was synthesized:\n{done.stderr.strip()[-2000:]}")


if __name__ == "__main__":
    run(main)
