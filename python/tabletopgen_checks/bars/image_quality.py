"""Images of the qualities fast and high beside those of the path tracer, of scenes of the graded texts.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.image_quality [--program PROGRAM] [--samples 256] [--width 480]

Light is linear after the tone curve, 1 being white. The error is the mean of absolute differences over pixels and
colors, the bias that of signed ones: above zero where the image is too light. SSIM is that of Wang et al. (2004) on
gray, with windows of 8 x 8 pixels. CPU seconds are those of the whole command, which also reads the bundle.
"""

import resource
import shutil
import struct
import subprocess
import zlib
from dataclasses import dataclass
from operator import mul
from pathlib import Path
from statistics import mean

from tabletopgen_checks.bars.grades import SEEDS, TEXTS, generated
from tabletopgen_checks.bars.page import SCENES_OF_TEXTS, arguments, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.edits.appearance import unfiltered
from tabletopgen_checks.problem import Problem

DEPENDS_ON = (*SCENES_OF_TEXTS, "src/cli/render.rs", "tests/words/graded_texts.txt")
FIRST, STEP = 4, 5
QUALITIES = ("fast", "high", "reference")
WINDOW, STRIDE = 8, 4
BAR_ERROR, BAR_SSIM = 0.03, 0.9
LINEAR = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in (k / 255.0 for k in range(256))]


@dataclass(frozen=True)
class Pixels:
    width: int
    rows: list

    def channels(self) -> list:
        """Bytes of red, green and blue of the whole image."""
        whole = b"".join(self.rows)
        return [whole[channel::4] for channel in range(3)]


@dataclass(frozen=True)
class Difference:
    error: float
    bias: float
    ssim: float
    cpu_s: float


def main() -> bool:
    given = arguments(__doc__, program="", samples=256, width=480, images="")
    binary = Path(given.program).resolve() if given.program else given.binary
    folder = Path(given.images).resolve() if given.images else given.work / "image_quality"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    texts = TEXTS.read_text(encoding="utf-8").splitlines()[FIRST::STEP]
    found = {text: compared(binary, text, folder / str(k), given.width, given.samples) for k, text in enumerate(texts)}
    body, holds = page(found, given.width, given.samples)
    write("image_quality", "Images beside those of the path tracer", body, DEPENDS_ON)
    return holds


def compared(binary: Path, text: str, folder: Path, width: int, samples: int) -> dict:
    """Differences of fast and high from the reference, and the CPU seconds of the reference."""
    if not any(generated(binary, text, seed, folder) for seed in SEEDS):
        raise Problem(f"no scene of {text!r} with any of the seeds {SEEDS}")
    images, cpu_s = {}, {}
    for quality in QUALITIES:
        image = folder.with_name(f"{folder.name}_{quality}.png")
        cpu_s[quality] = rendered(binary, folder, image, quality, width, samples)
        images[quality] = pixels(image)
        print(f"{text}: {quality} in {cpu_s[quality]:.1f} CPU s", flush=True)
    shutil.rmtree(folder)
    found = {name: difference(images[name], images["reference"], cpu_s[name]) for name in QUALITIES[:2]}
    return {**found, "reference": cpu_s["reference"]}


def rendered(binary: Path, bundle: Path, image: Path, quality: str, width: int, samples: int) -> float:
    """CPU seconds of the command."""
    command = [str(binary), "render", "--bundle", str(bundle), "--out", str(image), "--quality", quality, "--quiet"]
    command += ["--width-px", str(width), *(["--samples", str(samples)] if quality == "reference" else [])]
    before = children_cpu_s()
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise Problem(f"render ended with exit code {done.returncode}: {done.stderr.strip()}")
    return children_cpu_s() - before


def children_cpu_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def pixels(path: Path) -> Pixels:
    """The rows of an 8-bit RGBA image."""
    data, offset, packed, head = path.read_bytes(), 8, b"", (0,) * 7
    while offset < len(data):
        length, kind = struct.unpack(">I4s", data[offset : offset + 8])
        content = data[offset + 8 : offset + 8 + length]
        if kind == b"IHDR":
            head = struct.unpack(">IIBBBBB", content)
        elif kind == b"IDAT":
            packed += content
        offset += 12 + length
    width, height, bits, color_type, *_, interlaced = head
    channels = {2: 3, 6: 4}.get(color_type)
    if bits != 8 or channels is None or interlaced:
        raise Problem(f"{path} is no 8-bit PNG of color")
    raw, stride = zlib.decompress(packed), width * channels
    row, rows = bytearray(stride), []
    for k in range(height):
        start = k * (stride + 1)
        row = unfiltered(raw[start], raw[start + 1 : start + 1 + stride], row, channels)
        rows.append(bytes(row) if channels == 4 else with_alpha(row))
    return Pixels(width, rows)


def with_alpha(row: bytearray) -> bytes:
    whole = bytearray(b"\xff" * (len(row) // 3 * 4))
    for channel in range(3):
        whole[channel::4] = row[channel::3]
    return bytes(whole)


def difference(image: Pixels, reference: Pixels, cpu_s: float) -> Difference:
    if (image.width, len(image.rows)) != (reference.width, len(reference.rows)):
        raise Problem("images of different sizes cannot be compared")
    pairs = list(zip(image.channels(), reference.channels()))
    signed = [LINEAR[one] - LINEAR[other] for a, b in pairs for one, other in zip(a, b)]
    return Difference(mean(map(abs, signed)), mean(signed), ssim(gray(image), gray(reference)), cpu_s)


def gray(image: Pixels) -> list:
    return [
        [0.299 * r + 0.587 * g + 0.114 * b for r, g, b in zip(row[0::4], row[1::4], row[2::4])] for row in image.rows
    ]


def ssim(one: list, other: list) -> float:
    c1, c2, count = (0.01 * 255) ** 2, (0.03 * 255) ** 2, WINDOW * WINDOW
    found = []
    for y in range(0, len(one) - WINDOW + 1, STRIDE):
        for x in range(0, len(one[0]) - WINDOW + 1, STRIDE):
            a = [value for row in one[y : y + WINDOW] for value in row[x : x + WINDOW]]
            b = [value for row in other[y : y + WINDOW] for value in row[x : x + WINDOW]]
            mean_a, mean_b = sum(a) / count, sum(b) / count
            var_a = sum(map(mul, a, a)) / count - mean_a * mean_a
            var_b = sum(map(mul, b, b)) / count - mean_b * mean_b
            both = sum(map(mul, a, b)) / count - mean_a * mean_b
            alike = (2 * mean_a * mean_b + c1) * (2 * both + c2)
            found.append(alike / ((mean_a * mean_a + mean_b * mean_b + c1) * (var_a + var_b + c2)))
    return mean(found)


def page(found: dict, width: int, samples: int) -> tuple:
    rows = [
        [text, *(cell for name in QUALITIES[:2] for cell in cells(of[name])), f"{of['reference']:.0f}"]
        for text, of in found.items()
    ]
    means = {
        name: Difference(*(mean(getattr(of[name], field) for of in found.values()) for field in Difference.__annotations__))
        for name in QUALITIES[:2]
    }
    fast, high = means["fast"], means["high"]
    holds = high.error <= BAR_ERROR and high.ssim >= BAR_SSIM and high.error <= fast.error
    body = (
        f"{len(found)} scenes, hero images {width} pixels wide, the reference with {samples} paths in each pixel. Mean error "
        f"of high {high.error:.4f} ({BAR_ERROR} promised), mean SSIM {high.ssim:.3f} ({BAR_SSIM} promised), and an error no "
        f"larger than that of fast, {fast.error:.4f}: {'holds' if holds else 'does not hold'}.\n\n"
        "Light is linear after the tone curve, 1 being white. The error is the mean of absolute differences, the bias that "
        "of signed ones, above zero where the image is too light. The noise of the reference is part of the error. "
        "CPU s are those of the whole command.\n\n"
        + table(
            ["text", *(f"{name}: {what}" for name in QUALITIES[:2] for what in ("error", "bias", "SSIM", "CPU s")),
             "reference: CPU s"],
            [*rows, ["mean", *cells(fast), *cells(high), f"{mean(of['reference'] for of in found.values()):.0f}"]],
        )
    )
    return body, holds


def cells(one: Difference) -> list:
    return [f"{one.error:.4f}", f"{one.bias:+.4f}", f"{one.ssim:.3f}", f"{one.cpu_s:.2f}"]


if __name__ == "__main__":
    run(main)
