"""Coefficients of crates/method/vision/src/instance_segmentation/region_score.rs, fitted to synthetic images.

    tabletopgen-lab evaluate --set regions --split validation --scenes 600 --out out/training
    python training/region_score.py out/training/regions.json --but 80

prints the table of region_score.rs. Logistic regression on each measure and its square. Images before --but are those
on which thresholds are chosen: they are not fitted but judged.
"""

import argparse
import json
from pathlib import Path

import torch
from torch.nn import functional as F

#: An overlap above which a region is an object.
FOUND = 0.5
#: Measures farther out count as if they were this many spreads off.
FARTHEST = 4.0
#: What a squared weight costs.
DECAY = 1e-4
STEPS = 200


def regions_of(images):
    """Measures (N, M) and whether each region is an object (N)."""
    regions = [region for image in images for region in image["regions"]]
    measures = torch.tensor([region["measures"] for region in regions], dtype=torch.float64)
    return measures, torch.tensor([region["overlap"] > FOUND for region in regions], dtype=torch.float64)


def terms(measures, mean, spread):
    off = ((measures - mean) / spread).clamp(-FARTHEST, FARTHEST)
    return torch.cat([off, off**2], 1)


def fitted(measures, is_object):
    """Means, spreads, weights of measures and of their squares, and the odds at the means."""
    mean, spread = measures.mean(0), measures.std(0).clamp(min=1e-6)
    seen = terms(measures, mean, spread)
    weights = torch.zeros(seen.shape[1] + 1, dtype=seen.dtype, requires_grad=True)
    optimizer = torch.optim.LBFGS([weights], max_iter=STEPS, line_search_fn="strong_wolfe")

    def loss():
        optimizer.zero_grad()
        value = F.binary_cross_entropy_with_logits(seen @ weights[1:] + weights[0], is_object) + DECAY * weights[1:].square().sum()
        value.backward()
        return value

    optimizer.step(loss)
    first, second = weights.detach()[1:].chunk(2)
    return mean, spread, first, second, weights.detach()[0]


def log_odds(measures, fit):
    mean, spread, first, second, at_the_means = fit
    return terms(measures, mean, spread) @ torch.cat([first, second]) + at_the_means


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("regions", type=Path)
    parser.add_argument("--but", type=int, default=80, help="first image that is fitted")
    arguments = parser.parse_args()
    document = json.loads(arguments.regions.read_text())
    fit = fitted(*regions_of([p for p in document["images"] if p["number"] >= arguments.but]))
    mean, spread, first, second, at_the_means = fit
    print(f"const INTERCEPT: f64 = {at_the_means:.4f};")
    print("const TERMS: [Term; RegionFeatures::COUNT] = [")
    for row in zip(mean.tolist(), spread.tolist(), first.tolist(), second.tolist()):
        print("    term(" + ", ".join(f"{value:.4f}" for value in row) + "),")
    print("];")
    for name, chosen in (("fitted", lambda n: n >= arguments.but), ("judged", lambda n: n < arguments.but)):
        images = [p for p in document["images"] if chosen(p["number"])]
        if images:
            measures, is_object = regions_of(images)
            loss = F.binary_cross_entropy_with_logits(log_odds(measures, fit), is_object)
            print(f"// {name}: {len(images)} images, {len(is_object)} regions, {is_object.mean():.3f} objects, loss {loss:.4f}")


if __name__ == "__main__":
    main()
