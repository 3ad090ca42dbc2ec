"""Makes tests/golden/object_recognizer/: a small recognizer with random weights, and what the reference says with it.

    python3.11 -m venv golden && golden/bin/pip install -r training/requirements.txt
    PYTHONPATH=python golden/bin/python -m tabletopgen_checks.golden.object_recognizer

Run by hand, when the form of the golden files changes; no test needs it. The reference is `training/encoder.py` with
fewer blocks and channels, and `training/close_ups.py`.

    weights.safetensors   as training/recognizer.py writes weights, for the classes mug, banana, laptop and unknown
    golden.safetensors
        <n>.colors <n>.mask     bytes of an image, rows first, and the mask of an object in it
        <n>.square              normalized colors of its square, channels first
        <n>.probabilities       those of the classes
"""

import sys

import numpy as np
import torch
from PIL import Image
from safetensors.torch import save_file

from tabletopgen_checks.repository import ROOT

sys.path.insert(0, str(ROOT / "training"))

import close_ups  # noqa: E402
import encoder  # noqa: E402

SEED = 20261201
GOLDEN = ROOT / "tests" / "golden" / "object_recognizer"
NAMES = ["mug", "banana", "laptop", "unknown"]
INPUT_PX = 33
#: Height, width and the mask's box of the images: one inside, one at the border, one larger than the image is high.
IMAGES = [(60, 80, (20, 10, 62, 40)), (50, 70, (45, 5, 70, 50)), (40, 90, (10, 2, 75, 38))]


def random_encoder(last_stride=1):
    """Three blocks: without and with expansion, of stride 2 by a kernel of 5, of the last stride."""
    def convolution(outputs, inputs, side, **kind):
        scale = 1.4 / (inputs * side * side) ** 0.5
        return encoder.Convolution(torch.randn(outputs, inputs, side, side) * scale, 0.3 * torch.randn(outputs), **kind)

    made = encoder.Encoder.__new__(encoder.Encoder)
    torch.nn.Module.__init__(made)
    made.stem = convolution(8, 3, 3, stride=2)
    made.blocks = torch.nn.ModuleList([
        encoder.InvertedResidual(None, convolution(8, 1, 3, groups=8), convolution(6, 8, 1)),
        encoder.InvertedResidual(convolution(12, 6, 1), convolution(12, 1, 5, stride=2, groups=12), convolution(7, 12, 1)),
        encoder.InvertedResidual(convolution(14, 7, 1), convolution(14, 1, 3, stride=last_stride, groups=14), convolution(7, 14, 1)),
    ])
    made.head = convolution(16, 7, 1)
    return made


def main():
    torch.manual_seed(SEED)
    rng = np.random.default_rng(SEED)
    made, classifier = random_encoder(), (torch.randn(len(NAMES), 16) * 0.25, 0.2 * torch.randn(len(NAMES)))
    encoder.INPUT_PX = close_ups.INPUT_PX = INPUT_PX
    weights = encoder.as_read(made, *classifier, NAMES)
    # The reference calculates with the rounded weights.
    with torch.no_grad():
        for parameter in made.parameters():
            parameter.copy_(parameter.half().float())
    classifier = [values.half().float() for values in classifier]
    golden = {}
    for number, (height, width, (left, upper, right, lower)) in enumerate(IMAGES):
        coarse = Image.fromarray(rng.integers(0, 256, (height // 8, width // 8, 3), dtype=np.uint8))
        image = coarse.resize((width, height), Image.BICUBIC)
        mask = np.zeros((height, width), np.uint8)
        mask[upper:lower, left:right] = 255
        # Grown by less than one pixel, as the program does here.
        part = close_ups.square(close_ups.cut_out(image, Image.fromarray(mask), 1), (left, upper, right, lower), close_ups.MARGIN)
        square = np.asarray(part.resize((INPUT_PX, INPUT_PX), Image.BILINEAR))
        x = encoder.normalized(square[None])
        with torch.no_grad():
            features = x
            features = torch.nn.functional.relu6(made.stem(features))
            for block in made.blocks:
                features = block(features)
            features = torch.nn.functional.relu6(made.head(features)).mean((2, 3))
            probabilities = (features @ classifier[0].T + classifier[1]).softmax(1)[0]
        golden |= {
            f"{number}.colors": torch.from_numpy(np.array(image)),
            f"{number}.mask": torch.from_numpy((mask > 0).astype(np.uint8)),
            f"{number}.square": x[0].contiguous(),
            f"{number}.probabilities": probabilities,
        }
        print(number, probabilities)
    GOLDEN.mkdir(parents=True, exist_ok=True)
    save_file(weights, GOLDEN / "weights.safetensors")
    save_file(golden, GOLDEN / "golden.safetensors")


if __name__ == "__main__":
    main()
