"""Whether a color is what a color word means, by distance in CIELAB (Wyszecki and Stiles, "Color Science", 1982)."""

import functools
import tomllib

from tabletopgen_checks.repository import CATALOG

WORDS = CATALOG / "words.toml"
# Words whose colors do not overlap.
BASIC = ("red", "orange", "yellow", "green", "blue", "purple", "pink", "brown", "white", "black", "gray")
# Closer than this, shades of one word differ visibly only side by side.
SAME = 22.0


def is_color(rgb, word: str) -> bool:
    """Close to the word's color, or closer to it than to every other basic one."""
    found = lab(rgb)
    away = {name: distance(found, lab(rgb_of(name))) for name in (*BASIC, word)}
    return away[word] <= SAME or away[word] <= min(away.values())


def rgb_of(word: str) -> tuple:
    digits = words()[word].lstrip("#")
    return tuple(int(digits[k : k + 2], 16) / 255 for k in (0, 2, 4))


@functools.cache
def words() -> dict:
    return tomllib.loads(WORDS.read_text(encoding="utf-8"))["colors"]


def lab(rgb) -> tuple:
    """CIELAB of an sRGB color with channels from 0 to 1, for the white of D65."""
    r, g, b = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in rgb)
    x = (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505
    y = 0.2126 * r + 0.7152 * g + 0.0722 * b
    z = (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089
    fx, fy, fz = (c ** (1 / 3) if c > 0.008856 else 7.787 * c + 16 / 116 for c in (x, y, z))
    return 116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)


def distance(a, b) -> float:
    return sum((u - v) ** 2 for u, v in zip(a, b)) ** 0.5
