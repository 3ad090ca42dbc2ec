"""Objects out of the network's maps, and how many of the painted ones they are."""

import torch
from torch.nn import functional as F

from frames import FIRST_OBJECT, IGNORED
from network import split
from targets import OFFSET_UNIT

#: Least height of a center, and how far apart centers lie, map pixels.
LEAST_CENTER, APART = 0.3, 5
#: Objects of fewer map pixels neither count nor are believed.
LEAST_AREA = 12


def grouped(maps):
    """Instance ids (H, W), 0 where no object is, of one picture's maps (C, H, W)."""
    by_name = {name: m[0] for name, m in split(maps[None].float()).items()}
    is_object = by_name["kinds"].argmax(0) == FIRST_OBJECT
    center = by_name["center"][0]
    peak = F.max_pool2d(center[None, None], APART, 1, APART // 2)[0, 0] == center
    ys, xs = torch.nonzero(peak & (center > LEAST_CENTER) & is_object, as_tuple=True)
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
    """(painted, found, invented) of one picture at an overlap of one half."""
    counts = labels != IGNORED
    painted = torch.where(counts & (labels >= FIRST_OBJECT), labels.long() - FIRST_OBJECT + 1, 0)
    table = torch.bincount((ids * 64 + painted)[counts].flatten(), minlength=64 * (int(ids.max()) + 1)).view(-1, 64)
    read_area, painted_area = table.sum(1), table.sum(0)
    overlap = table / (read_area[:, None] + painted_area[None] - table).clamp(min=1)
    right = (overlap[1:, 1:] > 0.5) & (painted_area[1:] >= LEAST_AREA)[None]
    found = int(right.any(0).sum())
    # What lies mostly on a thing too small to count is neither right nor wrong.
    tiny = table[1:, 1:] * (painted_area[1:] < LEAST_AREA)
    believed = (read_area[1:] >= LEAST_AREA) & (tiny.sum(1) * 2 < read_area[1:])
    return int((painted_area[1:] >= LEAST_AREA).sum()), found, int((believed & ~right.any(1)).sum())
