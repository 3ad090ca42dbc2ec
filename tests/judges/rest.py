"""Everything stays where `scene.json` places it, in every program that the bundle's README shows, by the README's
lines.

    target/judges/bin/python tests/judges/rest.py BUNDLE_DIR... [--programs "MuJoCo 4.0.0,..."] [--seconds 5] [--json]

Each example runs in a process and an environment of its own (`tabletopgen_checks.judges.programs` makes those that are
not the judges'), until five seconds are simulated. Then no object may be farther from its pose than a quarter of its
smallest side, or turned by more than two degrees (or what rest_programs.toml says of its program), and no two bodies
may be deeper in each other than a quarter of the thinner one's smallest side or 2 mm. One measure serves all programs:
MuJoCo finds the depth of the exported shapes at the poses that each ended with. A program that only loads the scene
(Pinocchio) holds where its example ends well.
"""

import argparse
import json
import math
import subprocess
import sys
import tomllib
from dataclasses import asdict, dataclass, field
from pathlib import Path

import mujoco
import numpy as np

from readme import examples
from verdict import Verdict, bodies, read_scene, rotation

DURATION_S = 5.0
SIDE_SHARE = 0.25
DEPTH_M = 0.002
LIMIT_S = 1800
LINES = Path(__file__).with_name("rest_lines.py")
JAVASCRIPT = Path(__file__).with_name("rest_lines.mjs")


@dataclass(frozen=True)
class Program:
    """An example of the README and who runs it, as rest_programs.toml says."""

    name: str
    heading: str
    # In `rest_lines.READERS`; "load" where nothing is simulated, "javascript" for Node.js.
    reader: str
    example: int = 0
    environment: str = ""
    sample: bool = False
    # How far an object may turn, degrees.
    turn_deg: float = 2.0
    # Why rest is not promised there, as its section of the bundle's README says; empty where it is promised.
    not_promised: str = ""

    @property
    def folder(self) -> Path:
        return Path(sys.prefix) / "programs" / self.environment if self.environment else Path(sys.prefix)


def programs() -> dict:
    text = Path(__file__).with_name("rest_programs.toml").read_text(encoding="utf-8")
    return {entry["name"]: Program(**entry) for entry in tomllib.loads(text)["program"]}


PROGRAMS = programs()


@dataclass
class Rest:
    """How a scene rests in a program; shares of their limits are 1 where something just holds."""

    objects: int = 0
    # Why there is nothing to measure.
    failure: str = ""
    held: int = 0
    # Objects beyond their limit: millimeters and degrees.
    unstable: dict = field(default_factory=dict)
    worst: str = ""
    worst_share: float = 0.0
    moved_mm: float = 0.0
    turned_deg: float = 0.0
    deepest: str = ""
    deepest_share: float = 0.0
    depth_mm: float = 0.0
    cpu_s_per_s: float = 0.0
    step_s: float = 0.0

    @property
    def holds(self):
        return not self.failure and self.worst_share <= 1.0 and self.deepest_share <= 1.0


def rest(bundle: Path, program: str, duration_s: float = DURATION_S) -> Rest:
    """What became of a scene in one of `PROGRAMS`."""
    answer, failure = ended(bundle, PROGRAMS[program], duration_s)
    scene = read_scene(bundle)
    found = Rest(objects=len(scene["instances"]), failure=failure)
    if failure or "poses" not in answer:
        found.held = 0 if failure else found.objects
        return found
    found.step_s, found.cpu_s_per_s = answer["step_s"], answer["cpu_s"] / answer["simulated_s"]
    poses = {name: (np.array(pose[:3]), np.array(pose[3:])) for name, pose in answer["poses"].items()}
    lost = [name for name, pose in poses.items() if not np.isfinite(np.concatenate(pose)).all()]
    if lost:
        found.failure = f"{lost[0]} has no finite pose any more"
        return found
    measure_movement(found, scene, poses, math.radians(PROGRAMS[program].turn_deg))
    measure_depth(found, bundle, scene, poses)
    return found


def check_rest(verdict: Verdict, bundle: Path, program: str, duration_s: float = DURATION_S) -> Rest:
    """What a judge of one format tells of rest in its program."""
    found = rest(bundle, program, duration_s)
    if found.failure:
        verdict.complaints.append(f"in {program}, by the README's lines: {found.failure}")
    verdict.facts |= {
        "movable": found.objects, "stable": found.held, "simulated_s": duration_s, "unstable": found.unstable,
        "nearest_to_limit": f"{found.worst} {found.moved_mm:.2f} mm {found.turned_deg:.2f} deg",
        "deepest": f"{found.deepest} {found.depth_mm:.2f} mm", "cpu_s_per_s": round(found.cpu_s_per_s, 2),
    }
    return found


def measure_movement(found: Rest, scene, poses, limit_rad: float):
    for instance in scene["instances"]:
        position, turn = poses[instance["name"]]
        moved_m = float(np.linalg.norm(position - instance["translation_m"]))
        relative = rotation(instance["rotation_xyzw"]).T @ rotation(turn)
        turned_rad = math.acos(min(1.0, max(-1.0, (np.trace(relative) - 1.0) / 2.0)))
        share = max(moved_m / (SIDE_SHARE * min(instance["size_m"])), turned_rad / limit_rad)
        if share <= 1.0:
            found.held += 1
        else:
            found.unstable[instance["name"]] = [round(1e3 * moved_m, 1), round(math.degrees(turned_rad), 1)]
        if share > found.worst_share:
            found.worst, found.worst_share = instance["name"], share
            found.moved_mm, found.turned_deg = 1e3 * moved_m, math.degrees(turned_rad)


def measure_depth(found: Rest, bundle: Path, scene, poses):
    model = mujoco.MjModel.from_xml_path(str(bundle / "mjcf" / "scene.xml"))
    data = mujoco.MjData(model)
    for name, (position, (x, y, z, w)) in poses.items():
        address = model.jnt_qposadr[model.body(name).jntadr[0]]
        data.qpos[address : address + 7] = [*position, w, x, y, z]
    mujoco.mj_forward(model, data)
    sides = {body["name"]: min(body["size_m"]) for body in bodies(scene)}
    for contact in data.contact:
        pair = [model.body(int(model.geom_bodyid[geom])).name for geom in contact.geom]
        share = -contact.dist / min(DEPTH_M, SIDE_SHARE * min(sides.get(name, math.inf) for name in pair))
        if share > found.deepest_share:
            found.deepest, found.deepest_share = " and ".join(pair), float(share)
            found.depth_mm = -1e3 * float(contact.dist)


def ended(bundle: Path, program: Program, duration_s: float):
    """(what the lines tell, why there is nothing)."""
    language = "js" if program.reader == "javascript" else "python"
    found = examples((bundle / "README.md").read_text(encoding="utf-8"), language)
    codes = [code for heading, code in found if heading.split(" (")[0] == program.heading]
    if len(codes) <= program.example:
        return {}, f"the README has no example {program.example + 1} for {program.heading}"
    folder = program.folder
    if language == "js":
        command = [Path(sys.prefix) / "bin/node", JAVASCRIPT, folder, duration_s]
    else:
        command = [folder / "bin/python", LINES, program.reader, duration_s]
    if not folder.is_dir():
        return {}, f"there is no environment; python -m tabletopgen_checks.judges.programs {program.environment} makes it"
    try:
        run = subprocess.run(
            [str(part) for part in command], cwd=bundle, input=codes[program.example], capture_output=True, text=True,
            errors="replace", timeout=LIMIT_S,
        )
    except subprocess.TimeoutExpired:
        return {}, f"it is not done within {LIMIT_S} s"
    # Some programs say good-bye behind it.
    answer = [line.removeprefix("rest: ") for line in run.stdout.splitlines() if line.startswith("rest: ")]
    if run.returncode != 0 or not answer:
        return {}, (run.stderr or run.stdout).strip()[-300:] or f"exit code {run.returncode}"
    return json.loads(answer[-1]), ""


def main() -> int:
    parser = argparse.ArgumentParser(description="Let every program of the README keep unpacked bundles at rest.")
    parser.add_argument("bundles", nargs="+", type=Path, metavar="BUNDLE_DIR")
    parser.add_argument("--programs", default=";".join(PROGRAMS), help="names of rest_programs.toml with semicolons between")
    parser.add_argument("--seconds", type=float, default=DURATION_S, help="how long each scene is simulated")
    parser.add_argument("--json", action="store_true", help="print a line of JSON for each program and bundle")
    given = parser.parse_args()
    chosen = given.programs.split(";")
    if unknown := [name for name in chosen if name not in PROGRAMS]:
        print(f"unknown programs {unknown}; there are {list(PROGRAMS)}", file=sys.stderr)
        return 2
    held = True
    for bundle in given.bundles:
        for program in chosen:
            found = rest(bundle.resolve(), program, given.seconds)
            held &= found.holds
            if given.json:
                line = {"bundle": str(bundle.resolve()), "program": program, "holds": found.holds, **asdict(found)}
                print(json.dumps(line), flush=True)
            else:
                print(f"{bundle.name}, {program}: {words(found)}", flush=True)
    return 0 if held else 1


def words(found: Rest) -> str:
    if found.failure:
        return f"FAILS: {found.failure}"
    verdict = "holds" if found.holds else "DOES NOT HOLD"
    return (
        f"{verdict}; {found.worst} moves {found.moved_mm:.2f} mm and turns {found.turned_deg:.2f} degrees "
        f"({found.worst_share:.2f} of its limit); {found.deepest} {found.depth_mm:.3f} mm deep "
        f"({found.deepest_share:.2f}); {found.cpu_s_per_s:.2f} CPU s/s"
    )


if __name__ == "__main__":
    sys.exit(main())
