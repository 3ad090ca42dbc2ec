"""Masks as COCO compresses them: runs down the columns, differences to the run before the last, groups of five bits."""

import numpy as np


def compressed(mask: np.ndarray) -> dict:
    """`size` = [height, width] and `counts` of a two-dimensional mask of booleans."""
    height, width = mask.shape
    # Column after column; the first run is of background, and may be empty.
    flat = np.concatenate([[False], np.asarray(mask, bool).ravel(order="F")])
    changes = np.flatnonzero(flat[1:] != flat[:-1])
    edges = np.concatenate([[0], changes, [height * width]])
    runs = np.diff(edges).tolist()
    if len(runs) > 1 and runs[-1] == 0:
        runs.pop()
    return {"size": [height, width], "counts": "".join(map(_letters, _differences(runs)))}


def _differences(runs: list) -> list:
    return [run - runs[k - 2] if k > 2 else run for k, run in enumerate(runs)]


def _letters(number: int) -> str:
    letters = []
    while True:
        group, number = number & 31, number >> 5
        # The last group's highest bit is the sign.
        more = number != (-1 if group & 16 else 0)
        letters.append(chr(48 + group + (32 if more else 0)))
        if not more:
            return "".join(letters)
