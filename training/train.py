"""Trains the network that reads images of tables, and writes its weights.

    python training/train.py --images out/images --out out/network

`--images` has the folders `training` and `validation` that `tabletopgen-lab synthesize` wrote. An earlier run with the
same numbers in `--out` is continued: frames are packed once, a checkpoint is written every --every steps and again at
the end; --steps may be another as long as the learning rate has not begun to fall. The run is seeded; the order of the
images depends on the seed and the step alone. Written are `checkpoint.pt`, `history.json`, `history.png` (losses and
scores on validation images, whose categories, tops and backdrops no training image shows) and `weights.safetensors`.
Scored and written is a moving average of the network over its last steps, which is better than the network of any one
of them.
"""

import argparse
import json
import math
import os
import time
from datetime import timedelta
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
import torch
from safetensors.torch import load_file, save_file
from torch import distributed
from torch.nn import functional as F
from torch.optim.swa_utils import AveragedModel

from frames import CROPS, FIRST_OBJECT, IGNORED, STRIDE, opened, pack
from network import TableNetwork, begin, folded, split
from scores import MIN_AREA, compared, grouped
from targets import OFFSET_UNIT, elevation_of, targets
from variation import recolored
from without_tables import WithoutTables

#: Weights of the losses.
WEIGHTS = {"kinds": 1.0, "outline": 0.5, "border": 0.5, "contact": 0.3, "center": 30.0, "offset": 0.4, "base": 0.3, "top": 0.3, "ground": 0.2, "rise": 0.3, "latitude": 4.0, "focal": 1.0}


def batch(frames, numbers, device="cpu"):
    """Frames of colors 0..1, labels, flags, cameras, facts."""
    numbers = np.sort(numbers)
    def take(array):
        return torch.from_numpy(np.ascontiguousarray(array[numbers])).to(device)
    images = take(frames.images).permute(0, 3, 1, 2).float() / 255
    return images, take(frames.labels), take(frames.flags), take(frames.cameras), take(frames.facts)


def shown(images):
    """Frames as the network sees them: -1..1."""
    return (2 * images - 1).contiguous(memory_format=torch.channels_last)


def ahead_on(device, half):
    """The function from a network on the device and images to maps."""

    def ahead(model, images):
        with torch.autocast(device.type, torch.bfloat16, enabled=half):
            return model(shown(images.to(device))).float()

    return ahead


def varied(images, labels, flags, cameras, facts, generator):
    """The same batch, mirrored, and its colors changed, at random."""
    def random(*shape):
        return torch.rand(shape, generator=generator, device=generator.device)
    mirrored = random(len(images)) < 0.5
    def turned(t):
        return torch.where(mirrored.view(-1, *[1] * (t.dim() - 1)), t.flip(-1), t)
    images, labels, flags = turned(images), turned(labels), turned(flags)
    facts[..., 0] = torch.where(mirrored[:, None], labels.shape[-1] - facts[..., 0], facts[..., 0])
    images = recolored(images, labels, generator)
    gain = 1 + 0.3 * (random(len(images), 1, 1, 1) - 0.5) + 0.12 * (random(len(images), 3, 1, 1) - 0.5)
    gamma = torch.exp(0.5 * (random(len(images), 1, 1, 1) - 0.5))
    images = (images.clamp(min=1e-3) ** gamma * gain).clamp(0, 1)
    gray = images.mean(1, keepdim=True)
    images = torch.lerp(images, gray, 0.5 * random(len(images), 1, 1, 1) * (random(len(images), 1, 1, 1) < 0.3))
    return images, labels, flags, cameras, facts


#: Size of the small frame for each of a whole one.
SMALL = {(320, 256): (192, 160), (480, 384): (288, 224), (640, 288): (384, 160)}
#: Of so many steps in a row this many see whole images, the others closer crops.
WHOLE_STEPS, OF_STEPS = 3, 10


#: Images without a table, how many of them join each image of a batch of whole ones, and how many others are scored.
WITHOUT_TABLES, JOIN, SCORED_WITHOUT = 1200, 0.25, 100


def joined(batches):
    """One batch of several."""
    return tuple(torch.cat(parts) for parts in zip(*batches))


def shrunk(images, labels, flags, cameras, facts):
    """The same batch on small frames."""
    height, width = images.shape[-2:]
    small_width, small_height = SMALL[width, height]
    images = F.interpolate(images, (small_height, small_width), mode="bilinear", antialias=True, align_corners=False)
    def nearest(maps):
        return F.interpolate(maps[:, None], (small_height // STRIDE, small_width // STRIDE), mode="nearest-exact")[:, 0]
    across, down = small_width / width, small_height / height
    facts = facts * torch.tensor([across, down, down, down, 1.0], device=facts.device)
    return images, nearest(labels), nearest(flags), cameras, facts


#: Share of the parts that are shown nearer, and how much nearer at most.
SHOWN_NEARER, MAX_ENLARGEMENT = 0.5, 1.5


def nearer(images, labels, flags, cameras, facts, generator):
    """The same batch; of some frames a part anywhere, as large as the frame."""
    n, rows, columns = labels.shape
    def random():
        return torch.rand(n, generator=generator, device=generator.device)
    side = torch.where(random() < SHOWN_NEARER, MAX_ENLARGEMENT ** -random(), 1.0)
    # Left and upper edge, shares of the frame.
    corner = torch.stack([random(), random()], 1) * (1 - side[:, None])
    # From -1..1 of what is shown to -1..1 of the frame.
    center = 2 * corner + side[:, None] - 1
    turn = torch.diag_embed(side[:, None].expand(n, 2))
    def at(height, width):
        return F.affine_grid(torch.cat([turn, center[:, :, None]], 2), (n, 1, height, width), align_corners=False)
    images = F.grid_sample(images, at(*images.shape[-2:]), padding_mode="border", align_corners=False)
    def picked(maps):
        return F.grid_sample(maps[:, None].float(), at(rows, columns), mode="nearest", align_corners=False)[:, 0].to(maps.dtype)
    size = torch.tensor([columns, rows, rows, rows], device=facts.device)
    start = size * corner[:, [0, 1, 1, 1]]
    shown = torch.cat([(facts[..., :4] - start[:, None]) / side[:, None, None], facts[..., 4:]], 2)
    return images, picked(labels), picked(flags), cameras, shown


#: Losses that only whole images have.
CAMERA_LOSSES = "latitude", "focal"
#: Objects that fill less of a map than this share weigh more than their area, but at most so many times more.
SMALL_OBJECT, MAX_EMPHASIS = 0.02, 6.0
#: Distance from an object within which its surroundings weigh as much, map pixels.
BESIDE = 4


def log_rise(base, top):
    """Logarithm of one plus the number of map rows between the center of an object's base and its top: a flat object
    that is taken for a high one is as wrong as a high one taken for one ten times as high."""
    return torch.log1p(OFFSET_UNIT * (base[:, 1] - top).clamp(min=0))


def losses(maps, want):
    """Each loss by its name, not weighted."""
    by_name = split(maps)
    counts = want["counts"].float()
    def mean(value, where):
        return (value * where).sum() / where.sum().clamp(min=1)
    def said(name):
        return by_name[name][:, 0]
    # Small objects weigh more than their area, and so do their surroundings: otherwise they would be predicted too
    # large.
    small_area = SMALL_OBJECT * counts[0].numel()
    own = torch.where(want["is_object"], (small_area / want["area"]).clamp(1, MAX_EMPHASIS), 1.0)
    emphasis = counts * F.max_pool2d(own[:, None], 2 * BESIDE + 1, 1, BESIDE)[:, 0]
    def yes_or_no(name, rare):
        return mean(
            F.binary_cross_entropy_with_logits(said(name), want[name].float(), reduction="none") * (1 + rare * want[name]), counts
        )
    on_objects = want["is_object"].float() * emphasis
    known = on_objects * want["is_known"]
    tells_camera = want["tells_camera"].float()
    return {
        "kinds": mean(F.cross_entropy(by_name["kinds"], want["kinds"].clamp(max=3), reduction="none"), emphasis),
        "outline": yes_or_no("outline", 0.0),
        "border": yes_or_no("border", 4.0),
        "contact": yes_or_no("contact", 4.0),
        "center": mean((said("center") - want["center"]) ** 2, counts),
        "offset": mean(F.smooth_l1_loss(by_name["offset"], want["offset"], reduction="none", beta=0.1).sum(1), on_objects),
        "base": mean(F.smooth_l1_loss(by_name["base"], want["base"], reduction="none", beta=0.1).sum(1), known),
        **{name: mean(F.smooth_l1_loss(said(name), want[name], reduction="none", beta=0.1), known) for name in ("top", "ground")},
        "rise": mean(F.smooth_l1_loss(log_rise(by_name["base"], said("top")), log_rise(want["base"], want["top"]), reduction="none", beta=0.1), known),
        **{name: mean(F.smooth_l1_loss(said(name), want[name], reduction="none", beta=0.05), tells_camera) for name in ("latitude", "focal")},
    }


@torch.no_grad()
def validated(model, crops, count, ahead):
    """Losses and scores on about `count` images: outlines and cameras by whole images, objects by closer crops.
    `whole_recall` is of objects in whole images. `ahead` gives the maps of a network for images."""
    model.eval()
    sums, seen, outline_right, elevation, focal, rises = {}, {crop: 0 for crop in CROPS}, 0, [], [], []
    totals = {crop: np.zeros(3, int) for crop in CROPS}
    image_count = len(crops["whole"])
    for crop, frames in crops.items():
        numbers = frames.numbers[: math.ceil(count * len(frames) / image_count)]
        for first in range(0, len(numbers), 16):
            images, labels, flags, cameras, facts = batch(frames, numbers[first : first + 16])
            maps = ahead(model, images).cpu()
            want = targets(labels, flags, cameras, facts)
            seen[crop] += len(labels)
            for name, value in losses(maps, want).items():
                if name not in CAMERA_LOSSES or crop == "whole":
                    sums[name] = sums.get(name, 0.0) + float(value) * len(labels)
            for own, label in zip(maps, labels):
                totals[crop] += compared(grouped(own), label)
            if crop == "whole":
                inside = (split(maps)["outline"][:, 0] > 0) & want["counts"]
                outline = want["outline"] & want["counts"]
                overlap = (inside & outline).flatten(1).sum(1) / (inside | outline).flatten(1).sum(1).clamp(min=1)
                outline_right += int((overlap >= 0.9).sum())
                said, log_focal = elevation_of(split(maps), cameras[:, 2])
                elevation += (said - cameras[:, 0]).abs().rad2deg().tolist()
                focal += (log_focal - cameras[:, 1]).abs().tolist()
            else:
                rises += rise_errors(split(maps), want, labels)
    invented_in_nothing = invented_tables(model, ahead)
    labeled, found, invented = sum(total for crop, total in totals.items() if crop != "whole").tolist()
    model.train()
    frames_seen = {name: seen["whole"] if name in CAMERA_LOSSES else sum(seen.values()) for name in sums}
    return {
        **{f"loss_{name}": value / frames_seen[name] for name, value in sums.items()},
        "invented_tables": invented_in_nothing,
        "recall": found / max(labeled, 1),
        "precision": found / max(found + invented, 1),
        "whole_recall": float(totals["whole"][1] / max(totals["whole"][0], 1)),
        "right_outlines": outline_right / seen["whole"],
        "elevation_median_deg": float(np.median(elevation)),
        "focal_median": float(np.median(focal)),
        "rise_median": float(np.median(rises)) if rises else 1.0,
    }


#: A top fills at least this share of an image (`min_table_share` of the settings).
MIN_TABLE_SHARE = 0.03


@torch.no_grad()
def invented_tables(model, ahead):
    """Share of images without a table in which a top is predicted."""
    images, *_ = batch(WithoutTables(SCORED_WITHOUT, seed=2), np.arange(SCORED_WITHOUT))
    maps = torch.cat([ahead(model, part).cpu() for part in images.split(20)])
    return float(((split(maps)["outline"][:, 0] > 0).float().mean((1, 2)) > MIN_TABLE_SHARE).float().mean())


#: Share of itself that the averaged network keeps at a step, once there were enough of them.
KEPT = 0.998


def averaged(model):
    """A network that follows `model`: call its `update_parameters` after every step. It averages what the
    normalizations have counted, too."""

    def follow(average, current, updates):
        kept = min(KEPT, (1 + updates.item()) / (10 + updates.item()))
        return torch.lerp(current.float(), average.float(), kept).to(average.dtype)

    return AveragedModel(model, avg_fn=follow, use_buffers=True)


#: Steps over which the learning rate rises, and the share of all steps over which it falls.
RISE, FALL = 300, 0.6


#: Share of the steps, the last ones, in which the statistics of normalizations stay fixed. Whole images and closer
#: crops differ so much that their common statistics fit neither; the network adapts to them.
SETTLED = 0.25


def settle(model):
    """Normalizations go by what they have counted, and count no more."""
    for module in model.modules():
        if isinstance(module, torch.nn.BatchNorm2d):
            module.eval()


def rise_errors(by_name, want, labels):
    """Relative errors of the number of rows between the center of an object's base and its top, each the median over
    the object's own pixels."""
    errors = []
    said, true = by_name["base"][:, 1] - by_name["top"][:, 0], want["base"][:, 1] - want["top"]
    for rises, wanted, known, label in zip(said, true, want["is_known"], labels):
        for index in label[known].unique():
            own = known & (label == index)
            if FIRST_OBJECT <= index < IGNORED and own.sum() >= MIN_AREA:
                errors.append(abs(float(rises[own].median()) / max(float(wanted[own][0]), 1e-3) - 1))
    return errors


def falls_from(steps):
    """The step from which the learning rate falls; what comes before does not depend on how many steps there are."""
    return round((1 - FALL) * steps)


def learning_rate(step, steps, peak):
    """Rises, stays, and falls in a straight line to a hundredth."""
    rising = min((step + 1) / RISE, 1.0)
    falling = min((steps - step) / max(steps - falls_from(steps), 1), 1.0)
    return peak * rising * max(falling, 0.01)


def crop_of(step, crops):
    """The crop that a step sees, and how many steps before saw it. `crops` are the crops' names with their numbers of
    images."""
    whole, closer = "whole", [crop for crop in crops if crop != "whole" and crops[crop]]
    if not closer:
        return whole, step
    # Whole images first in each round; the other steps go to the closer crops as they have images.
    round_, place = divmod(step, OF_STEPS)
    whole_before = round_ * WHOLE_STEPS + min(place, WHOLE_STEPS)
    if place < WHOLE_STEPS:
        return whole, whole_before
    nth, first, all_ = step - whole_before, closer[0], sum(crops[crop] for crop in closer)
    def before(k):
        return k * crops[first] // all_
    if len(closer) == 1 or before(nth + 1) > before(nth):
        return first, before(nth)
    return closer[1], nth - before(nth)


def numbers_of(step, size, count, seed):
    """Images of a step: each epoch shows every image once, in an order of its own."""
    chosen = []
    for k in range(step * size, (step + 1) * size):
        epoch, place = divmod(k, count)
        chosen.append(order(count, seed, epoch)[place])
    return np.array(chosen)


@lru_cache(maxsize=8)
def order(count, seed, epoch):
    return np.random.default_rng([seed, epoch]).permutation(count)


def replace(path, write):
    """Writes a file so that it is there whole or as it was."""
    part = Path(f"{path}.part")
    write(part)
    os.replace(part, path)


def halved(tensors):
    """Half as large; the loss is a hundredth of what JPEG changes in an image."""
    return {name: tensor.half() for name, tensor in tensors.items()}


def plot(history, path):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (left, right) = pyplot.subplots(1, 2, figsize=(12, 4.5))
    steps = [entry["step"] for entry in history]
    for name in WEIGHTS:
        left.plot(steps, [WEIGHTS[name] * entry["training"][name] for entry in history], label=name)
    left.set(title="weighted losses, training", xlabel="step", yscale="log")
    for name in ("recall", "precision", "right_outlines"):
        right.plot(steps, [entry["validation"][name] for entry in history], label=name)
    right.set(title="validation", xlabel="step", ylim=(0, 1))
    for axes in (left, right):
        axes.legend()
        axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(path, format="png", dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--images", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--steps", type=int, default=20000)
    parser.add_argument("--batch", type=int, default=16)
    parser.add_argument("--rate", type=float, default=2e-3)
    parser.add_argument("--begin-with", type=Path, help="weights.safetensors of an earlier run to begin with; blocks it lacks do nothing at first")
    parser.add_argument("--small-share", type=float, default=0.6, help="share of the steps that see small frames: they take a third of the time, and what they teach holds for whole ones")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--every", type=int, default=500, help="steps between checkpoints and scores")
    parser.add_argument("--validate", type=int, default=400, help="validation images of a score")
    parser.add_argument("--device", choices=("cpu", "cuda"), default="cuda" if torch.cuda.is_available() else "cpu")
    parser.add_argument("--processes", type=int, help="each learns from a batch of its own on one core or one GPU; as many as there are, and a run's number stays what it was")
    parser.add_argument("--full-precision", action="store_true", help="no bfloat16 in convolutions")
    arguments = parser.parse_args()
    arguments.processes = arguments.processes or (torch.cuda.device_count() if arguments.device == "cuda" else os.cpu_count())
    arguments.out.mkdir(parents=True, exist_ok=True)
    training, _ = (pack(arguments.images / part, arguments.out / "frames" / part, os.cpu_count()) for part in ("training", "validation"))
    identity = {name: getattr(arguments, name) for name in ("batch", "processes", "rate", "small_share", "seed")}
    identity.update({"pictures": len(training["whole"]), "began_with": str(arguments.begin_with or "")})
    checkpoint = arguments.out / "checkpoint.pt"
    if checkpoint.is_file():
        state = torch.load(checkpoint, weights_only=True, map_location="cpu")
        if state["run"] != identity:
            parser.error(f"{checkpoint} is of another run ({state['run']}, not {identity}); name another --out")
        if arguments.steps != state["steps"] and state["step"] > falls_from(min(arguments.steps, state["steps"])):
            parser.error(
                f"{checkpoint} has done {state['step']} of {state['steps']} steps, and the rate of {arguments.steps} steps would "
                f"have been another by then; give --steps {state['steps']}, or name another --out"
            )
    (arguments.out / "meeting").unlink(missing_ok=True)
    torch.multiprocessing.spawn(run, (arguments, identity), arguments.processes)


def mean_of_processes(parameters, processes):
    """Replaces every gradient by its mean over the processes."""
    if processes == 1:
        return
    gradients = torch.cat([p.grad.flatten() for p in parameters])
    distributed.all_reduce(gradients)
    for p, own in zip(parameters, torch.split(gradients / processes, [p.numel() for p in parameters])):
        p.grad.copy_(own.view_as(p.grad))


def run(process, arguments, identity):
    """What one of the processes does; they hold the same network. The first one scores and writes."""
    processes, on_gpu = arguments.processes, arguments.device == "cuda"
    device = torch.device("cuda", process % torch.cuda.device_count()) if on_gpu else torch.device("cpu")
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    torch.manual_seed(arguments.seed)
    distributed.init_process_group("gloo", f"file://{(arguments.out / 'meeting').resolve()}", timedelta(hours=1), processes, process)
    training, validation = (opened(arguments.out / "frames" / part) for part in ("training", "validation"))
    without = WithoutTables(WITHOUT_TABLES, seed=1)
    ahead = ahead_on(device, not arguments.full_precision)

    model = TableNetwork().to(device, memory_format=torch.channels_last)
    if arguments.begin_with:
        first = [shown(batch(frames, frames.numbers[k : k + 16], device)[0]) for frames in training.values() for k in range(0, min(len(frames), 64), 16)]
        begin(model, load_file(arguments.begin_with), first)
    average = averaged(model)
    optimizer = torch.optim.AdamW(model.parameters(), lr=arguments.rate, weight_decay=1e-4)
    step, history = 0, []
    checkpoint = arguments.out / "checkpoint.pt"
    image_counts = {crop: len(frames) for crop, frames in training.items()}
    if checkpoint.is_file():
        state = torch.load(checkpoint, weights_only=True, map_location=device)
        model.load_state_dict(state["model"])
        average.load_state_dict(state["average"])
        optimizer.load_state_dict(state["optimizer"])
        step, history = state["step"], json.loads(state["history"])
    parameters = sum(p.numel() for p in model.parameters())
    if process == 0:
        print(f"{parameters} parameters, {len(training['whole'])} training and {len(validation['whole'])} validation images, from step {step}", flush=True)

    running, since, started, parent = {}, 0, time.monotonic(), os.getppid()
    while step < arguments.steps:
        if os.getppid() != parent:
            raise SystemExit(f"stopped after step {step}: the process that started this one is gone")
        for group in optimizer.param_groups:
            group["lr"] = learning_rate(step, arguments.steps, arguments.rate)
        if step >= (1 - SETTLED) * arguments.steps:
            settle(model)
        generator = torch.Generator(device).manual_seed((arguments.seed * 1_000_003 + step) * processes + process)
        crop, nth = crop_of(step, image_counts)
        nth = nth * processes + process
        places = numbers_of(nth, arguments.batch, image_counts[crop], arguments.seed)
        seen = batch(training[crop], training[crop].numbers[places], device)
        if crop == "whole":
            seen = joined([seen, batch(without, numbers_of(nth, round(JOIN * arguments.batch), WITHOUT_TABLES, arguments.seed), device)])
        else:
            seen = nearer(*seen, generator)
        if step < arguments.small_share * arguments.steps:
            seen = shrunk(*seen)
        images, labels, flags, cameras, facts = varied(*seen, generator)
        parts = losses(ahead(model, images), targets(labels, flags, cameras, facts))
        loss = sum(WEIGHTS[name] * value for name, value in parts.items())
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        mean_of_processes(list(model.parameters()), processes)
        torch.nn.utils.clip_grad_norm_(model.parameters(), 5.0)
        optimizer.step()
        average.update_parameters(model)
        step, since = step + 1, since + 1
        for name, value in parts.items():
            if name not in CAMERA_LOSSES or crop == "whole":
                total, times = running.get(name, (0.0, 0))
                running[name] = total + float(value.detach()), times + 1
        if process == 0 and (step % arguments.every == 0 or step == arguments.steps):
            rate = since * arguments.batch * processes / (time.monotonic() - started)
            torch.set_num_threads(threads)
            scores = validated(average.module, validation, arguments.validate, ahead)
            torch.set_num_threads(1)
            history.append({"step": step, "training": {n: total / times for n, (total, times) in running.items()}, "validation": scores})
            state = {
                "run": identity, "steps": arguments.steps, "step": step, "history": json.dumps(history),
                "model": model.state_dict(), "average": average.state_dict(), "optimizer": optimizer.state_dict(),
            }
            replace(checkpoint, partial(torch.save, state))
            replace(arguments.out / "history.json", lambda path: path.write_text(json.dumps(history, indent=1)))
            replace(arguments.out / "history.png", lambda path: plot(history, path))
            replace(arguments.out / "weights.safetensors", lambda path: save_file(halved(folded(average.module)), path))
            summary = ", ".join(f"{name} {value:.3f}" for name, value in scores.items() if not name.startswith("loss_"))
            print(f"step {step}/{arguments.steps}, {rate:.1f} images/s: {summary}", flush=True)
            running, since, started = {}, 0, time.monotonic()
    distributed.destroy_process_group()


if __name__ == "__main__":
    main()
