"""Squares around objects, from folders of close-ups, as the recognizer sees them.

The program cuts a square around the object's mask and fills what is not the object with gray
(`crates/method/vision/src/object_recognizer/crop.rs`); `square` and `cut_out` do the same. Training squares vary:
margins, places, masks that are too large or too small, a quarter of them with their surroundings, mirrored, turned, of
fewer pixels, of other brightness, contrast, saturation and white balance, blurred, with noise.
"""

import json
import random
from pathlib import Path

import numpy as np
from PIL import Image, ImageEnhance, ImageFilter

from encoder import INPUT_PX

#: Margin on each side of the box, a share of its longer side.
MARGIN = 0.1
#: Level of the gray around the object.
GRAY = 118
#: Least visible pixels, visible share and longer side of the box, pixels, of an object that is learned.
MIN_PX, MIN_SHARE, MIN_SIDE = 250, 0.35, 20
#: In labels, the first object (`Labels` of the synthesis).
FIRST_OBJECT = 3
#: Begins the name of a shape that is of no category.
NO_CATEGORY = "*"


def square(image, box, margin, shift=(0.0, 0.0)):
    """The square around a box (left, upper, right, lower); it moves into the image where it can, and repeats the pixels
    of the edge where it is larger."""
    side = max(box[2] - box[0], box[3] - box[1]) * (1 + 2 * margin)
    edges = []
    for k in range(2):
        limit, low = image.size[k], (box[k] + box[k + 2] - side) / 2 + shift[k] * side
        if side <= limit:
            low = min(max(low, 0), limit - side)
        edges.append((round(low), round(low + side)))
    (left, right), (upper, lower) = edges
    part = image.crop((max(left, 0), max(upper, 0), min(right, image.width), min(lower, image.height)))
    room = ((max(-upper, 0), max(lower - image.height, 0)), (max(-left, 0), max(right - image.width, 0)), (0, 0))
    return Image.fromarray(np.pad(np.asarray(part), room, mode="edge"))


def cut_out(image, mask, growth):
    """The image with gray where the mask, grown by that odd number of pixels, is not."""
    grown = mask.filter(ImageFilter.MaxFilter(growth)) if growth > 1 else mask
    inside = np.asarray(grown).astype(np.float32)[..., None] / 255
    return Image.fromarray((np.asarray(image).astype(np.float32) * inside + GRAY * (1 - inside)).astype(np.uint8))


def as_seen(image, mask, box):
    """Bytes of the square that the recognizer sees."""
    return np.asarray(square(cut_out(image, mask, 5), box, MARGIN).resize((INPUT_PX, INPUT_PX), Image.BILINEAR))


def varied(image, mask, box, rng):
    """Bytes of a square that varies."""
    if rng.random() >= 0.25:
        image = cut_out(image, mask, rng.choice([1, 3, 5, 5, 7, 9]))
    part = square(image, box, rng.uniform(0, 0.22), (rng.uniform(-0.05, 0.05), rng.uniform(-0.05, 0.05)))
    if rng.random() < 0.5:
        part = part.transpose(Image.FLIP_LEFT_RIGHT)
    if rng.random() < 0.4:
        mean = tuple(int(level) for level in np.asarray(part).mean((0, 1)))
        part = part.rotate(rng.uniform(-12, 12), Image.BILINEAR, fillcolor=mean)
    if rng.random() < 0.5:
        coarse = rng.choice([40, 56, 72, 96, 130])
        if part.width > coarse:
            part = part.resize((coarse, coarse), Image.BILINEAR)
    part = part.resize((INPUT_PX, INPUT_PX), Image.BILINEAR)
    for kind, range_ in ((ImageEnhance.Brightness, 0.35), (ImageEnhance.Contrast, 0.35), (ImageEnhance.Color, 0.5)):
        part = kind(part).enhance(1 + rng.uniform(-range_, range_))
    if rng.random() < 0.25:
        part = part.filter(ImageFilter.GaussianBlur(rng.uniform(0.3, 2.5)))
    colors = np.asarray(part).astype(np.float32)
    if rng.random() < 0.5:
        colors = colors * np.array([rng.uniform(0.85, 1.15) for _ in range(3)], np.float32)
    if rng.random() < 0.3:
        colors = colors + np.random.default_rng(rng.getrandbits(32)).normal(0, rng.uniform(2, 14), colors.shape)
    return np.clip(colors, 0, 255).astype(np.uint8)


def squares(folder, is_varied):
    """Name and square of each object of a close-up."""
    folder = Path(folder)
    truth = json.loads((folder / "truth.json").read_text())
    labels, image = np.asarray(Image.open(folder / "labels.png")), Image.open(folder / "image.jpg").convert("RGB")
    rng = random.Random(f"{truth['split']} {truth['number']}")
    for index, known in enumerate(truth["objects"]):
        if known["visible_px"] < MIN_PX or known["visible_share"] < MIN_SHARE:
            continue
        own = labels == FIRST_OBJECT + index
        rows, columns = np.nonzero(own)
        box = columns.min(), rows.min(), columns.max() + 1, rows.max() + 1
        if max(box[2] - box[0], box[3] - box[1]) < MIN_SIDE:
            continue
        mask = Image.fromarray((own * 255).astype(np.uint8))
        name = NO_CATEGORY * known["is_composite"] + known["name"]
        yield name, varied(image, mask, box, rng) if is_varied else as_seen(image, mask, box)
