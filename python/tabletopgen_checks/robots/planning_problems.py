"""The MotionBenchMaker problems of the Panda, as the source package `vamp-planner` has them, for two planners.

Nothing of the package is kept: it is downloaded into a folder, read, and written again as a file for the example
`plan_problems` of crate `robot` and one for VAMP. Both get the same solids: VAMP takes a capsule for each cylinder,
and in the set `box` a cuboid.

    python -m tabletopgen_checks.robots.planning_problems PACKAGE FOLDER

Writes `problems.json` and `problems.txt` into FOLDER. Needs PyYAML.
"""

import io
import json
import math
import re
import sys
import tarfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import yaml

from tabletopgen_checks.scene.scene import rotation

# The package states no limits of acceleration and jerk; these are Franka's for the arm.
MAX_ACCELERATION = [15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0]
MAX_JERK = [500.0 * acceleration for acceleration in MAX_ACCELERATION]


def matrix_of_angles(roll, pitch, yaw):
    """Rotations about the fixed axes x, y and z, in this order."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (roll, pitch, yaw))
    return [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]


def turned(matrix, vector):
    return [sum(a * b for a, b in zip(row, vector)) for row in matrix]


def product(left, right):
    columns = [turned(left, [row[k] for row in right]) for k in range(3)]
    return [[columns[k][row] for k in range(3)] for row in range(3)]


def placed(pose, vector):
    matrix, translation = pose
    return [a + b for a, b in zip(turned(matrix, vector), translation)]


def combined(outer, inner):
    return product(outer[0], inner[0]), placed(outer, inner[1])


def numbers(text):
    return [float(part) for part in text.split()]


def read_arm(folder: Path) -> dict:
    """Joints, bodies of spheres and pairs to check, from the URDF and SRDF of the package."""
    robot = ElementTree.parse(folder / "panda_spherized.urdf").getroot()
    joints, bodies, names = [], [], []
    links = {link.get("name"): link for link in robot.iter("link")}
    # From a link to the moving frame that it is fixed to, and its pose there.
    frames = {"panda_link0": (0, ([[1, 0, 0], [0, 1, 0], [0, 0, 1]], [0, 0, 0]))}
    waiting = [joint for joint in robot.iter("joint") if joint.find("parent") is not None]
    while waiting:
        joint = next(j for j in waiting if j.find("parent").get("link") in frames)
        waiting.remove(joint)
        origin = joint.find("origin")
        xyz, rpy = numbers(origin.get("xyz")), numbers(origin.get("rpy"))
        frame, pose = frames[joint.find("parent").get("link")]
        child = joint.find("child").get("link")
        if joint.get("type") == "fixed":
            frames[child] = (frame, combined(pose, (matrix_of_angles(*rpy), xyz)))
            continue
        limit, index = joint.find("limit"), len(joints)
        joints.append({
            "translation_m": xyz,
            "rpy_rad": rpy,
            "min_position": float(limit.get("lower")),
            "max_position": float(limit.get("upper")),
            "max_velocity": float(limit.get("velocity")),
            "max_acceleration": MAX_ACCELERATION[index],
            "max_jerk": MAX_JERK[index],
        })
        frames[child] = (len(joints), ([[1, 0, 0], [0, 1, 0], [0, 0, 1]], [0, 0, 0]))
    for name, link in links.items():
        spheres = []
        for collision in link.iter("collision"):
            center = placed(frames[name][1], numbers(collision.find("origin").get("xyz")))
            spheres.append(center + [float(collision.find("geometry/sphere").get("radius"))])
        if spheres:
            names.append(name)
            bodies.append({"frame": frames[name][0], "spheres_m": spheres})
    semantic = ElementTree.parse(folder / "panda.srdf").getroot()
    apart = {frozenset((d.get("link1"), d.get("link2"))) for d in semantic.iter("disable_collisions")}
    pairs = [
        [a, b]
        for a in range(len(names))
        for b in range(a + 1, len(names))
        if frozenset((names[a], names[b])) not in apart and bodies[a]["frame"] != bodies[b]["frame"]
    ]
    return {"joints": joints, "bodies": bodies, "pairs": pairs}


def read_obstacles(scene: dict, capsules: bool) -> list:
    obstacles = []
    for entry in scene["world"]["collision_objects"]:
        shape, place = entry["primitives"][0], entry["primitive_poses"][0]
        pose = rotation(place["orientation"]), place["position"]
        if "pose" in entry:
            pose = combined((rotation(entry["pose"]["orientation"]), entry["pose"]["position"]), pose)
        matrix, center = pose
        solid = {"center_m": center, "axes": [[row[k] for row in matrix] for k in range(3)]}
        size = shape["dimensions"]
        if shape["type"] == "box":
            obstacles.append({"kind": "cuboid", **solid, "half_extents_m": [part / 2 for part in size]})
        elif shape["type"] == "cylinder" and capsules:
            obstacles.append({"kind": "capsule", **solid, "radius_m": size[1], "half_length_m": size[0] / 2})
        elif shape["type"] == "cylinder":
            obstacles.append({"kind": "cuboid", **solid, "half_extents_m": [size[1], size[1], size[0] / 2]})
        else:
            raise ValueError(f"a {shape['type']} is no solid of these problems")
    return obstacles


def read_problems(archive: Path) -> list:
    """All problems by set and number."""
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    scenes, requests = {}, {}
    with tarfile.open(archive, "r:bz2") as tar:
        for member in tar.getmembers():
            match = re.search(r"([a-z_]+)_panda/(scene|request)(\d+)\.yaml$", member.name)
            if match:
                name, kind, number = match.groups()
                text = io.TextIOWrapper(tar.extractfile(member), encoding="utf-8").read()
                (scenes if kind == "scene" else requests)[(name, int(number))] = yaml.load(text, Loader=loader)
    problems = []
    for (name, number), request in sorted(requests.items()):
        state = request["start_state"]["joint_state"]
        by_name = dict(zip(state["name"], state["position"]))
        goal = {c["joint_name"]: c["position"] for c in request["goal_constraints"][0]["joint_constraints"]}
        joints = [f"panda_joint{k}" for k in range(1, 8)]
        problems.append({
            "name": f"{name}_{number}",
            "set": name,
            "start": [by_name[joint] for joint in joints],
            "goals": [[goal[joint] for joint in joints]],
            "obstacles": read_obstacles(scenes[(name, number)], capsules=name != "box"),
        })
    return problems


def write_for_vamp(problems: list, path: Path):
    def words(*lists):
        return " ".join(repr(float(part)) for one in lists for part in one)

    with path.open("w") as out:
        for problem in problems:
            out.write(f"problem {words(problem['start'], problem['goals'][0])}\n")
            for solid in problem["obstacles"]:
                center, axes = solid["center_m"], solid["axes"]
                if solid["kind"] == "capsule":
                    half = [solid["half_length_m"] * part for part in axes[2]]
                    ends = [[c + sign * h for c, h in zip(center, half)] for sign in (-1, 1)]
                    out.write(f"capsule {words(*ends, [solid['radius_m']])}\n")
                else:
                    out.write(f"cuboid {words(center, *axes, solid['half_extents_m'])}\n")
            out.write("end\n")


def main():
    package, folder = map(Path, sys.argv[1:])
    panda = package / "resources" / "panda"
    problems = read_problems(panda / "problems.tar.bz2")
    (folder / "problems.json").write_text(json.dumps({"arm": read_arm(panda), "problems": problems}))
    write_for_vamp(problems, folder / "problems.txt")


if __name__ == "__main__":
    main()
