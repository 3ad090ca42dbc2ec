"""Runs `tabletopgen edit` and judges what came of it."""

import json
import os
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

from tabletopgen_checks.edits.cases import Case
from tabletopgen_checks.edits.comparison import Comparison, complaints
from tabletopgen_checks.edits.parents import Parent
from tabletopgen_checks.edits.refusals import place_for
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.processes import run_alone
from tabletopgen_checks.scene.generation import fingerprint
from tabletopgen_checks.scene.scene import Scene, read_scene

TIMEOUT_S = 300
# How an edit can end.
RIGHT, REFUSED, NO_ROOM, WRONG = "right", "refused as it must be", "refused, no room is found", "wrong"
OUTCOMES = (RIGHT, REFUSED, NO_ROOM, WRONG)


@dataclass
class Edited:
    exit_code: int
    document: dict
    errors: str
    cpu_s: float
    command: list

    def message(self) -> str:
        return str((self.document.get("failure") or {}).get("message") or "")


@dataclass
class Judged:
    case: Case
    outcome: str
    # Why it is wrong; the reason of the refusal where it was refused.
    words: list = field(default_factory=list)
    command: str = ""
    # The bundle, where there is one.
    bundle: Path | None = None


def edit(
    binary: Path, bundle: Path, wire: list, seed: int, out: Path, threads: int | None = None, options=()
) -> Edited:
    """One call of the command; the CPU time is that of the process and what it waited for."""
    shutil.rmtree(out, ignore_errors=True)
    out.parent.mkdir(parents=True, exist_ok=True)
    operations = out.with_name(f"{out.name}.json")
    operations.write_text(json.dumps(wire, indent=1), encoding="utf-8")
    command = [str(binary), "edit", "--bundle", str(bundle), "--operations", str(operations), "--seed", str(seed),
               "--out", str(out), "--json"]
    command += ["--threads", str(threads)] if threads else []
    return called([*command, *options])


def called(command: list) -> Edited:
    try:
        run = run_alone(command, TIMEOUT_S, dict(os.environ))
    except subprocess.TimeoutExpired:
        return Edited(-1, {}, f"not done within {TIMEOUT_S} s", 0.0, command)
    except OSError as error:
        raise Problem(f"{command[0]} does not start: {error.strerror}; build it with `make lab`") from error
    try:
        document = json.loads(run.stdout)
    except ValueError:
        document = {}
    return Edited(run.exit_code, document, run.stderr.strip(), run.cpu_s, command)


def judged(binary: Path, parent: Parent, case: Case, folder: Path) -> Judged:
    """The outcome of one case, without its rest, which is simulated for many at once."""
    out, before = folder / case.name, fingerprint(parent.folder)
    done = edit(binary, parent.folder, case.wire(), case.seed, out)
    command = " ".join(done.command)
    if fingerprint(parent.folder) != before:
        return Judged(case, WRONG, ["the parent's bundle changed"], command)
    if done.exit_code == 0:
        try:
            wrong = child_complaints(parent.scene, read_scene(out), case, done.document)
        except (OSError, ValueError, KeyError, TypeError) as error:
            wrong = [f"the scene cannot be measured: {error!r}"]
        return Judged(case, WRONG if wrong else RIGHT, wrong, command, out)
    wrong = refusal_complaints(done, case, out)
    if wrong:
        return Judged(case, WRONG, wrong, command)
    if case.refused:
        return Judged(case, REFUSED, [done.message()], command)
    found = possible(binary, parent, case, folder)
    words = [f"refused: {done.message()}"]
    return Judged(case, WRONG if found else NO_ROOM, [*words, found] if found else words, command)


def child_complaints(parent: Scene, child: Scene, case: Case, document: dict) -> list:
    if case.refused:
        return [f"not refused, although it must be ({case.refused})"]
    return complaints(parent, child, case.operations, document)


def refusal_complaints(done: Edited, case: Case, out: Path) -> list:
    """What a refusal owes: a document with a reason that names what it is about, and nothing written."""
    failure, wrong = done.document.get("failure") or {}, []
    if not failure.get("message"):
        last = done.errors.splitlines()[-1:] or ["nothing"]
        wrong.append(f"exit code {done.exit_code} without a reason; verdict {done.document.get('verdict')}, "
                     f"reasons {done.document.get('reasons')}, on stderr: {last[0]}")
    elif failure.get("exit_code") != done.exit_code:
        wrong.append(f"exit code {done.exit_code}, the document says {failure.get('exit_code')}")
    if (out / "scene.json").exists():
        wrong.append("a refused edit wrote a scene")
    text = json.dumps(failure).lower()
    missing = [name for name in case.names if name.lower() not in text]
    if failure.get("message") and missing:
        wrong.append(f"the reason does not name {', '.join(missing)}: {failure['message']}")
    return wrong


def possible(binary: Path, parent: Parent, case: Case, folder: Path) -> str:
    """Words on why a refused edit is possible; empty where nothing speaks against the refusal.

    The operation of a chain that failed is the first with which its beginning is refused.
    """
    scene, added = parent.scene, {}
    for index, operation in enumerate(case.operations):
        if index + 1 < len(case.operations):
            out = folder / f"{case.name}_first_{index + 1}"
            part = edit(binary, parent.folder, case.wire()[: index + 1], case.seed, out)
            if part.exit_code == 0:
                scene = read_scene(out)
                added = Comparison(parent.scene, scene, case.operations[: index + 1]).added
                shutil.rmtree(out, ignore_errors=True)
                continue

        def names(words, added=added):
            return [found for name in words for found in (added.get(int(name[1:]), []) if name[0] == "+" else [name])]

        found = place_for(operation, scene, names)
        return f"operation {index + 1} ({operation.name}) is possible: {found}" if found else ""
    return ""
