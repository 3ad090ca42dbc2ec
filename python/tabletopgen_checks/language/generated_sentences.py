"""A thousand generated sentences of 1 to 12 objects with relations, and what each asks for.

The grammar below and the number of a sentence decide everything, so that the set is the same everywhere. Expectations
have the format of tests/words/README.md. Categories and their words are those of the catalog.
"""

import random

from tabletopgen_checks.catalog import nouns
from tabletopgen_checks.language.families import FAMILIES, Clauses, article
from tabletopgen_checks.language.sentences import Sentence

SENTENCES = 1000
MAX_OBJECTS = 12

NUMBERS = ["no", "one", "two", "three", "four", "five", "six", "seven", "eight"]
TABLES = {
    "office_living": ["an office desk", "a desk", "a wooden desk", "a study desk"],
    "dining_kitchen": ["a dining table", "a kitchen table", "a table", "a wooden table"],
    "workbench_utility": ["a workbench", "a repair bench", "a bench"],
    "crafting_hobby": ["a hobby desk", "a crafting table", "a table"],
}
LISTS = [
    "{Table} with {list}", "{Table} with {list}.", "Put {list} on {table}.", "Please create {table} with {list}.",
    "Can you make {table} with {list}?", "I need {table} holding {list}.", "On {table} there are {list}.",
    "{Table} that carries {list}", "Generate a scene of {table} with exactly {list} and nothing else.",
]
COLORS = ["red", "blue", "green", "yellow", "white", "black"]
COLORED = ["mug", "bowl", "book", "plate", "candle", "vase", "notebook", "toolbox", "model_car", "marker", "dice"]
BESIDE = {
    "left_of": ["to the left of", "left of", "on the left side of"],
    "right_of": ["to the right of", "right of", "on the right side of"],
    "in_front_of": ["in front of"],
    "behind": ["behind"],
    "next_to": ["next to", "beside"],
}
REGIONS = {
    "at_back": "at the back", "at_front": "at the front", "at_left": "on the left side", "at_right": "on the right side",
    "at_center": "in the center", "at_back_left": "in the back left corner", "at_back_right": "in the back right corner",
    "at_front_left": "in the front left corner", "at_front_right": "in the front right corner",
}
EDGES = {"from_left_edge": "left", "from_right_edge": "right", "from_front_edge": "front", "from_back_edge": "back"}
POSED = {"mug": ["lying_on_side"], "bowl": ["upside_down"], "water_bottle": ["lying_on_side"], "jar": ["lying_on_side"],
         "drinking_glass": ["upside_down"], "soda_can": ["lying_on_side"], "cereal_box": ["lying_on_side"]}
POSES = {"lying_on_side": "lying on its side", "upside_down": "upside down"}
# What a distance may deviate after the scene has settled.
SLACK_CM = 2


def generated(count: int = SENTENCES) -> list:
    """The first `count` of them; the whole set is the same whatever is asked for."""
    words = nouns()
    return [sentence(k, words) for k in range(count)]


def sentence(k: int, words: dict) -> Sentence:
    chance = random.Random(f"generated sentence {k}")
    family = list(FAMILIES)[k % len(FAMILIES)]
    clauses = GrownClauses(FAMILIES[family], words, chance, wanted=1 + k % MAX_OBJECTS)
    text = written(clauses.clauses, chance.choice(TABLES[family]), chance)
    expectation = {"id": f"generated_{k:04}", "kind": "generated", "text": text, **clauses.expectation, "closed": True}
    return Sentence(f"generated_{k:04}", chance.randrange(2**32), text, expectation)


def written(clauses: list, table: str, chance) -> str:
    capital = table[0].upper() + table[1:]
    if chance.random() < 0.15:
        return f"{capital}:\n" + "\n".join(f"- {clause}" for clause in clauses)
    if chance.random() < 0.15:
        return f"{capital}. " + " ".join(f"There is {clause}." for clause in clauses)
    listed = clauses[0] if len(clauses) == 1 else ", ".join(clauses[:-1]) + " and " + clauses[-1]
    return chance.choice(LISTS).format(Table=capital, table=table, list=listed)


class GrownClauses(Clauses):
    """Clauses until the wanted number of objects is reached."""

    def __init__(self, family, words, chance, wanted):
        super().__init__(family, words, chance)
        kinds = [self.plain, self.plain, self.inside, self.upon, self.stack, self.beside, self.region, self.distance,
                 self.between, self.row, self.pose]
        while self.objects < wanted:
            chance.choice(kinds)(wanted - self.objects)

    def plain(self, left):
        if category := self.fresh():
            number = self.number(category, left)
            self.clauses.append(self.noun(category, number, colored=True))

    def inside(self, left):
        forms = ["{host} with {objects} in it", "{objects} in {host}", "{host} containing {objects}"]
        self.hosted(left, self.family.inside, "in", forms)

    def upon(self, left):
        forms = ["{host} with {objects} on it", "{objects} on {host}"]
        self.hosted(left, self.family.upon, "on", forms)

    def hosted(self, left, pairs, relation, forms):
        host, category, max_count = self.chance.choice(pairs)
        if left < 2 or not self.is_fresh(host, category):
            return
        number = self.chance.randint(1, min(max_count, left - 1))
        nouns = {"host": self.noun(host, 1), "objects": self.noun(category, number)}
        self.clauses.append(self.chance.choice(forms).format(**nouns))
        self.relate(relation, category, host)

    def stack(self, left):
        category = self.chance.choice(sorted(self.family.piles))
        if left < 2 or not self.is_fresh(category):
            return
        number = self.chance.randint(2, min(self.family.piles[category], left))
        many = self.noun(category, number)
        form = self.chance.choice(["a stack of {}", "{} stacked on each other"])
        self.clauses.append(form.format(many))
        self.arrange("stack", category, number)

    def beside(self, left):
        subject, other = self.fresh(), None
        if left >= 2 and subject:
            other = self.fresh(besides=subject)
        if subject and other:
            relation = self.chance.choice(sorted(BESIDE))
            self.clauses.append(f"{self.noun(subject, 1)} {self.chance.choice(BESIDE[relation])} {self.noun(other, 1)}")
            self.relate(relation, subject, other)

    def between(self, left):
        pool = [category for category in sorted(self.family.objects) if category not in self.counts]
        if left >= 3 and len(pool) >= 3:
            subject, first, second = self.chance.sample(pool, 3)
            self.clauses.append(f"{self.noun(subject, 1)} between {self.noun(first, 1)} and {self.noun(second, 1)}")
            self.relate("between", subject, first, second=second)

    def region(self, left):
        if category := self.fresh():
            region = self.chance.choice(sorted(REGIONS))
            self.clauses.append(f"{self.noun(category, 1)} {REGIONS[region]}")
            self.relate(region, category)

    def distance(self, left):
        if category := self.fresh():
            edge, cm = self.chance.choice(sorted(EDGES)), self.chance.choice([5, 10, 15])
            self.clauses.append(f"{self.noun(category, 1)} {cm} cm from the {EDGES[edge]} edge")
            self.relate(edge, category, distance_cm=[cm - SLACK_CM, cm + SLACK_CM])

    def row(self, left):
        several = [c for c in sorted(self.family.objects) if c not in self.counts and self.family.objects[c] >= 3]
        if left >= 3 and several:
            category = self.chance.choice(several)
            number = self.chance.randint(3, min(left, self.family.objects[category]))
            self.clauses.append(self.chance.choice(["{} in a row", "a row of {}"]).format(self.noun(category, number)))
            self.arrange(["row", "column"], category, number)

    def pose(self, left):
        fitting = [c for c in sorted(POSED) if c not in self.counts and c in self.family.objects]
        if fitting:
            category = self.chance.choice(fitting)
            pose = self.chance.choice(POSED[category])
            self.clauses.append(f"{self.noun(category, 1)} {POSES[pose]}")
            self.expectation["objects"][-1]["pose"] = pose

    def fresh(self, besides=None):
        pool = [category for category in sorted(self.family.objects) if category not in {*self.counts, besides}]
        return self.chance.choice(pool) if pool else None

    def number(self, category, left) -> int:
        return self.chance.randint(1, min(left, self.family.objects[category]))

    def noun(self, category, number, colored=False) -> str:
        """The objects in words; they are counted from here on."""
        entry = self.expect(category, number)
        one, many = self.words[category]
        color = ""
        if colored and category in COLORED and self.chance.random() < 0.6:
            entry["color"] = self.chance.choice(COLORS)
            color = entry["color"] + " "
        if number > 1:
            count = str(number) if self.chance.random() < 0.3 else NUMBERS[number]
            return f"{count} {color}{many}"
        first = "a" if color and article(one) in ("a", "an") else article(one)
        return f"{first} {color}{one}"
