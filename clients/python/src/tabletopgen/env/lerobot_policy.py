"""Policies that LeRobot trained, run from a checkpoint as LeRobot 0.4.4 evaluates them: `lerobot-eval`.

Observations become tensors as by `preprocess_observation`. They go through the checkpoint's preprocessor, the policy's
`select_action`, and the checkpoint's postprocessor.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from tabletopgen._media import imported
from tabletopgen.env.envhub import renamed
from tabletopgen.env.policy import Description
from tabletopgen.env.scene_env import IMAGES, OBJECTS, STATE, Observation
from tabletopgen.env.vectors import Vector

CONFIG = "config.json"


class LeRobotPolicy:
    """The policy of a checkpoint: a folder with `config.json`, the weights and both processors."""

    def __init__(self, checkpoint: str, description: Description):
        if not (Path(checkpoint) / CONFIG).is_file():
            raise ValueError(f"{checkpoint} is no checkpoint of LeRobot: it has no {CONFIG}; name a folder `pretrained_model`")
        factory = imported("lerobot.policies.factory", "lerobot")
        config = imported("lerobot.configs.policies", "lerobot").PreTrainedConfig.from_pretrained(checkpoint)
        config.pretrained_path = checkpoint
        refuse_others(checkpoint, config, description)
        self._torch = imported("torch")
        self.device = str(config.device)
        self.policy = factory.get_policy_class(config.type).from_pretrained(checkpoint, config=config)
        self.policy.to(self.device)
        self.policy.eval()
        self._before, self._after = factory.make_pre_post_processors(
            policy_cfg=config,
            pretrained_path=checkpoint,
            preprocessor_overrides={"device_processor": {"device": self.device}},
        )
        self._as_tensors = imported("lerobot.envs.utils", "lerobot").preprocess_observation
        self._uses_amp = bool(config.use_amp)
        self._task = str(description["instruction"])

    def reset(self, info: Mapping[str, Any]) -> None:
        """Begins an episode; what the policy draws by chance depends on the episode alone."""
        self._torch.manual_seed(int(info["seed"]))
        self._task = str(info["instruction"])
        self.policy.reset()

    def act(self, observation: Observation) -> Vector:
        """The action after an observation."""
        torch = self._torch
        batch = self._as_tensors(one_of(renamed(observation)))
        batch["task"] = [self._task]
        precision = torch.autocast(device_type=torch.device(self.device).type) if self._uses_amp else nullcontext()
        with torch.inference_mode(), precision:
            action = self._after(self.policy.select_action(self._before(batch)))
        found: Vector = action.to("cpu").float().numpy()[0]
        return found

    def close(self) -> None:
        """Nothing is held open."""


def one_of(observed: Mapping[str, Any]) -> dict[str, Any]:
    """A batch of one observation."""
    return {name: one_of(part) if isinstance(part, Mapping) else np.asarray(part)[None] for name, part in observed.items()}


def refuse_others(checkpoint: str, config: Any, description: Description) -> None:
    """Refuses a policy that was trained on other observations or actions than an environment has."""
    own = {name: tuple(shape) for name, shape in description["observation_shapes"].items()}
    # LeRobot has images as channels, rows, columns.
    own = {name: (shape[2], shape[0], shape[1]) if name.startswith(IMAGES) else shape for name, shape in own.items()}
    for name, feature in (config.input_features or {}).items():
        shape = tuple(feature.shape)
        if name not in own:
            raise ValueError(
                f"the policy in {checkpoint} observes {name!r}, which the environment {description['environment']} does not have"
                f" ({', '.join(sorted(own))}); prepare the environment from the policy's dataset"
                f"{', or add --object-poses' if name == OBJECTS else ''}"
            )
        if name == STATE and shape != own[name]:
            raise ValueError(f"the policy in {checkpoint} observes {shape[0]} numbers as {name}, the environment has {own[name][0]}")
    numbers = (config.output_features or {})["action"].shape[0]
    if numbers != len(description["action_names"]):
        raise ValueError(
            f"the policy in {checkpoint} has actions of {numbers} numbers, the mode {description['action_mode']!r} of the environment"
            f" {description['environment']} has {len(description['action_names'])}; choose another --action-mode"
        )
