"""Every expectation of tests/words can be met: a description made from it has no complaint, and an empty one has."""

import math
import unittest

from tabletopgen_checks.language import words
from tabletopgen_checks.language.description import Described
from tabletopgen_checks.language.expectations import Cast, bounds, listed
from tabletopgen_checks.language.generated_sentences import generated
from tabletopgen_checks.scene.colors import rgb_of

SIDES_CM = {"small": 5.0, "medium": 10.0, "large": 15.0}


class Writer:
    """A description that says what an entry asks for."""

    def __init__(self, entry):
        self.entry, self.arrangements = entry, []
        self.objects = [
            self.object_of(f"object_{k}_{n}", asked)
            for k, asked in enumerate(entry["objects"])
            for n in range(max(1, bounds(asked["count"])[0]) if bounds(asked["count"])[1] else 0)
        ]
        self.by_name = {entry["id"]: entry for entry in self.objects}
        self.cast = Cast(entry["objects"], Described(self.description()).objects)
        for relation in entry.get("relations", ()):
            self.relate(relation)
        for group in entry.get("arrangements", ()):
            self.arrange(group)
        for (first, *_) in entry.get("any_of", ()):
            self.arrange(first["arrangement"]) if "arrangement" in first else self.relate(first["relation"])

    def object_of(self, name, asked):
        sides = asked.get("size_cm", {})
        usual = SIDES_CM[asked.get("size", "medium")]
        wide = sides.get("diameter", sides.get("length"))
        size_cm = [sides.get("x", wide), sides.get("y", sides.get("diameter")), sides.get("z", sides.get("height"))]
        entry = {
            "id": name, "label": name, "category": listed(asked["category"])[0], "requested": True, "relations": [],
            "size_m": [0.01 * (mean_of(side) if side else usual) for side in size_cm],
        }
        if "color" in asked:
            entry["color"] = rgb_of(asked["color"])
        for key in ("material", "state"):
            if key in asked:
                entry[key] = asked[key]
        if "pose" in asked:
            entry["pose"] = listed(asked["pose"])[0]
        if "mass_kg" in asked:
            entry["mass_kg"] = mean_of(asked["mass_kg"])
        if "yaw_deg" in asked:
            entry["yaw_rad"] = math.radians(mean_of(asked["yaw_deg"]))
        if "position_cm" in asked:
            entry["position_m"] = [0.01 * mean_of(asked["position_cm"][axis]) for axis in "xy"]
        return entry

    def relate(self, relation):
        subjects = self.cast.of(relation["object"])
        kind = listed(relation["relation"])[0]
        for k, subject in enumerate(subjects[: bounds(relation.get("count", len(subjects)))[0]]):
            entry = {"kind": "next_to" if kind == "distance" else kind}
            if "target" in relation:
                targets = [item for item in self.cast.of(relation["target"]) if item is not subject]
                entry["target"] = targets[k % len(targets)].name
            if "second" in relation:
                seconds = [item.name for item in self.cast.of(relation["second"]) if item is not subject]
                entry["second_target"] = next(name for name in seconds if name != entry["target"])
            if "distance_cm" in relation:
                entry["distance_m"] = 0.01 * mean_of(relation["distance_cm"])
            self.by_name[subject.name]["relations"].append(entry)

    def arrange(self, group):
        members = self.cast.of({k: v for k, v in group.items() if k not in ("kind", "count", "gap_cm")})
        names = [item.name for item in members[: bounds(group["count"])[0]]]
        kind = listed(group["kind"])[0]
        if kind == "stack":
            for lower, upper in zip(names, names[1:]):
                self.by_name[upper]["relations"].append({"kind": "stacked_on", "target": lower})
            return
        entry = {"kind": {"arrangement": kind}, "objects": names}
        if "gap_cm" in group:
            entry["gap_m"] = 0.01 * mean_of(group["gap_cm"])
        self.arrangements.append(entry)

    def goal(self):
        predicates = []
        for asked in self.entry.get("goal", ()):
            subjects = self.cast.of(asked["object"])
            for subject in subjects[: bounds(asked.get("count", len(subjects)))[0]]:
                entry = {"predicate": listed(asked["predicate"])[0], "object": subject.name}
                if "target" in asked:
                    # The last of them: the first may be where the object starts.
                    entry["target"] = [i.name for i in self.cast.of(asked["target"]) if i is not subject][-1]
                if "second" in asked:
                    others = (i.name for i in self.cast.of(asked["second"]) if i is not subject)
                    entry["second_target"] = next(name for name in others if name != entry["target"])
                predicates.append(entry)
        return {"instruction": self.entry["text"], "predicates": predicates}

    def description(self) -> dict:
        asked = self.entry.get("table", {})
        table = {key: asked[key] for key in ("shape", "material") if key in asked}
        if "size_cm" in asked:
            table["size_m"] = [0.01 * mean_of(asked["size_cm"].get(axis, [75, 75])) for axis in "xyz"]
        entry = {"table": table, "objects": self.objects, "arrangements": self.arrangements}
        entry["unrecognized"] = [
            {"span": {"text": listed(part["text"])[0]}, "reason": listed(part.get("reason", "unknown_word"))[0]}
            for part in self.entry.get("reported", ())
        ]
        entry["understood"] = [
            {"span": {"text": part["from"]}, "kind": "correction", "corrected": part["to"]}
            for part in self.entry.get("corrected", ())
        ]
        if self.entry.get("fillings"):
            entry["objects"] = [*self.objects, self.object_of("filling", {"category": "nothing"}) | {"requested": False}]
        return entry


def mean_of(limits) -> float:
    return 0.5 * (limits[0] + limits[1])


def outcome(entry) -> dict:
    if entry.get("refused"):
        return {"error": {"code": "", "message": entry.get("message", ""), "terms": []}}
    writer = Writer(entry)
    return {"description": writer.description() | ({"goal": writer.goal()} if "goal" in entry else {})}


EMPTY = {"description": {"table": {}, "objects": []}}


class Attainable(unittest.TestCase):
    def test_sentences(self):
        for entry in words.entries("sentences") + [one.expectation for one in generated(400)]:
            with self.subTest(entry["id"], text=entry["text"]):
                self.assertEqual(words.sentence_complaints(entry, outcome(entry)), [])
                self.assertNotEqual(words.sentence_complaints(entry, EMPTY), [])

    def test_tasks(self):
        for entry in words.entries("tasks"):
            with self.subTest(entry["id"], text=entry["text"]):
                score = words.task_score(entry, outcome(entry))
                self.assertEqual((score.scene, score.goal, score.solved), ([], [], False))
                score = words.task_score(entry, EMPTY)
                self.assertTrue(score.scene and score.goal and score.solved)


if __name__ == "__main__":
    unittest.main()
