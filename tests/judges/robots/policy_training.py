"""A small policy is trained on recorded episodes by behavior cloning, on the CPU.

    policy_training.py DATASET MJCF WEIGHTS [--epochs N] [--episodes N] [--seed N]

DATASET has the format `parquet-png`; MJCF is that of its robot, without the scene. The policy gives, from what is
observed at a frame (policy_observation.py), what the servos are asked for in each of the next frames. WEIGHTS is
written as numpy reads it. Prints one line of JSON: loss, frames, CPU seconds, and how many episodes differ in their
actions.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np
import pyarrow.parquet as parquet
import torch

from policy_observation import Chain, base_from_objects, observed, pose_of

# The policy asks for so many frames at a time.
CHUNK_FRAMES = 16
WIDTH, LAYERS = 512, 3
BATCH, RATE, DECAY = 1024, 1e-3, 1e-4
# Joint positions are perturbed by this while the targets stay, so that the policy learns to come back.
NOISE_RAD, NOISE_OPENING_M, NOISY_COPIES = 0.01, 0.0005, 6
# Numbers that vary by less are not blown up: where nothing varies in training, what is unseen stays moderate.
SMALLEST_SPREAD = 0.02
# Each so many-th episode is held out for the loss that is reported.
HELD_OUT = 20


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path)
    parser.add_argument("mjcf", type=Path)
    parser.add_argument("weights", type=Path)
    parser.add_argument("--epochs", type=int, default=60)
    parser.add_argument("--episodes", type=int, default=0, help="the first so many, or all")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    torch.manual_seed(given.seed)
    torch.set_num_threads(1)
    started_s = time.process_time()
    episodes, joints, base = episodes_of(given.dataset, given.episodes)
    chain = Chain(given.mjcf, joints)
    check_chain(chain, episodes)
    random = np.random.default_rng(given.seed)
    held = examples(chain, episodes[::HELD_OUT], None)
    kept = [episode for index, episode in enumerate(episodes) if index % HELD_OUT]
    copies = [examples(chain, kept, random) for _ in range(NOISY_COPIES)]
    scales = scales_of(*examples(chain, kept, None))
    network, losses = trained(copies, held, scales, given.epochs)
    linear = [layer for layer in network if isinstance(layer, torch.nn.Linear)]
    norms = [layer for layer in network if isinstance(layer, torch.nn.LayerNorm)]
    arrays = {f"weight_{k}": layer.weight for k, layer in enumerate(linear)}
    arrays |= {f"bias_{k}": layer.bias for k, layer in enumerate(linear)}
    arrays |= {f"gain_{k}": layer.weight for k, layer in enumerate(norms)}
    arrays |= {f"shift_{k}": layer.bias for k, layer in enumerate(norms)}
    arrays = {name: array.detach().numpy() for name, array in arrays.items()}
    np.savez(given.weights, joints=np.array(joints), world_from_base=base, **scales, **arrays)
    print(json.dumps({
        "episodes": len(kept), "held_out": len(episodes) - len(kept), "frames": sum(len(one["q"]) for one in kept),
        "parameters": sum(array.size for array in arrays.values()), "epochs": given.epochs,
        "different": len({one["targets"].tobytes() for one in episodes}), **losses, "cpu_s": time.process_time() - started_s,
    }))


def episodes_of(dataset: Path, count: int) -> tuple:
    """The episodes, the names of the joints, and where the base stands in all of them."""
    root = dataset / "parquet-png"
    action = json.loads((root / "dataset.json").read_text())["description"]["action"]
    joints = [element["name"] for element in action if element["group"] == "arm"]
    opening = [element["name"] for element in action].index("gripper_opening")
    arm = len(joints)
    episodes, bases = [], []
    for line in (root / "records.jsonl").read_text().splitlines()[: count or None]:
        entry = json.loads(line)
        frames = parquet.read_table(root / "episodes" / f"episode_{entry['episode_index']:06d}" / "frames.parquet")
        states, actions = (np.stack(frames[key].to_pylist()) for key in ("observation.state", "action"))
        bases.append(pose_of(entry["record"]["world_from_base"]))
        episodes.append({
            "q": states[:, :arm], "opening": states[:, -2], "tool": states[:, 2 * arm : 2 * arm + 3],
            "targets": np.concatenate([actions[:, :arm], actions[:, opening : opening + 1]], axis=1),
            "objects": base_from_objects(entry["record"], bases[-1]),
        })
    if not all(np.array_equal(base, bases[0]) for base in bases):
        raise SystemExit("the base does not stand at one place in all episodes")
    return episodes, joints, bases[0]


def check_chain(chain: Chain, episodes: list) -> None:
    one = episodes[0]
    error_m = np.abs(chain.base_from_tool(one["q"])[:, :3, 3] - one["tool"]).max()
    if error_m > 1e-4:
        raise SystemExit(f"the MJCF has the tool {error_m} m from where the dataset has it")


def examples(chain: Chain, episodes: list, random) -> tuple:
    """What is observed, with noise if `random`, and the next targets: of the joints from where they are."""
    seen, wanted = [], []
    for one in episodes:
        q, opening, count = one["q"], one["opening"], len(one["q"])
        if random is not None:
            q = q + random.normal(0.0, NOISE_RAD, q.shape)
            opening = opening + random.normal(0.0, NOISE_OPENING_M, opening.shape)
        seen.append(observed(chain, q, opening, np.broadcast_to(one["objects"], (count, *one["objects"].shape))))
        # After the last frame the last targets stay.
        ahead = np.minimum(np.arange(count)[:, None] + np.arange(CHUNK_FRAMES), count - 1)
        chunk = one["targets"][ahead].copy()
        chunk[:, :, :-1] -= q[:, None]
        wanted.append(chunk.reshape(count, -1))
    return np.concatenate(seen).astype(np.float32), np.concatenate(wanted).astype(np.float32)


def scales_of(seen: np.ndarray, wanted: np.ndarray) -> dict:
    # All joints in all frames have one scale, so that an error of any counts the same; the opening has one, too.
    chunk = wanted.reshape(len(wanted), CHUNK_FRAMES, -1)
    spread = np.full(chunk.shape[1:], chunk[:, :, :-1].std())
    spread[:, -1] = chunk[:, :, -1].std()
    return {
        "seen_mean": seen.mean(0), "seen_spread": np.maximum(seen.std(0), SMALLEST_SPREAD),
        "wanted_mean": wanted.mean(0), "wanted_spread": spread.ravel().astype(np.float32),
    }


def trained(copies: list, held: tuple, scales: dict, epochs: int) -> tuple:
    """The network, and its losses: mean absolute errors in units of the spread, and those of joints in radians."""
    scaled = lambda pair: (  # noqa: E731
        torch.from_numpy((pair[0] - scales["seen_mean"]) / scales["seen_spread"]),
        torch.from_numpy((pair[1] - scales["wanted_mean"]) / scales["wanted_spread"]),
    )
    copies, held = [scaled(pair) for pair in copies], scaled(held)
    sizes = [held[0].shape[1], *[WIDTH] * LAYERS]
    layers = []
    for inputs, outputs in zip(sizes, sizes[1:]):
        layers += [torch.nn.Linear(inputs, outputs), torch.nn.LayerNorm(outputs), torch.nn.ReLU()]
    network = torch.nn.Sequential(*layers, torch.nn.Linear(WIDTH, held[1].shape[1]))
    optimizer = torch.optim.AdamW(network.parameters(), lr=RATE, weight_decay=DECAY)
    steps = epochs * -(-len(copies[0][0]) // BATCH)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, RATE, total_steps=steps, pct_start=0.05)
    last = 0.0
    for epoch in range(epochs):
        seen, wanted = copies[epoch % len(copies)]
        total = 0.0
        for batch in torch.randperm(len(seen)).split(BATCH):
            loss = torch.nn.functional.l1_loss(network(seen[batch]), wanted[batch])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            total += loss.item() * len(batch)
        last = total / len(seen)
    with torch.no_grad():
        error = (network(held[0]) - held[1]).abs()
    radians = (error * torch.from_numpy(scales["wanted_spread"])).reshape(len(error), CHUNK_FRAMES, -1)
    return network, {"loss": last, "loss_held_out": error.mean().item(), "error_rad": radians[:, :, :-1].mean().item()}


if __name__ == "__main__":
    main()
