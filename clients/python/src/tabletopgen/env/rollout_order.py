"""Which episodes a rollout has: environments, starts and seeds, in an order that depends on nothing else."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np


@dataclass(frozen=True)
class Episode:
    """One episode: its number from 0, the places of its environment and start, and the seed of what is drawn in it."""

    number: int
    environment: int
    start: int
    seed: int


def episodes(starts: Sequence[int], count: int, seed: int) -> list[Episode]:
    """So many episodes in environments with these numbers of starts. More episodes begin with the same ones."""
    places = islice(passes(starts, np.random.default_rng(seed)), count)
    return [Episode(number, *place, seed_of(seed, number)) for number, place in enumerate(places)]


def passes(starts: Sequence[int], random: np.random.Generator) -> Iterator[tuple[int, int]]:
    """Places of environments and starts without end. A pass has each start once. It takes the environments in turns, so
    that each has about as many of the first episodes."""
    while True:
        waiting = {int(place): random.permutation(starts[place]).tolist() for place in random.permutation(len(starts))}
        while waiting:
            for place in list(waiting):
                yield place, waiting[place].pop()
                if not waiting[place]:
                    del waiting[place]


def seed_of(seed: int, number: int) -> int:
    """The seed of an episode, 32 bits."""
    return int(np.random.SeedSequence([seed, number]).generate_state(1)[0])
