"""The recorded actions of a suite as a policy: what can be reached in it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tabletopgen.env.policies import RecordedPolicy
from tabletopgen.env.policy import Description
from tabletopgen.env.scene_env import Observation
from tabletopgen.env.suite import EPISODES
from tabletopgen.env.vectors import Vector


class SuiteExpert:
    """Repeats the actions of the recorded episode whose start it gets, in any environment of a suite."""

    def __init__(self, description: Description):
        self.description = description
        self.experts: dict[Path, RecordedPolicy] = {}
        self.expert: RecordedPolicy | None = None

    def reset(self, info: Mapping[str, Any]) -> None:
        environment = Path(info["environment"])
        if environment not in self.experts:
            episodes = environment.parent.parent / EPISODES / environment.name
            self.experts[environment] = RecordedPolicy(str(episodes), self.description)
        self.expert = self.experts[environment]
        self.expert.reset(info)

    def act(self, observation: Observation) -> Vector:
        assert self.expert is not None
        return self.expert.act(observation)
