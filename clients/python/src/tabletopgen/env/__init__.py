"""Environments of Gymnasium for tasks in scenes, by MuJoCo.

    import gymnasium
    import tabletopgen.env

    env = gymnasium.make("tabletopgen/Scene-v0", scene="out/desk", task="put the mug on the plate", robot="panda")

Observations, actions and success are those of the datasets of `tabletopgen episodes` (`SceneEnv`).
"""

import gymnasium

from tabletopgen.env.folder import EnvironmentFolder
from tabletopgen.env.preparation import prepare
from tabletopgen.env.scene_env import SceneEnv

ID = "tabletopgen/Scene-v0"

gymnasium.register(ID, entry_point="tabletopgen.env.scene_env:SceneEnv")

__all__ = ["ID", "EnvironmentFolder", "SceneEnv", "prepare"]
