"""Finished scenes of texts, made beside each other; one that cannot be made or measured is a failure with its reason.

Scenes are kept as records in a folder named by the digest of the program, so that an interrupted measurement goes on
where it stopped, and a new program starts anew. A text that gave no scene has no record: it is tried again.
"""

import hashlib
import json
import shutil
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from tabletopgen_checks.language.description import Described
from tabletopgen_checks.language.measured import Measured
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.scene.generation import generate
from tabletopgen_checks.scene.scene import Scene, read_scene

# What measuring needs of an instance and a table.
INSTANCE = (
    "name", "label", "category", "translation_m", "rotation_xyzw", "yaw_rad", "symmetry_order", "size_m", "mass_kg", "friction",
    "center_of_mass_m", "support",
)
TABLE = ("shape", "outline_m", "size_m")


@dataclass
class SceneText:
    """A text to make a scene of, with what the parser made of it for the same seed."""

    name: str
    text: str
    seed: int
    outcome: dict


class SceneOutcome:
    """One scene, or why there is none."""

    def __init__(self, wanted: SceneText, record=None, failure=""):
        self.failure, self.view = failure, None
        record = record or {}
        self.cpu_s = record.get("cpu_s")
        self.reasons = record.get("reasons", [])
        self.unmet = record.get("unmet", [])
        self.certified = record.get("verdict") == "pass"
        if record:
            try:
                scene = Scene(record["scene"], record["hulls"])
                self.view = Measured(scene, Described(wanted.outcome["description"]))
            except Exception as error:  # a scene that cannot be measured fails, whatever it is that is wrong
                self.failure = f"the scene cannot be measured: {error!r}"

    def complaints(self, of_view) -> list:
        """What is not as the text asks for, by `of_view` of the measured scene; a scene in quarantine holds nothing."""
        if self.view is None:
            return [self.failure]
        wrong = [] if self.certified else [f"quarantine: {'; '.join(self.reasons) or 'no reason'}"]
        if differing := self.view.differences():
            return wrong + differing
        try:
            return wrong + of_view(self.view)
        except Exception as error:
            return wrong + [f"the scene cannot be measured: {error!r}"]

    def tells(self) -> bool:
        """Whether the program itself says that something is not as the text asks for."""
        return bool(self.failure or self.reasons or self.unmet or not self.certified)


class SceneMaker:
    """Makes scenes with one program, `jobs` at once, and keeps a record of each in `folder`."""

    def __init__(self, binary: Path, folder: Path, jobs: int = 2, threads: int = 1):
        if not binary.is_file():
            raise Problem(f"there is no {binary}; build it with `make build`")
        with binary.open("rb") as program:
            digest = hashlib.file_digest(program, "sha256").hexdigest()[:12]
        self.binary, self.folder, self.jobs, self.threads = binary, folder / digest, jobs, threads
        for other in folder.glob("*") if folder.is_dir() else ():
            if other != self.folder and other.is_dir():
                shutil.rmtree(other, ignore_errors=True)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.began, self.done = time.monotonic(), 0

    def make(self, every: list) -> dict:
        """Name to `SceneOutcome` of all of them, each shown when it is done."""
        finished, self.began, self.done = {}, time.monotonic(), 0
        pool = ThreadPoolExecutor(self.jobs)
        try:
            waiting = {pool.submit(self.made, wanted): wanted for wanted in every}
            for future in as_completed(waiting):
                wanted = waiting[future]
                finished[wanted.name] = future.result()
                self.show(wanted, finished[wanted.name], len(every))
        finally:
            pool.shutdown(cancel_futures=True)
        return finished

    def made(self, wanted: SceneText) -> SceneOutcome:
        record = self.recorded(wanted)
        if record is None:
            try:
                record = self.make_record(wanted)
            except Exception as problem:  # whatever one scene trips over must not end the measurement of the others
                lines = str(problem).strip().splitlines() or [repr(problem)]
                reason = lines[-1].strip() if isinstance(problem, Problem) else repr(problem)
                return SceneOutcome(wanted, failure=f"no scene: {reason}")
        return SceneOutcome(wanted, record)

    def again(self, wanted: SceneText) -> SceneOutcome:
        """Makes a scene once more, alone; the record keeps the lesser time. Without a second scene the first counts."""
        before = self.recorded(wanted)
        try:
            record = self.make_record(wanted)
        except Problem:
            return SceneOutcome(wanted, before)
        if before is not None and before["cpu_s"] < record["cpu_s"]:
            self.keep(wanted, before)
            record = before
        return SceneOutcome(wanted, record)

    def make_record(self, wanted: SceneText) -> dict:
        out = self.folder / wanted.name
        made = generate(self.binary, out, wanted.text, wanted.seed, threads=self.threads)
        scene = read_scene(out)
        record = {
            "text": wanted.text,
            "seed": wanted.seed,
            "verdict": made.printed["verdict"],
            "reasons": made.printed["reasons"],
            "cpu_s": made.cpu_s,
            "unmet": scene.scene.get("text", {}).get("unmet", []),
            "scene": {
                "table": {key: scene.table[key] for key in TABLE},
                "instances": [{key: one[key] for key in INSTANCE} for one in scene.scene["instances"]],
            },
            "hulls": {name: [body.outline()] for name, body in scene.bodies.items()},
        }
        self.keep(wanted, record)
        # A bundle with nothing wrong is not needed any more, and a thousand would fill the disk.
        if record["verdict"] == "pass":
            shutil.rmtree(out, ignore_errors=True)
        return record

    def keep(self, wanted: SceneText, record: dict):
        path = self.path(wanted)
        written = path.with_suffix(".new")
        written.write_text(json.dumps(record), encoding="utf-8")
        written.replace(path)

    def recorded(self, wanted: SceneText):
        try:
            record = json.loads(self.path(wanted).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return record if "hulls" in record and (record["text"], record["seed"]) == (wanted.text, wanted.seed) else None

    def path(self, wanted: SceneText) -> Path:
        return self.folder / f"{wanted.name}.json"

    def show(self, wanted: SceneText, found: SceneOutcome, total: int):
        self.done += 1
        left = (time.monotonic() - self.began) / self.done * (total - self.done) / 60
        said = found.failure or f"{'pass' if found.certified else 'quarantine'} in {found.cpu_s:.1f} CPU s"
        print(f"[{self.done}/{total}] {wanted.name}: {said[:200]} (about {left:.0f} min left)", flush=True)
