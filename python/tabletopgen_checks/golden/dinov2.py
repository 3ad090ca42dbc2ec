"""Makes tests/golden/dinov2/: two small DINOv2 models with random weights, and what the reference says of them.

    python3.11 -m venv golden && golden/bin/pip install torch transformers safetensors
    PYTHONPATH=python golden/bin/python -m tabletopgen_checks.golden.dinov2

Run by hand, when the form of the golden files changes; no test needs it. The reference is `Dinov2Model` of
`transformers`, in evaluation mode, in float32 on the CPU. Nothing is left at its initial value, layer scales and
position embeddings least of all: a model of zeros and ones agrees with many wrong ones.

    mlp/ swiglu/      config.json, model.safetensors as published weights are laid out
    golden.safetensors
        <model>.<rows>x<columns>.input        bytes b of the input tensor b / 64 - 2, channels first
        <model>.<rows>x<columns>.class_token  the class token after the final layer norm
        <model>.<rows>x<columns>.positions    position embeddings of the patches, interpolated
        picture.<n>.rgba  picture.<n>.pixels  an image; the same cropped, squared, resized and normalized
"""

import json

import torch
from safetensors.torch import load_file, save_file
from transformers import Dinov2Config, Dinov2Model

from tabletopgen_checks.repository import ROOT

SEED = 20260101
GOLDEN = ROOT / "tests" / "golden" / "dinov2"

MODELS = {
    "mlp": Dinov2Config(hidden_size=24, num_hidden_layers=3, num_attention_heads=4, image_size=70, patch_size=14),
    "swiglu": Dinov2Config(
        hidden_size=16,
        num_hidden_layers=2,
        num_attention_heads=2,
        mlp_ratio=2,
        image_size=56,
        patch_size=14,
        qkv_bias=False,
        use_swiglu_ffn=True,
    ),
}
# The first is the native size; the others are smaller, and of another shape and partly larger.
INPUTS = {"mlp": [(70, 70), (56, 56), (42, 98)], "swiglu": [(56, 56), (84, 42)]}
# Height, width, transparent border: one is reduced, one enlarged.
IMAGES = [(37, 52, 3), (11, 9, 0)]
IMAGE_SIDE_PX = 28
MEAN = torch.tensor([0.485, 0.456, 0.406]).reshape(3, 1, 1)
DEVIATION = torch.tensor([0.229, 0.224, 0.225]).reshape(3, 1, 1)


def randomize(model):
    for name, parameter in model.named_parameters():
        noise = torch.randn_like(parameter)
        if "layer_scale" in name:
            values = 0.2 + 1.2 * torch.rand_like(parameter)
        elif "norm" in name and name.endswith("weight"):
            values = 1.0 + 0.3 * noise
        elif name.endswith("bias"):
            values = 0.2 * noise
        elif "embeddings" in name and "projection" not in name:
            values = 0.6 * noise
        else:
            values = noise * 1.3 / parameter[0].numel() ** 0.5
        parameter.data.copy_(values)


def squared(rgba):
    """Channels first, 0..255: the opaque part on the mean color, centered in a square."""
    height, width, _ = rgba.shape
    color, alpha = rgba[..., :3].permute(2, 0, 1).float(), rgba[..., 3].float() / 255
    opaque = (rgba[..., 3] >= 128).nonzero()
    (top, left), (bottom, right) = opaque.min(0).values.tolist(), (opaque.max(0).values + 1).tolist()
    flat = (alpha * color + (1 - alpha) * 255 * MEAN)[:, top:bottom, left:right]
    height, width = flat.shape[1:]
    side = max(height, width)
    canvas = (255 * MEAN).expand(3, side, side).clone()
    y, x = (side - height) // 2, (side - width) // 2
    canvas[:, y : y + height, x : x + width] = flat
    return canvas


def main():
    torch.manual_seed(SEED)
    torch.use_deterministic_algorithms(True)
    golden = {}
    for model_name, config in MODELS.items():
        config._attn_implementation = "eager"
        model = Dinov2Model(config).eval()
        randomize(model)
        folder = GOLDEN / model_name
        model.save_pretrained(folder)
        for height, width in INPUTS[model_name]:
            data = torch.randint(0, 256, (3, height, width), dtype=torch.uint8)
            with torch.no_grad():
                tokens = model(data[None].float() / 64 - 2).last_hidden_state[0]
                patches = (height // 14) * (width // 14)
                embeddings = torch.zeros(1, 1 + patches, config.hidden_size)
                positions = model.embeddings.interpolate_pos_encoding(embeddings, height, width)[0, 1:]
            key = f"{model_name}.{height}x{width}"
            golden[f"{key}.input"] = data
            golden[f"{key}.class_token"] = tokens[0].clone()
            golden[f"{key}.positions"] = positions.clone()
        names = sorted(load_file(folder / "model.safetensors"))
        assert "encoder.layer.0.attention.attention.query.weight" in names, names
        assert ("encoder.layer.0.mlp.weights_in.weight" in names) == config.use_swiglu_ffn, names
        config_file = folder / "config.json"
        config_file.write_text(json.dumps(json.loads(config_file.read_text()), indent=2, sort_keys=True) + "\n")
    for index, (height, width, border) in enumerate(IMAGES):
        rgba = torch.randint(0, 256, (height, width, 4), dtype=torch.uint8)
        alpha = torch.tensor([0, 200, 255, 255], dtype=torch.uint8)[torch.randint(0, 4, (height, width))]
        if border:
            alpha[:, :border] = 0
            alpha[-border:, :] = 90
        rgba[..., 3] = alpha
        resized = torch.nn.functional.interpolate(
            squared(rgba)[None], size=(IMAGE_SIDE_PX,) * 2, mode="bicubic", align_corners=False, antialias=True
        )[0]
        golden[f"picture.{index}.rgba"] = rgba
        golden[f"picture.{index}.pixels"] = (resized.clamp(0, 255) / 255 - MEAN) / DEVIATION
    save_file(golden, GOLDEN / "golden.safetensors")


if __name__ == "__main__":
    main()
