"""Every operation of openapi.yaml under a fuzzer of contracts, and two generated clients used as they are.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.contract [--target-dir target] [--examples 100] \\
        [--program FILE] [--seed 1]

Schemathesis sends requests that fit the document and requests that break it, one by one and in sequences, and compares
every answer with the document. The client of openapi-python-client submits, polls and downloads; that of
openapi-typescript is compiled. All three are pinned in tests/contract/requirements.txt and lie in `contract` of the
target directory.
"""

import hashlib
import http.server
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path
from typing import NamedTuple

from tabletopgen_checks.bars.page import arguments, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.processes import output_of
from tabletopgen_checks.repository import ROOT
from tabletopgen_checks.service.server import Server

DEPENDS_ON = ("openapi.yaml", "src/api", "src/api.rs", "src/app", "src/problem.rs", "tests/contract")
CONTRACT = ROOT / "tests" / "contract"
DOCUMENT = ROOT / "openapi.yaml"
IMAGE = ROOT / "docs" / "demo_table.png"
NODE_PACKAGES = ("openapi-typescript@7.13.0", "typescript@5.9.3")
TSC = ("--noEmit", "--strict", "--target", "es2022", "--module", "nodenext", "--lib", "es2022,dom")
FUZZ_SECONDS = 1800
# tests/contract/hooks.py has an instruction for it.
SCENE = "a mug and a book"
# Scenes and their events, of which there are thousands, are not waited for, and batches make few of them.
QUICK = ("server.max_wait_secs=0", "server.max_event_stream_secs=1", "store.fsync=false", "batches.window=1")
# A page of results wants at least so many examples an operation.
FULL_EXAMPLES = 100
MISMATCH_COLUMNS = ["code", "mismatch", "times", "operations"]


def main() -> bool:
    given = arguments(__doc__, examples=FULL_EXAMPLES, seed=1, program="")
    if given.program:
        given.binary = Path(given.program)
    python = environment(given.target_dir / "contract")
    folder = given.work / "contract"
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "data").mkdir(parents=True)
    typescript = compile_typescript(python, folder)
    print(f"openapi-typescript: {typescript}", flush=True)
    generate_client(python, folder)
    with ImageServer() as images:
        settings = [*QUICK, f"server.fetch_hosts=127.0.0.1:{images.port}"]
        options = [word for setting in settings for word in ("--set", setting)]
        server = Server(given.binary, folder / "data", folder / "log", arguments=options)
        server.start()
        try:
            client = run_client(python, folder, server)
            print(f"openapi-python-client: {json.dumps(client)}", flush=True)
            scene = finished_scene(server)
            # Else the scenes of thousands of requests would be made beside them.
            output_of(given.binary, "queue", "pause", "--data-dir", folder / "data")
            report = fuzz(python, folder, server, images, scene, given.examples, given.seed)
            alive = server.request("GET", "/healthz")[0] == 200
        finally:
            # Thousands of scenes that are not needed may be waiting.
            server.kill()
    held = alive and not report["failures"] and not report["errors"] and report["complete"]
    body = page(report, client, typescript, given)
    if given.examples >= FULL_EXAMPLES:
        write("contract", "The API is its document", body, DEPENDS_ON)
    else:
        print(body)
    return held


def environment(venv: Path) -> Path:
    """The Python of a venv with the pinned tools; nothing is fetched where they are there already."""
    requirements = CONTRACT / "requirements.txt"
    pins = f"{requirements.read_text()} {NODE_PACKAGES} {venv} {sys.version_info[:2]}"
    stamp, python = hashlib.sha256(pins.encode()).hexdigest(), venv / "bin" / "python"
    mark = venv / "stamp"
    if mark.is_file() and mark.read_text() == stamp and python.exists():
        return python
    shutil.rmtree(venv, ignore_errors=True)
    quiet = ["--quiet", "--disable-pip-version-check"]
    output_of(sys.executable, "-m", "venv", venv)
    output_of(python, "-m", "pip", "install", *quiet, "-r", requirements)
    npm = [venv / "bin" / "npm", "install", "--silent", "--no-audit", "--no-fund", "--no-save", "--prefix", venv / "node"]
    output_of(*npm, *NODE_PACKAGES, environment=environment_of(python))
    mark.write_text(stamp)
    return python


def environment_of(python: Path) -> dict:
    """The venv's programs first: generators call formatters, npm calls node."""
    return dict(os.environ, PATH=f"{python.parent}{os.pathsep}{os.environ.get('PATH', '')}")


def compile_typescript(python: Path, folder: Path) -> str:
    """What openapi-typescript makes of the document, and a program that uses it, compile."""
    programs, around = python.parent.parent / "node" / "node_modules" / ".bin", environment_of(python)
    output_of(programs / "openapi-typescript", DOCUMENT, "-o", folder / "api.d.ts", environment=around)
    shutil.copy(CONTRACT / "client.ts", folder)
    output_of(programs / "tsc", *TSC, folder / "client.ts", environment=around, folder=folder)
    lines = len((folder / "api.d.ts").read_text().splitlines())
    return f"{lines} lines of types compile with a program that uses them"


def generate_client(python: Path, folder: Path):
    command = [python.parent / "openapi-python-client", "generate", "--path", DOCUMENT, "--output-path", folder / "client"]
    command += ["--config", CONTRACT / "python_client.yaml", "--overwrite", "--fail-on-warning"]
    words = output_of(*command, environment=environment_of(python), folder=folder)
    print(words.strip(), flush=True)


def run_client(python: Path, folder: Path, server: Server) -> dict:
    command = [python, CONTRACT / "client.py", f"http://127.0.0.1:{server.port}", IMAGE]
    around = dict(environment_of(python), PYTHONPATH=str(folder / "client"))
    return json.loads(output_of(*command, environment=around, folder=folder))


def finished_scene(server: Server) -> str:
    """A scene that the fuzzer may ask, edit and vary, and in which a robot may work."""
    scene = server.submit_text(SCENE, seed=7)
    server.wait(scene["job"]["id"])
    return scene["id"]


def fuzz(python: Path, folder: Path, server: Server, images, scene: str, examples: int, seed: int) -> dict:
    """The report of Schemathesis, with the answers of every operation counted."""
    base = f"http://127.0.0.1:{server.port}"
    options = ["--config-file", CONTRACT / "schemathesis.toml", "--no-color", "run", DOCUMENT, "--url", base]
    options += ["--max-examples", examples, "--seed", seed, "--report", "json,ndjson"]
    options += ["--report-json-path", folder / "report.json", "--report-ndjson-path", folder / "report.ndjson"]
    around = environment_of(python)
    if server.key:
        options += ["--header", f"authorization: Bearer {server.key}"]
        around["CONTRACT_KEY_ID"] = server.json("GET", "/session")["principal"].removeprefix("key:")
    around |= {"SCHEMATHESIS_HOOKS": str(CONTRACT / "hooks.py"), "CONTRACT_IMAGE_URL": images.url}
    around["CONTRACT_SCENE_ID"] = scene
    began = time.monotonic()
    with open(folder / "schemathesis.txt", "w") as words:
        command = [str(part) for part in [python.parent / "st", *options]]
        try:
            code = subprocess.run(
                command, stdout=words, stderr=subprocess.STDOUT, env=around, cwd=folder, timeout=FUZZ_SECONDS
            ).returncode
        except subprocess.TimeoutExpired:
            raise Problem(f"Schemathesis did not end within {FUZZ_SECONDS} s; its words are in {words.name}") from None
    if not (folder / "report.json").is_file():
        tail = (folder / "schemathesis.txt").read_text()[-3000:]
        raise Problem(f"Schemathesis ended with exit code {code} and no report\n{tail}")
    report = json.loads((folder / "report.json").read_text())
    report["seconds"], report["answers"] = time.monotonic() - began, answers(folder / "report.ndjson")
    if code != 0:
        print((folder / "schemathesis.txt").read_text()[-20000:], flush=True)
    return report


def answers(path: Path) -> dict:
    """Operation to a count of (meant to be accepted, first digit of the status)."""
    counts = {}
    with open(path) as lines:
        for line in lines:
            recorder = json.loads(line).get("ScenarioFinished", {}).get("recorder") or {}
            for case_id, interaction in recorder.get("interactions", {}).items():
                case = recorder["cases"][case_id]["value"]
                mode = ((case.get("meta") or {}).get("generation") or {}).get("mode")
                status = (interaction.get("response") or {}).get("status_code", 0)
                counts.setdefault(f"{case['method']} {case['path']}", Counter())[(mode == "positive", status // 100)] += 1
    return counts


class ImageServer:
    """An image at an address, for requests that name one."""

    def __enter__(self):
        content = IMAGE.read_bytes()

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                self.send_response(200)
                self.send_header("content-type", "image/png")
                self.send_header("content-length", str(len(content)))
                self.end_headers()
                self.wfile.write(content)

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.port = self.server.server_address[1]
        self.url = f"http://127.0.0.1:{self.port}/table.png"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        return self

    def __exit__(self, *_):
        self.server.shutdown()


class Summary(NamedTuple):
    """What a report counts over all operations."""

    sent: int
    accepted: int
    server_errors: int
    # A row for each kind of mismatch, by MISMATCH_COLUMNS, and how many there were.
    mismatches: list
    count: int


def summary(report: dict) -> Summary:
    totals = sum(report["answers"].values(), Counter())
    found = [[f["code"], f["title"], f["count"], ", ".join(f["operations"])] for f in report["failures"]]
    found += [[e.get("type", "error"), str(e.get("title", e))[:100], 1, ""] for e in report["errors"]]
    accepted, errors = (sum(n for (_, digit), n in totals.items() if digit == wanted) for wanted in (2, 5))
    return Summary(totals.total(), accepted, errors, found, sum(row[2] for row in found))


def page(report: dict, client: dict, typescript: str, given) -> str:
    declared = {name: counts for name, counts in report["answers"].items() if name in operations()}
    rows = []
    for name in sorted(operations()):
        counts = declared.get(name, Counter())
        accepted = [sum(n for key, n in counts.items() if key == (True, digit)) for digit in (2, 3, 4)]
        refused = [sum(n for key, n in counts.items() if key == (False, digit)) for digit in (2, 4)]
        errors = sum(n for (_, digit), n in counts.items() if digit in (0, 5))
        rows.append([name, sum(counts.values()), *accepted, *refused, errors])
    found = summary(report)
    columns = ["operation", "requests", "valid: 2xx", "3xx", "4xx", "invalid: 2xx", "4xx", "5xx or none"]
    text, image = client["text"], client["image as a file"]
    return (
        f"Schemathesis {report['schemathesis_version']}, all its checks, {given.examples} examples an operation, seed "
        f"{report['seed']}: {found.sent} requests in {report['seconds']:.0f} s, {found.server_errors} server errors, "
        f"{found.count} mismatches. `5xx or none` counts server errors and requests without an answer.\n\n"
        + table(columns, rows)
        + ("\n\n" + table(MISMATCH_COLUMNS, found.mismatches) if found.mismatches else "")
        + "\n\nValid requests are answered with 4xx where the scene or the job is not there, is deleted (410), in another "
        "state (409) or has changed (412), or the range is outside the file (416). Invalid requests are answered with 2xx where the "
        "value becomes a valid one on its way, such as a number as text. `tests/contract/hooks.py` replaces what no schema can express in "
        "requests that are meant to be valid: bytes and addresses of images by those of a real image, texts that are only "
        "validated by ones that name an object, settings by the document's examples, times by coming ones, idempotency keys by "
        "new ones.\n\n"
        f"openapi-python-client, without a warning: a text becomes a scene ({text['files']} files in the bundle), so does an "
        f"image as a file ({image['files']} files); each is polled, its bundle and an artifact are downloaded and compared with "
        f"their digest; lists, cancellation, deletion and refusals are read.\n\nopenapi-typescript: {typescript}, under "
        f"`--strict`."
    )


def operations() -> set:
    """Method and path of every operation of the document, found by its indentation."""
    found, path = set(), None
    for line in DOCUMENT.read_text(encoding="utf-8").splitlines():
        if line.startswith("  /"):
            path = line.strip().rstrip(":")
        elif line.startswith("components:"):
            return found
        elif path and line.startswith("    ") and line.strip() in ("get:", "post:", "put:", "patch:", "delete:"):
            found.add(f"{line.strip().rstrip(':').upper()} {path}")
    return found


if __name__ == "__main__":
    run(main)
