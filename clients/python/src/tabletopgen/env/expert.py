"""An expert without a policy: it repeats the recorded actions of the episode whose start it gets."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from tabletopgen.env.recorded_dataset import Numbers, RecordedDataset
from tabletopgen.env.scene_env import SceneEnv
from tabletopgen.env.vectors import action_names

# The last action is repeated for this long: recorded episodes end before objects have rested as long as a task asks.
HOLD_S = 3.0


@dataclass(frozen=True)
class Repeat:
    """One episode: whether its task was done, after how many steps, in how many seconds of this machine, and what the
    judge said last."""

    start: int
    episode: int
    is_success: bool
    steps: int
    wall_s: float
    predicates: list[dict[str, Any]]


class Expert:
    """Repeats a dataset in an environment that was prepared from it."""

    def __init__(self, env: SceneEnv, dataset: RecordedDataset):
        self.env, self.dataset = env, dataset
        names = action_names(env.files.robot.joints)
        self.columns = [names.index(name) for name in env.action_names]

    def actions(self, episode: int) -> Numbers:
        """The actions of an episode as the environment takes them, (frames, numbers)."""
        return self.dataset.frames(episode, ["action"])["action"][:, self.columns]

    def repeats(self, starts: Sequence[int]) -> Iterator[Repeat]:
        """Repeats the episodes of some starts."""
        return map(self.repeat, starts)

    def repeat(self, start: int) -> Repeat:
        """Repeats one episode from its start."""
        actions = self.actions(self.env.starts[start].episode)
        last = len(actions) + round(HOLD_S / self.env.step_s)
        began_s = time.perf_counter()
        self.env.reset(options={"start": start})
        info: dict[str, Any] = {}
        steps, is_over = 0, False
        while steps < last and not is_over:
            _, _, is_done, is_cut, info = self.env.step(actions[min(steps, len(actions) - 1)])
            steps, is_over = steps + 1, is_done or is_cut
        return Repeat(
            start=start,
            episode=self.env.starts[start].episode,
            is_success=info["is_success"],
            steps=steps,
            wall_s=time.perf_counter() - began_s,
            predicates=info.get("predicates", []),
        )
