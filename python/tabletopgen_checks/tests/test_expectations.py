"""The scorer of texts: for every kind of expectation a description that is right and one that is wrong."""

import unittest

from tabletopgen_checks.language.description import Described, unaccounted
from tabletopgen_checks.language.expectations import Cast, complaints, matching
from tabletopgen_checks.language.goals import goal_complaints, is_satisfied
from tabletopgen_checks.scene.colors import is_color, rgb_of


def entity(name, *relations, size=(0.1, 0.1, 0.1), **more):
    """An object of a description; a relation is (kind, target, second target, distance in m), the end left out."""
    stated = []
    for relation in relations:
        entry = dict(zip(("kind", "target", "second_target", "distance_m"), relation))
        stated.append({key: value for key, value in entry.items() if value is not None})
    category = name.rsplit("_", 1)[0]
    return {"id": name, "label": category, "category": category, "size_m": list(size), "requested": True, "seed": 1,
            "relations": stated, **more}


def view(*objects, **more):
    return Described({"theme": "", "family": "", "table": {}, "objects": list(objects), "prose": "", **more})


def some(category, count: int | list = 1, **more):
    return {"category": category, "count": count, **more}


def arrangement(kind, *names, **more):
    return {"kind": {"arrangement": kind}, "objects": list(names), **more}


def span(text, start=0):
    return {"start": start, "end": start + len(text.encode()), "text": text}


MUG, PLATE, BOWL = some("mug"), some("plate"), some("bowl")
RED, BLUE = [0.75, 0.22, 0.17], [0.18, 0.39, 0.71]


def relation(kind, object, target=None, **more):
    return {"relation": kind, "object": object, **({"target": target} if target else {}), **more}


# (what, expectation, right, wrong)
CASES = [
    ("count", {"objects": [some("mug", 2)]}, view(entity("mug_1"), entity("mug_2")), view(entity("mug_1"))),
    ("count of too many", {"objects": [MUG]}, view(entity("mug_1")), view(entity("mug_1"), entity("mug_2"))),
    ("range", {"objects": [some("mug", [2, 3])]}, view(*(entity(f"mug_{k}") for k in (1, 2, 3))), view(entity("mug_1"))),
    ("alternatives", {"objects": [some(["mug", "teacup"])]}, view(entity("teacup_1")), view(entity("bowl_1"))),
    ("another object", {"objects": [MUG]}, view(entity("mug_1")), view(entity("mug_1"), entity("plate_1"))),
    ("absent", {"objects": [MUG], "absent": ["fork"]}, view(entity("mug_1")),
     view(entity("mug_1"), entity("fork_1", requested=False))),
    ("closed", {"objects": [MUG], "closed": True}, view(entity("mug_1")),
     view(entity("mug_1"), entity("pen_1", requested=False))),
    ("fillings", {"objects": [MUG], "fillings": True}, view(entity("mug_1"), entity("fork_1"), entity("pen_1", requested=False)),
     view(entity("mug_1"))),
    ("open", {"objects": [MUG]}, view(entity("mug_1"), entity("pen_1", requested=False)),
     view(entity("pen_1", requested=False))),
    ("color", {"objects": [some("mug", color="red"), some("mug", color="blue")]},
     view(entity("mug_1", color=BLUE), entity("mug_2", color=RED)),
     view(entity("mug_1", color=RED), entity("mug_2", color=RED))),
    ("no color", {"objects": [some("mug", color="red")]}, view(entity("mug_1", color=RED)), view(entity("mug_1"))),
    ("material", {"objects": [some("spoon", material="wood")]}, view(entity("spoon_1", material="wood")),
     view(entity("spoon_1", material="steel"))),
    ("size", {"objects": [some("cube", size_cm={"x": [4, 5], "height": [9, 11]})]},
     view(entity("cube_1", size=(0.045, 0.3, 0.1))),
     view(entity("cube_1", size=(0.045, 0.3, 0.2)))),
    ("diameter", {"objects": [some("plate", size_cm={"diameter": [25, 27]})]},
     view(entity("plate_1", size=(0.26, 0.26, 0.02))),
     view(entity("plate_1", size=(0.2, 0.2, 0.02)))),
    ("pose", {"objects": [some("mug", pose="lying_on_side")]}, view(entity("mug_1", pose="lying_on_side")),
     view(entity("mug_1"))),
    ("state", {"objects": [some("laptop", state="closed")]}, view(entity("laptop_1", state="closed")),
     view(entity("laptop_1"))),
    ("mass", {"objects": [some("ball", mass_kg=[0.14, 0.16])]}, view(entity("ball_1", mass_kg=0.15)),
     view(entity("ball_1"))),
    ("yaw", {"objects": [some("book", yaw_deg=[-92, -88])]}, view(entity("book_1", yaw_rad=4.712389)),
     view(entity("book_1", yaw_rad=1.5708))),
    ("position", {"objects": [some("mug", position_cm={"x": [18, 22], "y": [-12, -8]})]},
     view(entity("mug_1", position_m=[0.2, -0.1])), view(entity("mug_1", position_m=[0.2, 0.1]))),
    ("small and large", {"objects": [some("cup", size="small"), some("cup", size="large"), some("spoon")],
                         "relations": [relation("in", "spoon", some("cup", size="large"))]},
     view(entity("cup_1", size=(0.1,) * 3), entity("cup_2", size=(0.2,) * 3), entity("spoon_1", ("in", "cup_2"))),
     view(entity("cup_1", size=(0.1,) * 3), entity("cup_2", size=(0.2,) * 3), entity("spoon_1", ("in", "cup_1")))),
    ("as small as large", {"objects": [some("cup", size="small"), some("cup", size="large")]},
     view(entity("cup_1", size=(0.1,) * 3), entity("cup_2", size=(0.2,) * 3)), view(entity("cup_1"), entity("cup_2"))),
    ("left of", {"objects": [MUG, PLATE], "relations": [relation("left_of", "mug", "plate")]},
     view(entity("mug_1", ("left_of", "plate_1")), entity("plate_1")),
     view(entity("mug_1", ("right_of", "plate_1")), entity("plate_1"))),
    ("the reverse", {"objects": [MUG, PLATE], "relations": [relation("left_of", "mug", "plate")]},
     view(entity("mug_1"), entity("plate_1", ("right_of", "mug_1"))),
     view(entity("mug_1"), entity("plate_1", ("left_of", "mug_1")))),
    ("order of a row", {"objects": [MUG, PLATE], "relations": [relation("left_of", "mug", "plate")]},
     view(entity("mug_1"), entity("plate_1"), arrangements=[arrangement("row", "mug_1", "plate_1")]),
     view(entity("mug_1"), entity("plate_1"), arrangements=[arrangement("row", "plate_1", "mug_1")])),
    ("support", {"objects": [MUG, BOWL], "relations": [relation("in", "mug", "bowl")]},
     view(entity("mug_1", ("in", "bowl_1")), entity("bowl_1")), view(entity("mug_1", ("on", "bowl_1")), entity("bowl_1"))),
    ("every object", {"objects": [some("mug", 2), PLATE], "relations": [relation("on", "mug", "plate")]},
     view(entity("mug_1", ("on", "plate_1")), entity("mug_2", ("stacked_on", "plate_1")), entity("plate_1")),
     view(entity("mug_1", ("on", "plate_1")), entity("mug_2"), entity("plate_1"))),
    ("so many objects", {"objects": [some("mug", 2), PLATE], "relations": [relation("on", "mug", "plate", count=1)]},
     view(entity("mug_1", ("on", "plate_1")), entity("mug_2"), entity("plate_1")),
     view(entity("mug_1", ("on", "plate_1")), entity("mug_2", ("on", "plate_1")), entity("plate_1"))),
    ("one for each", {"objects": [some("mug", 2), some("plate", 2)],
     "relations": [relation("on", "mug", "plate", each=True)]},
     view(entity("mug_1", ("on", "plate_1")), entity("mug_2", ("on", "plate_2")), entity("plate_1"), entity("plate_2")),
     view(entity("mug_1", ("on", "plate_1")), entity("mug_2", ("on", "plate_1")), entity("plate_1"), entity("plate_2"))),
    ("between", {"objects": [MUG, some("plate", 2)],
     "relations": [relation("between", "mug", "plate", second="plate")]},
     view(entity("mug_1", ("between", "plate_2", "plate_1")), entity("plate_1"), entity("plate_2")),
     view(entity("mug_1", ("next_to", "plate_1")), entity("plate_1"), entity("plate_2"))),
    ("region", {"objects": [MUG], "relations": [relation("at_left", "mug")]}, view(entity("mug_1", ("at_back_left",))),
     view(entity("mug_1", ("at_right",)))),
    ("region of coordinates", {"objects": [MUG], "relations": [relation("at_back_left", "mug")]},
     view(entity("mug_1", position_m=[-0.3, 0.2])), view(entity("mug_1", position_m=[0.3, 0.2]))),
    ("distance of a relation", {"objects": [MUG, PLATE],
     "relations": [relation("left_of", "mug", "plate", distance_cm=[9, 11])]},
     view(entity("mug_1", ("left_of", "plate_1", None, 0.1)), entity("plate_1")),
     view(entity("mug_1", ("left_of", "plate_1", None, 0.2)), entity("plate_1"))),
    ("distance from an edge", {"objects": [MUG], "relations": [relation("from_left_edge", "mug", distance_cm=[9, 11])]},
     view(entity("mug_1", ("from_left_edge", None, None, 0.1))),
     view(entity("mug_1", ("from_right_edge", None, None, 0.1)))),
    ("distance in any direction", {"objects": [MUG, PLATE],
     "relations": [relation("distance", "mug", "plate", distance_cm=[4, 6])]},
     view(entity("mug_1", ("next_to", "plate_1", None, 0.05)), entity("plate_1")),
     view(entity("mug_1", ("next_to", "plate_1")), entity("plate_1"))),
    ("row with gaps", {"objects": [some("cup", 3)],
     "arrangements": [{"kind": "row", "category": "cup", "count": 3, "gap_cm": [4, 6]}]},
     view(*(entity(f"cup_{k}") for k in (1, 2, 3)),
     arrangements=[arrangement("row", "cup_1", "cup_2", "cup_3", gap_m=0.05)]),
     view(*(entity(f"cup_{k}") for k in (1, 2, 3)), arrangements=[arrangement("row", "cup_1", "cup_2", "cup_3")])),
    ("kind of arrangement", {"objects": [some("cup", 2)],
     "arrangements": [{"kind": ["row", "column"], "category": "cup", "count": 2}]},
     view(entity("cup_1"), entity("cup_2"), arrangements=[arrangement("column", "cup_1", "cup_2")]),
     view(entity("cup_1"), entity("cup_2"), arrangements=[arrangement("circle", "cup_1", "cup_2")])),
    ("stack", {"objects": [some("book", 3)], "arrangements": [{"kind": "stack", "category": "book", "count": 3}]},
     view(entity("book_1"), entity("book_2", ("stacked_on", "book_1")), entity("book_3", ("stacked_on", "book_2"))),
     view(entity("book_1"), entity("book_2", ("stacked_on", "book_1")), entity("book_3", ("stacked_on", "book_1")))),
    ("one of several", {"objects": [some("plate", 3), some("vase")],
                        "any_of": [[{"arrangement": {"kind": "circle", "category": "plate", "count": 3}},
                                    {"relation": relation("around", "plate", "vase")}]]},
     view(*(entity(f"plate_{k}", ("around", "vase_1")) for k in (1, 2, 3)), entity("vase_1")),
     view(*(entity(f"plate_{k}") for k in (1, 2, 3)), entity("vase_1"))),
    ("table", {"objects": [MUG], "table": {"shape": "round", "size_cm": {"x": [79, 81]}}},
     view(entity("mug_1"), table={"shape": "round", "size_m": [0.8, 0.8, 0.75]}),
     view(entity("mug_1"), table={"shape": "square", "size_m": [0.8, 0.8, 0.75]})),
    ("wood of a table", {"objects": [MUG], "table": {"material": "wood"}}, view(entity("mug_1"),
     table={"material": "oak"}),
     view(entity("mug_1"), table={"material": "marble"})),
    ("reported", {"objects": [MUG], "reported": [{"text": "unicorn", "reason": "unknown_object"}]},
     view(entity("mug_1"), unrecognized=[{"span": span("unicorn"), "reason": "unknown_object"}]), view(entity("mug_1"))),
    ("reason", {"objects": [MUG], "reported": [{"text": ["left of", "right of"], "reason": "contradiction"}]},
     view(entity("mug_1"), unrecognized=[{"span": span("right of"), "reason": "contradiction"}]),
     view(entity("mug_1"), unrecognized=[{"span": span("right of"), "reason": "unknown_word"}])),
    ("stand-in of a compound", {"objects": [MUG], "reported": [{"text": "egg carton", "or_stand_in": True}]},
     view(entity("mug_1"), entity("stand_in_1", stand_in=True, label="egg carton")),
     view(entity("mug_1"), entity("egg_1"))),
    ("another category of a compound", {"objects": [MUG], "reported": [{"text": "bowl cover", "or_category": ["lid"]}]},
     view(entity("mug_1"), entity("lid_1")), view(entity("mug_1"), entity("bowl_1"))),
    ("corrected", {"objects": [MUG], "corrected": [{"from": "muug", "to": "mug"}]},
     view(entity("mug_1"), understood=[{"span": span("muug"), "kind": "correction", "corrected": "mug"}]),
     view(entity("mug_1"))),
]


class Complaints(unittest.TestCase):
    def test_right_descriptions_have_no_complaint_and_wrong_ones_have(self):
        for what, expected, right, wrong in CASES:
            with self.subTest(what):
                self.assertEqual(complaints(expected, right), [])
                self.assertNotEqual(complaints(expected, wrong), [])

    def test_complaints_name_what_is_wrong(self):
        expected = {"objects": [some("mug", 2, color="red"), PLATE], "relations": [relation("on", "mug", "plate")]}
        found = complaints(expected, view(entity("mug_1", color=RED), entity("plate_1"), entity("fork_1")))
        self.assertEqual(found, ["1 red mug instead of 2", "fork_1 is not asked for", "mug on plate: holds for 0 of 1"])

    def test_particular_entries_choose_before_plain_ones(self):
        cast = Cast([some("mug"), some("mug", color="red")], view(entity("mug_1", color=RED), entity("mug_2")).objects)
        self.assertEqual([item.name for item in cast.of({"category": "mug", "color": "red"})], ["mug_1"])
        self.assertEqual(cast.complaints(), [])

    def test_matching_gives_everyone_a_target_where_that_is_possible(self):
        found = matching({"a": ["x", "y"], "b": ["x"], "c": ["y", "z"]})
        self.assertEqual(found, {"a": "y", "b": "x", "c": "z"})
        self.assertEqual(len(matching({"a": ["x"], "b": ["x"]})), 1)


class Colors(unittest.TestCase):
    def test_shades_are_their_color_and_others_are_not(self):
        self.assertTrue(is_color(rgb_of("crimson"), "red"))
        self.assertTrue(is_color(rgb_of("royal blue"), "blue"))
        self.assertFalse(is_color(rgb_of("green"), "blue"))
        self.assertFalse(is_color(rgb_of("white"), "yellow"))


class Account(unittest.TestCase):
    def test_words_without_span_are_unaccounted(self):
        text = "A naïve mug, please don't spill"
        description = {"understood": [{"span": span("mug", 9)}], "unrecognized": [{"span": span("naïve", 2)}]}
        self.assertEqual(unaccounted(text, description, {"a", "please"}), ["don't", "spill"])
        self.assertEqual(unaccounted(text, description, {"a", "please", "dont", "spill"}), [])


def predicate(kind, object, target=None, second=None):
    entry = {"predicate": kind, "object": object, "target": target, "second_target": second}
    return {key: value for key, value in entry.items() if value is not None}


# (what, objects, expected goal, a right goal, a wrong goal)
GOALS = [
    ("in", ["apple_1", "bowl_1"], ("in", "apple", "bowl"), [predicate("in", "apple_1", "bowl_1")],
     [predicate("on", "apple_1", "bowl_1")]),
    ("every object", ["apple_1", "apple_2", "bowl_1"], ("in", "apple", "bowl"),
     [predicate("in", "apple_1", "bowl_1"), predicate("in", "apple_2", "bowl_1")],
     [predicate("in", "apple_1", "bowl_1")]),
    ("roles", ["mug_1", "plate_1"], ("on", "mug", "plate"), [predicate("stacked_on", "mug_1", "plate_1")],
     [predicate("on", "plate_1", "mug_1")]),
    ("the reverse", ["mug_1", "plate_1"], ("left_of", "mug", "plate"), [predicate("right_of", "plate_1", "mug_1")],
     [predicate("left_of", "plate_1", "mug_1")]),
    ("symmetric", ["mug_1", "plate_1"], ("swapped", "mug", "plate"), [predicate("swapped", "plate_1", "mug_1")],
     [predicate("next_to", "mug_1", "plate_1")]),
    ("of one object", ["mug_1"], ("lifted", "mug", None), [predicate("lifted", "mug_1")], []),
    ("nothing more", ["mug_1", "plate_1"], ("on", "mug", "plate"),
     [predicate("on", "mug_1", "plate_1"), predicate("lifted", "mug_1")],
     [predicate("on", "mug_1", "plate_1"), predicate("rotated", "plate_1")]),
    ("alternatives", ["book_1"], (["at_left", "moved"], "book", None), [predicate("moved", "book_1")],
     [predicate("at_right", "book_1")]),
]


class Goals(unittest.TestCase):
    def test_right_goals_have_no_complaint_and_wrong_ones_have(self):
        for what, names, (kind, object, target), right, wrong in GOALS:
            asked = {"predicate": kind, "object": object, **({"target": target} if target else {})}
            entries = [some(category, [1, 9]) for category in sorted({name.rsplit("_", 1)[0] for name in names})]
            for goal, holds in ((right, True), (wrong, False)):
                with self.subTest(what, goal=goal):
                    found = view(*map(entity, names), goal={"instruction": "", "predicates": goal})
                    cast = Cast(entries, found.objects)
                    self.assertEqual(goal_complaints([asked], cast, found) == [], holds)

    def test_between_needs_both_targets(self):
        asked = {"predicate": "between", "object": "cube", "target": "bowl", "second": "plate"}
        entries = [some("cube"), BOWL, PLATE]
        for second, holds in (("plate_1", True), ("bowl_1", False)):
            goal = {"predicates": [predicate("between", "cube_1", "bowl_1", second)]}
            found = view(entity("cube_1"), entity("bowl_1"), entity("plate_1"), goal=goal)
            self.assertEqual(goal_complaints([asked], Cast(entries, found.objects), found) == [], holds)

    def test_solved_starts_are_noticed(self):
        for goal, objects in [
            ([predicate("in", "apple_1", "bowl_1")], [entity("apple_1", ("in", "bowl_1")), entity("bowl_1")]),
            ([predicate("out_of", "apple_1", "bowl_1")], [entity("apple_1"), entity("bowl_1")]),
            ([predicate("closed", "cabinet_1")], [entity("cabinet_1")]),
            ([predicate("opened", "laptop_1")], [entity("laptop_1")]),
            ([predicate("upright", "mug_1")], [entity("mug_1")]),
        ]:
            self.assertTrue(is_satisfied(goal, view(*objects)), goal)
        for goal, objects in [
            ([predicate("in", "apple_1", "bowl_1")], [entity("apple_1"), entity("bowl_1")]),
            ([predicate("opened", "cabinet_1")], [entity("cabinet_1")]),
            ([predicate("upright", "mug_1")], [entity("mug_1", pose="upside_down")]),
            ([predicate("lifted", "mug_1")], [entity("mug_1")]),
            ([predicate("in", "apple_1", "bowl_1"), predicate("lifted", "bowl_1")],
             [entity("apple_1", ("in", "bowl_1")), entity("bowl_1")]),
            ([], [entity("mug_1")]),
        ]:
            self.assertFalse(is_satisfied(goal, view(*objects)), goal)


if __name__ == "__main__":
    unittest.main()
