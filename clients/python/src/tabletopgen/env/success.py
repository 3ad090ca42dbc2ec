"""When a task counts as done: as the recorder of the datasets decides it.

The hand is as far away as the task asks, all objects have rested for as long as it asks, every predicate of the goal
holds, nothing else was moved farther than permitted, and the time is not up. The program is asked only in states in
which the rest is so, and once for each arrangement.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from tabletopgen.env.judge import Verdict
from tabletopgen.env.poses import Array
from tabletopgen.env.simulation import Simulation

# Objects slower than this are at rest.
REST_M_S = 0.005
# Objects that are so near to where they were make no other arrangement.
SAME_M, SAME_RAD = 1e-3, 1e-2
# Predicates that hold with the object in the hand.
IN_HAND = ("lifted",)


class SuccessWatch:
    """Watches one episode; `verdict` is the program's newest, `None` before the first."""

    def __init__(self, simulation: Simulation, task: Mapping[str, Any], judged: Callable[[Mapping[str, Any]], Verdict]):
        self.simulation, self.limits, self.judged = simulation, task["limits"], judged
        self.ends_in_hand = any(predicate["predicate"] in IN_HAND for predicate in task["goal"])
        self.verdict: Verdict | None = None
        self._rested_s = 0.0
        self._decided_at: Array = np.empty((0, 7))

    def begin(self) -> None:
        """Begins to watch an episode in its first state, in which no task is done."""
        self.verdict, self._rested_s = None, 0.0
        self._decided_at = self.simulation.arrangement()

    def is_done(self, passed_s: float) -> bool:
        """Whether the task is done now, so many seconds of simulation after it was asked last."""
        simulation, limits = self.simulation, self.limits
        self._rested_s = self._rested_s + passed_s if simulation.fastest_m_s() < REST_M_S else 0.0
        if self._rested_s < limits["min_rest_s"] - 1e-9 or simulation.data.time > limits["max_duration_s"]:
            return False
        arrangement = simulation.arrangement()
        # An arrangement in which the task was done would have ended the episode.
        if is_same(arrangement, self._decided_at):
            return False
        if not (self.ends_in_hand or simulation.hand_is_away(limits["min_gripper_distance_m"])):
            return False
        self._decided_at, self.verdict = arrangement, self.judged(simulation.state())
        return self.verdict.reached and not self.verdict.disturbed


def is_same(arrangement: Array, before: Array) -> bool:
    """Whether all objects are where they were."""
    moved_m = np.linalg.norm(arrangement[:, :3] - before[:, :3], axis=1)
    cosines = np.abs((arrangement[:, 3:] * before[:, 3:]).sum(1))
    return bool(moved_m.max(initial=0.0) < SAME_M and cosines.min(initial=1.0) > np.cos(0.5 * SAME_RAD))
