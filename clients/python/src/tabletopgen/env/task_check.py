"""Whether a task can be done at all, by physics and the judge, without a policy: a script moves the objects.

A task whose predicates hold before anything moves, or hold nowhere that objects can rest, would train nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tabletopgen.env import poses
from tabletopgen.env.compiled import compiled
from tabletopgen.env.engine import mujoco
from tabletopgen.env.folder import EnvironmentFolder
from tabletopgen.env.judge import Judge, Verdict
from tabletopgen.env.scripted_moves import Move, ScriptedMoves
from tabletopgen.env.simulation import Simulation
from tabletopgen.env.success import IN_HAND, REST_M_S

# Objects that move farther before the robot does do not rest.
SETTLED_M = 0.005
# Time until objects are judged after they were let go, and until they have to rest.
REST_S, MAX_S = 0.4, 3.0
# Reasons of the judge that no place of objects changes.
HOPELESS = ("no_opening", "not_decidable", "missing_object")


@dataclass(frozen=True)
class StartCheck:
    """What was found from one start: how far objects moved by themselves, and whether the goal was reached before
    anything was moved, after the script had moved what it names, and after all was put back."""

    start: int
    moved_m: float
    is_done_at_start: bool
    is_reached: bool
    is_undone: bool
    # Verdicts about the predicates that held nowhere, or were not tried after one that did not.
    missed: list[dict[str, Any]]

    @property
    def is_sound(self) -> bool:
        return self.moved_m < SETTLED_M and not self.is_done_at_start and self.is_reached and self.is_undone


class TaskCheck:
    """Checks the task of an environment."""

    def __init__(self, files: EnvironmentFolder):
        self.files = files
        self.simulation = Simulation(compiled(files), files.robot, files.objects)
        self.judge = Judge(files.scene, files.task)
        self.moves = ScriptedMoves(files, self.simulation)

    def starts(self, numbers: Sequence[int]) -> Iterator[StartCheck]:
        """The checks of some starts."""
        return map(self.start, numbers)

    def start(self, number: int) -> StartCheck:
        """The check of one start."""
        simulation, start = self.simulation, self.files.starts[number]
        simulation.begin(start)
        self.judge.begin(start)
        before = {name: simulation.matrix(name) for name in simulation.present}
        self._settle({})
        moved_m = max(float(np.linalg.norm(simulation.matrix(name)[:3, 3] - pose[:3, 3])) for name, pose in before.items())
        at_start, at_rest = self._verdict(), self._now()
        for place, predicate in enumerate(self.files.task["goal"]):
            if not self._make_hold(place, predicate):
                break
        reached = self._verdict()
        simulation.data.qpos[:], simulation.data.qvel[:] = at_rest, 0.0
        self._settle({})
        return StartCheck(
            start=number,
            moved_m=moved_m,
            is_done_at_start=at_start.reached,
            is_reached=reached.reached and not reached.disturbed,
            is_undone=not self._verdict().reached,
            missed=[predicate for predicate in reached.predicates if not predicate["holds"]],
        )

    def _make_hold(self, place: int, predicate: dict[str, Any]) -> bool:
        """Moves objects until this predicate of the goal and all before it hold; otherwise leaves them."""
        simulation, before = self.simulation, self._now()
        verdict = self._verdict()
        if held(verdict, place):
            return True
        if verdict.predicates[place]["reason"] in HOPELESS:
            return False
        is_held_up = predicate["predicate"] in IN_HAND
        for move in self.moves.of(predicate):
            self._settle(move, is_held_up)
            verdict = self._verdict()
            if held(verdict, place) and not verdict.disturbed:
                return True
            simulation.data.qpos[:], simulation.data.qvel[:] = before, 0.0
        mujoco.mj_forward(simulation.model, simulation.data)
        return False

    def _settle(self, move: Move, is_held_up: bool = False) -> None:
        """Puts objects somewhere and lets all come to rest, while the robot stays; what is held up stays, too."""
        simulation = self.simulation
        for name, pose in move.items():
            simulation.put(name, poses.to_record(pose))
        mujoco.mj_forward(simulation.model, simulation.data)
        if is_held_up:
            return
        targets = simulation.data.ctrl[simulation.robot.servos].copy()
        began_s, rested_s = simulation.data.time, 0.0
        while simulation.data.time < began_s + MAX_S and rested_s < REST_S:
            simulation.move(targets, simulation.data.time + 0.1)
            rested_s = rested_s + 0.1 if simulation.fastest_m_s() < REST_M_S else 0.0

    def _now(self) -> Any:
        return self.simulation.data.qpos.copy()

    def _verdict(self) -> Verdict:
        return self.judge.verdict(self.simulation.state())

    def close(self) -> None:
        self.judge.close()


def held(verdict: Verdict, place: int) -> bool:
    """Whether all predicates up to one hold."""
    return all(predicate["holds"] for predicate in verdict.predicates[: place + 1])
