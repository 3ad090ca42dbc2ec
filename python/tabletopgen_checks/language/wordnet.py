"""The nouns of WordNet 3.0, read from its dictionary folder (Debian package `wordnet-base`: /usr/share/wordnet).

Formats: the manual pages wndb(5WN) and cntlist(5WN) of the same package.
"""

import re
from dataclasses import dataclass
from pathlib import Path

HYPERNYM = "@"
INSTANCE = "@i"
NAME = re.compile(r"(.+)\.n\.(\d{2})")


@dataclass(frozen=True)
class Synset:
    """A meaning: its words as they are spelled, the more general meanings, and whether it is a single named one."""

    words: tuple
    hypernyms: tuple
    is_instance: bool
    gloss: str


class Nouns:
    def __init__(self, folder: Path):
        self.synsets = dict(read_data(folder / "data.noun"))
        self.senses = dict(read_index(folder / "index.noun"))
        self.counts = dict(read_counts(folder / "cntlist.rev"))
        self._levels = {}

    def synset(self, name: str) -> int:
        """The offset of `word.n.01`: that word's first sense, words joined by `_`."""
        parts = NAME.fullmatch(name)
        senses = self.senses.get(parts[1], ()) if parts else ()
        if not parts or not 1 <= int(parts[2]) <= len(senses):
            raise ValueError(f"`{name}` is no noun sense of WordNet; write it as word.n.01")
        return senses[int(parts[2]) - 1]

    def count(self, lemma: str, sense: int) -> int:
        """How often the sense (from 1) occurs in the tagged texts of WordNet."""
        return self.counts.get((lemma, sense), 0)

    def levels(self, offset: int) -> tuple:
        """The synset, its hypernyms, theirs and so on: sets by distance; each synset stands in the nearest set."""
        if offset not in self._levels:
            levels, seen = [{offset}], {offset}
            while levels[-1]:
                above = {up for down in levels[-1] for up in self.synsets[down].hypernyms} - seen
                seen |= above
                levels.append(above)
            self._levels[offset] = tuple(levels[:-1])
        return self._levels[offset]


def lines(path: Path):
    """The lines of a file without the license, which is indented."""
    with path.open(encoding="latin-1") as file:
        yield from (line.rstrip("\n") for line in file if not line.startswith("  "))


def read_data(path: Path):
    """Of `offset file type word-count (word id)* pointer-count (symbol offset type places)* | gloss`."""
    for line in lines(path):
        head, _, gloss = line.partition(" | ")
        fields = head.split()
        after = 4 + 2 * int(fields[3], 16)
        words = tuple(fields[4:after:2])
        start = after + 1
        pointers = [(fields[k], int(fields[k + 1])) for k in range(start, start + 4 * int(fields[after]), 4)]
        up = tuple(target for symbol, target in pointers if symbol in (HYPERNYM, INSTANCE))
        yield int(fields[0]), Synset(words, up, any(symbol == INSTANCE for symbol, _ in pointers), gloss)


def read_index(path: Path):
    """Of `lemma type sense-count pointer-count symbol* sense-count tagged-count offset*`, most frequent sense first."""
    for line in lines(path):
        fields = line.split()
        yield fields[0], tuple(int(field) for field in fields[-int(fields[2]) :])


def read_counts(path: Path):
    """Of `lemma%type:file:id:: sense count`; type 1 is the noun."""
    for line in lines(path):
        key, sense, count = line.split()
        lemma, _, rest = key.partition("%")
        if rest.startswith("1:"):
            yield (lemma, int(sense)), int(count)
