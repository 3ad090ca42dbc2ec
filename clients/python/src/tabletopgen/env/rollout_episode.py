"""One episode of a rollout: a policy acts in an environment until that ends."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from tabletopgen.env.animated_png import AnimatedPng
from tabletopgen.env.policies import policy_of
from tabletopgen.env.policy import Description, Policy, PolicyFailedError, PolicyUnavailableError, description_of
from tabletopgen.env.rollout_factors import StartFactors
from tabletopgen.env.rollout_folder import VIDEOS, RolloutFolder
from tabletopgen.env.rollout_order import Episode
from tabletopgen.env.rollout_request import Request
from tabletopgen.env.scene_env import Observation, SceneEnv
from tabletopgen.env.vectors import Vector

# Environments that stay open in a process; others are made again.
OPEN = 8
# Ends of an episode.
DONE, TIME, UNSTABLE, POLICY_ERROR = "done", "time", "unstable", "policy_error"
ERROR_LENGTH = 2000

Answer = TypeVar("Answer")


@dataclass
class Course:
    """What happened in an episode so far."""

    actions: list[Vector]
    reason: str | None = None
    error: str | None = None
    info: Mapping[str, Any] | None = None
    policy_s: float = 0.0


class Episodes:
    """Runs episodes of a rollout in this process, and writes their actions and videos."""

    def __init__(self, request: Request, folder: RolloutFolder, is_wanted: Callable[[], bool] = lambda: True):
        self.request, self.folder, self.is_wanted = request, folder, is_wanted
        self._open: OrderedDict[int, tuple[SceneEnv, StartFactors]] = OrderedDict()
        self._policy: Policy | None = None

    def run(self, episode: Episode) -> dict[str, Any] | None:
        """The record of an episode; `None` if it is no longer wanted."""
        env, factors = self._environment(episode.environment)
        policy = self._made(env)
        video = AnimatedPng(env.files.fps) if episode.number < self.request.videos else None
        began_s = time.perf_counter()
        observed, _ = env.reset(seed=episode.seed, options={"start": episode.start})
        start = factors.of(env.starts[episode.start])
        course = self._acted(env, policy, episode, observed, video)
        if course.reason is None:
            return None
        if video is not None:
            self.folder.write(f"{VIDEOS}/{episode.number:06d}.png", video.content())
        numbers = np.array(course.actions, dtype=np.float32).reshape(-1, len(env.action_names))
        self.folder.write_actions(episode.number, numbers, env.simulation.data.qpos.copy())
        took = {"wall_s": round(time.perf_counter() - began_s, 3), "policy_s": round(course.policy_s, 3)}
        return {**self._identity(episode, env), **outcome(env, course), **took, **start}

    def _identity(self, episode: Episode, env: SceneEnv) -> dict[str, Any]:
        return {
            "episode": episode.number,
            "environment": self.request.environments[episode.environment],
            "start": episode.start,
            "recorded_episode": env.starts[episode.start].episode,
            "seed": episode.seed,
        }

    def _environment(self, place: int) -> tuple[SceneEnv, StartFactors]:
        if place not in self._open:
            if len(self._open) == OPEN:
                self._open.popitem(last=False)[1][0].close()
            env = environment_of(self.request, place, draws=self.request.videos > 0)
            self._open[place] = env, StartFactors(env, env.files)
        self._open.move_to_end(place)
        return self._open[place]

    def _made(self, env: SceneEnv) -> Policy:
        if self._policy is None:
            self._policy = policy_of(self.request.policy, self._description(env), self.request.chunk)
        return self._policy

    def _description(self, env: SceneEnv) -> Description:
        return description_of(env, env.files, self.request.action_mode, self.request.rename)

    def _acted(self, env: SceneEnv, policy: Policy, episode: Episode, observed: Observation, video: AnimatedPng | None) -> Course:
        """Lets the policy act until the episode ends."""
        course = Course([])
        begin = {**self._identity(episode, env), "environment": str(env.files.folder), "instruction": env.task_description}
        asked(course, policy.reset, begin)
        show(env, video)
        while course.reason is None and self.is_wanted():
            action = asked(course, self._action, policy, observed, env)
            if action is None:
                break
            began_s = env.simulation.data.time
            try:
                observed, _, is_done, is_cut, info = env.step(action)
            except ValueError as error:
                if env.simulation.data.time != began_s:
                    raise
                # Numbers that are no action moved nothing.
                course.reason, course.error = POLICY_ERROR, said(error)
                break
            course.actions.append(action)
            course.info = info
            show(env, video)
            course.reason = end_of(is_done, is_cut, info)
        return course

    def _action(self, policy: Policy, observed: Observation, env: SceneEnv) -> Vector:
        """The numbers of an action as they are recorded, so that the recorded ones give the same motion."""
        named = {self.request.rename.get(name, name): part for name, part in observed.items()}
        action: Vector = np.array(policy.act(named), dtype=np.float32)
        if action.shape != (len(env.action_names),):
            names = env.action_names
            raise PolicyFailedError(f"an action of shape {action.shape} was given, where one has {len(names)} numbers: {', '.join(names)}")
        return action

    def close(self) -> None:
        """Frees environments and policy."""
        for env, _ in self._open.values():
            env.close()
        self._open.clear()
        close = getattr(self._policy, "close", None)
        if callable(close):
            close()


def environment_of(request: Request, place: int, *, draws: bool = False) -> SceneEnv:
    """An environment of a rollout, which can draw videos."""
    return SceneEnv(
        folder=request.folders[place],
        action_mode=request.action_mode,
        images=request.images,
        object_poses=request.object_poses,
        max_duration_s=request.max_duration_s,
        render_mode="rgb_array" if draws else None,
    )


def end_of(is_done: bool, is_cut: bool, info: Mapping[str, Any]) -> str | None:
    """How a step ends an episode; `None` if it does not."""
    if is_done:
        return DONE
    if not is_cut:
        return None
    return UNSTABLE if info.get("unstable") else TIME


def asked(course: Course, function: Callable[..., Answer], *arguments: Any) -> Answer | None:
    """What a policy answers. Its errors end the episode, unless it cannot be asked at all."""
    began_s = time.perf_counter()
    try:
        return function(*arguments)
    except PolicyUnavailableError:
        raise
    except Exception as error:
        course.reason, course.error = POLICY_ERROR, said(error)
        return None
    finally:
        course.policy_s += time.perf_counter() - began_s


def outcome(env: SceneEnv, course: Course) -> dict[str, Any]:
    """How an episode ended. The verdict is the newest of the environment, or one about the last state."""
    is_stable = course.reason != UNSTABLE
    found = dict(course.info or {})
    if is_stable and course.reason != DONE:
        verdict = env.verdict()
        found |= {"predicates": verdict.predicates, "disturbed": verdict.disturbed}
    return {
        "success": course.reason == DONE,
        "reason": course.reason,
        "error": course.error,
        "steps": len(course.actions),
        "simulated_s": len(course.actions) * env.step_s,
        "predicates": found.get("predicates", []),
        "disturbed": found.get("disturbed", []),
        "final_poses": {name: env.simulation.pose(name) for name in env.simulation.present} if is_stable else None,
    }


def show(env: SceneEnv, video: AnimatedPng | None) -> None:
    """Adds what the camera of the scene sees now to a video."""
    if video is not None and (frame := env.render()) is not None:
        video.add(frame)


def said(error: Exception) -> str:
    """An error in words."""
    return f"{type(error).__name__}: {error}"[:ERROR_LENGTH]
