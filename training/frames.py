"""From painted folders to the frames a network sees and the maps it should answer with.

A frame is FRAME_WIDTH x FRAME_HEIGHT pixels: the picture shrunk until it fits, in the middle, the rest filled with the
picture's edge pixels. Maps lie on every second pixel of the frame (STRIDE). One painted picture becomes one row of a few
arrays that stay on disk (memory-mapped), so that training reads no JPEG twice.
"""

import json
import os
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

FRAME_WIDTH, FRAME_HEIGHT, STRIDE = 320, 256, 2
MAP_WIDTH, MAP_HEIGHT = FRAME_WIDTH // STRIDE, FRAME_HEIGHT // STRIDE
#: Values of the label map, as `Labels` of the painter has them; objects count from FIRST_OBJECT.
BACKDROP, FRAME, TOP, FIRST_OBJECT = 0, 1, 2, 3
#: A label of padding, which no loss looks at.
IGNORED = 255
#: Bits of the flags map.
OUTLINE, CONTACT = 1, 2
#: Most objects of a picture, and what is known of each: where the middle of its footprint lies in the map (x, y; pixel
#: centers at +0.5), in which rows the points lie that are above it at the object's height and below it on the table, and
#: whether all that is known.
MOST_OBJECTS, FACTS = 17, 5
#: Raised by hand when what is below changes.
VERSION = 4


def placement(width, height):
    """Scale from picture to frame pixels, and the picture's upper left corner in the frame."""
    scale = min(FRAME_WIDTH / width, FRAME_HEIGHT / height)
    shown = round(width * scale), round(height * scale)
    corner = (FRAME_WIDTH - shown[0]) // 2, (FRAME_HEIGHT - shown[1]) // 2
    return scale, corner, shown


def framed(picture):
    """RGB bytes of the frame of a PIL picture; shrinking, each pixel is a tent-weighted mean of all it covers."""
    _, (x, y), shown = placement(*picture.size)
    small = np.asarray(picture.convert("RGB").resize(shown, Image.BILINEAR))
    room = ((y, FRAME_HEIGHT - y - shown[1]), (x, FRAME_WIDTH - x - shown[0]), (0, 0))
    return np.pad(small, room, mode="edge")


def maps(labels, truth):
    """Label and flag map of a picture: labels is its label array, truth what truth.json says."""
    height, width = labels.shape
    scale, (x, y), shown = placement(width, height)
    # Pixel centers of the map, in the picture.
    columns = ((np.arange(MAP_WIDTH) + 0.5) * STRIDE - x) / scale
    rows = ((np.arange(MAP_HEIGHT) + 0.5) * STRIDE - y) / scale
    inside = ((rows >= 0) & (rows < height))[:, None] & ((columns >= 0) & (columns < width))[None, :]
    picked = labels[np.clip(rows.astype(int), 0, height - 1)[:, None], np.clip(columns.astype(int), 0, width - 1)[None, :]]
    label = np.where(inside, picked, IGNORED).astype(np.uint8)

    to_map = lambda p: ((p[0] * scale + x) / STRIDE, (p[1] * scale + y) / STRIDE)
    outline = Image.new("1", (MAP_WIDTH, MAP_HEIGHT))
    if len(truth["table"]["outline_px"]) >= 3:
        ImageDraw.Draw(outline).polygon([to_map(p) for p in truth["table"]["outline_px"]], fill=1)
    contact = np.zeros((MAP_HEIGHT, MAP_WIDTH), bool)
    for index, thing in enumerate(truth["objects"]):
        own = label == FIRST_OBJECT + index
        if len(thing["contact_px"]) < 2 or not own.any():
            continue
        # What touches below: the thing's own pixels on and near the drawn contact, and just below them.
        mark = Image.new("1", (MAP_WIDTH, MAP_HEIGHT))
        points = [to_map(p) for p in thing["contact_px"]]
        ImageDraw.Draw(mark).line(points + points[:1], fill=1, width=3)
        contact |= np.asarray(mark) & own
    flags = np.asarray(outline).astype(np.uint8) * OUTLINE | contact.astype(np.uint8) * CONTACT
    return label, np.where(inside, flags, 0).astype(np.uint8)


def camera(truth):
    """Elevation in radians, the logarithm of the focal length in longer sides of the picture, and that side in frame pixels."""
    longer = max(truth["width_px"], truth["height_px"])
    scale, _, _ = placement(truth["width_px"], truth["height_px"])
    return np.float32(truth["elevation_rad"]), np.float32(np.log(truth["camera"]["fx"] / longer)), np.float32(scale * longer)


def centroid(polygon):
    """Of a simple polygon's area; the corners' mean where it has none."""
    polygon = np.asarray(polygon, float)
    a, b = polygon - polygon[0], np.roll(polygon, -1, 0) - polygon[0]
    areas = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    if abs(areas.sum()) < 1e-9:
        return polygon.mean(0)
    return polygon[0] + (areas[:, None] * (a + b)).sum(0) / (3 * areas.sum())


def projected(camera, point):
    """Picture position of a world point, or None behind the camera."""
    eye = camera["world_from_camera"]
    vector, scalar = -np.array(eye["rotation_xyzw"][:3]), eye["rotation_xyzw"][3]
    away = np.asarray(point) - eye["translation_m"]
    turned = away + 2 * np.cross(vector, np.cross(vector, away) + scalar * away)
    if turned[2] < 1e-3:
        return None
    return camera["fx"] * turned[0] / turned[2] + camera["cx"], camera["fy"] * turned[1] / turned[2] + camera["cy"]


def facts(truth):
    """What is known of each object: (MOST_OBJECTS, FACTS)."""
    known = np.zeros((MOST_OBJECTS, FACTS), np.float32)
    scale, (x, y), _ = placement(truth["width_px"], truth["height_px"])
    for index, thing in enumerate(truth["objects"]):
        if len(thing["footprint_m"]) < 3:
            continue
        middle, foot_m = centroid(thing["footprint_m"]), thing["contact_z_m"]
        heights = foot_m, foot_m + thing["size_m"][2], 0.0
        points = [projected(truth["camera"], [*middle, height]) for height in heights]
        if all(point is not None for point in points):
            row = lambda point: (point[1] * scale + y) / STRIDE
            base, top, ground = points
            known[index] = (base[0] * scale + x) / STRIDE, row(base), row(top), row(ground), 1
    return known


def _one(folder):
    folder = Path(folder)
    truth = json.loads((folder / "truth.json").read_text())
    picture = framed(Image.open(folder / "picture.jpg"))
    label, flags = maps(np.asarray(Image.open(folder / "labels.png")), truth)
    return picture, label, flags, camera(truth), facts(truth)


def pack(painted, packed, workers):
    """Packs every whole picture below `painted` into arrays below `packed`; does nothing where they are there already."""
    folders = sorted(str(folder) for folder in Path(painted).iterdir() if (folder / "truth.json").is_file())
    packed = Path(packed)
    index = packed / "index.json"
    said = {"version": VERSION, "folders": [Path(folder).name for folder in folders]}
    if index.is_file() and json.loads(index.read_text()) == said:
        return Frames(packed)
    packed.mkdir(parents=True, exist_ok=True)
    index.unlink(missing_ok=True)
    arrays = {name: np.lib.format.open_memmap(packed / f"{name}.npy", "w+", kind, (len(folders), *shape)) for name, kind, shape in ARRAYS}
    with ProcessPoolExecutor(workers) as pool:
        for k, (picture, label, flags, taken, known) in enumerate(pool.map(_one, folders, chunksize=16)):
            arrays["pictures"][k], arrays["labels"][k], arrays["flags"][k] = picture, label, flags
            arrays["cameras"][k], arrays["facts"][k] = taken, known
    for array in arrays.values():
        array.flush()
    part = index.with_suffix(".part")
    part.write_text(json.dumps(said))
    os.replace(part, index)
    return Frames(packed)


ARRAYS = [
    ("pictures", np.uint8, (FRAME_HEIGHT, FRAME_WIDTH, 3)),
    ("labels", np.uint8, (MAP_HEIGHT, MAP_WIDTH)),
    ("flags", np.uint8, (MAP_HEIGHT, MAP_WIDTH)),
    ("cameras", np.float32, (3,)),
    ("facts", np.float32, (MOST_OBJECTS, FACTS)),
]


class Frames:
    """Packed frames, read where they lie."""

    def __init__(self, packed):
        for name, _, _ in ARRAYS:
            setattr(self, name, np.load(Path(packed) / f"{name}.npy", mmap_mode="r"))

    def __len__(self):
        return len(self.labels)
