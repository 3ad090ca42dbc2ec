"""A thousand scenes of ten descriptions in one batch, five times killed; and the dataset that is frozen of them.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.batches [--target-dir target] [--seeds 100] [--kills 5] \\
        [--seed 34]

Needs about 20 MB of disk for each scene. The dataset is verified by the program, searched for leaks by
`python/tabletopgen_checks/bars/batches/leaks.py`, and streamed with PyPI `webdataset`.
"""

import json
import random
import re
import shutil
import statistics
import subprocess
from pathlib import Path

from tabletopgen_checks.bars.batches import DEPENDS_ON
from tabletopgen_checks.bars.batches.alike import nearest_mm, read
from tabletopgen_checks.bars.batches.killed import run as run_batch
from tabletopgen_checks.bars.batches.killed import stage_counts
from tabletopgen_checks.bars.batches.leaks import leaks
from tabletopgen_checks.bars.page import arguments, percent, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.virtual_environment import environment_of

SEEDS, KILLS, SEED = 100, 5, 34
YIELD_BAR, ALIKE_MM = 0.99, 10.0
# Memory in the last fifth over that in the first fifth; kept rows and caches are far below.
FLAT_BAR = 1.25
# Rows of stages that a process has begun at a time: of two scenes, one row for each object and the table.
IN_PROGRESS = 12
PINS = ["webdataset==1.0.2", "numpy==2.4.6"]
TEXTS = [
    "a red mug, a spoon and a book",
    "a bowl with two apples in it and a knife",
    "a laptop, a mouse to the right of it and a cup",
    "two plates, two forks and a bottle",
    "a cutting board with a tomato on it, and a kettle",
    "three cubes and a ball",
    "a stapler, a notebook and a pen in a pen holder",
    "a teapot, two cups and a banana",
    "a toolbox, a hammer and a screwdriver",
    "a vase, a candle and a picture frame",
]
STREAM = """
import glob, json, sys, webdataset
shards = sorted(glob.glob(sys.argv[1]))
seen = [(sample["__key__"], json.loads(sample["json"])["id"]) for sample in webdataset.WebDataset(shards, shardshuffle=False)]
print(json.dumps({"samples": len(seen), "right": sum(key == name for key, name in seen)}))
"""


def main() -> bool:
    given = arguments(__doc__, seeds=SEEDS, kills=KILLS, seed=SEED)
    requests, folder = len(TEXTS) * given.seeds, given.work / "batch"
    for old in (folder, folder.with_suffix(".log"), given.work / "datasets"):
        shutil.rmtree(old, ignore_errors=True) if old.is_dir() else old.unlink(missing_ok=True)
    recipe = given.work / "batch.json"
    recipe.write_text(json.dumps({"templates": TEXTS, "seeds": {"first": given.seed, "count": given.seeds}}))
    command = [str(given.binary), "batch", str(recipe), "--out", str(folder), "--zip"]
    batch = run_batch(command, folder, requests, given.kills, given.seed)
    output = [json.loads(line) for line in (folder / "output.jsonl").read_text(encoding="utf-8").splitlines()]
    failures = (folder / "errors.jsonl").read_text(encoding="utf-8").splitlines()
    archives = sorted(folder.glob("*.zip"))
    passed = [record for record in output if record["state"] == "succeeded"]
    rows, again, jobs, more_jobs = stage_counts(folder / ".tabletopgen")
    nearest = nearest_mm([read(path) for path in archives])
    first, last = memory(batch.memory, 0.0, 0.2), memory(batch.memory, 0.8, 1.0)
    shutil.rmtree(folder / ".tabletopgen")
    per_hour = 3600.0 * len(output) / batch.seconds
    ids = {record["custom_id"] for record in output}
    allowed = IN_PROGRESS * len(batch.killed_at)
    bars = [
        ("Requests with a bundle, each once", f"{len(ids)} of {requests}", requests,
         len(ids) == len(output) == len(archives) == requests),
        ("Yield at the first attempt", percent(len(passed) / requests), percent(YIELD_BAR, 0),
         len(passed) >= YIELD_BAR * requests),
        ("Jobs beyond one per scene", more_jobs, 0, more_jobs == 0),
        (f"Stages of {rows} begun twice, by {len(batch.killed_at)} kills", again, f"at most {allowed}", again <= allowed),
        ("Nearest two scenes of a description, mm", f"{nearest:.0f}", f"{ALIKE_MM:.0f}", nearest >= ALIKE_MM),
        ("Memory, last fifth over first", f"{last / first:.2f}", FLAT_BAR, last <= FLAT_BAR * first),
    ]
    summary = (
        f"{requests} requests: {len(TEXTS)} descriptions of 3 to 5 objects, {given.seeds} seeds each. "
        f"{batch.seconds:.0f} s in all runs together, {per_hour:.0f} scenes per hour; `kill -9` after "
        f"{', '.join(map(str, batch.killed_at))} finished scenes. Resident memory {first:.0f} MiB in the first fifth, "
        f"{last:.0f} MiB in the last, at most {max(mib for _, mib in batch.memory):.0f} MiB. {len(failures)} failures. "
        "Two scenes are as far apart as the mean distance between the places of the objects of the same name."
    )
    more, dataset = frozen(given, folder)
    bars += more
    rows = [[what, value, bar, "holds" if holds else "DOES NOT HOLD"] for what, value, bar, holds in bars]
    write("batches", "Batches and datasets", "\n\n".join([table(["", "found", "bar", ""], rows), summary, dataset]), DEPENDS_ON)
    return all(holds for *_, holds in bars)


def memory(samples, low: float, high: float) -> float:
    """Median MiB while that share of the requests was done."""
    return statistics.median([mib for share, mib in samples if low <= share <= high] or [0.0])


def frozen(given, batch: Path) -> tuple:
    """Bars and a paragraph of the dataset of the batch."""
    out = given.work / "datasets"
    program = str(given.binary)
    done = called([program, "dataset", "freeze", "--name", "bar", "--output-file", str(batch / "output.jsonl"), "--out",
                   str(out), "--split", "train=0.8,validation=0.1,test=0.1"])
    version = out / "bar" / "v1"
    verified = subprocess.run([program, "dataset", "verify", str(out / "bar")], capture_output=True, text=True)
    scenes, counts, shared = leaks(version)
    python = environment_of(given.target_dir, "webdataset", PINS) / "bin/python"
    streamed = json.loads(called([str(python), "-c", STREAM, str(version / "shards" / "train-*.tar")]))
    damaged = found_damage(program, version, given.seed)
    page = (version / "statistics.html").read_text(encoding="utf-8")
    bars = [
        ("`dataset verify`, exit code", verified.returncode, 0, verified.returncode == 0),
        ("A flipped byte that `verify` finds", "found" if damaged else "not found", "found", damaged),
        ("What splits share", sum(shared.values()), 0, not shared),
        ("Scenes that `webdataset` streams of the split `train`", f"{streamed['right']} of {counts.get('train', 0)}",
         counts.get("train", 0), streamed["right"] == streamed["samples"] == counts.get("train", 0)),
        ("Plots of the page of statistics", len(re.findall("<svg", page)), "1", "<svg" in page),
    ]
    summary = f"The dataset has {scenes} scenes: {', '.join(f'{name} {n}' for name, n in sorted(counts.items()))}."
    print(done[-500:], flush=True)
    return bars, summary


def found_damage(program: str, version: Path, seed: int) -> bool:
    """Whether `verify` finds one flipped bit of a shard; it is flipped back."""
    shard = next(iter(sorted((version / "shards").glob("*.tar"))))
    at = random.Random(seed).randrange(shard.stat().st_size)

    def flip():
        with open(shard, "r+b") as file:
            file.seek(at)
            byte = file.read(1)[0] ^ 1
            file.seek(at)
            file.write(bytes([byte]))

    flip()
    found = subprocess.run([program, "dataset", "verify", str(version.parent)], capture_output=True).returncode != 0
    flip()
    return found


def called(command: list) -> str:
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise Problem(f"`{' '.join(command[:3])}` ended with {done.returncode}: {done.stderr[-1000:]}")
    return done.stdout


if __name__ == "__main__":
    run(main)
