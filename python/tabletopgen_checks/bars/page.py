"""A page of results: what was run, on which commit and machine, and a table.

What is measured is what was committed: with uncommitted changes a bar does not begin, unless `--uncommitted` is given,
and then its page says so.
"""

import argparse
import functools
import hashlib
import os
import platform
import re
import shlex
import sys
import time
from pathlib import Path

from tabletopgen_checks.repository import RESULTS, ROOT, git
from tabletopgen_checks.result_pages import dependency_line, split

# Options with a folder or a file as their value.
FOLDERS = ("--target-dir", "--program", "--pictures", "--images")
UNCOMMITTED = " with uncommitted changes"
# What decides the scenes that the embedded models make of texts, and of images.
SCENES_OF_TEXTS = (
    "config/catalog", "config/default.toml", "crates/base/catalog", "crates/models/embedded", "crates/data/export",
    "crates/base/geometry", "crates/method/physics", "crates/method/pose_estimation", "crates/method/render",
    "crates/base/certificate", "crates/base/scene", "crates/method/vision", "src/pipeline", "src/pipeline.rs",
)
SCENES_OF_IMAGES = (
    "config/catalog", "config/default.toml", "crates/base/catalog", "crates/models/embedded/src/mesh_generator.rs",
    "crates/models/embedded/src/single_view_reconstruction", "crates/data/export", "crates/base/geometry",
    "crates/method/physics", "crates/method/pose_estimation", "crates/method/render", "crates/base/certificate",
    "crates/base/scene", "crates/method/vision", "src/pipeline", "src/pipeline.rs", "weights",
)


def arguments(description: "str | None", **more) -> argparse.Namespace:
    """The options every bar has; `more` are options of its own with their defaults."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target-dir", type=Path, default=ROOT / "target")
    for name, default in more.items():
        parser.add_argument("--" + name.replace("_", "-"), type=type(default), default=default)
    parser.add_argument("--uncommitted", action="store_true", help="measure uncommitted changes; the page says so")
    given = parser.parse_args()
    if UNCOMMITTED in commit_at_the_begin() and not given.uncommitted:
        parser.error(f"the tree is at commit {commit()}: commit or stash them, or give --uncommitted")
    given.target_dir = given.target_dir.resolve()
    given.binary = given.target_dir / "release" / "tabletopgen"
    given.work = given.target_dir / "bars"
    given.work.mkdir(parents=True, exist_ok=True)
    return given


def table(columns, rows) -> str:
    cells = [[str(cell) for cell in row] for row in rows]
    number = [all(row[k][:1].isdigit() for row in cells) and bool(cells) for k in range(len(columns))]
    lines = ["| " + " | ".join(columns) + " |", "| " + " | ".join("---:" if n else "---" for n in number) + " |"]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in cells])


def write(bar: str, title: str, body: str, depends_on: tuple):
    """docs/results/BAR.md, with the command and the commit that made it, and the paths that decide its figures."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    path = RESULTS / f"{bar}.md"
    page = f"# {title}\n\n{made_by(bar)}\n\n{body.rstrip()}\n\n{dependency_line(depends_on)}\n"
    path.write_text(page, encoding="utf-8")
    print(f"{body}\n\nwritten to {path.relative_to(ROOT)}", flush=True)


def write_section(bar: str, heading: str, body: str, depends_on: tuple):
    """The part of docs/results/BAR.md below a heading alone, with the command and the commit that made it."""
    path = RESULTS / f"{bar}.md"
    page = path.read_text(encoding="utf-8") if path.is_file() else f"# {bar.capitalize()}\n"
    page = with_section(split(page)[0], heading, f"{made_by(bar)}\n\n{body.rstrip()}")
    path.write_text(f"{page}\n{dependency_line(depends_on)}\n", encoding="utf-8")
    print(f"{body}\n\nwritten to {path.relative_to(ROOT)}", flush=True)


def made_by(bar: str) -> str:
    """The command, the commit and the machine that a page or a section was made by."""
    day = time.strftime("%Y-%m-%d", time.gmtime())
    options = options_given()
    command = f"make bars BARS={bar}" + (f' BARS_OPTIONS="{options}"' if options else "")
    return f"`{command}` at commit {measured_commit()} on {day}, {machine()}."


def options_given() -> str:
    """The options of the command line that say what is measured and how much; folders are those of the machine."""
    kept, words = [], iter(sys.argv[1:])
    for word in words:
        if word in FOLDERS:
            next(words, None)
        elif word != "--uncommitted":
            kept.append(word)
    return shlex.join(kept)


def with_section(page: str, heading: str, body: str) -> str:
    """A page whose section of that heading has another body; a new section comes last."""
    section = f"## {heading}\n\n{body}\n"
    lead, *sections = re.split(r"^(?=## )", page, flags=re.MULTILINE)
    named = [k for k, one in enumerate(sections) if one.split("\n", 1)[0] == f"## {heading}"]
    if named:
        sections[named[0]] = section
    else:
        sections.append(section)
    return "\n\n".join(part.rstrip() for part in [lead, *sections]) + "\n"


def commit() -> str:
    found = git("rev-parse", "--short=12", "HEAD")
    changed = git("status", "--porcelain", "--", ".", ":!docs/results")
    return (found or "(no git)") + (UNCOMMITTED if changed else "")


@functools.cache
def commit_at_the_begin() -> str:
    return commit()


def measured_commit() -> str:
    """The commit at which the measurement began; changes on the way are uncommitted ones of it."""
    begun = commit_at_the_begin()
    return begun if UNCOMMITTED in begun or commit() == begun else begun + UNCOMMITTED


def source_digest() -> str:
    """Of everything that decides the program's bytes and its answers."""
    whole = hashlib.sha256()
    for name in ("src", "crates", "config", "schemas", "migrations", "Cargo.lock", "Cargo.toml", "rust-toolchain.toml"):
        path = ROOT / name
        files = [path] if path.is_file() else sorted(p for p in path.rglob("*") if p.is_file())
        for file in files:
            whole.update(file.relative_to(ROOT).as_posix().encode() + b"\0" + file.read_bytes())
    return whole.hexdigest()[:16]


def machine() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        model = next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        model = platform.processor() or platform.machine()
    return f"{len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else os.cpu_count()} cores of {model}"


def percent(fraction, digits=1) -> str:
    return f"{100 * fraction:.{digits}f} %"
