"""Makes tests/golden/lpips/ and tests/golden/clip/: small random models, and what the references say of images.

    python3.11 -m venv perceptual && perceptual/bin/pip install -r tests/judges/perceptual/requirements.txt
    perceptual/bin/python tests/judges/perceptual/reference.py
    perceptual/bin/python tests/judges/perceptual/reference.py --full FOLDER

Run by hand, when the form of the golden files changes; no test needs it. The references are `LPIPS` of the package
`lpips` over networks of `torchvision`, `CLIPVisionModelWithProjection`, `CLIPModel` and `CLIPImageProcessorPil` of
`transformers`, and Pillow, in evaluation mode, in float32 on the CPU. No parameter keeps its initial value: a model of
zeros and ones agrees with many wrong ones.

The networks of LPIPS are torchvision's with every convolution narrowed, so that the layout is theirs and the files are
small. `--full` writes them in full width, with the linear layers that the package ships, and a CLIP ViT-B/32, for the
tests that are ignored; those read the folder from TABLETOPGEN_PERCEPTUAL_REFERENCE.

    lpips/<network>/    backbone.safetensors as torchvision's state dict, linear_layers.safetensors as the package's
    lpips/golden.safetensors
        pair.<n>.a pair.<n>.b        bytes of two images, rows x columns x 3
        <network>.pair.<n>.distance  their distance
    clip/<model>/       config.json, model.safetensors as published weights are laid out
    clip/golden.safetensors
        image.<n>.rgb                bytes of an image, rows x columns x 3
        <model>.image.<n>.pixels     the same resized, cropped and normalized
        <model>.image.<n>.embedding  its projected embedding, not normalized
        resized.<n>                  bytes of image n as Pillow resizes it
"""

import argparse
import json
from pathlib import Path

import lpips
import torch
import torchvision
from PIL import Image
from safetensors.torch import load_file, save_file
from transformers import (
    CLIPConfig,
    CLIPModel,
    CLIPTextConfig,
    CLIPVisionConfig,
    CLIPVisionModelWithProjection,
)
from transformers.models.clip.image_processing_pil_clip import CLIPImageProcessorPil

SEED = 20260202
GOLDEN = Path(__file__).resolve().parents[2] / "golden"
# Name in torchvision, name in lpips, divisor of the widths.
NETWORKS = [("alexnet", "alex", 16), ("vgg16", "vgg", 32)]
# Height and width: multiples of all strides, and of none.
PAIRS = [(64, 48), (45, 67)]
FULL_PAIRS = [(224, 224), (192, 256)]
# Height and width: landscape and reduced, portrait and enlarged, the input's own size.
IMAGES = [(53, 80), (31, 20), (42, 42)]
RESIZED = [(17, 29), (64, 33), (42, 20)]

CLIP_VISION = {
    "patch14": CLIPVisionConfig(
        hidden_size=24,
        intermediate_size=40,
        projection_dim=10,
        num_hidden_layers=3,
        num_attention_heads=4,
        image_size=42,
        patch_size=14,
    ),
    "gelu": CLIPVisionConfig(
        hidden_size=16,
        intermediate_size=48,
        projection_dim=12,
        num_hidden_layers=2,
        num_attention_heads=2,
        image_size=32,
        patch_size=8,
        hidden_act="gelu",
        layer_norm_eps=1e-3,
    ),
}
CLIP_TEXT = CLIPTextConfig(
    vocab_size=12, hidden_size=8, intermediate_size=8, projection_dim=12, num_hidden_layers=1, num_attention_heads=1
)


def image(height, width):
    """Bytes of an image with smooth areas, edges and noise, rows x columns x 3."""
    y, x = torch.meshgrid(torch.linspace(0, 1, height), torch.linspace(0, 1, width), indexing="ij")
    channels = []
    for _ in range(3):
        a, b, c, d = torch.rand(4).tolist()
        wave = 0.5 + 0.3 * torch.sin(6 * a + 9 * b * x + 7 * c * y)
        wave[(x - a) ** 2 + (y - b) ** 2 < 0.02 + 0.1 * c] = d
        channels.append(wave + 0.05 * torch.randn(height, width))
    return (torch.stack(channels, 2).clamp(0, 1) * 255).round().to(torch.uint8)


def changed(bytes_):
    """The image shifted, darkened and with a bar in it."""
    other = torch.roll(bytes_, (2, 3), (0, 1)).float() * 0.9
    other[5:15, 8:30] = torch.tensor([220.0, 40.0, 10.0])
    return other.round().to(torch.uint8)


def narrowed(features, divisor):
    """The convolutions with a fraction of their channels, all else as it is."""
    layers, inputs = [], 3
    for layer in features:
        if isinstance(layer, torch.nn.Conv2d):
            outputs = layer.out_channels // divisor + (1 if divisor > 1 else 0)
            layer = torch.nn.Conv2d(inputs, outputs, layer.kernel_size, layer.stride, layer.padding)
            inputs = outputs
        layers.append(layer)
    return torch.nn.Sequential(*layers)


def randomize(model, bias=0.2, gain=1.3):
    """`gain` is the standard deviation of a matrix times the square root of its inputs."""
    for name, parameter in model.named_parameters():
        noise = torch.randn_like(parameter)
        if "norm" in name and name.endswith("weight"):
            values = 1.0 + 0.3 * noise
        elif name.endswith("bias"):
            values = bias * noise
        elif "embedding" in name and "patch" not in name:
            values = 0.6 * noise
        elif parameter.ndim > 1:
            values = noise * gain / parameter[0].numel() ** 0.5
        else:
            values = noise
        parameter.data.copy_(values)


def perceptual_model(name, short_name, divisor):
    """LPIPS over a random network, and the network's state dict."""
    network = getattr(torchvision.models, name)()
    network.features = narrowed(network.features, divisor)
    # Each bias counts, also in the last of 13 convolutions.
    randomize(network.features, bias=0.5, gain=1.5)
    model = lpips.LPIPS(net=short_name, pnet_rand=True, pretrained=divisor == 1, verbose=False)
    lpips.pretrained_networks.tv = type("Stub", (), {name: staticmethod(lambda pretrained: network)})
    model.net = type(model.net)(pretrained=False)
    lpips.pretrained_networks.tv = torchvision.models
    if divisor > 1:
        convolutions = [layer for layer in model.net.modules() if isinstance(layer, torch.nn.Conv2d)]
        ends = [[m for m in getattr(model.net, f"slice{k}").modules() if m in convolutions][-1] for k in range(1, 6)]
        for linear, end in zip(model.lins, ends):
            linear.model[1] = torch.nn.Conv2d(end.out_channels, 1, 1, bias=False)
            # The published weights are not negative either.
            linear.model[1].weight.data = torch.rand(1, end.out_channels, 1, 1)
    features = {k: v.contiguous() for k, v in network.state_dict().items() if k.startswith("features.")}
    return model.eval(), features


def write_lpips(folder, pairs, is_full):
    torch.manual_seed(SEED)
    golden = {}
    for index, (height, width) in enumerate(pairs):
        a = image(height, width)
        golden[f"pair.{index}.a"], golden[f"pair.{index}.b"] = a, changed(a)
    for name, short_name, divisor in NETWORKS:
        model, features = perceptual_model(name, short_name, 1 if is_full else divisor)
        own = folder / name
        own.mkdir(parents=True, exist_ok=True)
        save_file(features, own / "backbone.safetensors")
        linear = {k: v.clone() for k, v in model.state_dict().items() if k.startswith("lin") and not k.startswith("lins")}
        save_file(linear, own / "linear_layers.safetensors")
        for index in range(len(pairs)):
            a, b = (golden[f"pair.{index}.{side}"].permute(2, 0, 1)[None].float() / 255 for side in "ab")
            with torch.no_grad():
                distance = model(a, b, normalize=True)
            golden[f"{name}.pair.{index}.distance"] = distance.flatten()
            print(name, index, distance.item())
    save_file(golden, folder / "golden.safetensors")


def clip_model(name, config):
    """The tower alone, or within both towers, whose files have another form."""
    if name != "gelu":
        return CLIPVisionModelWithProjection(config).eval()
    towers = {"text_config": CLIP_TEXT.to_dict(), "vision_config": config.to_dict()}
    return CLIPModel(CLIPConfig(**towers, projection_dim=config.projection_dim)).eval()


def write_clip(folder, models, shapes):
    torch.manual_seed(SEED)
    golden = {}
    for index, (height, width) in enumerate(shapes):
        golden[f"image.{index}.rgb"] = image(height, width)
    for name, config in models.items():
        model = clip_model(name, config)
        randomize(model)
        own = folder / name
        model.save_pretrained(own)
        names = load_file(own / "model.safetensors").keys()
        assert "vision_model.encoder.layers.0.self_attn.q_proj.weight" in names, sorted(names)
        config_file = own / "config.json"
        config_file.write_text(json.dumps(json.loads(config_file.read_text()), indent=2, sort_keys=True) + "\n")
        side = config.image_size
        processor = CLIPImageProcessorPil(size={"shortest_edge": side}, crop_size={"height": side, "width": side})
        for index in range(len(shapes)):
            shown = Image.fromarray(golden[f"image.{index}.rgb"].numpy())
            pixels = processor(images=shown, return_tensors="pt").pixel_values
            with torch.no_grad():
                vision = model.vision_model(pixel_values=pixels)
                embedding = model.visual_projection(vision.pooler_output)
            golden[f"{name}.image.{index}.pixels"] = pixels[0].clone()
            golden[f"{name}.image.{index}.embedding"] = embedding[0].clone()
    if shapes == IMAGES:
        for index, (height, width) in enumerate(RESIZED):
            shown = Image.fromarray(golden[f"image.{index}.rgb"].numpy())
            resized = shown.resize((width, height), Image.Resampling.BICUBIC)
            golden[f"resized.{index}"] = torch.tensor(list(resized.tobytes()), dtype=torch.uint8).reshape(height, width, 3)
    save_file(golden, folder / "golden.safetensors")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--full", type=Path, metavar="FOLDER", help="write models of full size there instead")
    full = parser.parse_args().full
    torch.use_deterministic_algorithms(True)
    if full:
        write_lpips(full / "lpips", FULL_PAIRS, is_full=True)
        write_clip(full / "clip", {"base": CLIPVisionConfig()}, [(300, 400)])
    else:
        write_lpips(GOLDEN / "lpips", PAIRS, is_full=False)
        write_clip(GOLDEN / "clip", CLIP_VISION, IMAGES)


if __name__ == "__main__":
    main()
