"""What one scene costs a machine: processor time, memory, transactions, bytes. The sizing of docs/operations.md uses
it.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.sizing [--target-dir target] [--scenes 12]

The sample sentences one after the other, with one slot, on a fresh data directory with fsync; each is measured by the
server's own metrics before and after. Then the same sentences with 2 and with 4 slots, for the memory and the rate.
"""

import os
import re
import shutil
import time
from pathlib import Path

from tabletopgen_checks.bars.page import SCENES_OF_TEXTS, arguments, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.language.sentences import sentences
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.service.server import Server

DEPENDS_ON = (*SCENES_OF_TEXTS, "src/worker", "src/worker.rs")
SLOTS = (1, 2, 4)
SCENE_SECONDS = 300
MEGABYTE = 1e6


def main() -> bool:
    given = arguments(__doc__, scenes=12)
    chosen = sorted(sentences(), key=lambda sentence: not sentence.sample)[: given.scenes]
    folder = given.work / "sizing"
    each, idle_mb = one_by_one(given, folder, chosen)
    rows = [[name, *spread([scene[name] for scene in each])] for name in each[0]]
    body = (
        f"{len(each)} sentences with {sum(s.objects for s in chosen)} objects, one after the other with one slot, fsync "
        f"on. A server without jobs holds {idle_mb:.0f} MB.\n\n"
        + table(["of one scene", "mean", "least", "most"], rows)
        + "\n\nThe same sentences submitted at once:\n\n"
        + table(["slots", "seconds in all", "scenes per hour", "cores used", "most memory, MB"], at_once(given, folder, chosen))
        + "\n\nDisk and files count the data directory as it lies, with all artifacts; `database` is its SQLite file."
    )
    write("sizing", "What one scene costs", body, DEPENDS_ON)
    return all(scene["processor time, s"] > 0 for scene in each)


def one_by_one(given, folder, chosen):
    """What each scene took, and the memory of the idle server, megabytes."""
    each = []
    with fresh_server(given, folder, 1) as server:
        idle = memory_mb(server, "VmRSS")
        for sentence in chosen:
            before, started = taken(server, folder), time.monotonic()
            scene = server.submit_text(sentence.text, sentence.seed)
            job = server.wait(scene["job"]["id"], SCENE_SECONDS)
            if job["state"] != "succeeded":
                raise Problem(f"the scene {sentence.name} ended as {job['state']}: {job.get('failure')}")
            wall = time.monotonic() - started
            _, _, bundle = server.request("GET", f"/scenes/{scene['id']}/bundle", timeout=120)
            after = taken(server, folder)
            each.append({"wall time, s": wall} | {name: after[name] - before[name] for name in before})
            each[-1]["bundle, MB"] = len(bundle) / MEGABYTE
            each[-1]["blobs read, MB"] -= len(bundle) / MEGABYTE
            print(f"{sentence.name}: {each[-1]}", flush=True)
    return each, idle


def at_once(given, folder, chosen):
    rows = []
    for slots in SLOTS:
        with fresh_server(given, folder, slots) as server:
            before, started = processor_s(server), time.monotonic()
            scenes = [server.submit_text(sentence.text, sentence.seed) for sentence in chosen]
            for scene in scenes:
                server.wait(scene["job"]["id"], SCENE_SECONDS * len(chosen))
            wall, used = time.monotonic() - started, processor_s(server) - before
            rows.append(
                [slots, f"{wall:.1f}", f"{3600 * len(scenes) / wall:.0f}", f"{used / wall:.2f}", f"{memory_mb(server, 'VmHWM'):.0f}"]
            )
            print(rows[-1], flush=True)
    return rows


def taken(server, folder) -> dict:
    """Counters of the server and sizes on disk, so far."""
    exposed = server.request("GET", "/metrics")[2].decode()

    def metric(name):
        found = re.search(rf"^{name} (\S+)$", exposed, re.M)
        if not found:
            raise Problem(f"the server does not expose {name}")
        return float(found.group(1))

    files = [path for path in (folder / "data").rglob("*") if path.is_file()]
    return {
        "processor time, s": processor_s(server),
        "write transactions": metric("tabletopgen_store_write_seconds_count"),
        "blobs written, MB": metric("tabletopgen_blob_written_bytes_total") / MEGABYTE,
        "blobs read, MB": metric("tabletopgen_blob_read_bytes_total") / MEGABYTE,
        "disk, MB": sum(path.stat().st_size for path in files) / MEGABYTE,
        "files": len(files),
        "database, MB": (folder / "data" / "tabletopgen.sqlite").stat().st_size / MEGABYTE,
    }


def processor_s(server) -> float:
    """User and system time of the process, seconds."""
    fields = Path(f"/proc/{server.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_mb(server, name) -> float:
    status = Path(f"/proc/{server.pid}/status").read_text()
    found = dict(re.findall(r"^(\w+):\s+(\d+) kB", status, re.M))
    return int(found[name]) * 1024 / MEGABYTE


def spread(values):
    digits = 0 if min(values) >= 20 else 2
    return [f"{value:.{digits}f}" for value in (sum(values) / len(values), min(values), max(values))]


def fresh_server(given, folder, slots) -> Server:
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "data").mkdir(parents=True)
    return Server(given.binary, folder / "data", folder / "log", arguments=["--set", f"worker.concurrency={slots}"])


if __name__ == "__main__":
    run(main)
