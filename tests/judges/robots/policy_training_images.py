"""A small policy is trained on the camera images of recorded episodes by behavior cloning, on the CPU.

    policy_training_images.py DATASET MJCF WEIGHTS [--minutes N] [--episodes N] [--seed N]

As policy_training.py, but instead of the objects' poses the policy sees the images of each frame. Training replaces
what is behind the scene by random colors (with the dataset's instance ids), and changes contrast and colors, since
another simulator renders the scene in another light. Beside the targets the network learns where the objects stood at
first, as a second output that is not used later. Training ends after so many CPU minutes.
"""

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np
import torch
from PIL import Image

from policy_observation import Chain, observed
from policy_training import CHUNK_FRAMES, HELD_OUT, check_chain, episodes_of, examples, scales_of

# Of each layer: channels, kernel, stride.
CONVOLUTIONS, WIDTH, FEATURES = ((24, 6, 4), (48, 4, 2), (64, 3, 2)), 512, 256
BATCH, RATE, DECAY = 128, 1e-3, 1e-4
NOISE_RAD = 0.005
# The weight of the second output: where the objects stood, in units of the spread.
PLACES_WEIGHT = 0.3


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path)
    parser.add_argument("mjcf", type=Path)
    parser.add_argument("weights", type=Path)
    parser.add_argument("--minutes", type=float, default=20.0)
    parser.add_argument("--episodes", type=int, default=0, help="the first so many, or all")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    torch.manual_seed(given.seed)
    torch.set_num_threads(1)
    episodes, joints, base = episodes_of(given.dataset, given.episodes)
    chain = Chain(given.mjcf, joints)
    check_chain(chain, episodes)
    described = json.loads((given.dataset / "parquet-png" / "dataset.json").read_text())["description"]["cameras"]
    cameras = [camera["name"] for camera in described]
    images, masks = images_of(given.dataset / "parquet-png" / "episodes", cameras, [len(one["q"]) for one in episodes])
    is_held = np.concatenate([np.full(len(one["q"]), index % HELD_OUT == 0) for index, one in enumerate(episodes)])
    for one in episodes:
        one["places"] = one["objects"][:, :2, 3].ravel()
        one["objects"] = one["objects"][:0]
    places = np.concatenate([np.broadcast_to(one["places"], (len(one["q"]), one["places"].size)) for one in episodes])
    data = Data(chain, episodes, images, masks, places.astype(np.float32), is_held)
    started_s = time.process_time()
    network, result = trained(data, cameras, 60 * given.minutes)
    arrays = {name.replace(".", "_"): array.detach().numpy() for name, array in network.state_dict().items()}
    strides = np.array([stride for _, _, stride in CONVOLUTIONS])
    about = {"joints": np.array(joints), "cameras": np.array(cameras), "strides": strides, "world_from_base": base}
    np.savez(given.weights, **about, **data.scales, **arrays)
    print(json.dumps({
        "episodes": len(episodes) - len(episodes[::HELD_OUT]), "held_out": len(episodes[::HELD_OUT]),
        "frames": int((~is_held).sum()), "cameras": cameras, "size_px": images.shape[2],
        "parameters": sum(array.size for array in arrays.values()), **result, "cpu_s": time.process_time() - started_s,
    }))


def images_of(folder: Path, cameras: list, lengths: list) -> tuple:
    """Images (frames, cameras, height, width, 3), and where they show nothing (frames, cameras, height, width)."""
    images, masks = [], []
    for index, length in enumerate(lengths):
        episode = folder / f"episode_{index:06d}"
        for frame in range(length):
            images.append(np.stack([read(episode / name / f"rgb_{frame:06d}.png") for name in cameras])[..., :3])
            masks.append(np.stack([read(episode / name / f"instance_ids_{frame:06d}.png") for name in cameras]) == 0)
    return np.stack(images), np.stack(masks)


def read(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        return np.array(image)


class Data:
    """Examples, in units of their spread."""

    def __init__(self, chain, episodes, images, masks, places, is_held):
        self.images, self.masks, self.is_held = images, masks, is_held
        self.seen, wanted = examples(chain, episodes, None)
        self.scales = scales_of(self.seen[~is_held], wanted[~is_held])
        self.wanted = (wanted - self.scales["wanted_mean"]) / self.scales["wanted_spread"]
        self.places = (places - places[~is_held].mean(0)) / np.maximum(places[~is_held].std(0), 1e-3)
        self.chain, self.arm = chain, episodes[0]["q"].shape[1]

    def batch(self, rows: np.ndarray, random) -> tuple:
        """What is seen and wanted; with noise if `random`."""
        seen, wanted = self.seen[rows], self.wanted[rows]
        pixels = self.images[rows].astype(np.float32) / 255.0
        if random is not None:
            q = seen[:, : self.arm] + random.normal(0.0, NOISE_RAD, (len(rows), self.arm))
            none = np.empty((len(rows), 0, 4, 4))
            moved = q - seen[:, : self.arm]
            seen = observed(self.chain, q, seen[:, self.arm], none).astype(np.float32)
            wanted = wanted.reshape(len(rows), CHUNK_FRAMES, -1).copy()
            spread = self.scales["wanted_spread"].reshape(CHUNK_FRAMES, -1)[:, :-1]
            wanted[:, :, :-1] -= moved[:, None] / spread
            wanted = wanted.reshape(len(rows), -1).astype(np.float32)
            pixels = repainted(pixels, self.masks[rows], random)
        seen = (seen - self.scales["seen_mean"]) / self.scales["seen_spread"]
        pixels = torch.from_numpy(pixels.astype(np.float32)).permute(0, 1, 4, 2, 3)
        return pixels, torch.from_numpy(seen), torch.from_numpy(wanted), torch.from_numpy(self.places[rows])


def repainted(pixels: np.ndarray, empty: np.ndarray, random) -> np.ndarray:
    """Other colors behind the scene, another contrast and other colors of all, and a shadow on one side of a line."""
    frames, cameras, height, width, _ = pixels.shape
    shape = (frames, cameras, 1, 1, 3)
    down = np.linspace(0.0, 1.0, height, dtype=np.float32)[None, None, :, None, None]
    one, other = (random.uniform(0.0, 1.0, shape[:-1] + (1,)) + random.normal(0.0, 0.08, shape) for _ in range(2))
    has_edge = random.random((frames, cameras, 1, 1, 1)) < 0.5
    edge = np.where(has_edge, down > random.uniform(0.0, 0.7, (frames, cameras, 1, 1, 1)), down)
    behind = (one + (other - one) * edge).astype(np.float32)
    pixels = np.where(empty[..., None], behind, pixels)
    gain = (random.uniform(0.5, 1.2, shape[:-1] + (1,)) * random.uniform(0.85, 1.15, shape)).astype(np.float32)
    offset = random.uniform(-0.12, 0.12, shape[:-1] + (1,)).astype(np.float32)
    angle, shift = random.uniform(0.0, 2 * np.pi, (2, frames, cameras, 1, 1))
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    is_dark = np.cos(angle) * x + np.sin(angle) * y > np.cos(shift)
    shade = np.where(is_dark, random.uniform(0.4, 1.0, (frames, cameras, 1, 1)), 1.0).astype(np.float32)
    pixels *= gain
    pixels *= shade[..., None]
    pixels += offset
    return np.clip(pixels, 0.0, 1.0, out=pixels)


class Network(torch.nn.Module):
    """An encoder for each camera, and layers from what both see and the robot to targets and places."""

    def __init__(self, cameras: list, size_px: int, seen: int, wanted: int, places: int):
        super().__init__()
        self.encoders = torch.nn.ModuleDict()
        for name in cameras:
            layers, inputs, left_px = [], 3, size_px
            for outputs, kernel, stride in CONVOLUTIONS:
                layers += [torch.nn.Conv2d(inputs, outputs, kernel, stride=stride, padding=1), torch.nn.ReLU()]
                inputs, left_px = outputs, (left_px + 2 - kernel) // stride + 1
            layers += [torch.nn.Flatten(), torch.nn.Linear(left_px * left_px * inputs, FEATURES)]
            self.encoders[name] = torch.nn.Sequential(*layers)
        inputs = len(cameras) * FEATURES
        self.norm = torch.nn.LayerNorm(inputs)
        self.places = torch.nn.Linear(inputs, places)
        self.head = torch.nn.Sequential(
            torch.nn.Linear(inputs + seen, WIDTH), torch.nn.LayerNorm(WIDTH), torch.nn.ReLU(),
            torch.nn.Linear(WIDTH, WIDTH), torch.nn.LayerNorm(WIDTH), torch.nn.ReLU(), torch.nn.Linear(WIDTH, wanted),
        )

    def forward(self, pixels: torch.Tensor, seen: torch.Tensor) -> tuple:
        parts = [encoder(pixels[:, index] - 0.5) for index, encoder in enumerate(self.encoders.values())]
        features = torch.relu(self.norm(torch.cat(parts, 1)))
        return self.head(torch.cat([features, seen], 1)), self.places(features)


def trained(data: Data, cameras: list, limit_s: float) -> tuple:
    """The rate falls with the CPU time that is used up."""
    network = Network(cameras, data.images.shape[2], data.seen.shape[1], data.wanted.shape[1], data.places.shape[1])
    optimizer = torch.optim.AdamW(network.parameters(), lr=RATE, weight_decay=DECAY)
    random = np.random.default_rng(0)
    rows = np.flatnonzero(~data.is_held)
    absolute = torch.nn.functional.l1_loss
    started_s, frames, mean_loss = time.process_time(), 0, 1.0
    while (used := (time.process_time() - started_s) / limit_s) < 1.0:
        for group in optimizer.param_groups:
            group["lr"] = RATE * min(1.0, used / 0.02 + 0.01) * 0.5 * (1.0 + np.cos(np.pi * used))
        pixels, seen, wanted, places = data.batch(random.choice(rows, BATCH, replace=False), random)
        targets, stood = network(pixels, seen)
        loss = absolute(targets, wanted)
        optimizer.zero_grad()
        (loss + PLACES_WEIGHT * absolute(stood, places)).backward()
        optimizer.step()
        frames += BATCH
        mean_loss += 0.01 * (loss.item() - mean_loss)
        if frames // BATCH % 100 == 0:
            print(f"{used:.3f} {mean_loss:.4f} {absolute(stood, places).item():.4f}", file=sys.stderr, flush=True)
    network.eval()
    errors = []
    with torch.no_grad():
        for batch in np.array_split(np.flatnonzero(data.is_held), 20):
            pixels, seen, wanted, _ = data.batch(batch, None)
            errors.append((network(pixels, seen)[0] - wanted).abs())
    error = torch.cat(errors)
    radians = (error * torch.from_numpy(data.scales["wanted_spread"])).reshape(len(error), CHUNK_FRAMES, -1)[:, :, :-1]
    losses = {"loss": mean_loss, "loss_held_out": error.mean().item(), "error_rad": radians.mean().item()}
    return network, {"epochs": frames / len(rows), **losses}


if __name__ == "__main__":
    main()
