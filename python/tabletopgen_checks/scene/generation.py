"""Scenes by `tabletopgen generate`, and fingerprints of what it writes."""

import hashlib
import json
import os
import shutil
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.processes import run_alone


@dataclass
class Generated:
    folder: Path
    seconds: float
    cpu_s: float
    printed: dict


def generate(
    binary: Path, out: Path, source, seed: int, threads=None, environment=None, data=None, seconds=600, artifacts=False,
    more=(),
) -> Generated:
    """Makes one scene from a sentence, or from the image at a `Path`, in an empty data directory, or in `data`;
    `printed` is what `--json` printed. With `artifacts` the bundle's folder also gets what every stage put aside.
    `more` are further arguments.

    A scene that its own certificate quarantines is made all the same: `printed["verdict"]` says so.
    """
    if out.exists():
        shutil.rmtree(out)
    out.parent.mkdir(parents=True, exist_ok=True)
    asked = ["--image" if isinstance(source, Path) else "--text", str(source)]
    command = [str(binary), "generate", *asked, "--seed", str(seed), "--out", str(out), "--json"]
    command += ["--threads", str(threads)] if threads else []
    command += ["--artifacts"] if artifacts else []
    command += ["--data-dir", str(data)] if data else []
    command += more
    start = time.perf_counter()
    try:
        run = run_alone(command, seconds, dict(os.environ, **(environment or {})))
    except subprocess.TimeoutExpired:
        raise Problem(f"{asked[1]!r} was not done within {seconds} s") from None
    except OSError as error:
        raise Problem(f"{binary} does not start: {error.strerror}; build it with `make build`") from error
    took = time.perf_counter() - start
    try:
        printed = json.loads(run.stdout)
    except ValueError:
        printed = None
    # 3 is a quarantined scene, whose bundle is written.
    if run.exit_code not in (0, 3) or printed is None:
        last = "\n  ".join((run.stderr or run.stdout).strip().splitlines()[-12:])
        why = (printed or {}).get("failure", {}).get("message") or f"exit code {run.exit_code}:\n  {last}"
        raise Problem(f"{asked[1]!r} gave no scene: {why}")
    return Generated(out, took, run.cpu_s, printed)


def fingerprint(folder: Path) -> str:
    """One digest over the names and bytes of every file below the folder."""
    whole = hashlib.sha256()
    for path in sorted(p for p in folder.rglob("*") if p.is_file()):
        name = path.relative_to(folder).as_posix()
        whole.update(f"{name}\0{hashlib.sha256(path.read_bytes()).hexdigest()}\n".encode())
    return whole.hexdigest()


def differing_files(a: Path, b: Path) -> list:
    """Files that only one of two folders has, or that differ."""
    names = {p.relative_to(f).as_posix() for f in (a, b) for p in f.rglob("*") if p.is_file()}

    def content(folder, name):
        path = folder / name
        return path.read_bytes() if path.is_file() else None

    return sorted(name for name in names if content(a, name) != content(b, name))
