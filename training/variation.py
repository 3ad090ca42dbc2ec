"""Random variation of synthetic images: other colors of tops, backdrops and objects, patterns on tops and backdrops,
the same light.

The synthesis has a limited number of finishes; from varied ones the network learns that patterns lie flat and that
colors carry no meaning. Regions are multiplied, so that shading and shadows stay where they were.
"""

import math

import torch
from torch.nn import functional as F

from frames import BACKDROP, FRAME, IGNORED, TOP

#: Shares of images in which objects, tops and backdrops are varied.
OBJECTS_VARY, TOP_VARIES, BACKDROP_VARIES = 0.25, 0.25, 0.15
#: Labels that there can be; the last stands for padding.
SLOTS = 64


def uniform(low, high, shape, generator):
    return low + (high - low) * torch.rand(shape, generator=generator, device=generator.device)


def recolored(images, labels, generator):
    """Images (N, 3, H, W) of 0..1 with other colors and patterns of the regions of labels (N, h, w)."""
    n, h, w = labels.shape
    colors = region_colors(n, generator)
    logs = torch.stack([own[slots].permute(2, 0, 1) for own, slots in zip(colors, slots_of(labels))])
    for region, share in ((TOP, TOP_VARIES), (BACKDROP, BACKDROP_VARIES)):
        for k in torch.nonzero(uniform(0, 1, n, generator) < share)[:, 0]:
            logs[k] += (labels[k] == region) * pattern(h, w, generator)
    gain = F.interpolate(logs.exp(), images.shape[-2:], mode="bilinear", align_corners=False)
    return (images * gain).clamp(0, 1)


def slots_of(labels):
    return torch.where(labels == IGNORED, SLOTS - 1, labels.long()).clamp(max=SLOTS - 1)


def region_colors(n, generator):
    """Logarithms of what every region's color is multiplied by, (N, SLOTS, 3)."""
    vary = torch.full((n, SLOTS), OBJECTS_VARY, device=generator.device)
    vary[:, TOP], vary[:, BACKDROP], vary[:, FRAME], vary[:, SLOTS - 1] = TOP_VARIES, BACKDROP_VARIES, 0.15, 0.0
    brighter = uniform(-0.6, 0.25, (n, SLOTS, 1), generator)
    tint = uniform(-0.25, 0.25, (n, SLOTS, 3), generator)
    return (uniform(0, 1, (n, SLOTS, 1), generator) < vary[..., None]) * (brighter + tint)


def pattern(h, w, generator):
    """Logarithms of a pattern on a plane seen at a slant, (3, h, w): stripes, checks, blotches, inlaid patches or
    specks."""
    def number(low, high):
        return uniform(low, high, (), generator)
    contrast = uniform(-0.45, 0.45, (), generator) * (1 + uniform(-0.4, 0.4, (3, 1, 1), generator))
    kind = int(5 * uniform(0, 1, (), generator))
    if kind < 2:
        u, v = plane(h, w, generator)
        def wave(along, length):
            return torch.sin(2 * math.pi * along / length)
        wavelength, sharp = torch.exp(number(math.log(0.03), math.log(0.45))) * w, torch.exp(number(0.0, 3.0))
        stripes = wave(u, wavelength) + number(-0.9, 0.9)
        checks = wave(u, wavelength) * wave(v, wavelength * torch.exp(number(-0.7, 0.7)))
        drawn = torch.tanh(sharp * (stripes, checks)[kind])
    elif kind < 4:
        cells = int(number(3, 24))
        coarse = torch.randn(1, 1, cells, cells, generator=generator, device=generator.device)
        blotches = F.interpolate(coarse, (h, w), mode="bicubic", align_corners=False)[0, 0]
        drawn = blotches if kind == 2 else torch.tanh(6 * (blotches - number(0.3, 1.2)))
    else:
        drawn = 2.0 * (torch.randn(h, w, generator=generator, device=generator.device) > 2.6)
    return contrast * drawn


def plane(h, w, generator):
    """Places (u, v) on a plane whose horizon is above the frame, in map pixels at the center of the frame, each (h,
    w)."""
    def number(low, high):
        return uniform(low, high, (), generator)
    ys, xs = (torch.arange(side, device=generator.device) + 0.5 for side in (h, w))
    ys, xs = ys[:, None], xs[None]
    horizon = -h * torch.exp(number(-1.5, 1.5))
    below_horizon = 0.5 * h - horizon
    across, away = (xs - w * number(0.2, 0.8)) * below_horizon / (ys - horizon), below_horizon * below_horizon / (ys - horizon)
    turn = number(0.0, math.pi)
    return across * turn.cos() + away * turn.sin(), away * turn.cos() - across * turn.sin()
