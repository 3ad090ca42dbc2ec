"""A hundred wishes with fixed seeds, and what each asks for: how many of what, on which table, and where.

Four families in turn; a third are crowded (16 to 25 things) or stacked, a fifth ask for a round, a triangular or an
irregular table. A wish names every thing in words of the catalog, so that nothing is left for a theme to fill in.
"""

import random
import tomllib
from dataclasses import dataclass, field

from tabletopgen_checks.repository import CATALOG

WISHES = 100
FIRST_SEED = 50_000

NUMBERS = ["no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten"]

# Articles that do not follow from the first letter.
ARTICLES = {"hourglass": "an", "utility knife": "a", "pliers": "a pair of"}

# The words for a table of a shape, and the shape that scene.json must tell.
SHAPES = [("round", "round"), ("triangular", "triangular"), ("hexagonal", "irregular"), ("kidney-shaped", "irregular")]


@dataclass
class Family:
    """What wishes of a family are made of. Categories are those of the catalog."""

    tables: list
    # The same with a shape before the last word.
    shaped: str
    # Things that may stand anywhere, with the most there are of each.
    things: dict
    # (host, what goes in or on it, the most of those); there is one host.
    inside: list
    upon: list
    # Things of which several make a pile, with the most.
    piles: dict
    # (thing, place, of what): all one each.
    beside: list


FAMILIES = {
    "office_living": Family(
        tables=["An office desk", "A study desk", "A wooden desk"],
        shaped="A {} coffee table",
        things={
            "stapler": 1, "calculator": 1, "tissue_box": 1, "remote_control": 2, "smartphone": 2, "tape_dispenser": 1,
            "sticky_notes": 3, "cactus": 3, "candle": 4, "picture_frame": 2, "rubiks_cube": 2, "desk_clock": 1,
            "potted_plant": 2, "soda_can": 4, "water_bottle": 2, "game_controller": 2, "headphones": 1, "globe": 1,
            "hourglass": 1, "eyeglasses": 1, "ruler": 2, "glue_stick": 2, "banana": 2, "tablet": 1, "scissors": 1,
        },
        inside=[("pen_holder", "pen", 4), ("pen_holder", "pencil", 3), ("mug", "pencil", 2)],
        upon=[("coaster", "mug", 1)],
        piles={"book": 5, "notebook": 4, "coaster": 4, "playing_cards": 2},
        beside=[
            ("mouse", "right", "keyboard"), ("desk_lamp", "behind", "laptop"), ("speaker", "left", "monitor"),
            ("keyboard", "front", "monitor"), ("vase", "next", "laptop"), ("mouse", "right", "laptop"),
        ],
    ),
    "dining_kitchen": Family(
        tables=["A dining table", "A kitchen table", "A breakfast table"],
        shaped="A {} dining table",
        things={
            "wine_glass": 4, "drinking_glass": 4, "salt_shaker": 1, "pepper_mill": 1, "teapot": 1, "milk_carton": 1,
            "cereal_box": 2, "candle": 2, "jar": 3, "wine_bottle": 2, "whisk": 1, "ladle": 1, "rolling_pin": 1,
            "pitcher": 1, "kettle": 1, "lemon": 3, "pear": 3, "carrot": 3, "banana": 2, "toaster": 1, "saucepan": 1,
            "frying_pan": 1, "baguette": 2, "vase": 1, "napkin_holder": 1, "spatula": 1, "soda_can": 4,
        },
        inside=[("bowl", "apple", 4), ("bowl", "orange", 3), ("mug", "spoon", 1), ("basket", "croissant", 3)],
        upon=[
            ("plate", "croissant", 2), ("cutting_board", "tomato", 3), ("saucer", "teacup", 1), ("plate", "donut", 2),
            ("cutting_board", "cucumber", 2),
        ],
        piles={"plate": 5, "bowl": 3, "saucer": 4},
        beside=[
            ("fork", "left", "plate"), ("knife", "right", "plate"), ("spoon", "right", "bowl"),
            ("drinking_glass", "behind", "plate"), ("cheese_wedge", "next", "bread_loaf"),
        ],
    ),
    "workbench_utility": Family(
        tables=["A carpenter's workbench", "A workbench", "A repair bench"],
        shaped="A {} worktable",
        things={
            "hammer": 2, "screwdriver": 4, "wrench": 3, "pliers": 2, "adjustable_wrench": 1, "hand_saw": 1,
            "tape_measure": 2, "spirit_level": 1, "utility_knife": 2, "c_clamp": 3, "chisel": 3, "hand_plane": 1,
            "flashlight": 2, "multimeter": 1, "wire_spool": 3, "oil_can": 2, "glue_bottle": 3, "pencil": 3,
            "power_drill": 1, "funnel": 1, "bolt": 4, "nut": 4,
        },
        inside=[("storage_bin", "nut", 4), ("storage_bin", "bolt", 3)],
        upon=[("storage_case", "tape_measure", 1)],
        piles={"paint_can": 3, "storage_case": 3},
        beside=[
            ("hammer", "left", "toolbox"), ("flashlight", "right", "toolbox"), ("multimeter", "front", "toolbox"),
            ("paint_can", "next", "power_drill"), ("desk_lamp", "behind", "toolbox"),
        ],
    ),
    "crafting_hobby": Family(
        tables=["A hobby desk", "A crafting table", "A sewing table"],
        shaped="A {} hobby table",
        things={
            "model_car": 3, "paint_bottle": 5, "paintbrush": 4, "magnifying_glass": 1, "thread_spool": 4,
            "yarn_ball": 4, "pin_cushion": 1, "glue_stick": 3, "marker": 4, "dice": 4, "chess_pawn": 4, "scissors": 1,
            "crayon_box": 2, "watercolor_set": 1, "paint_palette": 1, "hot_glue_gun": 1, "embroidery_hoop": 2,
            "teddy_bear": 1, "model_airplane": 1, "color_pencil": 4, "button": 5, "canvas_board": 1,
        },
        inside=[("pen_holder", "paintbrush", 3), ("pen_holder", "color_pencil", 4), ("mug", "marker", 2)],
        upon=[("cutting_mat", "utility_knife", 1), ("cutting_mat", "ruler", 1)],
        piles={"building_brick": 4, "storage_case": 3, "book": 4, "playing_cards": 2},
        beside=[
            ("thread_spool", "right", "sewing_machine"), ("pin_cushion", "front", "sewing_machine"),
            ("desk_lamp", "behind", "cutting_mat"), ("glue_stick", "next", "storage_case"),
        ],
    ),
}

PLACES = {
    "left": "to the left of",
    "right": "to the right of",
    "front": "in front of",
    "behind": "behind",
    "next": "next to",
}


@dataclass
class Place:
    """`thing` is `in` or `on` a `host`, `piled` on its like, or at a side of it."""

    thing: str
    where: str
    host: str


@dataclass
class Wish:
    name: str
    family: str
    seed: int
    text: str
    # Category to number; nothing else may be there.
    expect: dict
    places: list
    crowded: bool
    stacked: bool
    # The shape that scene.json must tell, where the wish names one.
    table: str | None = None
    objects: int = field(init=False)

    def __post_init__(self):
        self.objects = sum(self.expect.values())


def wishes(count: int = WISHES) -> list:
    """The first `count` of them; the whole set is the same whatever is asked for."""
    words = catalog_words()
    return [wish(k, words) for k in range(count)]


def catalog_words() -> dict:
    """Category to (singular, plural)."""
    words = {}
    for path in sorted(CATALOG.glob("*.toml")):
        for category in tomllib.loads(path.read_text(encoding="utf-8")).get("category", []):
            label = category["label"]
            words[category["name"]] = (label, category.get("plural", label + "s"))
    return words


def wish(k: int, words: dict) -> Wish:
    chance = random.Random(f"wish {k}")
    name = list(FAMILIES)[k % len(FAMILIES)]
    family = FAMILIES[name]
    crowded, stacked = k % 6 == 0, k % 6 == 3
    lowest, highest = (16, 25) if crowded else (5, 15)
    told, shape = chance.choice(family.tables), None
    if k % 5 == 0:
        word, shape = SHAPES[k // 5 % len(SHAPES)]
        told = family.shaped.format(word)
    made = Clauses(words)
    if stacked:
        for category in chance.sample(sorted(family.piles), 2):
            made.pile(category, chance.randint(2, family.piles[category]))
        made.host(*chance.choice(family.inside), "in", chance)
    else:
        kinds = chance.sample(["in", "on", "beside", "pile"], 3 if crowded else 2)
        for kind in kinds:
            if kind == "pile":
                category = chance.choice(sorted(family.piles))
                made.pile(category, chance.randint(2, family.piles[category]))
            elif kind == "beside":
                made.beside(*chance.choice(family.beside))
            else:
                made.host(*chance.choice(family.inside if kind == "in" else family.upon), kind, chance)
    wanted = chance.randint(max(lowest, made.objects() + 1), highest)
    things = sorted(family.things)
    chance.shuffle(things)
    for category in things:
        left = wanted - made.objects()
        if left > 0:
            made.several(category, min(left, chance.randint(1, family.things[category])))
    chance.shuffle(made.clauses)
    listed = ", ".join(made.clauses[:-1]) + " and " + made.clauses[-1]
    return Wish(
        name=f"{name}_{k:02}", family=name, seed=FIRST_SEED + k, text=f"{told} with {listed}", expect=made.expect,
        places=made.places, crowded=crowded, stacked=stacked, table=shape,
    )


class Clauses:
    """A sentence as it grows. A category is named in one clause only, so that nobody can mistake which is meant."""

    def __init__(self, words):
        self.words, self.clauses, self.expect, self.places = words, [], {}, []

    def objects(self) -> int:
        return sum(self.expect.values())

    def fresh(self, *categories) -> bool:
        return not any(category in self.expect for category in categories)

    def several(self, category, number):
        if self.fresh(category):
            self.expect[category] = number
            self.clauses.append(self.noun(category, number))

    def pile(self, category, number):
        if self.fresh(category):
            self.expect[category] = number
            self.places.append(Place(category, "piled", category))
            self.clauses.append(f"a stack of {NUMBERS[number]} {self.words[category][1]}")

    def host(self, host, thing, most, where, chance):
        if self.fresh(host, thing):
            number = chance.randint(1, most)
            self.expect.update({host: 1, thing: number})
            self.places.append(Place(thing, where, host))
            self.clauses.append(f"{self.noun(host, 1)} with {self.noun(thing, number)} {where} it")

    def beside(self, thing, place, host):
        if self.fresh(thing, host):
            self.expect.update({thing: 1, host: 1})
            self.places.append(Place(thing, place, host))
            self.clauses.append(f"{self.noun(host, 1)}, {self.noun(thing, 1)} {PLACES[place]} the {self.words[host][0]}")

    def noun(self, category, number) -> str:
        one, many = self.words[category]
        if number > 1:
            return f"{NUMBERS[number]} {many}"
        article = ARTICLES.get(one) or ("an" if one[0].lower() in "aeiou" else "a")
        return f"{article} {one}"
