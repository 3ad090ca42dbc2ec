"""LeRobot loads a package of its EnvHub and evaluates a policy in it that repeats recorded episodes.

    replay_envhub.py PACKAGE DATASET [--episodes N]

PACKAGE is what `python -m tabletopgen.env envhub` wrote of an environment, DATASET the episodes that this was prepared
from. LeRobot's own `make_env` finds the package in a cache of the Hub that has nothing else, without a network, and its
own `eval_policy` counts. Needs `lerobot`, beside what clients/python needs for `env`. Prints one line of JSON.
"""

import argparse
import json
import os
import re
import sys
import tempfile
from pathlib import Path

COMMIT = "0" * 40


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("package", type=Path)
    parser.add_argument("dataset", type=Path)
    parser.add_argument("--episodes", type=int, default=4)
    given = parser.parse_args()
    repository = re.search(r'REPOSITORY = "(.*)"', (given.package / "env.py").read_text())[1]
    with tempfile.TemporaryDirectory() as cache:
        own = Path(cache) / f"models--{repository.replace('/', '--')}"
        (own / "refs").mkdir(parents=True)
        (own / "refs" / "main").write_text(COMMIT)
        (own / "snapshots").mkdir()
        (own / "snapshots" / COMMIT).symlink_to(given.package.resolve())
        # Packages read these when they are imported.
        os.environ |= {"HF_HUB_CACHE": cache, "HF_HUB_OFFLINE": "1"}
        sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "clients" / "python" / "src"))
        print(json.dumps(evaluated(repository, given.dataset, given.episodes)))


def evaluated(repository: str, dataset: Path, episodes: int) -> dict:
    """What LeRobot counts."""
    import lerobot
    import numpy as np
    import torch
    from lerobot.envs.factory import make_env
    from lerobot.envs.utils import close_envs
    from lerobot.policies.pretrained import PreTrainedPolicy
    from lerobot.processor.pipeline import PolicyProcessorPipeline
    from lerobot.scripts.lerobot_eval import eval_policy

    from tabletopgen.env.recorded_dataset import RecordedDataset

    recorded = RecordedDataset(dataset)
    frames = [recorded.frames(entry["episode_index"]) for entry in recorded.entries]

    class Repeating(PreTrainedPolicy):
        """A policy of LeRobot's kind that repeats the episode whose first state it sees."""

        name, config_class = "repeating", object

        def __init__(self):
            torch.nn.Module.__init__(self)
            self.reset()

        def reset(self):
            self.actions, self.step = None, 0

        def select_action(self, batch):
            states = batch["observation.state"].numpy()
            if self.actions is None:
                firsts = np.stack([one["observation.state"][0] for one in frames])
                self.actions = [frames[int(np.abs(firsts - state).max(1).argmin())]["action"] for state in states]
            asked = [rows[min(self.step, len(rows) - 1)] for rows in self.actions]
            self.step += 1
            return torch.from_numpy(np.stack(asked))

        def forward(self, batch):
            raise NotImplementedError

        def get_optim_params(self):
            raise NotImplementedError

        def predict_action_chunk(self, batch):
            raise NotImplementedError

    environments = make_env(repository, n_envs=2, trust_remote_code=True)
    (vector,) = (of_task[0] for of_task in environments.values())
    same = PolicyProcessorPipeline(steps=[])
    found = eval_policy(vector, Repeating(), same, same, lambda seen: seen, lambda action: action, n_episodes=episodes, start_seed=0)
    close_envs(environments)
    successes = [bool(one["success"]) for one in found["per_episode"]]
    return {"lerobot": lerobot.__version__, "episodes": len(successes), "successes": sum(successes)}


if __name__ == "__main__":
    main()
