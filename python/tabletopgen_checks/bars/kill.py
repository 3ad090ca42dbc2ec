"""`kill -9` at each stage boundary: the job finishes, no finished stage runs again, the bundle is the same.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.kill [--target-dir target]

For each stage a fresh data directory: submit, follow the events, kill the server the moment the last
finish event of that stage arrives, start it again on the same data, wait, compare.
"""

import shutil
import time

from tabletopgen_checks.bars.page import arguments, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.language.sentences import sentences
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.service.server import Server

DEPENDS_ON = (
    "crates/server/store", "src/pipeline.rs", "src/pipeline/checkpoint", "src/pipeline/checkpoint.rs", "src/worker",
    "src/worker.rs",
)
SENTENCE = "sewing_triangle"
JOB_SECONDS = 300


def main() -> bool:
    given = arguments(__doc__)
    sentence = next(s for s in sentences() if s.name == SENTENCE)
    folder = given.work / "kill"
    with fresh_server(given, folder) as server:
        scene = server.submit_text(sentence.text, sentence.seed)
        events = list(server.events(scene["job"]["id"], deadline=time.monotonic() + JOB_SECONDS))
        undisturbed = bundle_of(server, scene["id"])
    finishes = [about(event) for event in events if event["kind"] == "stage_finished"]
    stages = list(dict.fromkeys(stage for stage, _ in finishes))
    rows, held = [], True
    for stage in stages:
        count = sum(1 for name, _ in finishes if name == stage)
        row = kill_after(given, folder, sentence, stage, count, undisturbed)
        print(", ".join(map(str, row)), flush=True)
        held &= row[3:] == ["succeeded", "none", "same bytes"]
        rows.append(row)
    columns = ["killed after", "of its instances", "stages finished before", "job", "finished stages run again", "bundle"]
    body = (
        f"{len(stages)} stages, one `kill -9` after each, on fresh data each time; the bundle is compared with the one "
        f"of an undisturbed run.\n\nSentence ({sentence.objects} objects, seed {sentence.seed}): {sentence.text}\n\n"
        + table(columns, rows)
    )
    write("kill", "Killed at every stage boundary", body, DEPENDS_ON)
    return held and len(stages) >= 12


def kill_after(given, folder, sentence, stage, count, undisturbed) -> list:
    server = fresh_server(given, folder)
    finished, seen, last = set(), 0, 0
    with server:
        scene = server.submit_text(sentence.text, sentence.seed)
        job_id = scene["job"]["id"]
        for event in server.events(job_id, deadline=time.monotonic() + JOB_SECONDS):
            last = event["seq"]
            if event["kind"] == "stage_finished":
                finished.add(about(event))
                seen += about(event)[0] == stage
            if seen == count:
                server.kill()
                break
        else:
            raise Problem(f"the job ended before {count} instances of {stage} had finished")
    with Server(given.binary, folder / "data", folder / "log") as server:
        job = server.wait(job_id, JOB_SECONDS)
        # The kill may come after more was committed than was seen: what the new process found counts.
        again = {about(e) for e in server.events_after(job_id, last) if e["kind"] == "stage_started"} & finished
        stages = server.json("GET", f"/jobs/{job_id}/stages")["stages"]
        again |= {
            (s["stage"], s.get("instance"))
            for s in stages
            if (s["stage"], s.get("instance")) in finished and s["runs"] > 1
        }
        same = job["state"] == "succeeded" and bundle_of(server, scene["id"]) == undisturbed
    repeated = ", ".join(sorted(f"{name} {instance or ''}".strip() for name, instance in again)) or "none"
    return [stage, count, len(finished), job["state"], repeated, "same bytes" if same else "OTHER BYTES"]


def about(event):
    return event["data"]["stage"], event["data"].get("instance")


def fresh_server(given, folder) -> Server:
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "data").mkdir(parents=True)
    return Server(given.binary, folder / "data", folder / "log")


def bundle_of(server, scene_id) -> bytes:
    status, _, content = server.request("GET", f"/scenes/{scene_id}/bundle", timeout=120)
    if status != 200:
        raise Problem(f"the bundle of {scene_id} was answered with {status}")
    return content


if __name__ == "__main__":
    run(main)
