"""The network: a small residual encoder and a decoder with skips; maps at half the frame's size.

Only convolutions, additions, ReLU, nearest-neighbor doubling and one mean: the operations that the program has to
implement for inference. Normalizations are folded into the convolutions where the weights are written.

Three levels of the encoder also get what the blocks of `encoder.py` that stay as they are make of the frame: these have
seen photographs. The program has their weights from the recognizer of objects.
"""

import torch
from torch import nn
from torch.nn import functional as F

from encoder import Encoder, on_colors, public_weights

#: Channels of the maps, in order.
MAPS = [("kinds", 4), ("outline", 1), ("border", 1), ("contact", 1), ("center", 1), ("offset", 2), ("base", 2), ("top", 1), ("ground", 1), ("latitude", 1), ("focal", 1)]
WIDTHS = (24, 48, 96, 160, 224)
BLOCKS = (0, 2, 4, 6, 4)
#: Blocks of the pretrained encoder whose outputs the last levels get, which have as many rows.
PRETRAINED_BLOCKS = 6, 14, 17


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
    def __init__(self, widths=WIDTHS, blocks=BLOCKS, known_blocks=PRETRAINED_BLOCKS, pretrained=None):
        """`pretrained` is the encoder that stays as it is; the public one where None."""
        super().__init__()
        self.known_blocks = known_blocks
        # In a list, so that it is no part of what learns and is stored.
        self.pretrained = [pretrained or (Encoder(public_weights()).eval().requires_grad_(False) if known_blocks else None)]
        channels = [self.pretrained[0].blocks[k].project.weight.shape[0] for k in known_blocks]
        self.known = nn.ModuleList(Convolution(i, o, 1) for i, o in zip(channels, widths[len(widths) - len(channels) :]))
        inputs = (3, *widths[:-1])
        self.down = nn.ModuleList(Convolution(i, o, 3, 2) for i, o in zip(inputs, widths))
        self.blocks = nn.ModuleList(nn.Sequential(*(Block(w) for _ in range(n))) for w, n in zip(widths, blocks))
        self.across = nn.ModuleList(Convolution(o, i, 1) for i, o in zip(widths[:-1], widths[1:]))
        self.up = nn.ModuleList(Block(w) for w in widths[:-1])
        self.spread = Convolution(widths[-1], widths[-1], 1)
        self.maps = nn.Conv2d(widths[0], sum(n for _, n in MAPS), 3, 1, 1)

    def features(self, x):
        """What the pretrained encoder adds, by level."""
        if not self.known_blocks:
            return {}
        with torch.no_grad():
            outputs = self.pretrained[0].between(on_colors(0.5 * (x + 1)), self.known_blocks)
        first = len(self.down) - len(self.known)
        return {first + k: known(output) for k, (known, output) in enumerate(zip(self.known, outputs))}

    def forward(self, x):
        """Maps of frames (N, 3, H, W) with values in -1..1; H and W multiples of 32."""
        features = self.features(x)
        skips = []
        for level, (down, blocks) in enumerate(zip(self.down, self.blocks)):
            x = down(x)
            if level in features:
                x = x + features[level]
            x = blocks(F.relu(x, inplace=True))
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
    tensors["known.blocks"] = torch.tensor(model.known_blocks)
    return {name: tensor.detach().float().cpu().contiguous() for name, tensor in tensors.items()}


@torch.no_grad()
def begin(model, tensors, batches):
    """Makes the model compute what folded tensors do, its normalizations counted on batches of frames. Blocks and
    pretrained features that the tensors lack add nothing."""
    known = {name: m for name, m in model.named_modules() if isinstance(m, Convolution) and f"{name}.weight" in tensors}
    for name, module in model.named_modules():
        if isinstance(module, Block) and f"{name}.widen" not in known:
            nn.init.zeros_(module.widen.norm.weight)
    for name, module in model.known.named_children():
        if f"known.{name}" not in known:
            nn.init.zeros_(module.norm.weight)
    for name, module in known.items():
        module.conv.weight.copy_(tensors[f"{name}.weight"])
        module.norm.bias.copy_(tensors[f"{name}.bias"])
        module.norm.running_var.fill_(1 - module.norm.eps)
    model.maps.weight.copy_(tensors["maps.weight"])
    model.maps.bias.copy_(tensors["maps.bias"])

    sums = {module: [0, 0.0, 0.0] for module in model.modules() if isinstance(module, Convolution)}

    def count(module):
        def counted(_, inputs):
            (x,) = inputs
            own = sums[module]
            own[0] += x.numel() // x.shape[1]
            own[1] = own[1] + x.double().sum((0, 2, 3))
            own[2] = own[2] + x.double().square().sum((0, 2, 3))

        return module.norm.register_forward_pre_hook(counted)

    hooks = [count(module) for module in sums]
    model.eval()
    for frames in batches:
        model(frames)
    model.train()
    for hook in hooks:
        hook.remove()
    for module, (n, total, squares) in sums.items():
        mean = total / n
        variance = (squares / n - mean**2).clamp(min=1e-6)
        if module in known.values():
            module.norm.weight.copy_(torch.sqrt(variance + module.norm.eps))
            module.norm.bias.add_(mean)
        module.norm.running_mean.copy_(mean)
        module.norm.running_var.copy_(variance)
