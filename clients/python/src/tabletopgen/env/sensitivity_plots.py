"""Plots of success against factors, as SVG."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from tabletopgen._media import imported
from tabletopgen.env.rollout_report import wilson_interval
from tabletopgen.env.sensitivity_splits import Tested
from tabletopgen.env.sensitivity_table import Table

# Points of rates along a number, of about equally many episodes.
BINS = 8
WIDTH_IN, HEIGHT_IN = 5.0, 3.2
# Words that are drawn; a factor with more has those of most episodes.
MAX_WORDS = 12


def plot(one: Tested, table: Table) -> bytes:
    """Rates of success with their 95 % intervals by the values of a factor, each episode as a dot, and the best
    threshold as a line."""
    figures, svg = imported("matplotlib.figure", "matplotlib"), imported("matplotlib.backends.backend_svg", "matplotlib")
    figure = figures.Figure(figsize=(WIDTH_IN, HEIGHT_IN), layout="constrained")
    axes = figure.add_subplot()
    factor, present = one.splits.factor, one.splits.factor.present
    values, success = factor.values[present], ~table.failed[present]
    if factor.is_number:
        order = np.argsort(values, kind="stable")
        parts = [part for part in np.array_split(order, min(BINS, len(np.unique(values)))) if len(part)]
        draw_rates(axes, [float(values[part].mean()) for part in parts], [success[part] for part in parts])
        draw_episodes(axes, values, success)
        axes.axvline(one.splits.at[one.best], color="tab:red", linewidth=1)
    else:
        words, counts = np.unique(values, return_counts=True)
        words = words[np.argsort(-counts, kind="stable")][:MAX_WORDS]
        draw_rates(axes, list(range(len(words))), [success[values == word] for word in words])
        axes.set_xticks(range(len(words)), [str(word)[:24] for word in words], rotation=30, ha="right")
    axes.set(xlabel=factor.name, ylabel="share of successes", ylim=(-0.09, 1.09))
    content = io.BytesIO()
    # Neither a date nor random names of parts: equal plots have equal bytes.
    with imported("matplotlib").rc_context({"svg.hashsalt": "tabletopgen"}):
        svg.FigureCanvasSVG(figure).print_svg(content, metadata={"Date": None})
    return content.getvalue()


def draw_rates(axes: Any, at: Sequence[float], parts: Sequence[Any]) -> None:
    """Shares of successes, with intervals."""
    rates = [float(part.mean()) for part in parts]
    intervals = [wilson_interval(int(part.sum()), len(part)) for part in parts]
    beside = [[rate - low for rate, (low, _) in zip(rates, intervals, strict=True)]]
    beside.append([high - rate for rate, (_, high) in zip(rates, intervals, strict=True)])
    axes.errorbar(at, rates, yerr=np.maximum(beside, 0.0), fmt="o", capsize=3)


def draw_episodes(axes: Any, values: Any, success: Any) -> None:
    """Episodes as dots, successes above and failures below, drawn apart."""
    apart = np.random.default_rng(0).uniform(-0.03, 0.03, len(values))
    axes.plot(values, np.where(success, 1.05, -0.05) + apart, ".", color="0.6", markersize=3)
