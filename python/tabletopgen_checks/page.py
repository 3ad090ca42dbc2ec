"""The page of the server in studio/: its types, its tests, and the page in a browser.

    PYTHONPATH=python python3 -m tabletopgen_checks.page [--target-dir target] [--program target/release/tabletopgen]

The program must hold the page: `make studio` comes before its build. CHROMIUM names the browser.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import ROOT

STUDIO = ROOT / "studio"
TYPES = STUDIO / "src" / "api" / "schema.d.ts"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


def check(program: Path) -> str:
    """Runs what this machine can; a sentence that also says what was left out."""
    if not shutil.which("npm"):
        return "LEFT OUT: there is no npm, so the program is without its page"
    run([ROOT / "scripts" / "studio.sh"])
    check_types()
    counts = [f"{passed(run(['npm', 'test', '--silent']))} tests"]
    browser = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser:
        variables = {"TABLETOPGEN": str(program), "CHROMIUM": browser}
        counts.append(f"{passed(run(['npm', 'run', 'test:browser', '--silent'], variables))} in a browser")
    else:
        counts.append("LEFT OUT: the tests in a browser (no Chromium; Debian: apt install chromium)")
    return "; ".join(counts)


def check_types():
    """The types of requests and answers are those of openapi.yaml."""
    committed = TYPES.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        kept = Path(folder) / TYPES.name
        shutil.copy2(TYPES, kept)
        try:
            run(["npm", "run", "schema", "--silent"])
            made = TYPES.read_text(encoding="utf-8")
        finally:
            # With its time: a source that is newer than the page would have it built again.
            shutil.copy2(kept, TYPES)
    if made != committed:
        raise Problem(f"{TYPES.relative_to(ROOT)} is not of this openapi.yaml; run `npm run schema` in studio/")


def run(command: list, variables=None) -> str:
    """The output of a command in the folder of the page, which is shown as it comes."""
    words, lines = [str(part) for part in command], []
    environment = os.environ | (variables or {})
    with subprocess.Popen(
        words, cwd=STUDIO, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True, errors="replace"
    ) as process:
        for line in process.stdout or ():
            sys.stdout.write(line)
            sys.stdout.flush()
            lines.append(line)
    if process.returncode != 0:
        raise Problem(f"`{' '.join(words)}` in studio/ ended with exit code {process.returncode}; see above")
    return "".join(lines)


def passed(output: str) -> int:
    """The number of tests by the last lines of node's runner."""
    found = re.findall(r"^(?:#|ℹ) pass (\d+)$", output, re.MULTILINE)
    if not found or int(found[-1]) == 0:
        raise Problem("no test of the page ran")
    return int(found[-1])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target-dir", type=Path, default=ROOT / "target")
    parser.add_argument("--program", type=Path)
    given = parser.parse_args()
    print(check((given.program or given.target_dir / "release" / "tabletopgen").resolve()))
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Problem as problem:
        sys.exit(str(problem))
