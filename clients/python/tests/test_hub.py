"""Uploads by `huggingface_hub` to a server that answers like the Hub."""

from __future__ import annotations

import base64
import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from fake import Answer, Fake, Received, as_json
from tabletopgen import Client, Recording, Scene
from tabletopgen._sync.connection import digest_of

COMMIT = "0" * 40


class Hub:
    """A repository of the Hub: what the endpoints of an upload do with it."""

    def __init__(self) -> None:
        self.created: dict[str, Any] = {}
        self.objects: dict[str, bytes] = {}
        self.files: dict[str, bytes] = {}
        self.tags: list[str] = []
        self.tokens: set[str] = set()
        self.url = ""

    @property
    def address(self) -> str:
        return f"{self.url}/datasets/{self.created['organization']}/{self.created['name']}"

    def answer(self, received: Received) -> Answer:
        path, body = received.path.partition("?")[0], received.body
        if path.startswith("/objects/"):
            self.objects[path.rpartition("/")[2]] = body
            return Answer()
        self.tokens.add(received.headers.get("authorization", ""))
        if path == "/api/repos/create":
            self.created = json.loads(body)
            return as_json({"url": self.address})
        if path.endswith("/preupload/main"):
            # As of the Hub, large or binary files are stored apart.
            kinds = [("lfs" if not is_text(file) else "regular", file["path"]) for file in json.loads(body)["files"]]
            return as_json({"files": [{"path": name, "uploadMode": kind, "shouldIgnore": False} for kind, name in kinds]})
        if path.endswith("/info/lfs/objects/batch"):
            objects = [{**one, "actions": {"upload": {"href": f"{self.url}/objects/{one['oid']}"}}} for one in json.loads(body)["objects"]]
            return as_json({"objects": objects})
        if path.endswith("/commit/main"):
            for line in map(json.loads, body.splitlines()):
                self.commit(line["key"], line["value"])
            return as_json({"success": True, "commitOid": COMMIT, "commitUrl": f"{self.address}/commit/{COMMIT}"})
        if path.endswith("/refs"):
            tags = [{"name": tag, "ref": f"refs/tags/{tag}", "targetCommit": COMMIT} for tag in self.tags]
            return as_json({"branches": [], "converts": [], "tags": tags})
        if "/tag/" in path:
            name = path.rpartition("/tag/")[2]
            if received.method == "DELETE":
                self.tags.remove(name)
            else:
                self.tags.append(json.loads(body)["tag"])
            return as_json({})
        if path == "/api/validate-yaml":
            return as_json({"errors": [], "warnings": []})
        return as_json({"sha": COMMIT, "id": "me/x", "siblings": []})

    def commit(self, kind: str, value: dict[str, str]) -> None:
        if kind == "file":
            self.files[value["path"]] = base64.b64decode(value["content"])
        elif kind == "lfsFile":
            self.files[value["path"]] = self.objects[value["oid"]]


def is_text(file: dict[str, Any]) -> bool:
    return b"\0" not in base64.b64decode(file["sample"]) and file["size"] < 100_000


def pushed(client: Client, call: str, folder: Path) -> Hub:
    """What a program of its own has uploaded; the package reads its environment when it is imported."""
    hub = Hub()
    with Fake(hub.answer) as fake:
        hub.url = fake.url
        variables = {"HF_ENDPOINT": fake.url, "HF_TOKEN": "hf_secret", "HF_HOME": str(folder), "TABLETOPGEN_URL": client._connection.url}
        # The protocol of Xet is that of another server.
        variables |= {"HF_HUB_DISABLE_XET": "1", "HF_HUB_DISABLE_TELEMETRY": "1", "HF_HUB_DISABLE_PROGRESS_BARS": "1"}
        script = f"from tabletopgen import Client\nwith Client() as client:\n    print(client.{call})"
        run = subprocess.run([sys.executable, "-c", script], env=os.environ | variables, capture_output=True, text=True, timeout=120)
        requests = [f"{one.method} {one.path}" for one in fake.received]
    assert run.returncode == 0, f"{run.stderr}\n{requests}"
    assert run.stdout.strip() == hub.address
    assert hub.tokens == {"Bearer hf_secret"} and hub.created["type"] == "dataset"
    return hub


def digests(files: dict[str, bytes]) -> dict[str, str]:
    return {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}


def test_a_dataset_of_scenes_comes_to_the_hub_byte_for_byte(client: Client, made: Scene, tmp_path: Path) -> None:
    dataset = client.freeze_dataset("kitchen-hub", scenes=[made.id], splits={"train": 1.0}).wait()
    hub = pushed(client, f"dataset('{dataset.id}').push_to_hub('me/kitchen', private=True)", tmp_path)
    assert (hub.created["organization"], hub.created["name"]) == ("me", "kitchen")
    assert hub.created["visibility"] == "private"
    assert digests(hub.files) == {file.path: file.sha256 for file in dataset.files()} and hub.tags == []
    assert hub.objects, "large files are stored apart"


def test_a_recording_comes_to_the_hub_with_the_tag_that_lerobot_reads(client: Client, recorded: Recording, tmp_path: Path) -> None:
    hub = pushed(client, f"recording('{recorded.id}').push_to_hub('me/lift')", tmp_path / "home")
    root = recorded.to_lerobot(tmp_path / "dataset")
    assert digests(hub.files) == {str(path.relative_to(root)): digest_of(path) for path in root.rglob("*") if path.is_file()}
    assert hub.tags == ["v3.0"]


def test_the_tag_moves_with_another_upload(client: Client, recorded: Recording, tmp_path: Path) -> None:
    call = f"recording('{recorded.id}')"
    hub = pushed(client, f"{call}.push_to_hub('me/lift') and client.{call}.push_to_hub('me/lift')", tmp_path)
    assert hub.tags == ["v3.0"] and hub.files
