"""Images that show no table: blank pages, noise, flat shapes, drawn faces, writing, bands of a landscape.

A network that has only seen tables takes a face for a round one.
"""

import numpy as np
from PIL import Image, ImageDraw, ImageFilter

from frames import BACKDROP, CAMERA, FACTS, MAX_OBJECTS, STRIDE, WHOLE


def color(rng, pale=False):
    return tuple(int(c) for c in (rng.integers(200, 256, 3) if pale else rng.integers(0, 256, 3)))


def ellipse(draw, x, y, across, down, fill, line=None):
    draw.ellipse([x - across, y - down, x + across, y + down], fill=fill, outline=line)


def blank(draw, size, rng):
    del draw, size, rng


def face(draw, size, rng):
    """From in front: hair, head, eyes, brows, nose, mouth, some of them left out."""
    width, height = size
    x, y = width * rng.uniform(0.3, 0.7), height * rng.uniform(0.35, 0.65)
    across = height * rng.uniform(0.12, 0.42)
    down = across * rng.uniform(0.9, 1.45)
    dark = tuple(int(c) for c in rng.integers(0, 90, 3))
    if rng.random() < 0.6:
        draw.rectangle([x - 0.4 * across, y, x + 0.4 * across, height], fill=color(rng))
        ellipse(draw, x, height * 1.1, 1.8 * across, height * 1.1 - y - 0.8 * down, color(rng))
    if rng.random() < 0.6:
        ellipse(draw, x, y - 0.25 * down, 1.15 * across, 1.05 * down, dark)
    skin = color(rng, rng.random() < 0.5) if rng.random() < 0.5 else (int(rng.integers(150, 256)), int(rng.integers(110, 220)), int(rng.integers(70, 190)))
    ellipse(draw, x, y, across, down, skin, dark if rng.random() < 0.5 else None)
    apart, up, eye = across * rng.uniform(0.3, 0.5), down * rng.uniform(0.05, 0.3), across * rng.uniform(0.06, 0.2)
    for side in (-1, 1):
        white = rng.random() < 0.6
        ellipse(draw, x + side * apart, y - up, eye * 1.4, eye, (255, 255, 255) if white else dark)
        if white:
            ellipse(draw, x + side * apart, y - up, 0.6 * eye, 0.6 * eye, color(rng))
        if rng.random() < 0.6:
            draw.line([x + side * (apart - 2 * eye), y - up - 2.2 * eye, x + side * (apart + 2 * eye), y - up - 2 * eye], fill=dark, width=int(rng.integers(1, 6)))
    if rng.random() < 0.7:
        draw.polygon([(x, y - 0.1 * down), (x - 0.15 * across, y + 0.25 * down), (x + 0.15 * across, y + 0.25 * down)], fill=tuple(int(0.85 * c) for c in skin))
    mouth = [x - 0.45 * across, y + 0.3 * down, x + 0.45 * across, y + 0.7 * down]
    if rng.random() < 0.5:
        draw.arc(mouth, 20, 160, fill=dark, width=int(rng.integers(2, 7)))
    else:
        draw.chord(mouth, 0, 180, fill=(int(rng.integers(120, 230)), 40, 60))


def shapes(draw, size, rng):
    """Flat ellipses and polygons anywhere."""
    for _ in range(rng.integers(1, 14)):
        x, y, reach = rng.uniform(0, size[0]), rng.uniform(0, size[1]), size[1] * rng.uniform(0.02, 0.3)
        if rng.random() < 0.4:
            ellipse(draw, x, y, reach, reach * rng.uniform(0.5, 2.0), color(rng))
        else:
            turns = np.sort(rng.uniform(0, 2 * np.pi, rng.integers(3, 7)))
            draw.polygon([(x + reach * np.cos(t), y + reach * np.sin(t)) for t in turns], fill=color(rng))


def writing(draw, size, rng):
    """Lines of words."""
    ink, line = color(rng), rng.uniform(0.03, 0.08) * size[1]
    y = rng.uniform(0.02, 0.2) * size[1]
    while y < 0.95 * size[1]:
        x = 0.06 * size[0]
        while x < rng.uniform(0.7, 0.95) * size[0]:
            length = rng.uniform(0.5, 4.0) * line
            draw.rectangle([x, y, min(x + length, 0.95 * size[0]), y + 0.45 * line], fill=ink)
            x += length + 0.4 * line
        y += line


def landscape(draw, size, rng):
    """Bands of ground under a sky, a sun, houses or hills."""
    y = rng.uniform(0.3, 0.7) * size[1]
    if rng.random() < 0.6:
        ellipse(draw, rng.uniform(0, size[0]), rng.uniform(0, y), *[size[1] * rng.uniform(0.03, 0.12)] * 2, color(rng, True))
    for _ in range(rng.integers(0, 5)):
        x, reach = rng.uniform(0, size[0]), rng.uniform(0.05, 0.3) * size[0]
        high = rng.uniform(0.1, 0.4) * size[1]
        if rng.random() < 0.5:
            draw.polygon([(x - reach, y), (x, y - high), (x + reach, y)], fill=color(rng))
        else:
            draw.rectangle([x - 0.5 * reach, y - high, x + 0.5 * reach, y], fill=color(rng))
    while y < size[1]:
        draw.rectangle([0, y, size[0], size[1]], fill=color(rng))
        y += rng.uniform(0.1, 0.5) * size[1]


KINDS = [(blank, 1), (face, 4), (shapes, 2), (writing, 1), (landscape, 2)]


def drawn(number, seed):
    """RGB bytes (H, W, 3) of a frame of a whole image."""
    rng = np.random.default_rng([seed, number])
    width, height = WHOLE
    start, end = np.array(color(rng, rng.random() < 0.6)), np.array(color(rng, rng.random() < 0.6))
    share = np.linspace(0, 1, height)[:, None, None] * (rng.random() < 0.5)
    image = Image.fromarray(np.broadcast_to(start + share * (end - start), (height, width, 3)).astype(np.uint8))
    weights = np.array([weight for _, weight in KINDS], float)
    KINDS[rng.choice(len(KINDS), p=weights / weights.sum())][0](ImageDraw.Draw(image), (width, height), rng)
    if rng.random() < 0.5:
        image = image.filter(ImageFilter.GaussianBlur(rng.uniform(0.3, 2.5)))
    noise = rng.uniform(0, 0.06) if rng.random() < 0.8 else rng.uniform(0.1, 1.0)
    return (np.asarray(image) + 255 * noise * rng.standard_normal((height, width, 3))).clip(0, 255).astype(np.uint8)


class WithoutTables:
    """Frames of whole images without a table, as `Frames` has those with one."""

    def __init__(self, count, seed):
        rows, columns = WHOLE[1] // STRIDE, WHOLE[0] // STRIDE
        self.numbers = np.arange(count)
        self.images = np.stack([drawn(number, seed) for number in range(count)])
        self.labels = np.full((count, rows, columns), BACKDROP, np.uint8)
        self.flags = np.zeros((count, rows, columns), np.uint8)
        # Nothing tells the camera; the angles' focal length must not be zero.
        self.cameras = np.tile(np.array([0, 0, WHOLE[0], 0], np.float32)[:CAMERA], (count, 1))
        self.facts = np.zeros((count, MAX_OBJECTS, FACTS), np.float32)

    def __len__(self):
        return len(self.numbers)
