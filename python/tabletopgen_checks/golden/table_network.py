"""Makes tests/golden/table_network/: a small network of training/ with random weights, and what PyTorch says of it.

    python3.11 -m venv golden && golden/bin/pip install -r training/requirements.txt
    PYTHONPATH=python:training golden/bin/python -m tabletopgen_checks.golden.table_network

Run by hand, when the form of the golden files or of the network changes; no test needs it. In evaluation mode, in
float32 on the CPU. Nothing is left at its initial value, nor are running means and deviations. The encoder is that of
`golden.object_recognizer` with one more stride.

    encoder.safetensors   as training/recognizer.py writes weights
    weights.safetensors   as training/train.py writes them
    golden.safetensors
        <rows>x<columns>.input   bytes b of the frame b / 127.5 - 1, channels first
        <rows>x<columns>.maps
"""

import torch
from safetensors.torch import save_file

from encoder import as_read
from network import TableNetwork, folded
from tabletopgen_checks.golden.object_recognizer import NAMES, random_encoder
from tabletopgen_checks.repository import ROOT

SEED = 20260105
GOLDEN = ROOT / "tests" / "golden" / "table_network"


def main():
    torch.manual_seed(SEED)
    encoder = random_encoder(last_stride=2)
    weights = as_read(encoder, torch.zeros(len(NAMES), 16), torch.zeros(len(NAMES)), NAMES)
    with torch.no_grad():
        for parameter in encoder.parameters():
            parameter.copy_(parameter.half().float())
    model = TableNetwork((8, 12, 16), (1, 0, 2), known_blocks=(1, 2), pretrained=encoder)
    for parameter in model.parameters():
        parameter.data += 0.1 * torch.randn_like(parameter)
    for name, buffer in model.named_buffers():
        if name.endswith("running_mean"):
            buffer.normal_(0.0, 0.3)
        elif name.endswith("running_var"):
            buffer.uniform_(0.4, 2.0)
    model.eval()
    golden = {}
    for rows, columns in [(32, 48), (64, 24)]:
        frame = torch.randint(0, 256, (3, rows, columns), dtype=torch.uint8)
        with torch.no_grad():
            maps = model(frame[None].float() / 127.5 - 1)
        key = f"{rows}x{columns}"
        golden |= {f"{key}.input": frame, f"{key}.maps": maps[0].contiguous()}
    GOLDEN.mkdir(parents=True, exist_ok=True)
    save_file(weights, GOLDEN / "encoder.safetensors")
    save_file(folded(model), GOLDEN / "weights.safetensors")
    save_file(golden, GOLDEN / "golden.safetensors")


if __name__ == "__main__":
    main()
