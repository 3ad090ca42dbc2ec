"""A policy learns from recorded episodes: behavior cloning with and without randomization, evaluated in MuJoCo.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.policy [--target-dir target] [--count 500] [--starts 100] \\
        [--epochs 60]
        [--only all|images] [--image-episodes 160] [--image-starts 30] [--image-minutes 9]

A scene is generated, and `tabletopgen episodes` records `count` episodes of one task in it with the usual
randomization, as many without any, and `starts` with another seed, of which only the beginnings are used. A small
network is trained on each of the first two with PyTorch (tests/judges/robots/policy_training.py), and does the task
from the starts in MuJoCo, which made none of the data (tests/judges/robots/policy_rollout.py). Another network is
trained on images of fewer episodes, for so many CPU minutes, and sees MuJoCo's own images (train_images.py and
rollout_images.py there). Scene and datasets are kept under the target directory for the same program.
"""

import hashlib
import json
from collections import Counter
from pathlib import Path

from tabletopgen_checks.bars.page import arguments, table, write, write_section
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.processes import output_of
from tabletopgen_checks.repository import JUDGES
from tabletopgen_checks.virtual_environment import environment_of

DEPENDS_ON = (
    "config/robots", "crates/data/demonstrations", "crates/data/episodes", "crates/method/manipulation",
    "crates/method/physics", "crates/method/render", "crates/method/robot", "tests/judges/robots/policy_observation.py",
    "tests/judges/robots/policy_rollout.py", "tests/judges/robots/policy_rollout_images.py",
    "tests/judges/robots/policy_training.py", "tests/judges/robots/policy_training_images.py",
    "clients/python/src/tabletopgen/env",
)
SENTENCE, SCENE_SEED = "A small table with a can and a plate", 3
TASK = "put the can on the plate"
TRAINING_SEED, STARTS_SEED = 1, 1001
# The share of unseen starts from which the policy that was trained with randomization does the task.
BAR = 0.8
TRAINED = {"usual": "as usual", "none": "none"}
NOTES = f"""The task is easy on purpose: one compact object that stands, one grasp and one place of the robot's base in all
episodes, nothing else on the table; a grasp must be right by 6 mm to each side, and the can may end anywhere on the
plate. The policy sees joint positions, the opening of the gripper, the tool's pose, and the poses of can and plate
before the robot moves, not while it does; it does not see the time or the phase.
The starts are attempts with the seed {STARTS_SEED}; the robot stands where it stood in training."""
NOISE = """Training adds noise to what the policy sees, in six copies of each frame beside which the targets stay: to each joint
a normal deviation of 10 mrad, to the opening one of 0.5 mm. The policy learns to come back by it; the datasets themselves
have no such frames."""
IMAGE_NOISE = "Training adds noise to the joints, a normal deviation of 5 mrad, and repaints the images."
IMAGES = "From images"


def main() -> bool:
    given = arguments(__doc__, count=500, starts=100, epochs=60, only="all",
                      image_episodes=160, image_starts=30, image_minutes=9.0)
    with given.binary.open("rb") as program:
        folder = given.work / "policy" / hashlib.file_digest(program, "sha256").hexdigest()[:12]
    folder.mkdir(parents=True, exist_ok=True)
    scene, execution = folder / "scene", folder / "execution"
    if not scene.exists():
        output_of(given.binary, "generate", "--text", SENTENCE, "--seed", SCENE_SEED, "--out", scene)
    if not execution.exists():
        output_of(given.binary, "execute", "--scene", scene, "--task", TASK, "--out", execution)
    starts = recorded(given, scene, folder / f"starts_{given.starts}", STARTS_SEED, given.starts, "usual", "--keep-failures")
    torch, mujoco = python_of(given, "episode-judges", "episodes"), python_of(given, "robot-judges", "robots")
    if given.only == "images":
        write_section("policy", IMAGES, from_images(given, torch, mujoco, scene, execution, starts), DEPENDS_ON)
        return True
    rows, costs, share = [], [], {}
    for randomize, shown_as in TRAINED.items():
        dataset = recorded(given, scene, folder / f"{randomize}_{given.count}", TRAINING_SEED, given.count, randomize)
        weights = folder / f"{randomize}_{given.count}.npz"
        cost = trained_on(given, torch, dataset, execution, weights)
        found = rolled_out(given, mujoco, scene, execution, starts, weights)
        own = rolled_out(given, mujoco, scene, execution, dataset, weights, "--only", 1)[0]["outcome"]
        share[randomize] = sum(one == "success" for one in outcomes(found)) / len(found)
        kinds = Counter(one for one in outcomes(found) if one != "success").most_common()
        rows.append([shown_as, given.count, cost["different"], f"{100 * share[randomize]:.0f} % of {len(found)}",
                     ", ".join(f"{times} {kind}" for kind, times in kinds) or "none", own])
        costs.append([shown_as, cost["frames"], cost["parameters"], f"{cost['loss']:.4f}", f"{cost['loss_held_out']:.4f}",
                      f"{1e3 * cost['error_rad']:.1f}", f"{cost['cpu_s']:.0f}"])
    holds = share["usual"] >= BAR
    body = [
        table(["", "found", "bar", ""],
              [["Success in MuJoCo from unseen randomized starts, trained with randomization, states",
                f"{100 * share['usual']:.0f} %", f"{100 * BAR:g} %", "holds" if holds else "DOES NOT HOLD"]]),
        f"\"{TASK}\" in a scene of the sentence \"{SENTENCE}\", seed {SCENE_SEED}, by the Panda.",
        table(["randomization in training", "episodes", "different", "success, randomized starts", "failures",
               "first start of its training"], rows),
        f"The {len(starts_made(starts))} starts are of {starts_made(starts)[-1]['number'] + 1} attempts of the recorder, of which "
        f"{sum(one['success'] for one in starts_made(starts))} succeeded.",
        "Without randomization nothing varies, not even the motion where a direct path is free: all episodes may be one.",
        NOTES,
        "## Training",
        table(["randomization", "frames", "parameters", "loss", "loss, held out", "held out, mrad", "CPU s"], costs),
        f"{given.epochs} epochs of AdamW on one thread. The loss is the mean absolute error over the next 16 frames, in units of the "
        "spread of all joints, or of the opening; that in mrad is of the joints. The policy is asked again after 8 frames. One "
        "episode of 20 is held out.",
        NOISE,
    ]
    body += [f"## {IMAGES}", from_images(given, torch, mujoco, scene, execution, starts)]
    write("policy", "A policy learns", "\n\n".join(body), DEPENDS_ON)
    return holds


def from_images(given, torch: Path, mujoco: Path, scene: Path, execution: Path, starts: Path) -> str:
    """What a policy does that sees images, in words; no bar."""
    count = given.image_episodes
    dataset = recorded(given, scene, scene.with_name(f"images_{count}"), TRAINING_SEED, count, "usual",
                       "--size", 96, "--instance-ids", cameras="front,wrist")
    weights = scene.with_name(f"images_{count}.npz")
    robots = JUDGES / "robots"
    cost = output_of(torch, robots / "policy_training_images.py", dataset, execution / "mjcf" / "panda.xml", weights,
                "--minutes", given.image_minutes)
    cost = json.loads(cost.splitlines()[-1])
    text = output_of(mujoco, robots / "policy_rollout_images.py", given.binary, scene, execution, starts, weights, dataset,
                "--only", given.image_starts)
    found = outcomes([json.loads(line) for line in text.splitlines() if line.startswith("{")])
    kinds = ", ".join(f"{times} {kind}" for kind, times in Counter(found).most_common())
    return "\n\n".join([
        table(["episodes", "frames", "parameters", "epochs", "loss", "loss, held out", "held out, mrad", "CPU s", "success", "outcomes"],
              [[cost["episodes"], cost["frames"], cost["parameters"], f"{cost['epochs']:.0f}", f"{cost['loss']:.4f}",
                f"{cost['loss_held_out']:.4f}", f"{1e3 * cost['error_rad']:.1f}", f"{cost['cpu_s']:.0f}",
                f"{found.count('success')} of {len(found)}", kinds]]),
        "Two cameras of 96 x 96 pixels, at the front and on the hand, in place of the objects' poses; no randomization was left out. "
        "In MuJoCo the policy sees MuJoCo's images, whose light, shadows, floor and backdrop are others. There is no bar for it. "
        + IMAGE_NOISE,
    ])


def outcomes(found: list) -> list:
    return [one["outcome"] for one in found]


def starts_made(starts: Path) -> list:
    return [json.loads(line) for line in (starts / "parquet-png" / "records.jsonl").read_text(encoding="utf-8").splitlines()]


def recorded(given, scene: Path, out: Path, seed: int, count: int, randomize: str, *more, cameras: str = "none") -> Path:
    if not out.exists():
        output_of(given.binary, "episodes", "--scene", scene, "--task", TASK, "--count", count, "--seed", seed, "--out", out,
             "--randomize", randomize, "--cameras", cameras, "--format", "parquet-png", "--workers", 1, "--json", *more)
    return out


def python_of(given, name: str, judges: str) -> Path:
    folder = environment_of(given.target_dir, name, JUDGES / judges / "requirements.txt")
    return folder / "bin" / "python"


def trained_on(given, python: Path, dataset: Path, execution: Path, weights: Path) -> dict:
    mjcf = execution / "mjcf" / "panda.xml"
    text = output_of(python, JUDGES / "robots" / "policy_training.py", dataset, mjcf, weights, "--epochs", given.epochs)
    return json.loads(text.splitlines()[-1])


def rolled_out(given, python: Path, scene: Path, execution: Path, starts: Path, weights: Path, *more) -> list:
    script = JUDGES / "robots" / "policy_rollout.py"
    text = output_of(python, script, given.binary, scene, execution, starts, weights, *more)
    return [json.loads(line) for line in text.splitlines() if line.startswith("{")]


if __name__ == "__main__":
    run(main)
