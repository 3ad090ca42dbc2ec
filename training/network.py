"""The network: a small residual encoder and a decoder with skips; maps at half the frame's size.

Only convolutions, additions, ReLU, nearest-neighbor doubling and one mean: what the program that reads pictures has to
repeat. Normalizations are folded into the convolutions where the weights are written.
"""

import torch
from torch import nn
from torch.nn import functional as F

#: Channels of the maps, in order.
MAPS = [("kinds", 4), ("outline", 1), ("border", 1), ("contact", 1), ("center", 1), ("offset", 2), ("base", 2), ("top", 1), ("ground", 1), ("latitude", 1), ("focal", 1)]
WIDTHS = (24, 48, 96, 160, 224)
BLOCKS = (0, 2, 2, 3, 2)


class Convolution(nn.Module):
    """3 x 3 or 1 x 1, normalized."""

    def __init__(self, inputs, outputs, size=3, stride=1):
        super().__init__()
        self.conv = nn.Conv2d(inputs, outputs, size, stride, size // 2, bias=False)
        self.norm = nn.BatchNorm2d(outputs)

    def forward(self, x):
        return self.norm(self.conv(x))


class Block(nn.Module):
    """x + two convolutions, the first narrowing by half."""

    def __init__(self, width):
        super().__init__()
        self.narrow = Convolution(width, width // 2)
        self.widen = Convolution(width // 2, width)

    def forward(self, x):
        return F.relu(x + self.widen(F.relu(self.narrow(x), inplace=True)), inplace=True)


class TableNetwork(nn.Module):
    def __init__(self, widths=WIDTHS, blocks=BLOCKS):
        super().__init__()
        inputs = (3, *widths[:-1])
        self.down = nn.ModuleList(Convolution(i, o, 3, 2) for i, o in zip(inputs, widths))
        self.blocks = nn.ModuleList(nn.Sequential(*(Block(w) for _ in range(n))) for w, n in zip(widths, blocks))
        self.across = nn.ModuleList(Convolution(o, i, 1) for i, o in zip(widths[:-1], widths[1:]))
        self.up = nn.ModuleList(Block(w) for w in widths[:-1])
        self.spread = Convolution(widths[-1], widths[-1], 1)
        self.maps = nn.Conv2d(widths[0], sum(n for _, n in MAPS), 3, 1, 1)

    def forward(self, x):
        """Maps of frames (N, 3, H, W) with values in -1..1; H and W multiples of 32."""
        skips = []
        for down, blocks in zip(self.down, self.blocks):
            x = blocks(F.relu(down(x), inplace=True))
            skips.append(x)
        # What the whole frame shows reaches every place.
        x = F.relu(x + self.spread(x.mean((2, 3), keepdim=True)), inplace=True)
        for across, up, skip in zip(reversed(self.across), reversed(self.up), reversed(skips[:-1])):
            x = F.interpolate(across(x), scale_factor=2.0, mode="nearest")
            x = up(F.relu(x + skip, inplace=True))
        return self.maps(x)


def split(maps):
    """The maps by name."""
    return dict(zip([name for name, _ in MAPS], torch.split(maps, [n for _, n in MAPS], 1)))


def folded(model):
    """Tensors of the model with every normalization folded into its convolution: <name>.weight, <name>.bias."""
    tensors, inside = {}, set()
    for name, module in model.named_modules():
        if isinstance(module, Convolution):
            norm = module.norm
            scale = norm.weight / torch.sqrt(norm.running_var + norm.eps)
            tensors[f"{name}.weight"] = module.conv.weight * scale[:, None, None, None]
            tensors[f"{name}.bias"] = norm.bias - norm.running_mean * scale
            inside.add(name + ".")
    for name, tensor in model.state_dict().items():
        if not any(name.startswith(prefix) for prefix in inside):
            tensors[name] = tensor
    return {name: tensor.detach().float().contiguous() for name, tensor in tensors.items()}
