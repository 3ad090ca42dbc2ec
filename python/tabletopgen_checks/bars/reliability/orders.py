"""Work of every kind, ordered over HTTP: the scenes of a batch, executions of a task, a recording, a dataset that is
frozen of the batch, and its verification.
"""

import hashlib
import json

from tabletopgen_checks.bars.recordings import CAMERAS, FORMAT, SENTENCE, SIZE_PX, TASK, archived
from tabletopgen_checks.bars.reliability.scenes import digest_of, request_of
from tabletopgen_checks.problem import Problem

# Seeds of the sentence whose scenes the arm can do the task in; each round has another one.
TASK_SEEDS = (3, 4)
SMALL_SCENES, EXECUTIONS, EPISODES = 2, 2, 3
FINAL = ("succeeded", "failed", "cancelled", "finished")


class Round:
    """One batch, and what is ordered of its scenes; each next order follows as soon as it can."""

    def __init__(self, number: int):
        self.number = number
        self.batch = self.recording = self.dataset = ""
        self.scenes: dict[str, str] = {}
        self.executions: list[str] = []
        self.is_verified = self.is_over = False

    @property
    def is_begun(self) -> bool:
        """Whether its scenes are there."""
        return bool(self.dataset) or self.is_over

    def step(self, api):
        """Orders what can be ordered by now, and sees whether everything has ended."""
        if self.is_over:
            return
        if not self.batch:
            headers = {"content-type": "application/jsonl"}
            self.batch = api.json("POST", "/batches", self.lines(), headers)["id"]
        elif not self.dataset:
            if api.json("GET", f"/batches/{self.batch}")["state"] in FINAL:
                self.order_of_scenes(api)
        else:
            self.is_over = self.dataset_has_ended(api) and all(
                api.json("GET", path)["state"] in FINAL
                for path in (f"/episodes/{self.recording}", *(f"/jobs/{job}" for job in self.executions))
            )

    def lines(self) -> bytes:
        """The requests of the batch: a scene with a task, and small ones."""
        numbers = range(self.number * SMALL_SCENES, (self.number + 1) * SMALL_SCENES)
        requests = [(SENTENCE, TASK_SEEDS[self.number % len(TASK_SEEDS)]), *map(request_of, numbers)]
        lines = [
            {"custom_id": f"scene{k}", "body": {"text": text, "seed": seed}} for k, (text, seed) in enumerate(requests)
        ]
        return "".join(json.dumps(line) + "\n" for line in lines).encode()

    def order_of_scenes(self, api):
        status, _, content = api.request("GET", f"/batches/{self.batch}/output")
        if status != 200:
            raise Problem(f"the output of batch {self.batch} was answered with {status}")
        results = [json.loads(line) for line in content.splitlines()]
        self.scenes = {one["custom_id"]: one["scene_id"] for one in results if one["state"] == "succeeded"}
        if "scene0" not in self.scenes:
            # Nothing more can be ordered; what is missing is found when results are compared.
            self.is_over = True
            return
        scene = f"/scenes/{self.scenes['scene0']}"
        self.executions = [
            api.json("POST", f"{scene}/executions", {"text": TASK, "seed": seed})["id"] for seed in range(EXECUTIONS)
        ]
        order = {"task": TASK, "count": EPISODES, "seed": self.number, "formats": [FORMAT], "title": "kinds"}
        order["record"] = {"cameras": CAMERAS, "size_px": SIZE_PX}
        self.recording = api.json("POST", f"{scene}/episodes", order)["id"]
        dataset = {"name": f"kinds{self.number}", "batch": self.batch, "splits": {"train": 1.0}}
        self.dataset = api.json("POST", "/datasets", dataset)["id"]

    def dataset_has_ended(self, api) -> bool:
        """Whether the dataset is verified or has failed; a frozen one is to be verified."""
        view = api.json("GET", f"/datasets/{self.dataset}")
        if view["state"] == "finished" and not self.is_verified:
            api.json("POST", f"/datasets/{self.dataset}/verify")
            self.is_verified = True
            return False
        return view["state"] == "failed" or (view["verification"] or {}).get("state") == "finished"

    def expected(self) -> list:
        """The names of all results."""
        scenes = [f"scene{k}" for k in range(SMALL_SCENES + 1)]
        executions = [f"execution{k}" for k in range(EXECUTIONS)]
        return [f"{name} of round {self.number}" for name in (*scenes, *executions, "recording", "dataset")]

    def results(self, api) -> dict:
        """Parts of each result that is there, with their digests, by its name."""
        found = {name: {"bundle": digest_of(api, scene)} for name, scene in self.scenes.items()}
        for k, job in enumerate(self.executions):
            if (answer := content_of(api, f"/executions/{job}")) is not None:
                found[f"execution{k}"] = {"answer": hashlib.sha256(answer).hexdigest()}
        if self.recording and (archive := content_of(api, f"/episodes/{self.recording}/archives/{FORMAT}")) is not None:
            found["recording"] = archived(archive)
        if self.dataset and (archive := content_of(api, f"/datasets/{self.dataset}/archive")) is not None:
            view = api.json("GET", f"/datasets/{self.dataset}")
            found["dataset"] = {
                "manifest": view["digest"],
                "archive": hashlib.sha256(archive).hexdigest(),
                "verification": json.dumps(view["verification"], sort_keys=True),
            }
        return {f"{name} of round {self.number}": parts for name, parts in found.items()}


def content_of(api, path: str):
    """The bytes of a result; None where there is none."""
    status, _, content = api.request("GET", path, timeout=300)
    return content if status == 200 else None


def differences(calm: dict, found: dict) -> list:
    """What is missing, and what is another, than in the results of an undisturbed run."""
    wrong = [f"lost: {name} is missing" for name in calm if name not in found]
    for name, parts in found.items():
        known = calm.get(name, {})
        different = [part for part in sorted(parts.keys() | known.keys()) if parts.get(part) != known.get(part)]
        if different:
            wrong.append(f"bytes: {name} differs in {', '.join(different[:5])}")
    return wrong
