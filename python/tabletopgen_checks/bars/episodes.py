"""Demonstrations of one pick and place: what they cost, who reads them, and whether they are the same again.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.episodes [--target-dir target] [--count 20] [--kills 30] \\
        [--timed 20] [--train 50]
        [--regenerated 20] [--only all|speed]

A scene is generated, and `tabletopgen episodes` records a task in it in every format. LeRobot, PyAV, pyarrow, h5py and
Pillow read all frames, and LeRobot trains (tests/judges/episodes/recorded.py). MuJoCo repeats the episodes from their
servo commands, and from their actions (tests/judges/robots/replay_dataset.py). The dataset is recorded again with other
workers, and with kills; where it is complete before the last kill, it is begun anew. Episodes are made again from their
records. `speed` measures images beside MuJoCo's renderer and Embree (tests/judges/episodes/speed.py), and
steps beside MuJoCo and PhysX (stepping.py).
"""

import hashlib
import json
import os
import random
import resource
import signal
import subprocess
from pathlib import Path

from tabletopgen_checks.bars.page import arguments, percent, table, write, write_section
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.processes import output_of
from tabletopgen_checks.repository import JUDGES, lab_beside
from tabletopgen_checks.virtual_environment import environment_of

DEPENDS_ON = (
    "config/robots", "crates/data/demonstrations", "crates/data/episodes", "crates/method/manipulation",
    "crates/method/physics", "crates/method/render", "crates/method/robot", "crates/data/video",
    "tests/judges/episodes", "tests/judges/robots/replay_dataset.py",
    "clients/python/src/tabletopgen/env",
)
SENTENCE, SCENE_SEED = "A kitchen table with a carrot, a gray bowl, a banana, a mug and two plates", 11
TASK = "put the carrot in the bowl"
FORMATS = "lerobot-v3.0,lerobot-v3.0-images,lerobot-v2.1,robomimic,parquet-png"
# All that can be recorded.
ALL = ["--format", FORMATS, "--depth", "--instance-ids", "--point-cloud", 512]
# CPU seconds of an episode of about 8 s at 15 Hz with three cameras of 224 x 224 pixels, as LeRobot v3.0 with video.
CPU_S_BAR, REPLAY_BAR = 3.6, 0.95
SPEED, SPEED_IMAGES, SPEED_EPISODES = "Images and steps beside other programs", 90, 3


def main() -> bool:
    given = arguments(__doc__, count=20, kills=30, timed=20, train=50, regenerated=20, only="all")
    if given.only == "speed":
        write_section("episodes", SPEED, speed(given, given.work / "episodes_speed"), DEPENDS_ON)
        return True
    folder = given.work / "episodes"
    subprocess.run(["rm", "-rf", folder], check=True)
    folder.mkdir(parents=True)
    scene = folder / "scene"
    output_of(given.binary, "generate", "--text", SENTENCE, "--seed", SCENE_SEED, "--out", scene)
    costs = {kind: cost(given, scene, folder / f"timed_{kind}", kind, given.timed) for kind in ("none", "side,front,wrist")}
    whole = folder / "whole"
    report = recorded(given, scene, whole, "--workers", 2)
    read = read_by_others(given, whole)
    replays = replayed(given, scene, folder, whole, "servo_command")
    from_actions = replayed(given, scene, folder, whole, "action")
    again = folder / "again"
    recorded(given, scene, again, "--workers", 1)
    same = digest(whole) == digest(again)
    kills, completed = killed(given, scene, folder / "killed", given.kills)
    same_killed = completed.count(digest(whole))
    regenerated = again_from_records(given, scene, whole)
    wide = folder / "wide"
    wide_report = recorded(given, scene, wide, "--workers", 2, "--randomize", "wide")
    wide_read, wide_regenerated = read_by_others(given, wide), again_from_records(given, scene, wide)
    complaints = len(read["complaints"]) + len(wide_read["complaints"])
    regenerated += wide_regenerated
    reached = sum(one["reached"] for one in replays)
    cpu_s = costs["side,front,wrist"]["cpu_s"]
    bars = [
        ["Complaints of LeRobot, PyAV, pyarrow, h5py and Pillow", complaints, "0", complaints == 0],
        ["MuJoCo reaches the goal from the servo commands alone", f"{percent(reached / len(replays))} of {len(replays)}",
         f"{100 * REPLAY_BAR:g} %", reached >= REPLAY_BAR * len(replays)],
        ["Recorded again with one worker: same bytes", "yes" if same else "no", "yes", same],
        [f"Datasets completed during {kills} kills with the same bytes", f"{same_killed} of {len(completed)}", "all",
         same_killed == len(completed)],
        ["Episodes made again from their records, to the byte", f"{sum(regenerated)} of {len(regenerated)}", "all",
         all(regenerated)],
        ["CPU seconds of an episode with three cameras", f"{cpu_s:.1f}", f"{CPU_S_BAR}", cpu_s <= CPU_S_BAR],
    ]
    rows = [[*bar[:3], "holds" if bar[3] else "DOES NOT HOLD"] for bar in bars]
    body = [
        table(["", "found", "bar", ""], rows),
        f"\"{TASK}\" in a scene of the sentence \"{SENTENCE}\", seed {SCENE_SEED}, by the Panda; randomization as usual.",
        f"{attempted(report)}.",
        f"From the actions alone, which are within the robot's limits and lead nothing, MuJoCo reaches the goal in "
        f"{sum(one['reached'] for one in from_actions)} of {len(from_actions)}.",
        f"With `--randomize wide`, other objects and materials among it: {attempted(wide_report)}. MuJoCo does not repeat these, "
        "since other objects are not in the MJCF of the scene.",
        f"{read['checks'] + wide_read['checks']} checks by other programs; the largest error of a decoded video frame is "
        f"{read['worst_rms']} rms of 255. LeRobot's loss after {given.train} steps of training: {read['trained_loss']}.",
        "## Cost",
        table(
            ["cameras", "episodes", "CPU s an episode", "frames an episode"],
            [[kind.replace(",", ", "), one["episodes"], f"{one['cpu_s']:.2f}", f"{one['frames']:.0f}"]
             for kind, one in costs.items()],
        ),
        "User and system time of the whole command with LeRobot v3.0, less that of recording one episode, over the others. "
        f"No process took more than {costs['side,front,wrist']['mb']:.0f} MB.",
    ]
    write("episodes", "Episodes", "\n\n".join(body), DEPENDS_ON)
    write_section("episodes", SPEED, speed(given, given.work / "episodes_speed"), DEPENDS_ON)
    return all(bar[3] for bar in bars)


def attempted(report: dict) -> str:
    outcomes = ", ".join(f"{times} {outcome}" for outcome, times in sorted(report["attempts"].items()))
    return (f"{report['episodes']} episodes, {report['frames']} frames at {report['fps']} Hz, "
            f"{sum(report['attempts'].values())} attempts: {outcomes}")


def command(given, scene: Path, out: Path, count: int, *more) -> list:
    words = ["episodes", "--scene", scene, "--task", TASK, "--count", count, "--out", out, "--seed", 7, "--json", *more]
    return [str(given.binary), *map(str, words)]


def recorded(given, scene: Path, out: Path, *more) -> dict:
    return json.loads(output_of(*command(given, scene, out, given.count, *ALL, *more)))


def cost(given, scene: Path, out: Path, cameras: str, episodes: int) -> dict:
    """CPU seconds of an episode: of so many and one, less those of one."""
    used, report, memory_mb = [], {}, 0.0
    for count in (1, episodes + 1):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        report = json.loads(output_of(*command(given, scene, out.with_name(f"{out.name}_{count}"), count, "--cameras", cameras)))
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        used.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
        memory_mb = after.ru_maxrss / 1024
    attempts = sum(report["attempts"].values())
    return {"episodes": episodes, "attempts": attempts, "cpu_s": (used[1] - used[0]) / episodes,
            "frames": report["frames"] / report["episodes"], "mb": memory_mb}


def speed(given, folder: Path) -> str:
    """CPU time of an image here and of others, alternating, of the same scene, in words."""
    subprocess.run(["rm", "-rf", folder], check=True)
    folder.mkdir(parents=True)
    scene, execution = folder / "scene", folder / "execution"
    output_of(given.binary, "generate", "--text", SENTENCE, "--seed", SCENE_SEED, "--out", scene)
    output_of(given.binary, "execute", "--scene", scene, "--task", TASK, "--out", execution)
    python = environment_of(given.target_dir, "speed-judges", JUDGES / "episodes" / "speed_requirements.txt")
    words = [python / "bin/python", JUDGES / "episodes" / "speed.py", execution / "mjcf" / "scene_with_panda.xml", SPEED_IMAGES]
    own_ms, others = [], []
    for turn in range(2):
        kinds = ("none", "side,front,wrist")
        timed = {kind: cost(given, scene, folder / f"{turn}_{kind}", kind, SPEED_EPISODES) for kind in kinds}
        without, with_cameras = (timed[kind] for kind in kinds)
        own_ms.append(1e3 * (with_cameras["cpu_s"] - without["cpu_s"]) / (3 * with_cameras["frames"]))
        others.append(json.loads(output_of("env", "MUJOCO_GL=egl", *words)))
    words = [python / "bin/python", JUDGES / "episodes" / "stepping.py", lab_beside(given.binary), scene, execution]
    stepped = [json.loads(output_of(*words).splitlines()[-1]) for _ in range(2)]
    steps = [
        ["here", *(f"{one['own_us']:.0f}" for one in stepped), "-"],
        ["MuJoCo, with the options of the MJCF", *(f"{one['mujoco_us']:.0f}" for one in stepped), f"{stepped[0]['mujoco_apart_mm']:.1f}"],
        ["PhysX, as SAPIEN sets it up", *(f"{one['physx_us']:.0f}" for one in stepped), f"{stepped[0]['physx_apart_mm']:.1f}"],
    ]
    rows = [
        ["here: light, shadows, four samples a pixel, and the video of it", *(f"{ms:.1f}" for ms in own_ms)],
        ["MuJoCo's renderer by EGL in software, as it is set up by default", *(f"{one['mujoco_ms']:.1f}" for one in others)],
        ["Embree: the first triangle at each pixel", *(f"{one['embree_ms']:.1f}" for one in others)],
    ]
    return "\n\n".join([
        table(["CPU ms an image", "first turn", "second turn"], rows),
        f"Three cameras of 224 x 224 pixels at each pose of the arm, {others[0]['triangles']} triangles. Two of the cameras here "
        "do not move, and draw what stays once; the others draw all of each image, and Embree builds its tree once for three.",
        table(["CPU \u00b5s a step", "first turn", "second turn", "moved object ends elsewhere, mm"], steps),
        f"{stepped[0]['steps']} steps of 2 ms along the recorded targets of the task, each held until the next: the Panda, "
        f"{stepped[0]['objects']} objects and the table, {stepped[0]['hulls']} hulls.",
    ])


def read_by_others(given, dataset: Path) -> dict:
    python = environment_of(given.target_dir, "episode-judges", JUDGES / "episodes" / "requirements.txt")
    words = [python / "bin/python", JUDGES / "episodes" / "recorded.py", dataset, "--train", given.train]
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if not lines:
        raise Problem(f"recorded.py: {done.stderr[-1500:]}")
    return json.loads(lines[-1])


def replayed(given, scene: Path, folder: Path, dataset: Path, column: str) -> list:
    python = environment_of(given.target_dir, "robot-judges", JUDGES / "robots" / "requirements.txt")
    execution = folder / "execution"
    if not execution.exists():
        subprocess.run([str(given.binary), "execute", "--scene", scene, "--task", TASK, "--out", execution], check=False)
    script = JUDGES / "robots" / "replay_dataset.py"
    text = output_of(python / "bin/python", script, given.binary, scene, execution, dataset, column)
    return [json.loads(line) for line in text.splitlines() if line.startswith("{")]


def killed(given, scene: Path, out: Path, kills: int) -> tuple:
    """Records with so many SIGKILLs at random times; how many there were, and the digests of the datasets."""
    chance, done, digests = random.Random(1), 0, []
    words = command(given, scene, out, given.count, *ALL, "--workers", 2)
    while done < kills or not digests:
        process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        try:
            process.wait(timeout=chance.uniform(2.0, 14.0) if done < kills else None)
            digests.append(digest(out))
            subprocess.run(["rm", "-rf", out], check=True)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            done += 1
    if out.with_name(f"{out.name}.units").exists():
        process = subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
        digests.append(digest(out))
    return done, digests


def again_from_records(given, scene: Path, dataset: Path) -> list:
    """Of some episodes, whether `regenerate-episode` finds the recorded bytes."""
    chosen = random.Random(2).sample(range(given.count), min(given.regenerated, given.count))
    words = ["regenerate-episode", "--dataset", dataset, "--scene", scene, "--json", "--episode"]

    def is_same(episode: int) -> bool:
        done = subprocess.run([str(word) for word in (given.binary, *words, episode)], capture_output=True, text=True)
        return done.returncode == 0 and json.loads(done.stdout)["same"]

    return [is_same(episode) for episode in chosen]


def digest(dataset: Path) -> str:
    """Of every file but the cards, whose title is the folder's name."""
    total = hashlib.sha256()
    for path in sorted(path for path in dataset.rglob("*") if path.is_file() and path.name != "README.md"):
        total.update(str(path.relative_to(dataset)).encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()


if __name__ == "__main__":
    run(main)
