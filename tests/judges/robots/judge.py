"""Independent programs judge a robot that `cargo run -p tabletopgen-robot --example write_robot` wrote.

    judge.py FOLDER...

Each folder holds robot.urdf, robot.xml, robot.usda and kinematics.json. Prints one line of JSON for each folder and
judge; exit code 1 where one has a complaint. tabletopgen_checks.robots makes the environment and the folders.
"""

import importlib
import json
import sys
from pathlib import Path

JUDGES = ("published", "urdf", "mjcf", "usd", "bullet")


def main(folders: list) -> int:
    failed = False
    for folder in map(Path, folders):
        robot = json.loads((folder / "kinematics.json").read_text(encoding="utf-8"))
        for name in JUDGES:
            try:
                module = importlib.import_module(f"judge_{name}")
            except ModuleNotFoundError as missing:
                # Later Pythons have no packages of PyBullet.
                if missing.name != "pybullet":
                    raise
                print(json.dumps({"robot": label(robot), "judge": name, "left_out": "no pybullet"}))
                continue
            facts, complaints = module.judge(folder, robot)
            failed |= bool(complaints)
            print(json.dumps({"robot": label(robot), "judge": name, **facts, "complaints": complaints}), flush=True)
    return int(failed)


def label(robot: dict) -> str:
    return " ".join(filter(None, (robot["name"], robot["variant"])))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
