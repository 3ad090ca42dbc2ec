"""Robots at work: proposed tasks in generated scenes, the tasks of the paper, and MuJoCo's opinion of both.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.robot [--target-dir target] [--scenes 100] [--tasks 3] \\
        [--seeds 100] [--jobs 2]
        [--only all|scenes|paper|pick_place] [--problems 300] [--repeated 100] [--readers yes|no] [--minutes 0]

`scenes` generated sentences of at least three objects become scenes. For each, `tasks` tasks are proposed, their BDDL
is read by PyPI `bddl`, and they are executed; each task of the paper is executed in its scene with `seeds` seeds by
both robots. MuJoCo repeats what was done from its joint targets (tests/judges/robots/replay.py); of the tasks of the
paper, those of the first `repeated` seeds. `problems` picks and places in the same scenes are planned
(bars/pick_place.py). What was done is kept under the target directory: the same program goes on where it was
interrupted, and records that another machine made are used if they are put there. All of it takes hours on two cores;
`--only` measures one part, and writes its section of the page alone. Nothing new is begun after `minutes` (0: no
limit); without `readers`, the executions whose files other programs read are left out.
"""

import hashlib
import json
import shutil
import statistics
import subprocess
import threading
import time
import zlib
from collections import Counter, defaultdict
from concurrent.futures import ThreadPoolExecutor, as_completed
from functools import partial
from pathlib import Path

from tabletopgen_checks.bars import pick_place
from tabletopgen_checks.bars.page import arguments, percent, table, write, write_section
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.language.generated_sentences import generated
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.processes import run_alone
from tabletopgen_checks.repository import JUDGES
from tabletopgen_checks.scene.generation import generate
from tabletopgen_checks.virtual_environment import environment_of

DEPENDS_ON = (
    "config/robots", "crates/base/geometry", "crates/method/manipulation", "crates/method/physics",
    "crates/method/robot", "crates/method/tasks", "src/pipeline/rehearse", "src/pipeline/rehearse.rs",
    "tests/judges/robots/replay.py", "clients/python/src/tabletopgen/env",
)
CHECK_BDDL = JUDGES / "tasks" / "check_bddl.py"
# The bars.
DONE, AGREED, PAPER = 0.90, 0.95, 0.95
READ_ONE_IN = 30
# A task that takes longer than this to execute is given up.
EXECUTE_S = 600
# Scenes have at least so many objects.
MIN_OBJECTS = 3
# 6 is a task that was attempted and failed, 2 one that is refused.
ATTEMPTED = (0, 6)
KITCHEN = "A kitchen table with a cucumber, a bowl, a carrot, a salt shaker and a cutting board"
COFFEE = "A coffee table with a cup, an apple and a magazine"
PAPER_TASKS = {
    "cucumber": (KITCHEN, "put the cucumber in the bowl"),
    "carrot": (KITCHEN, "put the carrot on the cutting board, then the salt shaker on the cutting board"),
    "swap": (COFFEE, "swap the cup and the apple"),
    "mango": ("A table with a mango and a plate", "put the mango on the plate"),
    "strawberry": ("A table with a strawberry and a mug", "put the strawberry in the mug"),
    "blocks": (
        "A table with a red block, a blue block and a plate",
        "put the red block on the plate, then stack the blue block on the red block",
    ),
}
ROBOTS = ("panda", "piper")
REASONS = {
    "object_too_wide": "a mango, an apple or a cup is wider everywhere than the gripper opens (80 mm of the Panda, 70 mm of"
    " the PiPER, of which 5 mm stay free)",
    "goal_not_met": "the motions were made, and a predicate does not hold: most cucumbers are longer than the bowl is wide and"
    " weigh as much, so that they tip it, or end with their center above or beside it",
    "disturbed_others": "something else was moved by more than the task allows: the bowl, under a cucumber that leans on it",
    "no_path": "no grasp or no place has a free straight motion, or the motion between was not found",
    "table_out_of_reach": "no place for the base reaches both objects",
    "no_grasp": "no grasp held the object in the trials, or the fingers did not get hold of it",
    "no_free_place": "two objects cannot change places: one does not fit where the other is",
    "unreachable": "no configuration of the arm has the hand at a grasp",
    "slipped": "the object moved in the hand, and the goal is not reached",
    "dropped": "the hand lost the object",
}


class Bench:
    """The program, MuJoCo, and what both have done so far."""

    def __init__(self, given):
        with given.binary.open("rb") as program:
            digest = hashlib.file_digest(program, "sha256").hexdigest()[:12]
        self.binary, self.jobs, self.has_readers = given.binary, given.jobs, given.readers == "yes"
        self.ends = time.monotonic() + 60 * given.minutes if given.minutes else float("inf")
        self.making = defaultdict(threading.Lock)
        self.folder = given.work / "robot" / digest
        self.folder.mkdir(parents=True, exist_ok=True)
        self.python = environment_of(given.target_dir, "robot-judges", JUDGES / "robots" / "requirements.txt") / "bin" / "python"

    def scene(self, name: str, text: str, seed: int) -> Path:
        """The bundle of a text."""
        bundle = self.folder / "scenes" / name
        with self.making[name]:
            if not (bundle / "manifest.json").is_file():
                self.expect_time()
                made = generate(self.binary, bundle, text, seed, threads=1)
                if made.printed["verdict"] != "pass":
                    shutil.rmtree(bundle)
                    raise Problem(f"{text!r} is in quarantine: {made.printed['reasons']}")
        return bundle

    def expect_time(self):
        if time.monotonic() > self.ends:
            raise Problem("there was no time left for it")

    def proposed(self, name: str, scene, count: int, seed: int) -> list:
        """Proposed tasks, as they are printed. Their files have to be what the parser of BEHAVIOR reads."""
        path = self.folder / "tasks" / f"{name}.json"
        if path.is_file():
            return json.loads(path.read_text(encoding="utf-8"))
        bundle, out = scene(), self.folder / "out" / f"tasks_{name}"
        self.expect_time()
        shutil.rmtree(out, ignore_errors=True)
        # As the command proposes by default: rehearsed.
        asked = ["tasks", "--bundle", bundle, "--count", count, "--seed", seed, "--out", out, "--json"]
        found = json.loads(self.call(asked, (0,)).stdout)["proposed"]
        if found:
            checked = subprocess.run([self.python, CHECK_BDDL, out], capture_output=True, text=True)
            if checked.returncode != 0:
                raise Problem(f"the BDDL of {out}: {checked.stdout or checked.stderr}")
        shutil.rmtree(out, ignore_errors=True)
        keep(path, found)
        return found

    def executed(self, name: str, scene, task, seed: int, robot: str, is_repeated: bool = True) -> dict:
        """What became of a task (a dictionary, or an instruction) in a scene, and what MuJoCo says of it, if it is
        asked."""
        path = self.folder / "executions" / f"{name}.json"
        if path.is_file():
            return json.loads(path.read_text(encoding="utf-8"))
        # The files of one execution in so many are read by other programs, its video too.
        is_read = zlib.crc32(name.encode()) % READ_ONE_IN == 0
        if is_read and not self.has_readers:
            raise Problem("the readers of its files are not here")
        bundle, out = scene(), self.folder / "out" / name
        self.expect_time()
        shutil.rmtree(out, ignore_errors=True)
        out.parent.mkdir(parents=True, exist_ok=True)
        # An execution is not written into a folder that holds its task.
        source = out.with_name(f"{out.name}.json") if isinstance(task, dict) else task
        if isinstance(task, dict):
            source.write_text(json.dumps(task), encoding="utf-8")
        asked = ["execute", "--bundle", bundle, "--task", source, "--robot", robot, "--seed", seed, "--out", out]
        ran = self.call([*asked, "--json", *(["--video"] if is_read else [])], None)
        record = {"cpu_s": ran.cpu_s, **self.outcome(ran)}
        if record["outcome"] == "done":
            if is_repeated:
                record["replay"] = self.replayed(bundle, out)
            if is_read:
                record["files"] = self.read(out)
        # A task that was refused has no folder.
        shutil.rmtree(out, ignore_errors=True)
        keep(path, record)
        return record

    @staticmethod
    def outcome(ran) -> dict:
        printed = json.loads(ran.stdout) if ran.stdout.startswith("{") else {}
        if ran.exit_code in ATTEMPTED and "execution" in printed:
            execution = printed["execution"]
            return {
                "outcome": execution["failure"] or "done",
                "detail": execution["detail"],
                "instruction": printed["task"]["instruction"],
                "duration_s": execution["duration_s"],
                "slip_m": max((pick["slip_m"] for pick in execution["picks"]), default=0.0),
            }
        failure = printed.get("failure", {})
        code = failure.get("problem", {}).get("code", f"exit {ran.exit_code}")
        return {"outcome": code, "detail": failure.get("message", ran.stderr[-300:])}

    def replayed(self, bundle: Path, out: Path) -> dict:
        command = [self.python, JUDGES / "robots" / "replay.py", self.binary, bundle, out]
        ran = subprocess.run([str(part) for part in command], capture_output=True, text=True)
        if ran.returncode not in (0, 1) or not ran.stdout.startswith("{"):
            raise Problem(f"MuJoCo did not repeat {out.name}: {ran.stderr[-500:]}")
        return json.loads(ran.stdout)

    def read(self, out: Path) -> list:
        """What the readers of the other formats complain about."""
        command = [self.python, JUDGES / "robots" / "scene_files.py", out]
        ran = subprocess.run([str(part) for part in command], capture_output=True, text=True)
        lines = [line for line in ran.stdout.splitlines() if line.startswith("{")]
        return json.loads(lines[-1])["complaints"] if lines else [ran.stderr[-300:]]

    def call(self, words: list, expected):
        command = [str(self.binary), *map(str, words)]
        ran = run_alone(command, EXECUTE_S, {"RAYON_NUM_THREADS": "1", "PATH": "/usr/bin:/bin"})
        if expected is not None and ran.exit_code not in expected:
            raise Problem(f"{' '.join(command)}: {ran.stderr[-500:] or ran.stdout[-500:]}")
        return ran

    def each(self, what: str, every: list, work) -> list:
        """`work` on all of them, `jobs` at once, in their order; a problem is a record with its reason."""
        done = 0

        def safely(one):
            try:
                return work(one)
            except Exception as problem:  # one that fails must not end the measurement of the others
                return [{"outcome": "problem", "detail": str(problem)[:300], "cpu_s": 0.0}]

        with ThreadPoolExecutor(self.jobs) as pool:
            waiting = {pool.submit(safely, one): k for k, one in enumerate(every)}
            found: list = [None] * len(every)
            for future in as_completed(waiting):
                found[waiting[future]] = future.result()
                done += 1
                said = ", ".join(record["outcome"] for record in future.result())
                print(f"[{done}/{len(every)}] {what} {every[waiting[future]]}: {said}", flush=True)
        return found


def keep(path: Path, records):
    path.parent.mkdir(parents=True, exist_ok=True)
    written = path.with_suffix(".part")
    written.write_text(json.dumps(records), encoding="utf-8")
    written.rename(path)


def main() -> bool:
    options = {"scenes": 100, "tasks": 3, "seeds": 100, "jobs": 2, "only": "all", "problems": 300, "readers": "yes"}
    options["repeated"] = 100
    options["minutes"] = 0.0
    given = arguments(__doc__, **options)
    bench = Bench(given)
    parts = {
        "scenes": ("Rehearsed proposals", lambda: in_scenes(bench, given.scenes, given.tasks)),
        "paper": ("Tasks of the paper", lambda: of_paper(bench, given.seeds, given.repeated)),
        "pick_place": (pick_place.HEADING, lambda: pick_place.measure(bench, scene_sentences(), given.problems)),
    }
    every, sections = [], []
    for name, (heading, measure) in parts.items():
        if given.only in ("all", name):
            bars, body = measure()
            every += bars
            sections.append((heading, f"{bar_table(bars)}\n\n{body}"))
    if given.only == "all":
        write("robot", "Robots at work", "\n\n".join(f"## {heading}\n\n{body}" for heading, body in sections), DEPENDS_ON)
    else:
        for heading, body in sections:
            write_section("robot", heading, body, DEPENDS_ON)
    return all(holds for *_, holds in every)


def bar_table(bars: list) -> str:
    rows = [[what, value, f"{100 * bar:g} %", "holds" if holds else "DOES NOT HOLD"] for what, value, bar, holds in bars]
    return table(["", "found", "bar", ""], rows)


def scene_sentences() -> list:
    return [one for one in generated() if one.objects >= MIN_OBJECTS]


def share(what: str, found: int, total: int, bar: float) -> tuple:
    value = found / total if total else 0.0
    return what, f"{percent(value)} of {total}", bar, value >= bar


def agreement(records: list) -> tuple:
    replays = [record["replay"] for record in records if "replay" in record]
    return sum(replay["reached"] for replay in replays), len(replays)


def in_scenes(bench: Bench, scenes: int, count: int) -> tuple:
    wanted = scene_sentences()[:scenes]

    def work(number: int) -> list:
        sentence = wanted[number]
        name = f"scene_{number:03}"
        scene = partial(bench.scene, name, sentence.text, sentence.seed)
        records = []
        for k, proposal in enumerate(bench.proposed(name, scene, count, number)):
            record = bench.executed(f"{name}_{k}", scene, proposal["task"], number, "panda")
            records.append({"kind": proposal["kind"], "instruction": proposal["task"]["instruction"], **record})
        return records

    found = [record for records in bench.each("scene", list(range(len(wanted))), work) for record in records]
    done = [record for record in found if record["outcome"] == "done"]
    agreed, replayed = agreement(found)
    bars = [
        share("Tasks that `tasks` proposes by default (rehearsed) and that are done", len(done), len(found), DONE),
        share("Of these, MuJoCo satisfies the goal too", agreed, replayed, AGREED),
    ]
    read = [record["files"] for record in found if "files" in record]
    if read:
        bars.append(share("Folders of executions that PyBullet, usd-core, pyarrow and PyAV read", read.count([]), len(read), 1.0))
    kinds = sorted({record.get("kind", "") for record in found})
    rows = [
        [kind or "-", len(of), sum(r["outcome"] == "done" for r in of), *agreement(of)[:1], outcomes(of)]
        for kind in kinds
        for of in [[record for record in found if record.get("kind", "") == kind]]
    ]
    failures = [
        f"- {record.get('instruction', '')!r}: {record['outcome']}, {record.get('detail') or 'no detail'}"
        for record in found
        if record["outcome"] != "done"
    ]
    apart = [
        f"- {record['instruction']!r}: {[p['reason'] for p in record['replay']['predicates'] if not p['holds']]}"
        for record in done
        if not record["replay"]["reached"]
    ]
    body = [
        f"{len(wanted)} scenes of generated sentences, up to {count} tasks each that `tabletopgen tasks` proposes for the "
        "Panda by default: rehearsed, so that a grasp holds in simulation and the arm makes the straight motions of each "
        f"step. `--no-rehearse` is not measured here. Half of the executions took at most "
        f"{median(done, 'cpu_s')} s of processor time, grasps included, for {median(done, 'duration_s')} s of motion.",
        table(["kind", "tasks", "done", "MuJoCo agrees", "others"], rows),
    ]
    body += ["What failed:\n\n" + "\n".join(failures)] if failures else []
    complaints = [f"- {complaint}" for files in read for complaint in files]
    body += ["What the readers complain about:\n\n" + "\n".join(complaints)] if complaints else []
    body += ["Where MuJoCo ends elsewhere:\n\n" + "\n".join(apart)] if apart else []
    return bars, "\n\n".join(body)


def median(records: list, key: str) -> str:
    values = [record[key] for record in records]
    return f"{statistics.median(values):.1f}" if values else "-"


def outcomes(records: list) -> str:
    counts = Counter(record["outcome"] for record in records if record["outcome"] != "done")
    return ", ".join(f"{name} {count}" for name, count in counts.most_common()) or "-"


def of_paper(bench: Bench, seeds: int, repeated: int) -> tuple:
    every = [(name, robot, seed) for seed in range(seeds) for name in PAPER_TASKS for robot in ROBOTS]

    def work(one: tuple) -> list:
        name, robot, seed = one
        text, instruction = PAPER_TASKS[name]
        # Two robots and two tasks share scenes.
        scene = partial(bench.scene, f"paper_{'kitchen' if text == KITCHEN else name}_{seed}", text, seed)
        return [bench.executed(f"paper_{name}_{robot}_{seed}", scene, instruction, seed, robot, seed < repeated)]

    found = dict(zip(every, (records[0] for records in bench.each("paper", every, work))))
    bars, rows = [], []
    for name, (_, instruction) in PAPER_TASKS.items():
        for robot in ROBOTS:
            of = [found[name, robot, seed] for seed in range(seeds)]
            done, (agreed, replayed) = sum(r["outcome"] == "done" for r in of), agreement(of)
            bars.append(share(f"{instruction}, {robot}", done, seeds, PAPER))
            rows.append([instruction, robot, seeds, done, f"{agreed} of {replayed}", outcomes(of)])
    body = [
        f"Each seed is another scene of the same text. MuJoCo repeats those of the first {min(repeated, seeds)} seeds.",
        table(["task", "robot", "seeds", "done", "MuJoCo agrees", "others"], rows),
        reasons(list(found.values())),
    ]
    return bars, "\n\n".join(body)


def reasons(records: list) -> str:
    """What limits those that are not done, the most frequent first."""
    counts = Counter(record["outcome"] for record in records if record["outcome"] != "done")
    return "\n".join(f"- `{name}`, {count}: {REASONS.get(name, 'see above')}." for name, count in counts.most_common())


if __name__ == "__main__":
    run(main)
