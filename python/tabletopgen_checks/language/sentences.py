"""The sentences of tests/words/scenes.toml, and whether a scene holds what its sentence asks for."""

import json
import tomllib
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from tabletopgen_checks.repository import WORDS


@dataclass
class Sentence:
    name: str
    family: str
    seed: int
    text: str
    expect: dict
    table: str | None = None
    sample: bool = False
    threads: bool = False
    objects: int = field(init=False)

    def __post_init__(self):
        self.objects = sum(self.expect.values())


def sentences() -> list:
    return [Sentence(**entry) for entry in tomllib.loads((WORDS / "scenes.toml").read_text(encoding="utf-8"))["sentence"]]


def differences(sentence: Sentence, bundle: Path) -> list:
    """What the scene has too much or too little of; empty when all is as asked for."""
    scene = json.loads((bundle / "scene.json").read_text(encoding="utf-8"))
    found = Counter(instance["category"] for instance in scene["instances"])
    wrong = [
        f"{found[category]} {category} instead of {sentence.expect.get(category, 0)}"
        for category in sorted(set(found) | set(sentence.expect))
        if found[category] != sentence.expect.get(category, 0)
    ]
    if sentence.table and scene["table"]["shape"] != sentence.table:
        wrong.append(f"a {scene['table']['shape']} table instead of a {sentence.table} one")
    return wrong
