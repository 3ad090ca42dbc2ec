"""Sentences with what they ask for, and whether a scene is as its sentence says."""

import tomllib
from dataclasses import dataclass

from tabletopgen_checks.language.expectations import complaints
from tabletopgen_checks.language.measured import view_of
from tabletopgen_checks.repository import WORDS
from tabletopgen_checks.scene.scene import Scene


@dataclass
class Sentence:
    name: str
    seed: int
    text: str
    # As an entry of tests/words/sentences.jsonl.
    expectation: dict
    # Whether `make test` makes a scene of it, and whether it makes another with two threads.
    sample: bool = False
    threads: bool = False

    @property
    def objects(self) -> int:
        return sum(entry["count"] for entry in self.expectation["objects"])

    def complaints(self, scene: Scene) -> list:
        """What is missing, too much or elsewhere in a scene; empty when all is as the sentence asks for."""
        return complaints(self.expectation, view_of(scene))


def sentences() -> list:
    """Those of tests/words/scenes.toml."""
    return [sentence(**entry) for entry in tomllib.loads((WORDS / "scenes.toml").read_text(encoding="utf-8"))["sentence"]]


def sentence(name: str, seed: int, text: str, expect: dict, table: str | None = None, **more) -> Sentence:
    objects = [{"category": category, "count": count} for category, count in expect.items()]
    return Sentence(name, seed, text, {"objects": objects, "table": {"shape": table} if table else {}}, **more)
