"""Instances from the network's maps, and their agreement with the labels."""

import torch
from torch.nn import functional as F

from frames import FIRST_OBJECT, IGNORED
from network import split
from targets import OFFSET_UNIT

#: Minimum height of a center, and minimum distance of centers, map pixels.
MIN_CENTER, APART = 0.3, 5
#: Minimum area of an instance, labeled or predicted, map pixels; smaller ones are not counted.
MIN_AREA = 12


def grouped(maps):
    """Instance ids (H, W), 0 where no object is, of the maps (C, H, W) of one image."""
    by_name = {name: m[0] for name, m in split(maps[None].float()).items()}
    is_object = by_name["kinds"].argmax(0) == FIRST_OBJECT
    center = by_name["center"][0]
    peak = F.max_pool2d(center[None, None], APART, 1, APART // 2)[0, 0] == center
    ys, xs = torch.nonzero(peak & (center > MIN_CENTER) & is_object, as_tuple=True)
    ids = torch.zeros(is_object.shape, dtype=torch.long)
    if len(xs) == 0:
        return ids
    h, w = is_object.shape
    gy, gx = torch.meshgrid(torch.arange(h), torch.arange(w), indexing="ij")
    toward_x, toward_y = gx + OFFSET_UNIT * by_name["offset"][0], gy + OFFSET_UNIT * by_name["offset"][1]
    squared = (toward_x[None] - xs[:, None, None]) ** 2 + (toward_y[None] - ys[:, None, None]) ** 2
    ids[is_object] = squared.argmin(0)[is_object] + 1
    return ids


def compared(ids, labels):
    """(labeled, found, invented) instances of one image at an overlap of one half."""
    counts = labels != IGNORED
    labeled = torch.where(counts & (labels >= FIRST_OBJECT), labels.long() - FIRST_OBJECT + 1, 0)
    table = torch.bincount((ids * 64 + labeled)[counts].flatten(), minlength=64 * (int(ids.max()) + 1)).view(-1, 64)
    read_area, labeled_area = table.sum(1), table.sum(0)
    overlap = table / (read_area[:, None] + labeled_area[None] - table).clamp(min=1)
    right = (overlap[1:, 1:] > 0.5) & (labeled_area[1:] >= MIN_AREA)[None]
    found = int(right.any(0).sum())
    # An instance that lies mostly on an object too small to count is neither right nor wrong.
    tiny = table[1:, 1:] * (labeled_area[1:] < MIN_AREA)
    is_counted = (read_area[1:] >= MIN_AREA) & (tiny.sum(1) * 2 < read_area[1:])
    return int((labeled_area[1:] >= MIN_AREA).sum()), found, int((is_counted & ~right.any(1)).sum())
