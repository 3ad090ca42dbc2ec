"""The search for changes of a scene that make a policy fail: explore, and then shrink what fails.

Exploring takes turns between a space-filling design of all axes at once (Sobol, "Distribution of points in a cube and
approximate evaluation of integrals", 1967) and the ends of each axis alone. What fails is shrunk: changes that are not
needed are taken back, first by halves and then one by one, and each change that is left is bisected toward the base
scene. A found failure explains changes that go as far or farther in the same directions; where a planned change has
one of these, it is taken back before the scene is made, so that the budget finds other failures.

All choices follow from the seed and from the outcomes, so that a search that was stopped takes the same way again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import zip_longest

import numpy as np

from tabletopgen._media import imported
from tabletopgen.env.counterexample_axes import WORDS, Axis, Change, change_of

# Scenes of the design: two to this power.
DESIGN_POWER = 10
# The share of the range of each axis that the design leaves as it is: half of all axes change at once.
LEFT = 0.5
# Bisections of each change: a failure is known to this power of a half of it.
BISECTIONS = 5


class BudgetSpentError(Exception):
    """Raised where a scene is wanted, and all of the budget are made."""


class Search:
    """A search. `fails` makes the scene of a change, and says whether the policy fails in it although the task can be
    done there. It raises `BudgetSpentError` in the end."""

    def __init__(self, axes: Sequence[Axis], fails: Callable[[Change], bool], seed: int):
        self.axes, self._fails, self.seed = {axis.name: axis for axis in axes}, fails, seed
        self.found: list[Change] = []
        self._known: dict[tuple[tuple[str, float | str], ...], bool] = {}
        # Before the first scene: a missing package costs no scene, and no interrupt of a search meets this import and
        # the reading of SciPy's tables, out of which Python ends by the signal, or loses the interrupt.
        sobol = imported("scipy.stats.qmc", "scipy").Sobol(len(self.axes), rng=np.random.default_rng(seed))
        self._points = sobol.random_base2(DESIGN_POWER)

    def run(self) -> None:
        """Searches until the budget is spent, or nothing is left of the design. Without changes, the policy must
        succeed."""
        try:
            if self.fails({}):
                self.found.append({})
                return
            for planned in self.planned():
                change = self.unexplained(planned)
                if change and key_of(change) not in self._known and self.fails(change):
                    self.found.append(self.shrunk(change))
        except BudgetSpentError:
            return

    def fails(self, change: Change) -> bool:
        """Whether the policy fails, asked once for each change."""
        key = key_of(change)
        if key not in self._known:
            self._known[key] = self._fails(change)
        return self._known[key]

    def planned(self) -> Iterator[Change]:
        """Changes to explore: in turns of the design, and of one axis alone at its ends, in an order by chance."""
        random = np.random.default_rng(self.seed)
        alone: list[Change] = [{name: end} for name, axis in self.axes.items() for end in axis.ends]
        ends = [alone[place] for place in random.permutation(len(alone))]
        for pair in zip_longest(self.design(), ends):
            yield from (change for change in pair if change is not None)

    def design(self) -> Iterator[Change]:
        """Changes of all axes that fill their ranges evenly."""
        for point in self._points:
            yield change_of({name: level_of(axis, float(share)) for (name, axis), share in zip(self.axes.items(), point, strict=True)})

    def unexplained(self, change: Change) -> Change:
        """A change without those parts that failures already explain."""
        left = dict(change)
        for found in self.found:
            if all(reaches(left.get(name), level) for name, level in found.items()):
                # The part that the failure needs most of is taken back.
                del left[max(found, key=lambda name: size_of(found[name]))]
        return left

    def shrunk(self, change: Change) -> Change:
        """The smallest part of a failing change that fails."""
        change = self.needed(change)
        for name, level in change.items():
            if isinstance(level, float):
                change = self.bisected(change, name, level)
        return change

    def needed(self, change: Change) -> Change:
        """Without changes that the failure does not need."""
        names = sorted(change, key=lambda name: -size_of(change[name]))
        while len(names) > 1:
            halves = (names[: len(names) // 2], names[len(names) // 2 :])
            half = next((half for half in halves if self.fails(part(change, half))), None)
            if half is None:
                break
            names = half
        for name in list(names) if len(names) > 1 else []:
            rest = [other for other in names if other != name]
            if rest and self.fails(part(change, rest)):
                names = rest
        return part(change, names)

    def bisected(self, change: Change, name: str, level: float) -> Change:
        """With the smallest level of one axis that fails."""
        holds, fails = 0.0, level
        for _ in range(BISECTIONS):
            between = self.axes[name].rounded((holds + fails) / 2)
            if not isinstance(between, float) or between in (holds, fails):
                break
            if self.fails({**change, name: between}):
                fails = between
            else:
                holds = between
        return {**change, name: fails}


def level_of(axis: Axis, share: float) -> float | str:
    """The level of an axis for a number from 0 to 1; a part of them changes nothing."""
    if axis.kind == WORDS:
        place = int((share - LEFT) / (1 - LEFT) * len(axis.words))
        return axis.words[place] if share >= LEFT else 0.0
    signed = share if len(axis.ends) == 1 else 2 * share - 1
    return float(np.sign(signed)) * max(0.0, abs(signed) - LEFT) / (1 - LEFT)


def key_of(change: Change) -> tuple[tuple[str, float | str], ...]:
    return tuple(sorted(change.items()))


def part(change: Change, names: Sequence[str]) -> Change:
    """Some parts of a change, in its order."""
    return {name: level for name, level in change.items() if name in names}


def reaches(level: float | str | None, other: float | str) -> bool:
    """Whether a level goes as far as another or farther in the same direction, or is the same word."""
    if isinstance(level, float) and isinstance(other, float):
        return level * other > 0 and abs(level) >= abs(other)
    return level == other


def size_of(level: float | str) -> float:
    return abs(level) if isinstance(level, float) else 1.0
