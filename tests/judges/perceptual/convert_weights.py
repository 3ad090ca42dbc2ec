"""Converts published weights of LPIPS to the two files that the program reads.

    perceptual/bin/python tests/judges/perceptual/convert_weights.py --network alexnet \\
        --backbone alexnet-owt-7be5be79.pth --out weights/lpips

The backbone is torchvision's file of that network, trained on ImageNet: `alexnet-owt-7be5be79.pth` or
`vgg16-397923af.pth`. The linear layers are those that the package `lpips` ships. Nothing is downloaded.
"""

import argparse
from pathlib import Path

import lpips
import torch
from safetensors.torch import save_file

# Name of the linear layers' file in the package.
LINEAR_LAYERS = {"alexnet": "alex", "vgg16": "vgg"}


def tensors(path, prefix):
    """The tensors of a state dict whose names begin with the prefix."""
    state = torch.load(path, map_location="cpu", weights_only=True)
    return {name: tensor.float().contiguous() for name, tensor in state.items() if name.startswith(prefix)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--network", choices=sorted(LINEAR_LAYERS), required=True)
    parser.add_argument("--backbone", type=Path, required=True, metavar="FILE", help="torchvision's state dict")
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER")
    options = parser.parse_args()
    linear_layers = Path(lpips.__file__).parent / "weights" / "v0.1" / f"{LINEAR_LAYERS[options.network]}.pth"
    options.out.mkdir(parents=True, exist_ok=True)
    save_file(tensors(options.backbone, "features."), options.out / "backbone.safetensors")
    save_file(tensors(linear_layers, "lin"), options.out / "linear_layers.safetensors")


if __name__ == "__main__":
    main()
