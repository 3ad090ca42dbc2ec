"""Writes config/catalog/stand_ins.tsv: which plain shape stands in for a noun that the catalog lacks.

    PYTHONPATH=python python3 -m tabletopgen_checks.language.stand_ins /usr/share/wordnet

The folder is WordNet's dictionary, of Debian's package `wordnet-base` 1:3.0-37. config/catalog/stand_in_rules.toml maps
meanings of WordNet to shapes, or to the reason why an object cannot stand on a table; a noun follows the rule of the
nearest meaning above its own. The labels of the catalog give the nearest category. Equal inputs give equal bytes.

Of a noun's meanings the most frequent one counts. Among equally frequent ones an object that can stand on a table comes
first, plants last, then WordNet's order. The second in this order counts if it is such an object, the first is none and
not much more frequent.
"""

import argparse
import string
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

from tabletopgen_checks.language.wordnet import Nouns
from tabletopgen_checks.repository import CATALOG

RULES = CATALOG / "stand_in_rules.toml"
RESULT = CATALOG / "stand_ins.tsv"
WIDTH = 120
# Occurrences in the tagged texts that say nothing.
NOISE = 3
# How much more frequent a meaning without a shape may be than the next one, which has a shape and counts.
RIVAL = 8
NO_CATEGORY = "-"
REFUSED = "not:"
# Words of a noun: lower case without digits; the parser splits at other signs.
LETTERS = frozenset(string.ascii_lowercase + "_-'.")

HEADER = """\
# Nouns of WordNet 3.0 with the shape that stands in for them; written by tabletopgen_checks.language.stand_ins, not by hand.
# WordNet 3.0 Copyright 2006 by Princeton University. All rights reserved. License: stand_ins.LICENSE
# Columns: rule of stand_in_rules.toml (or not:REASON), nearest category of the catalog, nouns.
"""


@dataclass(frozen=True)
class Rule:
    """`order` is the place in the file; `reason` is empty for shapes."""

    order: int
    name: str
    reason: str

    @property
    def key(self) -> str:
        return REFUSED + self.reason if self.reason else self.name


@dataclass(frozen=True)
class Meaning:
    """`frequency` is coarse; `is_spelled_so`: in lower case, as the lemma is."""

    synset: int
    rule: Rule
    frequency: int
    is_spelled_so: bool
    is_plant: bool
    is_alive: bool


class Rules:
    def __init__(self, table: dict, nouns: Nouns):
        self.nouns = nouns
        self.of = {}
        shapes = [(shape["name"], "", shape["of"]) for shape in table["shape"]]
        refusals = [(refusal["reason"], refusal["reason"], refusal["of"]) for refusal in table["refusal"]]
        for order, (name, reason, meanings) in enumerate(shapes + refusals):
            for meaning in meanings:
                known = self.of.setdefault(nouns.synset(meaning), Rule(order, name, reason))
                if known.order != order:
                    raise ValueError(f"`{meaning}` of `{name}` is also a meaning of `{known.name}`; keep one of them")
        self.chosen = {lemma: nouns.synset(meaning) for lemma, meaning in table["meanings"].items()}
        names = ("ignored", "plants", "living", "too_general")
        sets = [{nouns.synset(meaning) for meaning in table[name]["of"]} for name in names]
        self.ignored, self.plants, self.living, self.general = sets
        self.left_out = set(table["left_out"]["nouns"])

    def rule(self, synset: int):
        """The rule of the nearest meaning at or above a synset; the first in the file of equally near ones."""
        for level in self.nouns.levels(synset):
            if found := [self.of[meaning] for meaning in level if meaning in self.of]:
                return min(found, key=lambda rule: rule.order)
        return None

    def meaning(self, lemma: str):
        """What a noun stands for, or None if it is only a proper name."""
        if lemma in self.chosen:
            synset = self.chosen[lemma]
            rule = self.rule(synset)
            assert rule is not None, f"the chosen meaning of {lemma} has no rule"
            return Meaning(synset, rule, 0, True, False, False)
        meanings = list(self.meanings(lemma))
        # "Frisbee" is no name of one object; a word that is also spelled in lower case is not meant as a name.
        meanings = [meaning for meaning in meanings if meaning.is_spelled_so] or meanings
        ranked = sorted(meanings, key=lambda meaning: (-meaning.frequency, bool(meaning.rule.reason), meaning.is_plant))
        if not ranked:
            return None
        first, second = ranked[0], ranked[min(1, len(ranked) - 1)]
        is_rival = 0 < first.frequency <= RIVAL * second.frequency
        return second if first.rule.reason and is_rival and not second.rule.reason else first

    def meanings(self, lemma: str):
        for sense, synset in enumerate(self.nouns.senses[lemma], start=1):
            found = self.nouns.synsets[synset]
            above = set().union(*self.nouns.levels(synset))
            rule = self.rule(synset)
            if rule and not found.is_instance and above.isdisjoint(self.ignored):
                yield Meaning(
                    synset,
                    rule,
                    self.nouns.count(lemma, sense) // NOISE,
                    lemma in found.words,
                    not above.isdisjoint(self.plants),
                    not above.isdisjoint(self.living),
                )


class Categories:
    """The catalog's categories as meanings of WordNet."""

    def __init__(self, files: list, rules: Rules, chosen: dict):
        self.rules = rules
        # Name to the steps up from the category to each meaning that is specific enough to compare by.
        self.steps = {}
        for category in (category for file in files for category in file.get("category", [])):
            name = category["name"]
            found = (rules.nouns.synset(chosen[name]), 0) if name in chosen else self.named(category["label"])
            if found:
                self.steps[name] = self.upward(*found)

    def named(self, label: str):
        """The object that the label stands for. Its last words alone mean something more general: one step up."""
        words = label.lower().split()
        for start in range(len(words)):
            lemma = "_".join(words[start:])
            meaning = self.rules.meaning(lemma) if lemma in self.rules.nouns.senses else None
            if meaning and not meaning.rule.reason:
                return meaning.synset, int(start > 0)
        return None

    def upward(self, synset: int, before: int = 0) -> dict:
        levels = self.rules.nouns.levels(synset)
        return {up: before + k for k, level in enumerate(levels) for up in level if up not in self.rules.general}

    def nearest(self, synset: int) -> str:
        """The category with the fewest steps over a common meaning; the first of the catalog among equal ones."""
        steps = self.upward(synset)
        best = (sys.maxsize, NO_CATEGORY)
        for name, above in self.steps.items():
            shared = [steps[up] + above[up] for up in steps if up in above]
            if shared and min(shared) < best[0]:
                best = (min(shared), name)
        return best[1]


def noun_of(lemma: str) -> str:
    return lemma.replace("_", " ").replace("-", " ").replace(".", "")


def is_listed(lemma: str, meaning: Meaning, rules: Rules) -> bool:
    """Whether a noun is worth its bytes: Latin names are not, nor breeds and species that their last word describes as
    well, nor rare words for no object."""
    nouns, reason = rules.nouns, meaning.rule.reason
    if meaning.is_alive and not meaning.is_spelled_so:
        return False
    head = lemma.rpartition("_")[2]
    if meaning.is_alive and head != lemma and head in nouns.senses:
        of_head = rules.meaning(head)
        if of_head and of_head.rule == meaning.rule and not reason:
            return False
    if reason in ("abstract", "substance"):
        is_frequent = any(nouns.count(lemma, sense) for sense in range(1, len(nouns.senses[lemma]) + 1))
        return "_" not in lemma and (is_frequent or reason == "substance")
    return not reason or "_" not in lemma or reason == "too_large"


def table(rules: Rules, categories: Categories) -> dict:
    """(rule, nearest category) to nouns."""
    rows, found = {}, {}
    for lemma in sorted(rules.nouns.senses.keys() | rules.chosen.keys()):
        if not LETTERS.issuperset(lemma) or len(lemma) < 2 or lemma in rules.left_out:
            continue
        meaning = rules.meaning(lemma)
        if meaning and is_listed(lemma, meaning, rules):
            # The spelling without hyphen comes last in the index and its meaning wins.
            found[noun_of(lemma)] = meaning
    for noun, meaning in sorted(found.items()):
        nearest = NO_CATEGORY if meaning.rule.reason else categories.nearest(meaning.synset)
        rows.setdefault((meaning.rule.order, meaning.rule.key, nearest), []).append(noun)
    return rows


def written(rows: dict) -> str:
    """One row or more for each rule and category, each at most WIDTH wide."""
    lines = []
    for (_, rule, nearest), nouns in sorted(rows.items()):
        start = f"{rule}\t{nearest}\t"
        line = start
        for noun in nouns:
            if line != start and len(line) + 1 + len(noun) > WIDTH:
                lines.append(line)
                line = start
            line += noun if line == start else ";" + noun
        lines.append(line)
    return HEADER + "".join(line + "\n" for line in lines)


def catalog_files() -> list:
    files = sorted(CATALOG.rglob("*.toml"))
    return [tomllib.loads(file.read_text(encoding="utf-8")) for file in files if not file.name.startswith("stand_in")]


def main() -> int:
    parser = argparse.ArgumentParser(description="Write the stand-ins of nouns.")
    parser.add_argument("wordnet", type=Path, help="folder of data.noun, index.noun and cntlist.rev")
    folder = parser.parse_args().wordnet
    try:
        nouns = Nouns(folder)
    except FileNotFoundError as error:
        print(f"{error.filename} is missing; name the folder of Debian's package wordnet-base", file=sys.stderr)
        return 1
    read = tomllib.loads(RULES.read_text(encoding="utf-8"))
    rules = Rules(read, nouns)
    rows = table(rules, Categories(catalog_files(), rules, read["categories"]))
    RESULT.write_text(written(rows), encoding="utf-8")
    placed = sum(len(names) for (_, rule, _), names in rows.items() if not rule.startswith(REFUSED))
    refused = sum(map(len, rows.values())) - placed
    print(f"{placed} nouns with a shape and {refused} without, {RESULT.stat().st_size} bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
