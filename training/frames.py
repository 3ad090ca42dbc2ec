"""Frames that the network sees and maps of labels, from folders of synthetic images.

Each image gives two crops: the whole image, and a closer crop of the table top and what stands on it. A frame holds a
crop, scaled until it fits and centered; edge pixels fill the rest. Maps have a value for every second pixel of the
frame (STRIDE). One crop of one image is one row of a few memory-mapped arrays, so that training decodes no JPEG twice.
"""

import json
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

STRIDE = 2
#: Width and height of frames, multiples of 32: of whole images, and of closer crops, which get the shape that shows
#: them larger.
WHOLE = 320, 256
CLOSER = (480, 384), (640, 288)
#: Range of the margin on each side of a closer crop, a share of its longer side.
MARGIN = 0.02, 0.15
#: Largest scale of a closer crop, frame pixels per image pixel.
MAX_SCALE = 1.5
#: Values of the label map, as `Labels` of the synthesis has them; objects count from FIRST_OBJECT.
BACKDROP, FRAME, TOP, FIRST_OBJECT = 0, 1, 2, 3
#: A label of padding, which no loss counts.
IGNORED = 255
#: Bits of the flags map.
OUTLINE, CONTACT = 1, 2
#: Maximum number of objects in an image, and numbers per object: position of the center of its footprint in the map (x,
#: y; pixel centers at +0.5), rows of the points above it at the object's height and below it on the table, and whether
#: these are known.
MAX_OBJECTS, FACTS = 17, 5
#: What is known of the camera.
CAMERA = 4
#: Raised by hand when what is below changes.
VERSION = 6


@dataclass(frozen=True)
class Crop:
    """A part of an image in a frame: `part` is its left, upper, right and lower edge in whole image pixels."""

    part: tuple
    shape: tuple

    @staticmethod
    def whole(width, height):
        return Crop((0, 0, width, height), WHOLE)

    @staticmethod
    def closer(width, height, box):
        """The crop around a box (left, upper, right, lower), in the shape that shows the box larger, with as much of
        its surroundings as the frame has room for."""
        wanted = max(box[2] - box[0], 1), max(box[3] - box[1], 1)
        def scale_in(shape):
            return min(shape[0] / wanted[0], shape[1] / wanted[1])
        shape = max(CLOSER, key=scale_in)
        scale = min(scale_in(shape), MAX_SCALE)
        edges = []
        for side, low, high, limit in ((shape[0], box[0], box[2], width), (shape[1], box[1], box[3], height)):
            length = min(round(side / scale), limit)
            start = min(max(round(0.5 * (low + high - length)), 0), limit - length)
            edges.append((start, start + length))
        return Crop((edges[0][0], edges[1][0], edges[0][1], edges[1][1]), shape)

    @property
    def size(self):
        return self.part[2] - self.part[0], self.part[3] - self.part[1]

    @property
    def map_shape(self):
        """Rows and columns of the maps."""
        return self.shape[1] // STRIDE, self.shape[0] // STRIDE

    def placement(self):
        """Scale from image to frame pixels, the part's upper left corner in the frame, and its size there."""
        scale = min(self.shape[0] / self.size[0], self.shape[1] / self.size[1])
        shown = round(self.size[0] * scale), round(self.size[1] * scale)
        corner = (self.shape[0] - shown[0]) // 2, (self.shape[1] - shown[1]) // 2
        return scale, corner, shown

    def to_map(self):
        """The function from points of the image to points of the maps."""
        scale, (x, y), _ = self.placement()
        left, upper = self.part[:2]
        return lambda p: (((p[0] - left) * scale + x) / STRIDE, ((p[1] - upper) * scale + y) / STRIDE)


def shown_box(labels, truth, rng):
    """Left, upper, right and lower edge of the top and all that stands on it, with margins; of the whole image where
    neither is visible."""
    rows, columns = np.nonzero((labels >= FIRST_OBJECT) & (labels != IGNORED))
    corners = [*truth["table"]["outline_px"], *([[columns.min(), rows.min()], [columns.max() + 1, rows.max() + 1]] if len(rows) else [])]
    if not corners:
        return 0, 0, labels.shape[1], labels.shape[0]
    low, high = np.min(corners, 0), np.max(corners, 0)
    margins = rng.uniform(*MARGIN, 4) * max(high - low)
    limits = labels.shape[1], labels.shape[0]
    low, high = np.clip(low - margins[:2], 0, limits), np.clip(high + margins[2:], 0, limits)
    return (*low, *high)


def framed(image, crop):
    """RGB bytes of the frame; shrinking, each pixel is a tent-weighted mean of all it covers."""
    _, (x, y), shown = crop.placement()
    small = np.asarray(image.convert("RGB").crop(crop.part).resize(shown, Image.BILINEAR))
    room = ((y, crop.shape[1] - y - shown[1]), (x, crop.shape[0] - x - shown[0]), (0, 0))
    return np.pad(small, room, mode="edge")


def maps(labels, truth, crop):
    """Label and flag map of a crop: labels is the label array of the image, truth the content of truth.json."""
    scale, (x, y), _ = crop.placement()
    left, upper, right, lower = crop.part
    map_height, map_width = crop.map_shape
    # Pixel centers of the map, in the image.
    columns = ((np.arange(map_width) + 0.5) * STRIDE - x) / scale + left
    rows = ((np.arange(map_height) + 0.5) * STRIDE - y) / scale + upper
    inside = ((rows >= upper) & (rows < lower))[:, None] & ((columns >= left) & (columns < right))[None, :]
    picked = labels[np.clip(rows.astype(int), upper, lower - 1)[:, None], np.clip(columns.astype(int), left, right - 1)[None, :]]
    label = np.where(inside, picked, IGNORED).astype(np.uint8)

    to_map = crop.to_map()
    outline = Image.new("1", (map_width, map_height))
    if len(truth["table"]["outline_px"]) >= 3:
        ImageDraw.Draw(outline).polygon([to_map(p) for p in truth["table"]["outline_px"]], fill=1)
    contact = np.zeros((map_height, map_width), bool)
    for index, instance in enumerate(truth["objects"]):
        own = label == FIRST_OBJECT + index
        if len(instance["contact_px"]) < 2 or not own.any():
            continue
        # The object's own pixels on and near the outline of its contact.
        mark = Image.new("1", (map_width, map_height))
        points = [to_map(p) for p in instance["contact_px"]]
        ImageDraw.Draw(mark).line(points + points[:1], fill=1, width=3)
        contact |= np.asarray(mark) & own
    flags = np.asarray(outline).astype(np.uint8) * OUTLINE | contact.astype(np.uint8) * CONTACT
    return label, np.where(inside, flags, 0).astype(np.uint8)


def camera(truth, crop):
    """Elevation in radians, the logarithm of the focal length in longer sides of the image, that side in frame pixels,
    and whether the crop shows where the optical axis is: a part of an image does not."""
    longer = max(truth["width_px"], truth["height_px"])
    is_whole = crop == Crop.whole(truth["width_px"], truth["height_px"])
    scale, _, _ = crop.placement()
    return np.array([truth["elevation_rad"], np.log(truth["camera"]["fx"] / longer), scale * longer, is_whole], np.float32)


def centroid(polygon):
    """Of a simple polygon's area; the corners' mean where it has none."""
    polygon = np.asarray(polygon, float)
    a, b = polygon - polygon[0], np.roll(polygon, -1, 0) - polygon[0]
    areas = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    if abs(areas.sum()) < 1e-9:
        return polygon.mean(0)
    return polygon[0] + (areas[:, None] * (a + b)).sum(0) / (3 * areas.sum())


def projected(camera, point):
    """Image position of a world point, or None behind the camera."""
    eye = camera["world_from_camera"]
    vector, scalar = -np.array(eye["rotation_xyzw"][:3]), eye["rotation_xyzw"][3]
    away = np.asarray(point) - eye["translation_m"]
    turned = away + 2 * np.cross(vector, np.cross(vector, away) + scalar * away)
    if turned[2] < 1e-3:
        return None
    return camera["fx"] * turned[0] / turned[2] + camera["cx"], camera["fy"] * turned[1] / turned[2] + camera["cy"]


def facts(truth, crop):
    """What is known of each object: (MAX_OBJECTS, FACTS)."""
    known = np.zeros((MAX_OBJECTS, FACTS), np.float32)
    to_map = crop.to_map()
    for index, instance in enumerate(truth["objects"]):
        if len(instance["footprint_m"]) < 3:
            continue
        center, foot_m = centroid(instance["footprint_m"]), instance["contact_z_m"]
        heights = foot_m, foot_m + instance["size_m"][2], 0.0
        points = [projected(truth["camera"], [*center, height]) for height in heights]
        if all(point is not None for point in points):
            base, top, ground = map(to_map, points)
            known[index] = *base, top[1], ground[1], 1
    return known


def _crops(folder):
    """Both crops of a synthetic image, each with its frame, maps, camera and facts."""
    folder = Path(folder)
    truth = json.loads((folder / "truth.json").read_text())
    image, labels = Image.open(folder / "image.jpg"), np.asarray(Image.open(folder / "labels.png"))
    height, width = labels.shape
    rng = np.random.default_rng([VERSION, truth["number"]])
    crops = Crop.whole(width, height), Crop.closer(width, height, shown_box(labels, truth, rng))
    return [(crop.shape, framed(image, crop), *maps(labels, truth, crop), camera(truth, crop), facts(truth, crop)) for crop in crops]


class Frames:
    """Memory-mapped crops of one shape; `numbers` are the rows that exist."""

    def __init__(self, packed, numbers):
        self.numbers = numbers
        for name in ARRAYS:
            setattr(self, name, np.load(packed / f"{name}.npy", mmap_mode="r"))

    def __len__(self):
        return len(self.numbers)


def _arrays(shape):
    """Name, type and shape of a row of what a frame of `shape` becomes."""
    map_shape = shape[1] // STRIDE, shape[0] // STRIDE
    return [
        ("images", np.uint8, (shape[1], shape[0], 3)),
        ("labels", np.uint8, map_shape),
        ("flags", np.uint8, map_shape),
        ("cameras", np.float32, (CAMERA,)),
        ("facts", np.float32, (MAX_OBJECTS, FACTS)),
    ]


ARRAYS = [name for name, _, _ in _arrays(WHOLE)]
#: Folders of the crops, with the shapes of their frames.
CROPS = {"whole": WHOLE, **{f"closer_{width}x{height}": (width, height) for width, height in CLOSER}}


def pack(images, packed, workers):
    """Packs every synthetic image below `images` into arrays below `packed`, unless they exist; returns the `Frames` of
    each of CROPS. An image has its row in `whole` and in one of the others, whose files have holes for the rest."""
    folders = sorted(str(folder) for folder in Path(images).iterdir() if (folder / "truth.json").is_file())
    packed = Path(packed)
    index = packed / "index.json"
    said = {"version": VERSION, "arrays": ARRAYS, "folders": [Path(folder).name for folder in folders]}
    known = json.loads(index.read_text()) if index.is_file() else {}
    if {name: known.get(name) for name in said} != said:
        index.unlink(missing_ok=True)
        arrays, numbers = {}, {crop: [] for crop in CROPS}
        for crop, shape in CROPS.items():
            (packed / crop).mkdir(parents=True, exist_ok=True)
            arrays[crop] = [
                np.lib.format.open_memmap(packed / crop / f"{name}.npy", "w+", kind, (len(folders), *row))
                for name, kind, row in _arrays(shape)
            ]
        with ProcessPoolExecutor(workers) as pool:
            for k, (whole, closer) in enumerate(pool.map(_crops, folders, chunksize=16)):
                for crop, (_, *row) in (("whole", whole), ("closer_{}x{}".format(*closer[0]), closer)):
                    numbers[crop].append(k)
                    for array, value in zip(arrays[crop], row):
                        array[k] = value
        for array in (array for own in arrays.values() for array in own):
            array.flush()
        part = index.with_suffix(".part")
        part.write_text(json.dumps({**said, "numbers": numbers}))
        os.replace(part, index)
    return opened(packed)


def opened(packed):
    """The `Frames` of each of CROPS that `pack` packed there."""
    numbers = json.loads((Path(packed) / "index.json").read_text())["numbers"]
    return {crop: Frames(Path(packed) / crop, np.array(numbers[crop], int)) for crop in CROPS}
