"""Scenes of several texts by one `tabletopgen batch`."""

import json
import shutil
import subprocess
from pathlib import Path

from tabletopgen_checks.problem import Problem


def batch_of_texts(binary: Path, folder: Path, wanted: list) -> list:
    """Makes the scene of each (id, text, seed) in `folder`, which is emptied first.

    For each in its order: its line of the output or of the errors, `None` if there is none, and the path of its bundle,
    which exists where a scene was made.
    """
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    lines = [json.dumps({"custom_id": id, "body": {"text": text, "seed": seed}}) for id, text, seed in wanted]
    requests = folder / "requests.jsonl"
    requests.write_text("\n".join(lines) + "\n", encoding="utf-8")
    out = folder / "out"
    command = [str(binary), "batch", str(requests), "--out", str(out), "--zip", "--json"]
    ran = subprocess.run(command, capture_output=True, text=True)
    if ran.returncode not in (0, 5):
        raise Problem(f"the batch ended with exit code {ran.returncode}: {ran.stderr.strip()[-1000:]}")
    answers = {}
    for name in ("output.jsonl", "errors.jsonl"):
        for line in (out / name).read_text(encoding="utf-8").splitlines():
            entry = json.loads(line)
            answers[entry["custom_id"]] = entry
    return [(answers.get(id), out / f"{id}.zip") for id, _, _ in wanted]
