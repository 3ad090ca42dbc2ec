"""Several processes record one dataset, and one of them is killed: PostgreSQL, an S3 server, an interface and two
workers.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.recordings [--target-dir target] [--count 40] [--kills 3]

A scene is made, and episodes of a task in it are ordered over HTTP. While they are recorded, a worker is killed with
SIGKILL at random times and another begins in its place. The dataset has to be the one that `tabletopgen episodes`
writes for the same bundle, byte for byte.
"""

import hashlib
import io
import random
import subprocess
import tarfile
import time
import uuid
from contextlib import ExitStack
from pathlib import Path

from tabletopgen_checks.bars.page import arguments, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.processes import output_of
from tabletopgen_checks.service.postgres import Postgres
from tabletopgen_checks.service.s3 import S3
from tabletopgen_checks.service.server import Server

DEPENDS_ON = (
    "crates/data/demonstrations", "crates/data/episodes", "crates/server/store", "src/recorder", "src/recorder.rs",
    "src/worker", "src/worker.rs",
)
SENTENCE, SCENE_SEED = "A table with a block and a plate", 3
TASK, SEED, TITLE = "put the block on the plate", 5, "dataset"
FORMAT, CAMERAS, SIZE_PX = "parquet-png", ["front"], 32
LEASE_S, DEADLINE_S = 15, 900


def main() -> bool:
    given = arguments(__doc__, count=40, kills=3)
    folder = given.work / "recordings"
    subprocess.run(["rm", "-rf", folder], check=True)
    folder.mkdir(parents=True)
    with ExitStack() as stack:
        postgres = stack.enter_context(Postgres(given.target_dir))
        s3 = stack.enter_context(S3(given.target_dir, folder / "s3.log"))
        database, bucket = f"recordings_{uuid.uuid4().hex[:8]}", "recordings"
        postgres.create(database)
        s3.create(bucket)
        settings = {"store.database": postgres.url(database), **s3.settings(bucket), "worker.lease_secs": LEASE_S,
                    "worker.heartbeat_secs": 3, "store.s3.retry_secs": 3}
        words = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]

        def server(name: str, role: str) -> Server:
            return Server(given.binary, folder / name, folder / f"{name}.log", s3.environment(), words, role)

        api = stack.enter_context(server("api", "api"))
        names = iter(f"worker_{number}" for number in range(given.kills + 2))
        workers = [stack.enter_context(server(next(names), "worker")) for _ in range(2)]
        made = api.submit_text(SENTENCE, SCENE_SEED)
        wait_for_scene(api, made["job"]["id"])
        bundle = folder / "scene.zip"
        api.download(f"/scenes/{made['id']}/bundle", bundle)
        order = {"task": TASK, "count": given.count, "seed": SEED, "formats": [FORMAT], "title": TITLE,
                 "record": {"cameras": CAMERAS, "size_px": SIZE_PX}}
        recording = api.json("POST", f"/scenes/{made['id']}/episodes", order)["id"]
        kills = recorded(api, recording, workers, lambda: stack.enter_context(server(next(names), "worker")), given.kills)
        status, _, archive = api.request("GET", f"/episodes/{recording}/archives/{FORMAT}", timeout=300)
        if status != 200:
            raise Problem(f"the archive was answered with {status}")
    over_http = archived(archive)
    output_of(given.binary, "episodes", "--scene", bundle, "--task", TASK, "--count", given.count, "--seed", SEED, "--out",
         folder / TITLE, "--format", FORMAT, "--cameras", ",".join(CAMERAS), "--size", SIZE_PX, "--json")
    alone = of_folder(folder / TITLE / FORMAT)
    differing = sorted(path for path in over_http.keys() | alone.keys() if over_http.get(path) != alone.get(path))
    holds = not differing and kills == given.kills
    rows = [
        ["Workers killed while they recorded", kills, given.kills, "holds" if kills == given.kills else "DOES NOT HOLD"],
        [f"Files that differ from those of the command, of {len(alone)}", len(differing), 0,
         "DOES NOT HOLD" if differing else "holds"],
    ]
    body = [
        table(["", "found", "bar", ""], rows),
        f"{given.count} episodes of \"{TASK}\" in a scene of the sentence \"{SENTENCE}\", ordered over HTTP: one process with the "
        f"interface, two workers, PostgreSQL and an S3 server. A killed worker's attempts are free again after {LEASE_S} s.",
    ]
    body += ["What differs:\n\n" + "\n".join(f"- {path}" for path in differing[:20])] if differing else []
    write("recordings", "Datasets recorded by several processes", "\n\n".join(body), DEPENDS_ON)
    return holds


def wait_for_scene(api: Server, job: str):
    until = time.monotonic() + DEADLINE_S
    while (state := api.json("GET", f"/jobs/{job}")["state"]) != "succeeded":
        if state in ("failed", "cancelled") or time.monotonic() > until:
            raise Problem(f"the scene was not made: its job is {state}")
        time.sleep(0.2)


def recorded(api: Server, recording: str, workers: list, another, kills: int) -> int:
    """Waits for the dataset and kills workers in turn; how many there were."""
    chance, done, until = random.Random(3), 0, time.monotonic() + DEADLINE_S
    next_kill = time.monotonic() + chance.uniform(5.0, 8.0)
    while time.monotonic() < until:
        view = api.json("GET", f"/episodes/{recording}")
        if view["state"] == "finished":
            return done
        if view["state"] in ("failed", "cancelled"):
            raise Problem(f"the recording ended: {view}")
        if done < kills and time.monotonic() > next_kill and view["state"] == "running":
            workers.pop(0).kill()
            workers.append(another())
            done += 1
            next_kill = time.monotonic() + chance.uniform(4.0, 8.0)
        time.sleep(0.3)
    raise Problem(f"the recording took longer than {DEADLINE_S} s: {view}")


def archived(archive: bytes) -> dict:
    """Digests of the files of a format's archive, by their paths below its folder."""
    with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
        members = [member for member in tar.getmembers() if member.isfile()]
        files = {member.name.split("/", 1)[1]: tar.extractfile(member) for member in members}
        return {name: digest(file.read()) for name, file in files.items() if file is not None}


def of_folder(folder: Path) -> dict:
    files = [path for path in folder.rglob("*") if path.is_file()]
    return {str(path.relative_to(folder)): digest(path.read_bytes()) for path in files}


def digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


if __name__ == "__main__":
    run(main)
