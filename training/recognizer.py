"""Trains the recognizer of objects on close-ups of every category, and writes its weights.

    python training/recognizer.py --close-ups out/training/images/close_ups --out out/training/recognizer

`--close-ups` has the folders `training`, `validation` and `test` that `tabletopgen-lab synthesize --close-ups` wrote.
The encoder is public (`encoder.py`) and its first blocks stay as they are, so their output is computed once, to disk;
the last blocks and a linear classifier learn. The classifier begins with the encoder's own classes where they are ours
(`imagenet_categories.txt`), and both are held near where they begin: photographs, of which no close-up is one, are
more like what the encoder knows. Shapes of no category are the class "unknown".

A run that was stopped goes on with what is complete: outputs of the first blocks, and epochs. It is seeded. Written are
`checkpoint.pt`, `scores.json` (test close-ups: other seeds, tops and backdrops than in training) and
`object_recognizer.safetensors`, with the temperature that fits validation close-ups and more weight for categories that
images show more often (`common_categories.txt`). With `--withhold 4` every fourth category is left out, and the scores
tell how often its objects are called unknown.
"""

import argparse
import json
import os
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import torch
from safetensors.torch import save_file
from torch.nn import functional as F

from close_ups import NO_CATEGORY, squares
from encoder import FROZEN, Encoder, as_read, normalized, public_weights

HERE = Path(__file__).parent
BATCH, EXTRACTED = 128, 32
#: Largest rates of the classifier and of the blocks, label smoothing, dropout of features, and the weights that hold
#: the classifier and the blocks where they begin.
RATES, SMOOTHING, DROPOUT, HELD = (2e-3, 1.5e-4), 0.1, 0.2, (3e-5, 1e-3)
#: What a category gains, natural logarithm, that images show more often.
COMMON_GAIN = 1.5
SEED = 1


def extract(folders, is_varied, out):
    """Writes the output of the frozen blocks for the objects of close-ups: 16-bit numbers one object after the other,
    and the names."""
    if out.with_suffix(".names.npy").is_file():
        return
    torch.set_num_threads(1)
    encoder, names, waiting = Encoder(public_weights()).eval(), [], []
    with out.with_suffix(".bin").open("wb") as file:

        def flush():
            with torch.no_grad(), torch.autocast("cpu", torch.bfloat16):
                outputs = encoder.frozen(normalized(np.stack(waiting)))
            file.write(outputs.half().contiguous().numpy().tobytes())
            waiting.clear()

        for folder in folders:
            for name, square in squares(folder, is_varied):
                names.append(name)
                waiting.append(square)
                if len(waiting) == EXTRACTED:
                    flush()
        if waiting:
            flush()
    np.save(out.with_suffix(".names.npy"), np.array(names))


class Outputs:
    """Outputs of the frozen blocks for all objects of a split, on disk."""

    def __init__(self, close_ups, split, out, workers):
        folders = sorted(folder for folder in (close_ups / split).iterdir() if (folder / "truth.json").is_file())
        # Another number of close-ups or processes makes other parts.
        parts = [out / f"{split}_{len(folders)}_{k}_of_{workers}" for k in range(workers)]
        with ProcessPoolExecutor(workers) as pool:
            list(pool.map(extract, [folders[k::workers] for k in range(workers)], [split == "training"] * workers, parts))
        self.names = np.concatenate([np.load(part.with_suffix(".names.npy")) for part in parts])
        self.arrays = []
        for part in parts:
            count = len(np.load(part.with_suffix(".names.npy")))
            values = np.memmap(part.with_suffix(".bin"), np.float16, "r")
            side = int((len(values) // count // CHANNELS) ** 0.5)
            self.arrays.append(values.reshape(count, CHANNELS, side, side))
        self.starts = np.cumsum([0, *(len(array) for array in self.arrays)])

    def take(self, numbers):
        part = np.searchsorted(self.starts, numbers, "right") - 1
        rows = [self.arrays[k][n - self.starts[k]] for k, n in zip(part, numbers)]
        return torch.from_numpy(np.stack(rows)).float().contiguous(memory_format=torch.channels_last)


#: Channels of the output of the frozen blocks.
CHANNELS = len(public_weights()[f"_blocks.{FROZEN - 1}._project_conv.weight"])


def lines(name):
    return [line for line in (HERE / name).read_text().splitlines() if line and not line.startswith("#")]


def first_classifier(encoder, categories):
    """Weights and biases of the categories and of "unknown": those of the encoder's own classes, less the mean of all;
    zeros for what it has no class of."""
    weight, bias = encoder.classes
    own = {}
    for line in lines("imagenet_categories.txt"):
        number, names = int(line.split()[0]), line.split(":")[1].split()
        for name in names:
            own.setdefault(name, []).append(number)
    classifier = torch.zeros(len(categories) + 1, weight.shape[1]), torch.zeros(len(categories) + 1)
    for k, name in enumerate(categories):
        if name in own:
            classifier[0][k] = weight[own[name]].mean(0) - weight.mean(0)
            classifier[1][k] = bias[own[name]].mean() - bias.mean()
    return classifier


def logits(encoder, classifier, outputs, numbers):
    with torch.no_grad(), torch.autocast("cpu", torch.bfloat16):
        features = [encoder.learning(outputs.take(part)).float() for part in np.array_split(numbers, -(-len(numbers) // 256))]
    return torch.cat(features) @ classifier[0].T + classifier[1]


def train(encoder, classifier, outputs, labels, numbers, epochs, checkpoint):
    """Trains the last blocks and the classifier on the objects of these numbers."""
    blocks = [p for k, block in enumerate(encoder.blocks) if k >= FROZEN for p in block.parameters()]
    blocks += list(encoder.head.parameters())
    first = [p.detach().clone() for p in (*classifier, *blocks)]
    held = [HELD[0]] * len(classifier) + [HELD[1]] * len(blocks)
    classifier = [p.requires_grad_() for p in classifier]
    optimizer = torch.optim.AdamW([{"params": classifier}, {"params": blocks}], weight_decay=0.0)
    steps = len(numbers) // BATCH
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, RATES, total_steps=epochs * steps + 1, pct_start=0.15)
    begun = 0
    if checkpoint.is_file():
        saved = torch.load(checkpoint, weights_only=True)
        begun = saved["epoch"]
        with torch.no_grad():
            for p, value in zip((*classifier, *blocks), saved["values"]):
                p.copy_(value)
        optimizer.load_state_dict(saved["optimizer"])
        schedule.load_state_dict(saved["schedule"])
    for epoch in range(begun, epochs):
        order = np.random.default_rng([SEED, epoch]).permutation(numbers)
        torch.manual_seed(SEED + epoch)
        total = 0.0
        for step in range(steps):
            chosen = np.sort(order[step * BATCH : (step + 1) * BATCH])
            with torch.autocast("cpu", torch.bfloat16):
                features = encoder.learning(outputs.take(chosen))
            features = F.dropout(features.float(), DROPOUT)
            loss = F.cross_entropy(features @ classifier[0].T + classifier[1], labels[chosen], label_smoothing=SMOOTHING)
            total += loss.item()
            for p, value, weight in zip((*classifier, *blocks), first, held):
                loss = loss + weight * (p - value).square().sum()
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            if step % 20 == 0:
                print(f"epoch {epoch + 1} of {epochs}, step {step} of {steps}: {total / (step + 1):.3f}", flush=True)
        values = [p.detach() for p in (*classifier, *blocks)]
        state = {"epoch": epoch + 1, "values": values, "optimizer": optimizer.state_dict(), "schedule": schedule.state_dict()}
        torch.save(state, checkpoint.with_suffix(".part"))
        os.replace(checkpoint.with_suffix(".part"), checkpoint)
    return [p.detach() for p in classifier]


def fitting_temperature(values, labels):
    """The temperature at which the labels are most likely."""
    tried = np.geomspace(0.3, 3.0, 60)
    return min(tried, key=lambda temperature: F.cross_entropy(values / temperature, labels).item())


def scores(values, labels, unknown, is_withheld):
    """Shares of right first and of right five first names, of shapes of no category and of withheld categories called
    unknown, and for tenths of confidence the number of names and the share of right ones."""
    probabilities = values.softmax(1)
    best, known = probabilities.max(1), (labels != unknown) & ~is_withheld
    right = best.indices == labels
    among_five = (probabilities.topk(5, 1).indices == labels[:, None]).any(1)
    tenths = []
    for tenth in range(10):
        inside = known & (best.indices != unknown) & ((best.values * 10).long().clamp(max=9) == tenth)
        tenths.append([int(inside.sum()), round(right[inside].float().mean().item(), 3) if inside.any() else None])
    # A name is given from a probability of one half on.
    is_unnamed = (best.indices == unknown) | (best.values < 0.5)
    shares = {
        "first": right[known], "among_five": among_five[known], "named": ~is_unnamed[known],
        "right_of_named": right[known & ~is_unnamed], "no_category_unnamed": is_unnamed[labels == unknown],
        "withheld_unnamed": is_unnamed[is_withheld],
    }
    return {name: round(of.float().mean().item(), 4) for name, of in shares.items() if len(of)} | {"tenths": tenths}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--close-ups", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--epochs", type=int, default=4)
    parser.add_argument("--withhold", type=int, default=0, metavar="N", help="leave out every N-th category")
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    splits = {split: Outputs(given.close_ups, split, given.out, given.workers) for split in ("training", "validation", "test")}
    categories = sorted({str(name) for name in splits["training"].names if not name.startswith(NO_CATEGORY)})
    withheld = set(categories[:: given.withhold]) if given.withhold else set()
    number = {name: k for k, name in enumerate(categories)}
    unknown = len(categories)
    labels = {split: torch.tensor([number.get(str(name), unknown) for name in own.names]) for split, own in splits.items()}
    is_withheld = {split: np.isin(own.names, sorted(withheld)) for split, own in splits.items()}
    encoder = Encoder(public_weights())
    classifier = first_classifier(encoder, categories)
    learned = np.flatnonzero(~is_withheld["training"])
    checkpoint = given.out / f"checkpoint_{given.withhold}.pt"
    classifier = train(encoder, classifier, splits["training"], labels["training"], learned, given.epochs, checkpoint)
    encoder.eval()
    found = {split: logits(encoder, classifier, splits[split], np.arange(len(splits[split].names))) for split in ("validation", "test")}
    own = torch.from_numpy(~is_withheld["validation"])
    temperature = fitting_temperature(found["validation"][own], labels["validation"][own])
    result = scores(found["test"] / temperature, labels["test"], unknown, torch.from_numpy(is_withheld["test"]))
    result |= {"temperature": round(float(temperature), 3), "categories": len(categories), "objects": {split: len(own.names) for split, own in splits.items()}}
    (given.out / f"scores_{given.withhold}.json").write_text(json.dumps(result, indent=1) + "\n")
    print(json.dumps(result))
    common = set(lines("common_categories.txt"))
    gain = torch.tensor([COMMON_GAIN * (name in common) for name in categories] + [COMMON_GAIN])
    tensors = as_read(encoder, classifier[0] / temperature, classifier[1] / temperature + gain, [*categories, "unknown"])
    if not withheld:
        save_file(tensors, given.out / "object_recognizer.safetensors")


if __name__ == "__main__":
    main()
