"""Fuzzes each parser of foreign bytes (fuzz/), one after the other; writes docs/results/fuzz.md.

    PYTHONPATH=python python3 -m tabletopgen_checks.fuzz [--target-dir target] [--seconds 600] [--only glb,images] \\
        [--build-only]

Needs a nightly toolchain, for the coverage that libFuzzer steers by; cargo-fuzz is not needed. Each target
begins with the files of fuzz/seeds/ and tests/fixtures/hostile/; what it finds on the way stays in the corpus
under the target directory. A crash, an answer that takes ten seconds or memory beyond the limit ends a
target, and is exit code 1: its input lies beside the corpus.
"""

import argparse
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import time
from pathlib import Path

from tabletopgen_checks.bars.page import commit, machine, table
from tabletopgen_checks.repository import RESULTS, ROOT
from tabletopgen_checks.result_pages import dependency_line, split

DEPENDS_ON = (
    "crates/models/embedded/src/text_parser", "crates/models/embedded/src/text_parser.rs", "crates/models/http_client",
    "crates/base/imaging", "crates/base/mesh_io", "crates/models/remote", "crates/base/scene", "crates/method/tasks",
    "crates/method/vision", "fuzz",
)
TRIPLE = "x86_64-unknown-linux-gnu"

# What cargo-fuzz passes, without the address sanitizer: the program has no unsafe code, and its dependencies' is
# theirs.
COVERAGE = [
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
    "--cfg=fuzzing",
    "-Cllvm-args=-simplifycfg-branch-fold-threshold=0",
]

# Target, what it reads, folders and files of tests/ that it begins with beside its seeds.
TARGETS = [
    ("glb", "GLB files of mesh generators", ["fixtures/hostile/glb"]),
    ("wavefront", "OBJ files, with MTL files and images, in ZIP archives and plain", ["fixtures/hostile/archive"]),
    ("images", "PNG, JPEG and WebP of requests, image generators and textures", ["fixtures/hostile/picture"]),
    ("segmentations", "answers of the segmenter's server: boxes, words, masks as run lengths", ["fixtures/hostile/answer"]),
    ("vendor_answers", "answers of chat, image and mesh endpoints as they come over the wire", ["fixtures/hostile/answer"]),
    ("cassettes", "recordings", ["fixtures/hostile/answer"]),
    ("weights", "safetensors files of the table network and of DINOv2, with its config.json", []),
    ("requests", "bodies of POST /scenes, with their options, settings and images", ["fixtures/hostile/answer"]),
    ("chat_answers", "answers of chat models to each question", ["fixtures/hostile/answer"]),
    ("texts", "texts of scenes and tasks, as the embedded parser reads them", []),
    ("instructions", "instructions for edits and tasks", []),
]

RSS_LIMIT_MB, MALLOC_LIMIT_MB, TIMEOUT_SECS, MAX_LEN = 2048, 1024, 10, 65536


def main() -> bool:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target-dir", type=Path, default=ROOT / "target")
    parser.add_argument("--seconds", type=int, default=600)
    parser.add_argument("--only", default=",".join(name for name, _, _ in TARGETS))
    parser.add_argument("--build-only", action="store_true")
    parser.add_argument("--as-built", action="store_true", help="run what was built before")
    given = parser.parse_args()
    work = given.target_dir.resolve() / "fuzz"
    asked, held = given.only.split(","), True
    if unknown := set(asked) - {name for name, _, _ in TARGETS}:
        parser.error(f"unknown targets {', '.join(sorted(unknown))}")
    if not given.as_built:
        build(work, asked)
    if given.build_only:
        return True
    for name, reads, seeds in TARGETS:
        if name in asked:
            found = run(work, name, reads, seeds, given.seconds)
            (work / f"{name}.json").write_text(json.dumps(found), encoding="utf-8")
            held &= found["finds"] == "none"
            write(work)
    return held


def build(work: Path, targets: list):
    # The versions are the package's.
    shutil.copy(ROOT / "Cargo.lock", ROOT / "fuzz/Cargo.lock")
    command = ["cargo", "+nightly", "build", "--release", "--target", TRIPLE]
    command += [part for name in targets for part in ("--bin", name)]
    environment = {**os.environ, "RUSTFLAGS": " ".join(COVERAGE), "CARGO_TARGET_DIR": str(work)}
    subprocess.run(command, cwd=ROOT / "fuzz", env=environment, check=True)
    (work / "commit").write_text(commit(), encoding="utf-8")


def run(work: Path, name: str, reads: str, seeds: list, seconds: int) -> dict:
    corpus, found = work / "corpus" / name, work / "found" / name
    for folder in (corpus, found):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
    begun_with = seeded(corpus, name, seeds)
    words = work / f"{name}.dict"
    words.write_text("".join(f'"{word}"\n' for word in dictionary(corpus)), encoding="ascii")
    command = [
        work / TRIPLE / "release" / name,
        corpus,
        f"-max_total_time={seconds}",
        f"-rss_limit_mb={RSS_LIMIT_MB}",
        f"-malloc_limit_mb={MALLOC_LIMIT_MB}",
        f"-timeout={TIMEOUT_SECS}",
        f"-max_len={MAX_LEN}",
        f"-dict={words}",
        f"-artifact_prefix={found}/",
        "-print_final_stats=1",
        "-seed=1",
    ]
    begun = time.monotonic()
    with open(work / f"{name}.log", "wb") as log:
        code = subprocess.run(command, stdout=log, stderr=subprocess.STDOUT).returncode
    took = time.monotonic() - begun
    log = (work / f"{name}.log").read_text(encoding="utf-8", errors="replace")
    finds = sorted(path.name for path in found.iterdir())
    def stat(of):
        return (re.findall(rf"stat::{of}:\s+(\d+)", log) or ["?"])[-1]
    # Those that were reached at all: the seeds', and those that were found on the way.
    edges = (re.findall(r"cov: (\d+)", log) or ["?"])[-1]
    at_first = (re.findall(r"INITED cov: (\d+)", log) or ["?"])[-1]
    executed, rss = stat("number_of_executed_units"), stat("peak_rss_mb")
    row = {
        "target": name,
        "reads": reads,
        "seeds": begun_with,
        "runs": executed,
        "seconds": round(took),
        "edges at first": at_first,
        "edges": edges,
        "corpus": len(list(corpus.iterdir())),
        "peak RSS, MB": rss,
        "finds": ", ".join(finds) or ("none" if code == 0 else f"ended with {code}"),
        "measured": f"at commit {(work / 'commit').read_text(encoding='utf-8')} on {time.strftime('%Y-%m-%d', time.gmtime())}",
    }
    print(*row.values(), sep=" | ", flush=True)
    return row


def seeded(corpus: Path, name: str, more: list) -> int:
    """Copies what a target begins with; how many files that is."""
    folders = [ROOT / "fuzz/seeds" / name] + [ROOT / "tests" / folder for folder in more]
    files = [path for folder in folders if folder.is_dir() for path in sorted(folder.iterdir())]
    for path in files:
        shutil.copy(path, corpus / f"{path.parent.name}_{path.name}")
    if name == "weights":
        golden = ROOT / "tests/golden"
        shutil.copy(golden / "table_network/weights.safetensors", corpus / "table_network")
        config = (golden / "dinov2/swiglu/config.json").read_bytes()
        weights = (golden / "dinov2/swiglu/model.safetensors").read_bytes()
        (corpus / "dinov2").write_bytes(b"D" + struct.pack("<H", len(config)) + config + weights)
    if name in ("texts", "instructions"):
        for path in (ROOT / "tests/words/sentences.jsonl", ROOT / "tests/words/tasks.jsonl"):
            for entry in map(json.loads, path.read_text(encoding="utf-8").splitlines()):
                (corpus / f"{path.stem}_{entry['id']}").write_text(entry["text"], encoding="utf-8")
    return len(list(corpus.iterdir()))


def dictionary(corpus: Path) -> list:
    """Words of the JSON and OBJ files: names of fields are not guessed letter by letter."""
    words = set()
    for path in corpus.iterdir():
        words.update(re.findall(rb"[A-Za-z_]{3,30}", path.read_bytes()[:20000]))
    return sorted(word.decode() for word in words)[:2000]


def write(work: Path):
    """The page, with the last run of each target; of targets that never ran here, the row stays that stands there."""
    files = [work / f"{name}.json" for name, _, _ in TARGETS]
    rows = [json.loads(path.read_text(encoding="utf-8")) for path in files if path.exists()]
    path = RESULTS / "fuzz.md"
    earlier = split(path.read_text(encoding="utf-8"))[0] if path.exists() else ""
    body = f"""# Fuzzing

`make fuzz`, {machine()}, one process at a time, each at the commit of its row.

Each parser of foreign bytes, under libFuzzer with overflow checks and assertions on. A run may take
{TIMEOUT_SECS} seconds, the process {RSS_LIMIT_MB} MB and one allocation {MALLOC_LIMIT_MB} MB; inputs have up to {MAX_LEN} bytes. Edges
are those reached, in the whole program; before that, those of the files that a target begins with.

"""
    # Findings of earlier runs, which tests replay, are listed by hand.
    kept = earlier[earlier.index("\n## ") :] if "\n## " in earlier else "\n"
    cells = {cell[0]: cell for cell in table_cells(earlier)} | {row["target"]: list(row.values()) for row in rows}
    page = body + table(list(rows[0]), list(cells.values())) + "\n" + kept
    path.write_text(f"{page.rstrip()}\n\n{dependency_line(DEPENDS_ON)}\n", encoding="utf-8")


def table_cells(page: str) -> list:
    """The cells of the first table of a page, without its head."""
    found = re.search(r"^\|.*\n\|[ :|-]+\n((?:\|.*\n)*)", page, re.MULTILINE)
    lines = found[1].splitlines() if found else []
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]


if __name__ == "__main__":
    sys.exit(0 if main() else 1)
