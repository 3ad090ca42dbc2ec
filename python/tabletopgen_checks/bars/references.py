"""Annotated images from elsewhere: what is found in them, and how like them their scenes are.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.references [--target-dir target] \\
        [--pictures ../shared/references]

The folder has images and an `annotations.json`: by name a file, its width and height, the corners of the table's top
(`table.top_outline_px`) and the box of every object (`objects[].bbox_px`), pixels. It is no part of the program. An
object counts as found where the box of a mask overlaps its box by one half (intersection over union), each for one at
most.
"""

import json
import statistics
from collections import Counter

from tabletopgen_checks.bars.page import SCENES_OF_IMAGES, arguments, percent, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.judges.judging import JUDGE_NAMES, complaints, finish_setup, judge, start_setup
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import ROOT
from tabletopgen_checks.scene.generation import generate

DEPENDS_ON = SCENES_OF_IMAGES
FOUND_BAR, SILHOUETTE_BAR = 0.8, 0.75
OUTLINE_OVERLAP, OUTLINES_BAR = 0.9, 6
# The README's examples are the business of the sentences.
JUDGES = [name for name in JUDGE_NAMES if name != "readme"]
#: Rows on which outlines are compared.
ROWS = 1000


def main() -> bool:
    given = arguments(__doc__, pictures=ROOT.parent / "shared" / "references")
    listed = given.pictures / "annotations.json"
    if not listed.is_file():
        raise Problem(f"there are no annotated images: {listed} is missing; name their folder with --pictures")
    environment = given.target_dir / "judges"
    finish_setup(start_setup(environment))
    seen = [
        AnnotatedImage(name, known, given, environment) for name, known in sorted(json.loads(listed.read_text("utf-8")).items())
    ]
    def total(what):
        return sum(getattr(one, what) for one in seen)
    recall, precision = total("found") / total("objects"), total("found") / max(total("read"), 1)
    outlines = sum(one.outline >= OUTLINE_OVERLAP for one in seen)
    silhouettes = [overlap for one in seen for overlap in one.silhouettes]
    silhouette = statistics.mean(silhouettes) if silhouettes else 0.0
    clean = sum(not one.wrong for one in seen)
    bars = [
        ("Recall at box overlap 0.5", percent(recall), percent(FOUND_BAR, 0), recall >= FOUND_BAR),
        ("Precision", percent(precision), percent(FOUND_BAR, 0), precision >= FOUND_BAR),
        ("Outlines of overlap 0.9", f"{outlines} of {len(seen)}", OUTLINES_BAR, outlines >= OUTLINES_BAR),
        ("Silhouette overlap of scene and image, mean over all objects read", f"{silhouette:.3f}", SILHOUETTE_BAR,
         silhouette >= SILHOUETTE_BAR),
        ("Scenes whose certificate is clean and that every judge accepts", f"{clean} of {len(seen)}", "all", clean == len(seen)),
    ]
    methods = sum((one.methods for one in seen), Counter())
    shares = ", ".join(f"{name} {percent(count / methods.total(), 0)}" for name, count in methods.most_common())
    body = (
        table(["", "measured", "bar", ""], [[*bar, "holds" if held else "**missed**"] for *bar, held in bars])
        + f"\n\nReconstructed as: {shares}.\n\n"
        + table(
            ["image", "objects", "found", "read", "outline", "silhouettes", "verdict", "seconds", "wrong"],
            [one.row() for one in seen],
        )
    )
    write("references", "Annotated images", body, DEPENDS_ON)
    return all(held for *_, held in bars)


class AnnotatedImage:
    """An image, its annotations and the scene that was made of it."""

    def __init__(self, name, known, given, environment):
        self.name, self.objects = name, len(known["objects"])
        self.found = self.read = 0
        self.outline, self.silhouettes, self.methods = 0.0, [], Counter()
        self.verdict, self.seconds, self.wrong = "-", "-", []
        folder = given.work / "references" / name
        print(f"{name} ...", flush=True)
        try:
            made = generate(given.binary, folder, given.pictures / known["file"], seed=1, artifacts=True)
        except Problem as problem:
            self.wrong = [str(problem).splitlines()[-1].strip()]
            return
        self.seconds = f"{made.seconds:.1f}"
        masks = json.loads((folder / "artifacts/segment/masks.json").read_text("utf-8"))
        boxes = [box for mask in masks if (box := box_of(mask["visible"]))]
        self.read, self.found = len(boxes), len(matches([known_object["bbox_px"] for known_object in known["objects"]], boxes))
        scene, report = (json.loads((folder / file).read_text("utf-8")) for file in ("scene.json", "report.json"))
        top = [projected(scene["camera"], corner) for corner in scene["table"]["outline_m"]]
        self.outline = overlap_of_outlines(known["table"]["top_outline_px"], top, known["height"])
        self.silhouettes = [o["silhouette_iou"] for o in report["objects"] if o.get("silhouette_iou") is not None]
        self.methods = Counter({m["method"]: m["objects"] for m in report["fidelity"]["methods"]})
        self.verdict = report["verdict"]
        self.wrong = [reason["sentence"] for reason in report["reasons"]]
        findings = judge(environment, [folder], only=JUDGES)
        self.wrong += complaints(findings, folder)

    def row(self):
        silhouette = f"{statistics.mean(self.silhouettes):.3f}" if self.silhouettes else "-"
        reasons = "; ".join(self.wrong[:3])
        return [self.name, self.objects, self.found, self.read, f"{self.outline:.3f}", silhouette, self.verdict, self.seconds, reasons]


def box_of(visible):
    """Left, upper, right and lower edge of a mask by its run lengths (column by column, the first not set)."""
    height, _ = visible["size"]
    columns, rows, at = [], [], 0
    for k, count in enumerate(visible["counts"]):
        if k % 2 and count:
            (left, upper), (right, lower) = divmod(at, height), divmod(at + count - 1, height)
            columns += [left, right]
            rows += [upper, lower] if left == right else [0, height - 1]
        at += count
    return (min(columns), min(rows), max(columns) + 1, max(rows) + 1) if columns else None


def overlap_of_boxes(a, b):
    across, down = (max(min(a[k + 2], b[k + 2]) - max(a[k], b[k]), 0) for k in (0, 1))
    def area(box):
        return (box[2] - box[0]) * (box[3] - box[1])
    return across * down / max(area(a) + area(b) - across * down, 1e-9)


def matches(true, read):
    """Pairs of indices of boxes that overlap by one half, the best first, each box in one pair at most."""
    pairs = sorted(((overlap_of_boxes(a, b), j, k) for j, a in enumerate(true) for k, b in enumerate(read)), reverse=True)
    chosen = {}
    for overlap, j, k in pairs:
        if overlap >= 0.5 and j not in chosen and k not in chosen.values():
            chosen[j] = k
    return chosen


def projected(camera, corner):
    """Pixel of a point of the table top."""
    pose = camera["world_from_camera"]
    eye, (x, y, z, w) = pose["translation_m"], pose["rotation_xyzw"]
    axes = (
        (1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)),
        (2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)),
        (2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)),
    )
    away = (corner[0] - eye[0], corner[1] - eye[1], -eye[2])
    right, down, ahead = (sum(a * b for a, b in zip(axis, away)) for axis in axes)
    ahead = max(ahead, 1e-6)
    return camera["fx"] * right / ahead + camera["cx"], camera["fy"] * down / ahead + camera["cy"]


def overlap_of_outlines(one, other, height) -> float:
    """Intersection over union of two polygons, row by row."""
    both = either = 0.0
    for row in range(ROWS):
        y = (row + 0.5) / ROWS * 2 * height - 0.5 * height
        a, b = spans(one, y), spans(other, y)
        shared = sum(max(min(p[1], q[1]) - max(p[0], q[0]), 0.0) for p in a for q in b)
        both += shared
        either += sum(p[1] - p[0] for p in a + b) - shared
    return both / max(either, 1e-9)


def spans(polygon, y):
    """Where a row runs within a polygon."""
    sides = list(zip(polygon, polygon[1:] + polygon[:1]))
    xs = sorted(a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) for a, b in sides if (a[1] <= y) != (b[1] <= y))
    return list(zip(xs[::2], xs[1::2]))


if __name__ == "__main__":
    run(main)
