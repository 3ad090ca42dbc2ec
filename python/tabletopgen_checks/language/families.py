"""Families of objects that belong together, and the clauses of sentences that are generated from them."""

from dataclasses import dataclass

# Articles that do not follow from the first letter.
ARTICLES = {"hourglass": "an", "utility knife": "a", "pliers": "a pair of"}


@dataclass
class Family:
    """What sentences of a family are made of. Categories are those of the catalog."""

    tables: list
    # The same with a shape before the last word.
    shaped: str
    # Objects that may stand anywhere, with the largest number of each.
    objects: dict
    # (host, what goes in or on it, the largest number of those); there is one host.
    inside: list
    upon: list
    # Objects of which several make a stack, with the largest number.
    piles: dict
    # (object, relation, target): all one each.
    beside: list


FAMILIES = {
    "office_living": Family(
        tables=["An office desk", "A study desk", "A wooden desk"],
        shaped="A {} coffee table",
        objects={
            "stapler": 1, "calculator": 1, "tissue_box": 1, "remote_control": 2, "smartphone": 2, "tape_dispenser": 1,
            "sticky_notes": 3, "cactus": 3, "candle": 4, "picture_frame": 2, "rubiks_cube": 2, "desk_clock": 1,
            "potted_plant": 2, "soda_can": 4, "water_bottle": 2, "game_controller": 2, "headphones": 1, "globe": 1,
            "hourglass": 1, "eyeglasses": 1, "ruler": 2, "glue_stick": 2, "banana": 2, "tablet": 1, "scissors": 1,
        },
        inside=[("pen_holder", "pen", 4), ("pen_holder", "pencil", 3), ("mug", "pencil", 2)],
        upon=[("coaster", "mug", 1)],
        piles={"book": 5, "notebook": 4, "coaster": 4, "playing_cards": 2},
        beside=[
            ("mouse", "right_of", "keyboard"), ("desk_lamp", "behind", "laptop"), ("speaker", "left_of", "monitor"),
            ("keyboard", "in_front_of", "monitor"), ("vase", "next_to", "laptop"), ("mouse", "right_of", "laptop"),
        ],
    ),
    "dining_kitchen": Family(
        tables=["A dining table", "A kitchen table", "A breakfast table"],
        shaped="A {} dining table",
        objects={
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
            ("fork", "left_of", "plate"), ("knife", "right_of", "plate"), ("spoon", "right_of", "bowl"),
            ("drinking_glass", "behind", "plate"), ("cheese_wedge", "next_to", "bread_loaf"),
        ],
    ),
    "workbench_utility": Family(
        tables=["A carpenter's workbench", "A workbench", "A repair bench"],
        shaped="A {} worktable",
        objects={
            "hammer": 2, "screwdriver": 4, "wrench": 3, "pliers": 2, "adjustable_wrench": 1, "hand_saw": 1,
            "tape_measure": 2, "spirit_level": 1, "utility_knife": 2, "c_clamp": 3, "chisel": 3, "hand_plane": 1,
            "flashlight": 2, "multimeter": 1, "wire_spool": 3, "oil_can": 2, "glue_bottle": 3, "pencil": 3,
            "power_drill": 1, "funnel": 1, "bolt": 4, "nut": 4,
        },
        inside=[("storage_bin", "nut", 4), ("storage_bin", "bolt", 3)],
        upon=[("storage_case", "tape_measure", 1)],
        piles={"paint_can": 3, "storage_case": 3},
        beside=[
            ("hammer", "left_of", "toolbox"), ("flashlight", "right_of", "toolbox"), ("multimeter", "in_front_of", "toolbox"),
            ("paint_can", "next_to", "power_drill"), ("desk_lamp", "behind", "toolbox"),
        ],
    ),
    "crafting_hobby": Family(
        tables=["A hobby desk", "A crafting table", "A sewing table"],
        shaped="A {} hobby table",
        objects={
            "model_car": 3, "paint_bottle": 5, "paintbrush": 4, "magnifying_glass": 1, "thread_spool": 4,
            "yarn_ball": 4, "pin_cushion": 1, "glue_stick": 3, "marker": 4, "dice": 4, "chess_pawn": 4, "scissors": 1,
            "crayon_box": 2, "watercolor_set": 1, "paint_palette": 1, "hot_glue_gun": 1, "embroidery_hoop": 2,
            "teddy_bear": 1, "model_airplane": 1, "color_pencil": 4, "button": 5, "canvas_board": 1,
        },
        inside=[("pen_holder", "paintbrush", 3), ("pen_holder", "color_pencil", 4), ("mug", "marker", 2)],
        upon=[("cutting_mat", "utility_knife", 1), ("cutting_mat", "ruler", 1)],
        piles={"building_brick": 4, "storage_case": 3, "book": 4, "playing_cards": 2},
        beside=[
            ("thread_spool", "right_of", "sewing_machine"), ("pin_cushion", "in_front_of", "sewing_machine"),
            ("desk_lamp", "behind", "cutting_mat"), ("glue_stick", "next_to", "storage_case"),
        ],
    ),
}


class Clauses:
    """Clauses of a sentence as it grows, with what they ask for in the format of tests/words. A category is in one
    clause only, so that every reference is clear.
    """

    def __init__(self, family: Family, words: dict, chance):
        self.family, self.words, self.chance = family, words, chance
        self.clauses, self.counts = [], {}
        self.expectation: dict = {"objects": [], "relations": [], "arrangements": []}

    @property
    def objects(self) -> int:
        return sum(self.counts.values())

    def is_fresh(self, *categories) -> bool:
        return not any(category in self.counts for category in categories)

    def expect(self, category: str, number: int) -> dict:
        """The entry of the objects, which are counted from here on."""
        self.counts[category] = number
        self.expectation["objects"].append({"category": category, "count": number})
        return self.expectation["objects"][-1]

    def relate(self, relation: str, category: str, target: str | None = None, **more):
        entry = {"relation": relation, "object": category} | ({"target": target} if target else {})
        self.expectation["relations"].append(entry | more)

    def arrange(self, kind, category: str, number: int):
        self.expectation["arrangements"].append({"kind": kind, "category": category, "count": number})


def article(noun: str) -> str:
    return ARTICLES.get(noun) or ("an" if noun[0].lower() in "aeiou" else "a")
