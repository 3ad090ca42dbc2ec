"""Scenes of tests/judges/rest_scenes.toml in the programs of rest_programs.toml, by tests/judges/rest.py."""

import json
import subprocess
import tomllib
from dataclasses import dataclass
from pathlib import Path

from tabletopgen_checks.judges import programs
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import JUDGES
from tabletopgen_checks.scene.generation import generate


@dataclass(frozen=True)
class RestScene:
    name: str
    kind: str
    seed: int
    text: str
    sample: bool = False


def rest_scenes(sample=False) -> list:
    entries = tomllib.loads((JUDGES / "rest_scenes.toml").read_text(encoding="utf-8"))["scene"]
    return [RestScene(**entry) for entry in entries if entry.get("sample") or not sample]


def simulators(sample=False) -> list:
    """Entries of rest_programs.toml."""
    entries = tomllib.loads((JUDGES / "rest_programs.toml").read_text(encoding="utf-8"))["program"]
    return [entry for entry in entries if entry.get("sample") or not sample]


def make_environments(judges: Path, chosen: list):
    for name in sorted({entry["environment"] for entry in chosen if "environment" in entry}):
        programs.make(judges, name)


def make(binary: Path, scene: RestScene, folder: Path):
    """(the bundle, what is wrong with it); None and why where there is none."""
    bundle = folder / scene.name
    try:
        made = generate(binary, bundle, scene.text, scene.seed)
    except Problem as problem:
        return None, [str(problem).splitlines()[-1].strip()]
    return bundle, made.printed["reasons"]


def rest(judges: Path, program: str, bundles: list, seconds: float = 5.0):
    """What rest.py tells of each bundle, as it comes."""
    command = [judges / "bin/python", JUDGES / "rest.py", "--json", "--programs", program, "--seconds", seconds, *bundles]
    with subprocess.Popen([str(part) for part in command], stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout or ():
            yield json.loads(line)
    if process.returncode not in (0, 1):
        raise Problem(f"rest.py did not run for {program}; see above")


def words(finding: dict) -> str:
    """Why a scene does not rest in a program."""
    if finding["failure"]:
        return " ".join(finding["failure"].split())[-200:]
    moved = f"{finding['worst']} moves {finding['moved_mm']:.2f} mm and turns {finding['turned_deg']:.2f} degrees"
    deep = f"{finding['deepest']} {finding['depth_mm']:.2f} mm deep in each other"
    return " and ".join([moved] * (finding["worst_share"] > 1) + [deep] * (finding["deepest_share"] > 1))
