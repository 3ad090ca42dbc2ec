"""The environment of a task: a robot in a scene, with observations, actions and success as in datasets."""

from __future__ import annotations

from pathlib import Path
from typing import Any, SupportsFloat, TypeAlias, cast

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from tabletopgen.env.appearance import Appearance
from tabletopgen.env.cameras import CameraImages, Image
from tabletopgen.env.compiled import OVERVIEW, RENDER_PX, compiled
from tabletopgen.env.control import CONTROLS, Control
from tabletopgen.env.engine import mujoco
from tabletopgen.env.folder import EnvironmentFolder
from tabletopgen.env.judge import Judge, Verdict
from tabletopgen.env.preparation import prepared
from tabletopgen.env.simulation import Simulation
from tabletopgen.env.start import Start
from tabletopgen.env.success import SuccessWatch
from tabletopgen.env.tracking import Tracking
from tabletopgen.env.vectors import StateVector, Vector, state_names

STATE, OBJECTS, IMAGES = "observation.state", "observation.environment_state", "observation.images."
# Bounds of what is observed, beyond all that a robot on a table does.
MAX_NUMBER = 100.0

Observation: TypeAlias = dict[str, NDArray[Any]]


class SceneEnv(gymnasium.Env[Observation, Vector]):
    """A task in a scene, by MuJoCo.

    The environment is that of a `folder` which `prepare` wrote, or it is prepared from a `scene` (the folder of a
    bundle), a `task` and a `robot`, and kept in the cache of the user; `dataset` and `options` are those of `prepare`.

    `action_mode` is `joint`, `tool` or `recorded` (`control.py`). `images` leaves cameras out if false. `object_poses`
    adds `observation.environment_state`: position in meters and quaternion (w first) of each object in the frame of
    the scene, of an absent one zeros. `max_duration_s` ends an episode before the time that the task gives. `program`
    is the one that judges, by default that of the wheel or on PATH."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 15}

    def __init__(
        self,
        scene: str | Path | None = None,
        task: str | Path | None = None,
        robot: str = "panda",
        *,
        folder: str | Path | None = None,
        dataset: str | Path | None = None,
        action_mode: str = "joint",
        images: bool = True,
        object_poses: bool = False,
        max_duration_s: float | None = None,
        program: Path | None = None,
        render_mode: str | None = None,
        **options: Any,
    ):
        if (folder is None) == (scene is None):
            raise ValueError("give a scene, or the folder of an environment that was prepared")
        if action_mode not in CONTROLS:
            raise ValueError(f"there is no action mode {action_mode!r}; choose one of {', '.join(CONTROLS)}")
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"there is no render mode {render_mode!r}; choose one of {', '.join(self.metadata['render_modes'])}")
        self.files = EnvironmentFolder.read(folder) if folder is not None else prepared(scene or "", task, robot, dataset, **options)
        self.task, self.starts, self.render_mode = self.files.task, self.files.starts, render_mode
        self.task_description = str(self.task["instruction"])
        self.step_s = 1.0 / self.files.fps
        self.max_duration_s = min(max_duration_s or float("inf"), self.task["limits"]["max_duration_s"])
        self._max_episode_steps = int(np.ceil(self.max_duration_s * self.files.fps - 1e-9))
        self.metadata = {**type(self).metadata, "render_fps": self.files.fps}
        self.simulation = Simulation(compiled(self.files), self.files.robot, self.files.objects, sleeps=True)
        self.cameras = CameraImages(self.simulation.model, self.files.cameras, self.simulation.robot.tool_site)
        self.appearance = Appearance(self.simulation.model, self.simulation.geoms)
        self._shows_images, self._shows_objects = images and bool(self.files.cameras), object_poses
        self._control: Control = CONTROLS[action_mode](self.simulation, self.step_s)
        self._tracking = Tracking(self.simulation.robot, self.step_s)
        self._judge = Judge(self.files.scene, self.task, program)
        self._watch = SuccessWatch(self.simulation, self.task, self._judge.verdict)
        low, high = self._control.bounds()
        self.action_space = spaces.Box(low, high, dtype=np.float32)
        self.action_names = self._control.names
        self.state_names = state_names(self.files.robot.joints)
        self.observation_space = cast("spaces.Space[Observation]", self._observed_space())

    def _observed_space(self) -> spaces.Dict:
        def numbers(count: int) -> spaces.Box:
            return spaces.Box(-MAX_NUMBER, MAX_NUMBER, (count,), np.float32)

        parts: dict[str, spaces.Space[Any]] = {STATE: numbers(len(self.state_names))}
        if self._shows_objects:
            parts[OBJECTS] = numbers(7 * len(self.files.objects))
        for camera in self.files.cameras if self._shows_images else ():
            parts[IMAGES + camera.name] = spaces.Box(0, 255, (camera.height_px, camera.width_px, 3), np.uint8)
        return spaces.Dict(parts)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        """Begins an episode from one of the recorded starts, drawn evenly, or from that of `options["start"]`, the
        place of one in `starts`."""
        super().reset(seed=seed)
        chosen = (options or {}).get("start")
        number = int(self.np_random.integers(len(self.starts))) if chosen is None else int(chosen)
        if not 0 <= number < len(self.starts):
            raise ValueError(f"there is no start {number}; the environment has {len(self.starts)}, which count from 0")
        start = self.starts[number]
        self._begin(start)
        return self._observation(), {"start": number, "episode": start.episode, "is_success": False}

    def _begin(self, start: Start) -> None:
        self.cameras.place(start.cameras)
        self.appearance.begin(start)
        self.simulation.begin(start)
        self._judge.begin(start)
        self._watch.begin()
        self._state = StateVector(self.simulation.robot.max_opening_m, start.tool_quaternion_wxyz)
        self._tracking.begin(np.array(start.positions_rad))
        self._steps = 0

    def step(self, action: Vector) -> tuple[Observation, SupportsFloat, bool, bool, dict[str, Any]]:
        """Moves to an action within a step of the datasets' rate. The reward is 1 in the step that finds the task done,
        which ends the episode, and 0 in all others."""
        robot = self.simulation.robot
        asked_rad, opening_m = self._control.asked(action, self._tracking.asked_rad)
        pulled_rad = self._tracking.targets(asked_rad, robot.positions_rad(self.simulation.data))
        self._steps += 1
        self.simulation.move(robot.servo_targets(pulled_rad, opening_m), self._steps * self.step_s)
        is_stable = self.simulation.is_stable()
        is_done = is_stable and self._watch.is_done(self.step_s)
        info: dict[str, Any] = {"is_success": is_done}
        if self._watch.verdict is not None:
            info |= {"predicates": self._watch.verdict.predicates, "disturbed": self._watch.verdict.disturbed}
        if not is_stable:
            info["unstable"] = True
        is_over = not is_done and (self._steps >= self._max_episode_steps or not is_stable)
        return self._observation(), float(is_done), is_done, is_over, info

    def verdict(self) -> Verdict:
        """The program's verdict about the predicates in this state, whether or not anything rests."""
        return self._judge.verdict(self.simulation.state())

    def _observation(self) -> Observation:
        data, robot = self.simulation.data, self.simulation.robot
        positions_rad, velocities_rad_s = robot.positions_rad(data), data.qvel[robot.arm_dof]
        state = self._state.numbers(positions_rad, velocities_rad_s, robot.base_from_tool(data), robot.opening_m(data))
        observed: Observation = {STATE: np.clip(state, -MAX_NUMBER, MAX_NUMBER)}
        if self._shows_objects:
            observed[OBJECTS] = self._object_poses()
        if self._shows_images:
            mujoco.mj_camlight(self.simulation.model, data)
            observed |= {IMAGES + name: image for name, image in self.cameras.images(data).items()}
        return observed

    def _object_poses(self) -> Vector:
        simulation, numbers = self.simulation, np.zeros((len(self.files.objects), 7), dtype=np.float32)
        for place, name in enumerate(simulation.objects):
            if name in simulation.present:
                numbers[place] = simulation.data.qpos[simulation.qpos[name] : simulation.qpos[name] + 7]
        return np.clip(numbers, -MAX_NUMBER, MAX_NUMBER).ravel()

    def render(self) -> Image | None:
        """What the camera of the scene sees, (height, width, 3), in the mode `rgb_array`."""
        if self.render_mode is None:
            return None
        mujoco.mj_camlight(self.simulation.model, self.simulation.data)
        return self.cameras.image(self.simulation.data, OVERVIEW, *RENDER_PX)

    def close(self) -> None:
        """Frees renderers, and the files of the judge."""
        self.cameras.close()
        self._judge.close()
