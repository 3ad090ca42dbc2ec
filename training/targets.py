"""What the network should answer, from label and flag maps; all on the maps' grid."""

import torch
from torch.nn import functional as F

from frames import BACKDROP, CONTACT, FIRST_OBJECT, IGNORED, MAX_OBJECTS, OUTLINE, WHOLE

#: Standard deviation of the bump at an object's center, map pixels.
CENTER_SIGMA = 2.5
#: Offsets are counted in this many map pixels.
OFFSET_UNIT = 8.0


def slants(rows, cameras):
    """Angle of a row's rays to the optical axis, downward, (N, rows), with the focal lengths of the cameras (N, 4); of
    frames of whole images."""
    below_px = ((torch.arange(rows, device=cameras.device) + 0.5) / rows - 0.5) * WHOLE[1]
    return torch.atan(below_px / (cameras[:, 1].exp() * cameras[:, 2])[:, None])


def elevation_of(by_name, cameras_px):
    """Elevation (N) and logarithm of the focal length (N) that maps say, by all places inside the outline.

    `by_name` are the maps by name, `cameras_px` (N) the longer side of each image in frame pixels.
    """
    weight = by_name["outline"][:, 0].sigmoid()
    def mean(values):
        return (values * weight).sum((1, 2)) / weight.sum((1, 2)).clamp(min=1e-3)
    log_focal = mean(by_name["focal"][:, 0])
    said = torch.stack([torch.zeros_like(log_focal), log_focal, cameras_px], 1)
    return mean(by_name["latitude"][:, 0] - slants(weight.shape[1], said)[:, :, None]), log_focal


def targets(labels, flags, cameras, facts):
    """Of labels and flags (N, H, W), cameras (N, 4) and facts (N, MAX_OBJECTS, FACTS): a dictionary of maps, and where
    they count."""
    n, h, w = labels.shape
    device, labels = labels.device, labels.long()
    counts = labels != IGNORED
    is_object = counts & (labels >= FIRST_OBJECT)
    ids = torch.where(is_object, labels - FIRST_OBJECT + 1, 0)
    kinds = torch.where(is_object, FIRST_OBJECT, labels).clamp(max=FIRST_OBJECT)
    ys, xs = torch.meshgrid(torch.arange(h, device=device), torch.arange(w, device=device), indexing="ij")
    # Centroid of the visible pixels of every object, by sums over ids.
    slots = MAX_OBJECTS + 1
    flat = (ids + slots * torch.arange(n, device=device)[:, None, None]).flatten()
    def total(values):
        return torch.zeros(n * slots, device=device).index_add_(0, flat, values.expand(n, h, w).flatten().float())
    pixels = total(torch.ones_like(xs))
    area = pixels.clamp(min=1)
    cx, cy = total(xs) / area, total(ys) / area
    def at(value):
        return value[flat].view(n, h, w)
    offset = torch.stack([at(cx) - xs, at(cy) - ys], 1) / OFFSET_UNIT
    # What is known of the object that a place belongs to; nothing where none is.
    known = F.pad(facts, (0, 0, 1, 0)).reshape(n * slots, -1)[flat].view(n, h, w, -1).permute(0, 3, 1, 2)
    base = torch.stack([known[:, 0] - 0.5 - xs, known[:, 1] - 0.5 - ys], 1) / OFFSET_UNIT
    # Bumps: the nearest center wins.
    shown = (pixels > 0).view(n, slots)[:, 1:]
    cx, cy = cx.view(n, slots)[:, 1:], cy.view(n, slots)[:, 1:]
    far = torch.where(shown, 0.0, 1e6)
    squared = (xs - cx[:, :, None, None]) ** 2 + (ys - cy[:, :, None, None]) ** 2 + far[:, :, None, None]
    center = torch.exp(-0.5 * squared.amin(1) / CENTER_SIGMA**2)
    # Border: a pixel of an object beside one of another object.
    wide = F.pad(ids, (1, 1, 1, 1), value=-1)
    border = torch.zeros_like(is_object)
    for dy in (0, 1, 2):
        for dx in (0, 1, 2):
            other = wide[:, dy : dy + h, dx : dx + w]
            border |= (other > 0) & (other != ids) & is_object
    return {
        "kinds": kinds.clamp(max=FIRST_OBJECT),
        "counts": counts,
        "outline": (flags & OUTLINE) > 0,
        "contact": (flags & CONTACT) > 0,
        "border": border,
        "center": center,
        "offset": offset,
        "base": base,
        "top": (known[:, 2] - 0.5 - ys) / OFFSET_UNIT,
        "ground": (known[:, 3] - 0.5 - ys) / OFFSET_UNIT,
        # How far below the horizon a place is seen.
        "latitude": (cameras[:, :1] + slants(h, cameras))[:, :, None].expand(n, h, w),
        "focal": cameras[:, 1, None, None].expand(n, h, w),
        "tells_camera": counts & (labels != BACKDROP) & (cameras[:, 3] > 0)[:, None, None],
        "is_known": known[:, 4] > 0,
        "is_object": is_object,
        "area": torch.where(is_object, at(area), 1.0),
    }
