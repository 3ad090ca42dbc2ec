"""Runs an example of a bundle's README for so many seconds of simulated time and prints where every object is then.

    python rest_lines.py PROGRAM SECONDS < example.py     # in the bundle's folder, by the program's own Python

Runs in the environment of the program: it imports nothing but the standard library and what the example imports. The
example runs as it stands but for the count of its loop of steps (or the time that Drake advances to). Prints a line of
JSON after `rest: `: the poses, the length of a step, how long was simulated, and the CPU seconds of the steps after the
first.
"""

import ast
import json
import sys
import time


def main() -> int:
    program, seconds, code = sys.argv[1], float(sys.argv[2]), sys.stdin.read()
    with open("scene.json", encoding="utf-8") as file:
        names = [instance["name"] for instance in json.load(file)["instances"]]
    before, steps = parts(code)
    names_of_example = {"__name__": "__main__"}
    exec(compile(before, "README.md", "exec"), names_of_example)
    answer = {} if steps is None else simulated(READERS[program], steps, names_of_example, seconds, names)
    print("\nrest: " + json.dumps(answer), flush=True)
    return 0


def parts(code: str):
    """What stands before the loop of steps, and the loop or the call of `AdvanceTo`; all and None where neither is
    there."""
    tree = ast.parse(code)
    for k, node in enumerate(tree.body):
        if is_loop_of_steps(node) or is_advance(node):
            return ast.Module(tree.body[:k], []), node
    return tree, None


def is_loop_of_steps(node) -> bool:
    """`for _ in range(100):` with a number."""
    if not (isinstance(node, ast.For) and isinstance(node.iter, ast.Call) and len(node.iter.args) == 1):
        return False
    return ast.unparse(node.iter.func) == "range" and isinstance(node.iter.args[0], ast.Constant)


def is_advance(node) -> bool:
    """`simulator.AdvanceTo(1.0)`."""
    called = isinstance(node, ast.Expr) and isinstance(node.value, ast.Call) and node.value.func
    return isinstance(called, ast.Attribute) and called.attr == "AdvanceTo"


def simulated(reader, steps, given: dict, seconds: float, names: list) -> dict:
    step_s = reader.step_s(given, steps)
    count = max(1, round(seconds / step_s))
    # The first step compiles kernels.
    run(steps, given, 1, step_s)
    start = time.process_time()
    run(steps, given, count, step_s, already=1)
    cpu_s = time.process_time() - start
    if hasattr(reader, "clock_s") and reader.clock_s(given) < (count - 0.5) * step_s:
        raise RuntimeError("the simulation diverged and began anew")
    poses = {name: [float(x) for x in reader.pose(given, name, k)] for k, name in enumerate(names)}
    return {"poses": poses, "step_s": step_s, "simulated_s": count * step_s, "cpu_s": cpu_s}


def run(steps, given: dict, count: int, step_s: float, already: int = 0):
    """Steps of the loop of the example beyond those `already` done, or Drake up to the time of all of them."""
    if isinstance(steps, ast.For):
        steps.iter.args[0] = ast.Constant(count - already)
    else:
        steps.value.args = [ast.Constant(count * step_s)]
    exec(compile(ast.fix_missing_locations(ast.Module([steps], [])), "README.md", "exec"), given)


class Mujoco:
    """`model` and `data`."""

    @staticmethod
    def step_s(given, _):
        return float(given["model"].opt.timestep)

    @staticmethod
    def clock_s(given):
        """Zero again where it diverged; then everything is in its place again, too."""
        return float(given["data"].time)

    @staticmethod
    def pose(given, name, _):
        body = given["data"].body(name)
        return (*body.xpos, *xyzw(body.xquat))


class Robosuite(Mujoco):
    """The same; robosuite names the body of an object after it."""

    @staticmethod
    def pose(given, name, _):
        return Mujoco.pose(given, f"{name}_main", _)


class Warp:
    """`model` of MuJoCo and the `world` of MuJoCo Warp."""

    @staticmethod
    def step_s(given, _):
        return float(given["model"].opt.timestep)

    @staticmethod
    def pose(given, name, _):
        body, world = given["model"].body(name).id, given["world"]
        return (*world.xpos.numpy()[0][body], *xyzw(world.xquat.numpy()[0][body]))


class Bullet:
    """`p`, whose bodies are the table and the objects in order."""

    @staticmethod
    def step_s(given, _):
        return float(given["p"].getPhysicsEngineParameters()["fixedTimeStep"])

    @staticmethod
    def pose(given, _, k):
        p = given["p"]
        body = p.getBodyUniqueId(k + 1)
        com = p.getDynamicsInfo(body, -1)[3:5]
        position, turn = p.multiplyTransforms(*p.getBasePositionAndOrientation(body), *p.invertTransform(*com))
        return (*position, *turn)


class Sapien:
    """`scene`, whose entities bear the names."""

    @staticmethod
    def step_s(given, _):
        return float(given["scene"].timestep)

    @staticmethod
    def pose(given, name, _):
        entity = next(entity for entity in given["scene"].entities if entity.name == name)
        return (*entity.pose.p, *xyzw(entity.pose.q))


class Drake:
    """`plant` and `simulator`."""

    @staticmethod
    def step_s(given, _):
        return float(given["plant"].time_step())

    @staticmethod
    def pose(given, name, _):
        plant = given["plant"]
        context = plant.GetMyContextFromRoot(given["simulator"].get_context())
        model = plant.GetModelInstanceByName(name) if plant.HasModelInstanceNamed(name) else None
        body = plant.GetBodyByName(name, model) if model else plant.GetBodyByName(name)
        pose = plant.EvalBodyPoseInWorld(context, body)
        return (*pose.translation(), *xyzw(pose.rotation().ToQuaternion().wxyz()))


class Newton:
    """`model` and `state`; the step is the last argument of `solver.step`."""

    @staticmethod
    def step_s(given, steps):
        calls = [node for node in ast.walk(steps) if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)]
        step = next(call for call in calls if call.func.attr == "step")
        return float(eval(compile(ast.Expression(step.args[-1]), "README.md", "eval"), given))

    @staticmethod
    def pose(given, name, _):
        model = given["model"]
        labels = getattr(model, "body_label", None) or model.body_key
        index = next(k for k, label in enumerate(labels) if label.split("/")[-1] == name)
        return tuple(given["state"].body_q.numpy()[index])


class Genesis:
    """`scene` and `objects`, its entities by name."""

    @staticmethod
    def step_s(given, _):
        return float(given["scene"].dt)

    @staticmethod
    def pose(given, name, _):
        entity = given["objects"][name]
        position, turn = (value.cpu().numpy().reshape(-1) for value in (entity.get_pos(), entity.get_quat()))
        return (*position, *xyzw(turn))


def xyzw(wxyz):
    w, x, y, z = wxyz
    return x, y, z, w


READERS = {
    "mujoco": Mujoco, "robosuite": Robosuite, "warp": Warp, "bullet": Bullet, "sapien": Sapien, "drake": Drake,
    "newton": Newton, "genesis": Genesis,
}


if __name__ == "__main__":
    sys.exit(main())
