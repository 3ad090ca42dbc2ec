"""A hundred sentences with fixed seeds, and what each asks for: how many of what, on which table, and where.

Four families in turn; a third are crowded (16 to 25 objects) or stacked, a fifth ask for a round, a triangular or an
irregular table. A sentence names every object in words of the catalog, so that nothing is left for a theme to fill in.
"""

import random

from tabletopgen_checks.catalog import nouns
from tabletopgen_checks.language.families import FAMILIES, Clauses, article
from tabletopgen_checks.language.sentences import Sentence

COUNT = 100
FIRST_SEED = 50_000

NUMBERS = ["no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten"]
# The words for a table of a shape, and the shape that scene.json must tell.
SHAPES = [("round", "round"), ("triangular", "triangular"), ("hexagonal", "irregular"), ("kidney-shaped", "irregular")]
BESIDE = {
    "left_of": "to the left of",
    "right_of": "to the right of",
    "in_front_of": "in front of",
    "behind": "behind",
    "next_to": "next to",
}


def certified_sentences(count: int = COUNT) -> list:
    """The first `count` of them; the whole set is the same whatever is asked for."""
    words = nouns()
    return [sentence(k, words) for k in range(count)]


def sentence(k: int, words: dict) -> Sentence:
    chance = random.Random(f"wish {k}")
    name = list(FAMILIES)[k % len(FAMILIES)]
    family = FAMILIES[name]
    crowded, stacked = k % 6 == 0, k % 6 == 3
    lowest, highest = (16, 25) if crowded else (5, 15)
    table, shape = chance.choice(family.tables), None
    if k % 5 == 0:
        word, shape = SHAPES[k // 5 % len(SHAPES)]
        table = family.shaped.format(word)
    made = ListedClauses(family, words, chance)
    if stacked:
        for category in chance.sample(sorted(family.piles), 2):
            made.pile(category, chance.randint(2, family.piles[category]))
        host, category, max_count = chance.choice(family.inside)
        made.host(host, category, max_count, "in")
    else:
        kinds = chance.sample(["in", "on", "beside", "pile"], 3 if crowded else 2)
        for kind in kinds:
            if kind == "pile":
                category = chance.choice(sorted(family.piles))
                made.pile(category, chance.randint(2, family.piles[category]))
            elif kind == "beside":
                made.beside(*chance.choice(family.beside))
            else:
                host, category, max_count = chance.choice(family.inside if kind == "in" else family.upon)
                made.host(host, category, max_count, kind)
    wanted = chance.randint(max(lowest, made.objects + 1), highest)
    categories = sorted(family.objects)
    chance.shuffle(categories)
    for category in categories:
        left = wanted - made.objects
        if left > 0:
            made.several(category, min(left, chance.randint(1, family.objects[category])))
    chance.shuffle(made.clauses)
    listed = ", ".join(made.clauses[:-1]) + " and " + made.clauses[-1]
    made.expectation["table"] = {"shape": shape} if shape else {}
    return Sentence(f"{name}_{k:02}", FIRST_SEED + k, f"{table} with {listed}", made.expectation)


class ListedClauses(Clauses):
    def several(self, category, number):
        if self.is_fresh(category):
            self.expect(category, number)
            self.clauses.append(self.noun(category, number))

    def pile(self, category, number):
        if self.is_fresh(category):
            self.expect(category, number)
            self.arrange("stack", category, number)
            self.clauses.append(f"a stack of {NUMBERS[number]} {self.words[category][1]}")

    def host(self, host, category, max_count, where):
        if self.is_fresh(host, category):
            number = self.chance.randint(1, max_count)
            self.expect(host, 1)
            self.expect(category, number)
            self.relate(where, category, host)
            self.clauses.append(f"{self.noun(host, 1)} with {self.noun(category, number)} {where} it")

    def beside(self, category, place, host):
        if self.is_fresh(category, host):
            self.expect(category, 1)
            self.expect(host, 1)
            self.relate(place, category, host)
            self.clauses.append(f"{self.noun(host, 1)}, {self.noun(category, 1)} {BESIDE[place]} the {self.words[host][0]}")

    def noun(self, category, number) -> str:
        one, many = self.words[category]
        if number > 1:
            return f"{NUMBERS[number]} {many}"
        return f"{article(one)} {one}"
