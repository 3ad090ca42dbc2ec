"""`make demo`: a sentence and an image go in, two bundles come out. Standard library only, of Python 3.9 or later;
scripts/demo.sh does the same without a Python and without the server.

    PYTHONPATH=python python3 -m tabletopgen_checks.demo --binary target/release/tabletopgen [--out out] [--text T]
        [--image F] [--seed N]

Starts the server on its embedded defaults (any free port, temporary data), submits both, shows what
happens, downloads and unpacks both bundles, prints their certificates and stops the server.
"""

import argparse
import contextlib
import errno
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import ROOT
from tabletopgen_checks.scene.unpacking import print_certificate, unpack
from tabletopgen_checks.service.server import Server, loopback_works

TEXT = (
    "A wooden desk with a laptop, a mug with two pencils in it, three books stacked on each other, a plate with two apples "
    "and a potted plant"
)
# Two bundles, their archives and the server's data take some 100 MB.
NEEDED_BYTES = 500_000_000
JOB_SECONDS = 600


def main() -> int:
    parser = argparse.ArgumentParser(description="Make two scenes through the server and unpack them.")
    parser.add_argument("--binary", type=Path, default=ROOT / "target/release/tabletopgen")
    parser.add_argument("--out", type=Path, default=ROOT / "out")
    parser.add_argument("--text", default=TEXT)
    parser.add_argument("--image", type=Path, default=ROOT / "docs/demo_table.png")
    parser.add_argument("--seed", type=int, default=7)
    arguments = parser.parse_args()
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.default_int_handler)
    log = arguments.out / "server.log"
    try:
        make_room(arguments.out)
        image = read_image(arguments.image)
        loopback_works()
        log.unlink(missing_ok=True)
        with temporary_data() as data, Server(arguments.binary, data, log) as server:
            version = server.json("GET", "/version")["version"]
            print(f"tabletopgen {version} listens on http://127.0.0.1:{server.port} (until this demo ends)\n")
            print(f"the sentence: {arguments.text}")
            make(server, server.submit_text(arguments.text, arguments.seed), arguments.out, "sentence")
            print(f"the image: {arguments.image} ({len(image)} bytes, nothing else is known about it)")
            make(server, server.submit_image(image, arguments.seed), arguments.out, "image")
        print(f"done; see {arguments.out}/sentence/preview and {arguments.out}/image/preview,")
        print("or load a scene as the README.md beside it says; the server has stopped")
        return 0
    except KeyboardInterrupt:
        print("\nstopped; the server is gone and its temporary data too", file=sys.stderr)
        return 130
    except Problem as problem:
        print(f"\nthe demo did not finish: {problem}", file=sys.stderr)
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            print(f"\nthe demo did not finish: the disk is full ({error.filename or arguments.out})", file=sys.stderr)
        else:
            print(f"\nthe demo did not finish: {error}", file=sys.stderr)
    return 1


@contextlib.contextmanager
def temporary_data():
    """A folder that is gone afterwards; what cannot be removed is no reason to fail."""
    folder = Path(tempfile.mkdtemp(prefix="tabletopgen-demo-"))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def make_room(out: Path):
    out.mkdir(parents=True, exist_ok=True)
    for folder in (out, Path(tempfile.gettempdir())):
        free = shutil.disk_usage(folder).free
        if free < NEEDED_BYTES:
            raise Problem(f"{folder} has {free // 10**6} MB left and {NEEDED_BYTES // 10**6} MB are needed; free some")


def read_image(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise Problem(f"the image {path} cannot be read: {error.strerror}") from error


def make(server, scene, out: Path, name: str):
    """Follows the scene's job to its end, then downloads and unpacks the bundle."""
    start = time.monotonic()
    follow(server, scene["job"]["id"], start)
    scene = server.json("GET", f"/scenes/{scene['id']}")
    if scene["state"] != "ready":
        failure = scene["failure"] or {"message": "no reason was given", "code": scene["state"]}
        raise Problem(f"no scene came of the {name}: {failure['message']} ({failure['code']})\n{server.words()}")
    took = time.monotonic() - start
    content = server.download(scene["links"]["bundle"], out / f"{name}.zip")
    folder = unpack(out / f"{name}.zip", out / name)
    print(f"  {took:.1f} s; {len(content) / 1e6:.1f} MB in {out / name}.zip, unpacked to {folder}\n  certificate")
    print_certificate(folder)
    print(flush=True)


def follow(server, job_id, start):
    """A line as each stage begins and ends, as the server's events tell it."""
    work_ms, instances = Counter(), Counter()
    for event in server.events(job_id, deadline=time.monotonic() + JOB_SECONDS):
        kind, data = event["kind"], event["data"]
        at = f"  {time.monotonic() - start:6.2f} s  "
        stage = data.get("stage")
        if kind == "stage_started" and stage not in work_ms:
            work_ms[stage] = 0
            print(f"{at}{stage:<13} ...", flush=True)
        elif kind == "stage_finished":
            work_ms[stage] += data["elapsed_ms"]
            instances[stage] += 1
            of = f"{data['instance']} ({instances[stage]})" if "instance" in data else "done"
            print(f"{at}{stage:<13} {of}, {work_ms[stage]} ms of work", flush=True)
        elif kind == "stage_progress":
            print(f"{at}{data['stage']:<13} {data['message']}", flush=True)
        elif kind == "job_retrying":
            print(f"{at}trying again: {data['failure']['message']}", flush=True)


if __name__ == "__main__":
    sys.exit(main())
