"""Splits of episodes by one factor, and whether failures differ across them more than by chance.

A split divides episodes into two sides: numbers up to a threshold and above, or one word and all others. Its gain is
the difference of deviances (twice the log likelihood) between one rate of failure and one on each side. A factor's gain
is that of its best split.

Chance is what remains when outcomes are shuffled between starts, all episodes of a start together: those of one start
are not independent. Probabilities are corrected for the number of factors by the greatest of all factors in each
shuffle (Westfall and Young, "Resampling-based multiple testing", 1993), where the gain of each factor counts beyond
the one that it has by chance in one of twenty shuffles. They are corrected for the number of splits in the same way,
since each shuffle chooses its best split, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tabletopgen.env.sensitivity_table import Factor, Table

# Episodes on the smaller side of a split.
MIN_SIDE, MIN_SHARE = 5, 0.05
# Thresholds of a factor, of about equally many episodes between them.
MAX_THRESHOLDS = 400
SHUFFLES = 999
# Half the central 95 % of a deviance with one degree of freedom: thresholds within it of the best are about as good.
ABOUT_AS_GOOD = 3.841
# The share of shuffles whose gains make factors with many splits comparable with those that have few.
CHANCE = 0.05
# Gains that differ by less are equal.
SAME = 1e-9

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True)
class Splits:
    """The splits of a factor: which episodes are on the second side of each, (splits, episodes), and what divides. For
    numbers that is the number halfway between both sides; for words the word of the second side."""

    factor: Factor
    second: Bools
    at: Sequence[Any]
    between: Sequence[tuple[float, float]]


def splits_of(factor: Factor) -> Splits:
    """All splits of a factor with enough episodes on both sides. Episodes without a value are on neither."""
    present = factor.present
    values = factor.values[present]
    enough = max(MIN_SIDE, int(np.ceil(MIN_SHARE * len(values))))
    distinct, counts = np.unique(values, return_counts=True)
    if factor.is_number:
        below = np.cumsum(counts)[:-1]
        fits = np.flatnonzero((below >= enough) & (len(values) - below >= enough))
        if len(fits) > MAX_THRESHOLDS:
            fits = np.unique(fits[np.linspace(0, len(fits) - 1, MAX_THRESHOLDS).round().astype(int)])
        between = [(float(distinct[place]), float(distinct[place + 1])) for place in fits]
        at: list[Any] = [(low + high) / 2 for low, high in between]
        second = np.array([present & (factor.values > threshold) for threshold in at], dtype=bool)
    else:
        at = [str(value) for value, count in zip(distinct, counts, strict=True) if min(count, len(values) - count) >= enough]
        between = []
        second = np.array([factor.values == value for value in at], dtype=bool)
    return Splits(factor, second.reshape(len(at), len(factor.values)), at, between)


def gains(splits: Splits, failed: Floats) -> Floats:
    """The gain of each split for each of several outcomes, (splits, outcomes); `failed` is (episodes, outcomes)."""
    present = splits.factor.present.astype(np.float64)
    all_of, failed_of = present.sum(), present @ failed
    second_of = splits.second.sum(axis=1, dtype=np.float64)[:, None]
    second_failed = splits.second.astype(np.float64) @ failed
    first_of, first_failed = all_of - second_of, failed_of - second_failed
    whole: Floats = log_likelihood(failed_of, all_of)
    found: Floats = 2 * (log_likelihood(first_failed, first_of) + log_likelihood(second_failed, second_of) - whole)
    return np.maximum(found, 0.0)


def log_likelihood(failed: Any, of: Any) -> Any:
    """Of so many failures at the rate that they have."""
    share = np.clip(failed / np.maximum(of, 1.0), 0.0, 1.0)
    return failed * np.log(np.maximum(share, 1e-300)) + (of - failed) * np.log(np.maximum(1 - share, 1e-300))


def shuffled(failed: Bools, starts: NDArray[np.int64], strata: NDArray[Any], count: int, seed: int) -> Floats:
    """Outcomes as they are, and so many times shuffled between starts, (episodes, 1 + count). Only starts with equally
    many episodes, in equal strata, exchange theirs."""
    random = np.random.default_rng(seed)
    found = np.repeat(failed.astype(np.float64)[:, None], 1 + count, axis=1)
    classes: dict[Any, list[NDArray[np.int64]]] = {}
    for start in np.unique(starts):
        rows = np.flatnonzero(starts == start)
        classes.setdefault((len(rows), *strata[rows].tolist()), []).append(rows)
    for alike in classes.values():
        places = np.array(alike)
        own = failed[places].astype(np.float64)
        for number in range(1, 1 + count):
            found[places, number] = own[random.permutation(len(own))]
    return found


@dataclass(frozen=True)
class Tested:
    """A factor with its best split. `probability` is that of such a gain by chance, for this factor alone;
    `corrected` that of one among all factors. `explained` is the gain as a share of the whole deviance."""

    splits: Splits
    best: int
    gain: float
    explained: float
    probability: float
    corrected: float

    @property
    def name(self) -> str:
        return self.splits.factor.name

    def about_as_good(self, table: Table) -> tuple[float, float]:
        """Lowest and highest threshold whose gain is within 3.84 of the best."""
        own = gains(self.splits, table.failed.astype(np.float64)[:, None])[:, 0]
        near = np.flatnonzero(own >= own[self.best] - ABOUT_AS_GOOD)
        return self.splits.between[int(near[0])][0], self.splits.between[int(near[-1])][1]


def ranked(table: Table, seed: int = 0) -> list[Tested]:
    """All factors that can be split, the one first that explains most."""
    found = [splits for factor in table.factors if len((splits := splits_of(factor)).at)]
    if not found or not 0 < table.failed.sum() < len(table.failed):
        return []
    outcomes = shuffled(table.failed, table.starts, np.zeros(len(table.failed)), SHUFFLES, seed)
    by_split = [gains(splits, outcomes) for splits in found]
    best = np.array([own.max(axis=0) for own in by_split])
    beyond = best - np.quantile(best, 1 - CHANCE, axis=1, keepdims=True)
    greatest = beyond.max(axis=0)
    whole = -2 * float(log_likelihood(float(table.failed.sum()), len(table.failed)))
    rows = [
        Tested(
            splits=splits,
            best=int(own[:, 0].argmax()),
            gain=float(own[:, 0].max()),
            explained=float(own[:, 0].max()) / whole,
            probability=float((best[place] >= best[place, 0] - SAME).mean()),
            corrected=float((greatest >= beyond[place, 0] - SAME).mean()),
        )
        for place, (splits, own) in enumerate(zip(found, by_split, strict=True))
    ]
    return sorted(rows, key=lambda one: (-one.gain, one.name))


def probability_beside(one: Tested, other: Tested, table: Table, seed: int = 0) -> float:
    """The probability of a factor's gain by chance where outcomes are shuffled only among episodes on the same side of
    another's best split: high if the other leaves nothing to explain."""
    sides = np.where(other.splits.factor.present, other.splits.second[other.best].astype(int), 2)
    outcomes = shuffled(table.failed, table.starts, sides, SHUFFLES, seed)
    best = gains(one.splits, outcomes).max(axis=0)
    return float((best >= best[0] - SAME).mean())
