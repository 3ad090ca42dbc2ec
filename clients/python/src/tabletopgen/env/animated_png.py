"""Animated images without a package that encodes them: PNG with the chunks of animation of its third edition.

Browsers play such a file, and ffmpeg reads it. Pixels that stay as they are in the frame before are transparent, so
that they take next to no space. No pixel loses anything.
"""

from __future__ import annotations

import struct
import zlib

import numpy as np
from numpy.typing import NDArray

SIGNATURE = b"\x89PNG\r\n\x1a\n"
# Eight bits a channel, with a channel of opacity.
BIT_DEPTH, RGBA = 8, 6
# What lies below a transparent pixel stays.
KEEP, OVER = 0, 1
COMPRESSION = 6

Image = NDArray[np.uint8]


class AnimatedPng:
    """Frames of one size, (height, width, 3), that are shown so many a second, once."""

    def __init__(self, fps: int):
        self.fps = fps
        self._frames: list[bytes] = []
        self._shown: Image | None = None

    def add(self, frame: Image) -> None:
        """Adds the next frame."""
        opaque = np.full(frame.shape[:2], 255, dtype=np.uint8)
        if self._shown is not None:
            if frame.shape != self._shown.shape:
                raise ValueError(f"a frame of {frame.shape} follows one of {self._shown.shape}; give frames of one size")
            opaque[(frame == self._shown).all(axis=2)] = 0
        self._shown = frame.copy()
        colors = np.where(opaque[:, :, None] > 0, frame, 0)
        self._frames.append(compressed(np.dstack([colors, opaque])))

    def content(self) -> bytes:
        """The bytes of the file."""
        if self._shown is None:
            raise ValueError("an animated image needs one frame or more; add one")
        height, width = self._shown.shape[:2]
        header = struct.pack(">IIBBBBB", width, height, BIT_DEPTH, RGBA, 0, 0, 0)
        parts = [SIGNATURE, chunk(b"IHDR", header), chunk(b"acTL", struct.pack(">II", len(self._frames), 1))]
        number = 0
        for place, data in enumerate(self._frames):
            parts.append(chunk(b"fcTL", struct.pack(">IIIIIHHBB", number, width, height, 0, 0, 1, self.fps, KEEP, OVER)))
            number += 1
            if place == 0:
                parts.append(chunk(b"IDAT", data))
            else:
                parts.append(chunk(b"fdAT", struct.pack(">I", number) + data))
                number += 1
        return b"".join([*parts, chunk(b"IEND", b"")])


def compressed(pixels: Image) -> bytes:
    """The data of a frame; each row has the filter that subtracts the row above."""
    below = np.diff(pixels.astype(np.int16), axis=0, prepend=np.zeros_like(pixels[:1], dtype=np.int16)).astype(np.uint8)
    up = np.full((len(pixels), 1), 2, dtype=np.uint8)
    return zlib.compress(np.hstack([up, below.reshape(len(pixels), -1)]).tobytes(), COMPRESSION)


def chunk(kind: bytes, data: bytes) -> bytes:
    """A chunk with its length and checksum."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
