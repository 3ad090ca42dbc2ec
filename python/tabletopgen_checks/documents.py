"""Runs the commands of the documents as they are printed, against the program and a server of it.

    PYTHONPATH=python python3 -m tabletopgen_checks.documents [--target-dir target] \\
        [--program target/debug/tabletopgen] [--only docs/tutorial.md]

A fence that begins with ```sh or ```python runs; `sh exit=1` ends with that code, and `sh slow` takes minutes, so that
`make test` leaves it out. A fence ```output holds the whole output of the fence before; a line `...` in it stands for
any lines, and N for any number. A fence ```toml file=NAME is that file; ```nginx the configuration of a proxy in front
of a server. Documents of a group run one after the other in one shell and one folder, so that a later one may use the
scenes and variables of an earlier one. `localhost:8080` is the server; other ports of PORTS are free ones, and what
still runs at the end is ended.

A fence of commands without a language is listed in LEFT_OUT with the reason why it does not run.
"""

import argparse
import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import ROOT
from tabletopgen_checks.service.login_proxy import LoginProxy
from tabletopgen_checks.service.postgres import free_port
from tabletopgen_checks.service.server import Server

GROUPS = [
    ["README.md", "docs/tutorial.md"],
    [
        "docs/user_guide.md", "docs/catalog.md", "docs/tasks.md", "docs/episodes.md", "docs/robots.md", "docs/datasets.md",
        "docs/operations.md",
    ],
]
# Document and first line of a fence, and why it does not run.
LEFT_OUT = {
    ("README.md", "make build   # target/release/tabletopgen; needs a Rust toolchain, a C and C++ compiler and make"):
        "`make test` builds, too",
    ("README.md", "make test    # formatting, lints, all tests; then independent programs judge sample scenes"):
        "it is what runs these fences",
    ("docs/user_guide.md", "curl -s localhost:8080/webhooks -H 'content-type: application/json' \\"):
        "would send to example.org; tests/it/api/webhooks.rs sends",
    ("README.md", 'pip install "$(echo target/wheel/tabletopgen-*.whl)[mujoco]"'): "the tests of clients/python install the wheel",
    ("docs/user_guide.md", "tabletopgen-lab evaluate --set layout --difficulty clean      "
     "# 78 scenes: yaw, position, scale against ground truth"):
        "takes hours; the bars run them",
    ("docs/episodes.md", 'tabletopgen episodes --scene out/desk --task "put the apple on the plate" --count 50 --out out/apple'):
        "an hour; the user guide records one episode",
    ("docs/episodes.md", "curl -s localhost:8080/scenes/$SCENE/episodes -H 'content-type: application/json' -d '{"):
        "half an hour; tests/it/api/episodes.rs records over HTTP",
    ("docs/episodes.md", "curl -sN localhost:8080/episodes/$RECORDING/events -H 'accept: text/event-stream'"):
        "needs the recording before",
    ("docs/episodes.md", "make bars BARS=policy    # an hour or more on two cores; datasets are kept below target/bars/policy"):
        "an hour",
    ("docs/episodes.md", "cargo run -p tabletopgen-episodes --example synthetic -- out/synthetic    # small episodes in every format"):
        "compiles an example; `make test` runs the judges of episodes",
    ("docs/robots.md", "cargo run -p tabletopgen-robot --example write_robot -- piper out/piper"):
        "compiles an example",
    ("docs/datasets.md", "import glob, json, webdataset"):
        "wants the package webdataset; the bar `batches` streams shards with it",
    ("docs/operations.md", "tabletopgen serve --listen 127.0.0.1:8080 --data-dir data --config server.toml"):
        "does not end; every other fence uses such a server",
    ("docs/operations.md", 'pg_dump --format=custom --file=tabletopgen.dump "$URL"      # first: every row has its blob'):
        "wants PostgreSQL and a bucket",
}
# What a line of commands begins with.
COMMAND = re.compile(
    r"(\$ )?([A-Z_]+=\S* )*(tabletopgen|target/release/|curl|make|cargo|python3?|pip|docker|kubectl|psql|pg_dump|aws|npx?)\b"
)
# Ports of servers that commands of the documents start, and that of the proxy.
PROXY_PORT = "4180"
PORTS = ("8090", "8091", PROXY_PORT)
# A group that takes longer hangs.
GROUP_SECONDS = 1800


@dataclass
class Fence:
    document: str
    # Of the line with the backticks, from 1.
    line: int
    language: str
    options: str
    text: str

    @property
    def first(self) -> str:
        return self.text.split("\n", 1)[0]

    @property
    def exit_code(self) -> int:
        found = re.search(r"exit=(\d+)", self.options)
        return int(found.group(1)) if found else 0

    @property
    def is_slow(self) -> bool:
        return "slow" in self.options.split()

    @property
    def place(self) -> str:
        return f"{self.document}:{self.line}"

    def has_commands(self) -> bool:
        return any(COMMAND.match(line) for line in self.text.split("\n"))


def fences(document: str, text: str) -> list:
    """The fences of a document in their order."""
    found, begun = [], None
    for number, line in enumerate(text.split("\n"), 1):
        mark = re.fullmatch(r"```(\w*) ?(.*)", line)
        if begun is None and mark:
            begun = Fence(document, number, mark.group(1), mark.group(2), "")
        elif begun is not None and line == "```":
            begun.text = begun.text[:-1]
            found.append(begun)
            begun = None
        elif begun is not None:
            begun.text += f"{line}\n"
    if begun is not None:
        raise Problem(f"the fence of {begun.place} does not end")
    return found


def complaints(every: list, left_out: dict) -> list:
    """Fences with commands that neither run nor are left out for a reason, and reasons that are of no fence."""
    found, seen = [], set()
    for fence in every:
        seen.add((fence.document, fence.first))
        if fence.language == "" and fence.has_commands():
            if (fence.document, fence.first) not in left_out:
                found.append(f"{fence.place}: begin the fence with ```sh so that it runs, or list it in LEFT_OUT: {fence.first}")
    unused = [key for key in left_out if key not in seen]
    return found + [f"LEFT_OUT lists a fence that {document} does not have: {first}" for document, first in unused]


def is_run(fence: Fence) -> bool:
    return fence.language in ("sh", "python") and (fence.document, fence.first) not in LEFT_OUT


def without_slow(every: list) -> list:
    """The fences that `make test` runs, each with its output."""
    kept = []
    for fence, before in zip(every, [None, *every]):
        is_output_of_slow = fence.language == "output" and before is not None and before.is_slow
        if not fence.is_slow and not is_output_of_slow:
            kept.append(fence)
    return kept


def script(every: list, folder: Path) -> str:
    """The fences as one script; each leaves its output and errors in `folder`, and the last one begun is in `begun`."""
    lines = ["set -o pipefail"]
    for number, fence in enumerate(every):
        if not is_run(fence):
            continue
        body = fence.text
        if fence.language == "python":
            path = folder / f"{number}.py"
            path.write_text(f"{body}\n", encoding="utf-8")
            body = f'"{sys.executable}" "{path}"'
        lines += [
            f'echo {number} > "{folder}/begun"',
            "set +e" if fence.exit_code else "set -e",
            "{",
            body,
            f'}} > "{folder}/{number}.out" 2> "{folder}/{number}.err"',
        ]
        if fence.exit_code:
            lines.append(f"[ $? = {fence.exit_code} ] || exit 99")
    return "\n".join([*lines, f'echo end > "{folder}/begun"', ""])


def same(expected: str, found: str) -> bool:
    """Whether an output is the printed one, in which a line `...` stands for any lines and N for any number."""
    parts = re.split(r"(?m)^\.\.\.\n", f"{expected.rstrip()}\n")
    pattern = "(?:.*\n)*".join(re.sub(r"\bN\b", r"[0-9.]+", re.escape(part)) for part in parts)
    return re.fullmatch(pattern, f"{found.rstrip()}\n") is not None


def run(every: list, program: Path, work: Path) -> float:
    """Runs the fences of a group in a folder; the CPU seconds of the commands."""
    home, outputs = work / "home", work / "outputs"
    for folder in (home / "target/release", home / "bin", outputs):
        folder.mkdir(parents=True)
    for name in ("tabletopgen", "tabletopgen-lab"):
        for place in (home / "bin", home / "target/release"):
            (place / name).symlink_to(program.with_name(name))
    for name in ("docs", "tests"):
        (home / name).symlink_to(ROOT / name)
    # An answer that is an error ends a command; as they are printed they show it.
    (work / ".curlrc").write_text("fail-with-body\n", encoding="utf-8")
    with Server(program, home / "data", work / "log") as server, contextlib.ExitStack() as stack:
        ports = {"localhost:8080": f"127.0.0.1:{server.port}"} | {f":{port}": f":{free_port()}" for port in PORTS}
        words = script(every, outputs)
        for fence in every:
            if found := re.fullmatch(r"file=([\w.]+)", fence.options):
                (home / found[1]).write_text(replaced(f"{fence.text}\n", ports), encoding="utf-8")
            if fence.language == "nginx":
                stack.enter_context(LoginProxy(replaced(fence.text, ports), int(ports[f":{PROXY_PORT}"][1:])))
        for path in outputs.glob("*.py"):
            path.write_text(replaced(path.read_text(encoding="utf-8"), ports), encoding="utf-8")
        environment = dict(os.environ, PATH=f"{home / 'bin'}:{os.environ['PATH']}", CURL_HOME=str(work))
        before = os.times()
        code = run_shell(replaced(words, ports), home, environment)
        if code is None:
            raise Problem(f"{every[int((outputs / 'begun').read_text())].place} takes too long")
        after = os.times()
    begun = (outputs / "begun").read_text().strip()
    if begun != "end":
        fence = every[int(begun)]
        said = "".join((outputs / f"{begun}.{kind}").read_text(encoding="utf-8") for kind in ("out", "err"))
        raise Problem(f"{fence.place} ended with exit code {code}: {fence.text}\n{said[-2000:]}")
    for number, fence in enumerate(every):
        if fence.language == "output":
            found = (outputs / f"{number - 1}.out").read_text(encoding="utf-8")
            if not same(fence.text, found):
                raise Problem(f"{fence.place} prints another output than there is:\n{found}")
    return after.children_user + after.children_system - before.children_user - before.children_system


def replaced(text: str, ports: dict) -> str:
    for printed, port in ports.items():
        text = text.replace(printed, port)
    return text


def run_shell(words: str, home: Path, environment: dict):
    """The exit code of a script; None where it takes too long. What it left running is ended."""
    process = subprocess.Popen(["bash", "-c", words], cwd=home, env=environment, stdin=subprocess.DEVNULL, start_new_session=True)
    try:
        return process.wait(GROUP_SECONDS)
    except subprocess.TimeoutExpired:
        return None
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def check(program: Path, groups: list, with_slow: bool = False) -> str:
    """A line about the documents of some groups; a problem for the first command that fails, and for fences of any
    document that neither run nor are left out."""
    every = {name: fences(name, (ROOT / name).read_text(encoding="utf-8")) for group in GROUPS for name in group}
    if found := complaints([fence for part in every.values() for fence in part], LEFT_OUT):
        raise Problem("\n".join(found))
    ran, cpu_s = 0, 0.0
    for group in groups:
        of_group = [fence for name in group for fence in every[name]]
        of_group = of_group if with_slow else without_slow(of_group)
        with tempfile.TemporaryDirectory(prefix="tabletopgen-documents-") as work:
            began = time.monotonic()
            used = run(of_group, program.resolve(), Path(work))
            print(f"   {', '.join(group)}: {used:.0f} CPU s of commands, {time.monotonic() - began:.0f} s", flush=True)
            cpu_s += used
        ran += sum(map(is_run, of_group))
    return f"{ran} fences of {sum(map(len, groups))} documents run as they are printed"


def main() -> int:
    parser = argparse.ArgumentParser(description="Run the commands of the documents.")
    parser.add_argument("--target-dir", type=Path, default=ROOT / "target")
    parser.add_argument("--program", type=Path)
    parser.add_argument("--only", choices=[name for group in GROUPS for name in group], help="run the group of this document")
    given = parser.parse_args()
    groups = [group for group in GROUPS if given.only in (None, *group)]
    try:
        print(check(given.program or given.target_dir / "debug" / "tabletopgen", groups, with_slow=True))
    except Problem as problem:
        print(problem, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
