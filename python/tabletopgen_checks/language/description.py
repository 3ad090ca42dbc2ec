"""What the parser says it understood of a text: a view of a scene description for `expectations.py`."""

import math
import re

from tabletopgen_checks.language.expectations import Item

INVERSE = {
    "left_of": "right_of", "right_of": "left_of", "in_front_of": "behind", "behind": "in_front_of",
    "next_to": "next_to", "parallel_to": "parallel_to",
}
# What else says the same.
ALSO = {
    "on": ("stacked_on",),
    "stacked_on": ("on",),
    "at_left": ("at_back_left", "at_front_left", "from_left_edge"),
    "at_right": ("at_back_right", "at_front_right", "from_right_edge"),
    "at_back": ("at_back_left", "at_back_right", "from_back_edge"),
    "at_front": ("at_front_left", "at_front_right", "from_front_edge"),
}
# The relation of the earlier to the later objects of an arrangement.
ORDER = {"row": "left_of", "column": "in_front_of"}


class Described:
    """The `description` that `tabletopgen-lab parse` prints for a text."""

    def __init__(self, description: dict):
        self.description = description
        self.objects = [item(entry) for entry in description["objects"]]
        self.by_name = {found.name: found for found in self.objects}
        self.relations = [
            (entry["id"], relation["kind"], *map(relation.get, ("target", "second_target", "distance_m")))
            for entry in description["objects"]
            for relation in entry.get("relations", ())
        ]
        # (object, target) of the relations that the person at the target sees.
        self.seated = {
            (entry["id"], relation["target"])
            for entry in description["objects"]
            for relation in entry.get("relations", ())
            if relation.get("seated")
        }
        self.arrangements = [
            (group["kind"]["arrangement"], group["objects"], group.get("gap_m"), group.get("center"))
            for group in description.get("arrangements", ())
        ]
        table = description["table"]
        self.table = {name: table[name] for name in ("shape", "material") if name in table}
        if "size_m" in table:
            self.table["size_cm"] = [100 * side for side in table["size_m"]]
        self.excluded = description.get("excluded_categories", [])
        self.reported = [(part["span"]["text"], part["reason"]) for part in description.get("unrecognized", ())]
        self.corrected = [
            (part["span"]["text"], part["corrected"])
            for part in description.get("understood", ())
            if part["kind"] == "correction"
        ]
        self.goal = (description.get("goal") or {}).get("predicates", [])

    def related(self, kind, name, target, second=None) -> bool:
        if kind == "between":
            return any(
                r[0] == name and r[1] == "between" and {r[2], r[3]} == {target, second} for r in self.relations
            )
        if any(r[:3] == (name, same, target) for same in (kind, *ALSO.get(kind, ())) for r in self.relations):
            return True
        if target is None:
            return self.placed(kind, name)
        if kind in INVERSE and any(r[:3] == (target, INVERSE[kind], name) for r in self.relations):
            return True
        return any(self.follows(kind, name, target, group) for group in self.arrangements)

    def follows(self, kind, name, target, group) -> bool:
        """What an arrangement says of two objects."""
        shape, members, _, center = group
        if kind == "around":
            return shape == "circle" and name in members and center == target
        if name not in members or target not in members:
            return False
        steps = members.index(target) - members.index(name)
        if kind == "next_to":
            return shape in ORDER and abs(steps) == 1
        order = ORDER.get(shape)
        return order is not None and (kind == order and steps > 0 or kind == INVERSE[order] and steps < 0)

    def placed(self, kind, name) -> bool:
        """Whether stated coordinates put an object at a part of the table."""
        position = self.by_name[name].position_cm
        if position is None or not kind.startswith("at_"):
            return False
        words = kind.split("_")[1:]
        sides = {"left": position[0] < 0, "right": position[0] > 0, "front": position[1] < 0, "back": position[1] > 0}
        sides["center"] = max(map(abs, position)) < 5
        return all(sides[word] for word in words)

    def distances_cm(self, kind, name, target) -> list:
        """The distances of an object to a target that a relation states, or any relation (`distance`)."""
        found = [
            100 * distance
            for subject, stated, to, _, distance in self.relations
            if distance is not None
            and (
                (subject, to) == (name, target) and kind in (stated, "distance")
                or (to, subject) == (name, target) and kind in (INVERSE.get(stated), "distance")
            )
        ]
        for _, members, gap_m, _ in self.arrangements:
            if gap_m is not None and name in members and target in members:
                if abs(members.index(name) - members.index(target)) == 1:
                    found.append(100 * gap_m)
        return found

    def arranged(self, kind, names) -> list:
        """(members, gap in cm) of every arrangement of the kind that these objects alone make."""
        if kind == "stack":
            def carried(a, b):
                return self.related("on", a, b) or self.related("in", a, b)
            return [(chain, None) for chain in chains(names, carried)]
        return [
            (members, None if gap_m is None else 100 * gap_m)
            for shape, members, gap_m, _ in self.arrangements
            if shape == kind and set(members) <= set(names)
        ]


def chains(names, carried) -> list:
    """Runs of objects of which each is carried by the one before, from every object that none of them carries."""
    below = {name: [other for other in names if other != name and carried(name, other)] for name in names}
    found = []
    for bottom in (name for name in names if not below[name]):
        chain = [bottom]
        while upper := [name for name in names if chain[-1] in below[name] and name not in chain]:
            chain.append(upper[0])
        found.append(chain)
    return found


def item(entry: dict) -> Item:
    position, yaw = entry.get("position_m"), entry.get("yaw_rad")
    return Item(
        name=entry["id"],
        category=entry["category"],
        label=entry["label"],
        requested=entry["requested"],
        stand_in=entry.get("stand_in", False),
        color=entry.get("color"),
        material=entry.get("material"),
        size_cm=tuple(100 * side for side in entry["size_m"]),
        pose=entry.get("pose", "upright"),
        state=entry.get("state"),
        mass_kg=entry.get("mass_kg"),
        yaw_deg=None if yaw is None else math.degrees(yaw),
        position_cm=None if position is None else tuple(100 * side for side in position),
    )


def unaccounted(text: str, description: dict, ignorable) -> list:
    """Words of a text that no span of the account covers and that are not ignorable."""
    spans = [part["span"] for key in ("understood", "unrecognized") for part in description.get(key, ())]
    left = []
    for word in re.finditer(r"\w+(?:['’]\w+)*", text):
        # Spans are in bytes.
        start = len(text[: word.start()].encode())
        end = start + len(word[0].encode())
        covered = any(span["start"] < end and start < span["end"] for span in spans)
        if not covered and not is_ignorable(word[0].lower(), ignorable):
            left.append(word[0])
    return left


def is_ignorable(word: str, ignorable) -> bool:
    return all(part in ignorable for part in re.split(r"['’]", word)) or re.sub(r"['’]", "", word) in ignorable
