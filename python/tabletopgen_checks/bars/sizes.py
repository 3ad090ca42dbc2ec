"""Extents and masses of objects beside those of real ones, measured and published.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.sizes [--target-dir target] [--program PROGRAM] [--seed 1]

Each row of `tests/words/real_sizes.tsv` is asked for alone. A ratio is that of the larger to the smaller, 1 or more.
The ratio of the extents is the worst of the three, sorted, without what is thinner than 6 mm in reality: simulators
need thicker bodies there.
"""

import csv
import json
import zipfile
from dataclasses import dataclass
from pathlib import Path

from tabletopgen_checks.bars.batch_of_texts import batch_of_texts
from tabletopgen_checks.bars.page import SCENES_OF_TEXTS, arguments, percent, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.repository import ROOT

DEPENDS_ON = (*SCENES_OF_TEXTS, "tests/words/real_sizes.tsv")
REAL = ROOT / "tests" / "words" / "real_sizes.tsv"
LIMIT = 1.5
BAR = 0.9
THIN_MM = 6.0
AT_A_TIME = 60


@dataclass(frozen=True)
class Real:
    words: str
    extents_mm: tuple
    mass_g: "float | None"
    source: str


@dataclass(frozen=True)
class BuiltObject:
    category: str
    extents_mm: tuple
    mass_g: float


def main() -> bool:
    given = arguments(__doc__, program="", seed=1)
    binary = Path(given.program).resolve() if given.program else given.binary
    real = known()
    found = made(binary, given.work / "sizes", real, given.seed)
    body, holds = page(real, found)
    write("sizes", "Sizes and masses beside real ones", body, DEPENDS_ON)
    return holds


def known() -> list:
    with REAL.open(encoding="utf-8", newline="") as file:
        rows = csv.DictReader((line for line in file if not line.startswith("#")), delimiter="\t")
        return [Real(row["words"], extents(row["extents_mm"]), mass(row["mass_g"]), row["source"]) for row in rows]


def extents(text: str) -> tuple:
    return tuple(sorted((float(one) for one in text.split(" x ")), reverse=True))


def mass(text: str) -> "float | None":
    return float(text) if text else None


def made(binary: Path, folder: Path, real: list, seed: int) -> list:
    """What each became, `None` where no scene was made."""
    found = []
    for start in range(0, len(real), AT_A_TIME):
        some = real[start : start + AT_A_TIME]
        wanted = [(f"size-{start + k}", one.words, seed) for k, one in enumerate(some)]
        found += [measured(bundle) for _, bundle in batch_of_texts(binary, folder, wanted)]
    return found


def measured(bundle: Path) -> "BuiltObject | None":
    """The largest object of a scene."""
    if not bundle.exists():
        return None
    with zipfile.ZipFile(bundle) as archive:
        name = next(name for name in archive.namelist() if name.endswith("scene.json") and name.count("/") <= 1)
        instances = json.loads(archive.read(name))["instances"]
    if not instances:
        return None
    largest = max(instances, key=lambda one: one["mass_kg"])
    size_mm = tuple(sorted((1000.0 * one for one in largest["size_m"]), reverse=True))
    return BuiltObject(largest["category"], size_mm, 1000.0 * largest["mass_kg"])


def ratio(one: float, other: float) -> float:
    return max(one, other) / max(min(one, other), 1e-9)


def size_ratio(real: Real, found: BuiltObject) -> float:
    pairs = zip(real.extents_mm, found.extents_mm)
    return max(ratio(one, other) for one, other in pairs if one >= THIN_MM)


def page(real: list, found: list) -> tuple:
    rows, sizes, masses = [], [], []
    for one, other in zip(real, found):
        if other is None:
            rows.append([one.words, "no scene", millimeters(one.extents_mm), "", "", "", "", "", one.source])
            sizes.append(float("inf"))
            continue
        size = size_ratio(one, other)
        weight = ratio(one.mass_g, other.mass_g) if one.mass_g else None
        sizes.append(size)
        masses += [weight] if weight else []
        rows.append([
            one.words, other.category, millimeters(one.extents_mm), millimeters(other.extents_mm), f"{size:.2f}",
            f"{one.mass_g:g}" if one.mass_g else "", f"{other.mass_g:.3g}", f"{weight:.2f}" if weight else "", one.source,
        ])
    within = [share_within(sizes), share_within(masses)]
    stood_in = sum(other is not None and other.category.startswith("stand_in") for other in found)
    holds = min(within) >= BAR
    body = (
        f"{len(real)} objects, {stood_in} of them as stand-ins. All three extents are within a factor of {LIMIT} of the "
        f"real ones for {percent(within[0])}, and the masses for {percent(within[1])} of {len(masses)} "
        f"({percent(BAR)} promised: {'holds' if holds else 'does not hold'}).\n\n"
        + table(
            ["asked for", "category", "real, mm", "found, mm", "ratio", "real, g", "found, g", "ratio of masses", "source"],
            rows,
        )
    )
    return body, holds


def share_within(ratios: list) -> float:
    return sum(one <= LIMIT for one in ratios) / len(ratios)


def millimeters(size_mm: tuple) -> str:
    return " x ".join(f"{one:.3g}" for one in size_mm)


if __name__ == "__main__":
    run(main)
