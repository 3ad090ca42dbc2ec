"""Whether a scene is what a text asks for. The format of the expectations is in tests/words/README.md.

The same checks serve what the program says it understood (`description.py`) and the finished scene (`measured.py`):
both are views with `objects`, `related`, `distances_cm`, `arranged`, `table`, `excluded`, `reported` and `corrected`.
"""

import itertools
import re
from dataclasses import dataclass

from tabletopgen_checks.scene.colors import is_color

SIZES = ("small", "medium", "large")
# What an entry or a reference may say of an object beside its category.
QUALIFIERS = ("color", "material", "size_cm", "pose", "state", "mass_kg", "yaw_deg", "position_cm")
# Materials of a table that are wood.
WOODS = ("any_wood", "wood", "oak", "walnut", "pine", "birch")


@dataclass
class Item:
    """An object of a view, with lengths in cm, angles in degrees, and the position from the center of the table top."""

    name: str
    category: str
    label: str = ""
    requested: bool = True
    stand_in: bool = False
    color: tuple | None = None
    material: str | None = None
    size_cm: tuple = (0.0, 0.0, 0.0)
    pose: str = "upright"
    state: str | None = None
    mass_kg: float | None = None
    yaw_deg: float | None = None
    position_cm: tuple | None = None

    def volume(self) -> float:
        return self.size_cm[0] * self.size_cm[1] * self.size_cm[2]


class Cast:
    """Which objects of a view play which entry of the expectation."""

    def __init__(self, entries, items):
        self.entries, self.taken = entries, [[] for _ in entries]
        free = list(items)
        # The most particular entries choose first, the plain ones get what is left.
        def rank(k):
            return (-len(qualifiers(entries[k])), len(listed(entries[k]["category"])))
        for k in sorted(range(len(entries)), key=rank):
            entry = entries[k]
            fitting = [item for item in free if fits(item, entry)]
            if entry.get("size") == "large":
                fitting.sort(key=Item.volume, reverse=True)
            elif entry.get("size") == "small":
                fitting.sort(key=Item.volume)
            self.taken[k] = fitting[: bounds(entry["count"])[1]]
            free = [item for item in free if item not in self.taken[k]]
        self.left_over = free

    def of(self, reference) -> list:
        """The objects of all entries that a reference means: a category, several, or a category with qualifiers."""
        reference = reference if isinstance(reference, dict) else {"category": reference}
        wanted = set(listed(reference["category"]))
        stated = qualifiers(reference)
        return [
            item
            for entry, items in zip(self.entries, self.taken)
            if wanted & set(listed(entry["category"])) and all(entry.get(name) == reference[name] for name in stated)
            for item in items
        ]

    def complaints(self) -> list:
        wrong = []
        for entry, items in zip(self.entries, self.taken):
            low, high = bounds(entry["count"])
            if not low <= len(items) <= high:
                asked = str(low) if low == high else f"{low} to {high}"
                wrong.append(f"{len(items)} {in_words(entry)} instead of {asked}")
        return wrong + self.size_complaints()

    def size_complaints(self) -> list:
        """What is called small has to be smaller than what is called large."""
        wrong = []
        for small, large in itertools.product(self.sized(), repeat=2):
            if SIZES.index(small[0]) < SIZES.index(large[0]) and small[1] & large[1] and small[2] and large[2]:
                if max(map(Item.volume, small[2])) >= min(map(Item.volume, large[2])):
                    wrong.append(f"the {small[0]} {small[2][0].category} is no smaller than the {large[0]} one")
        return wrong

    def sized(self) -> list:
        return [
            (entry["size"], set(listed(entry["category"])), items)
            for entry, items in zip(self.entries, self.taken)
            if "size" in entry
        ]


def complaints(expected: dict, view) -> list:
    """What is not as the text asks for; empty when all is."""
    cast = Cast(expected["objects"], [item for item in view.objects if item.requested])
    wrong = cast.complaints()
    if not expected.get("fillings"):
        wrong += [f"{item.name} is not asked for" for item in cast.left_over if not is_reported_stand_in(item, expected)]
    elif len(view.objects) == sum(map(len, cast.taken)):
        wrong.append("nothing fills the table")
    wrong += [
        f"{item.name} has to be absent"
        for item in view.objects
        if item.category in expected.get("absent", ())
    ]
    if expected.get("closed"):
        wrong += [f"{item.name} is a filling" for item in view.objects if not item.requested]
    wrong += [stated for relation in expected.get("relations", ()) for stated in relation_complaints(relation, cast, view)]
    wrong += [stated for group in expected.get("arrangements", ()) for stated in arrangement_complaints(group, cast, view)]
    for alternatives in expected.get("any_of", ()):
        stated = [alternative_complaints(alternative, cast, view) for alternative in alternatives]
        if all(stated):
            wrong.append("neither: " + "; nor: ".join("; ".join(words) for words in stated))
    wrong += table_complaints(expected.get("table", {}), view)
    wrong += [
        f"{asked['text']!r} is not reported"
        for asked in expected.get("reported", ())
        if not is_reported(asked, view)
    ]
    wrong += [
        f"{asked['from']!r} is not corrected to {asked['to']!r}"
        for asked in expected.get("corrected", ())
        if not any(is_correction(asked, pair) for pair in view.corrected)
    ]
    return wrong


def alternative_complaints(alternative, cast, view) -> list:
    if "arrangement" in alternative:
        return arrangement_complaints(alternative["arrangement"], cast, view)
    return relation_complaints(alternative["relation"], cast, view)


def relation_complaints(relation, cast, view) -> list:
    """A relation holds for every object it names, or for `count` of them, each with some target."""
    subjects = cast.of(relation["object"])
    partners = {item.name: partners_of(item, relation, cast, view) for item in subjects}
    held = [name for name, targets in partners.items() if targets]
    low, high = bounds(relation.get("count", max(1, len(subjects))))
    kinds = "/".join(listed(relation["relation"]))
    words = f"{in_words(relation['object'])} {kinds} {in_words(relation.get('target'))}".strip()
    if "distance_cm" in relation:
        words += f" at {relation['distance_cm'][0]} to {relation['distance_cm'][1]} cm"
    if not low <= len(held) <= high:
        return [f"{words}: holds for {len(held)} of {len(subjects)}"]
    if relation.get("each") and len(matching(partners)) < len(subjects):
        return [f"{words}: not one for each"]
    return []


def partners_of(item, relation, cast, view) -> list:
    """Names of the targets to which an object has the relation."""
    targets = cast.of(relation["target"]) if "target" in relation else [None]
    seconds = cast.of(relation["second"]) if "second" in relation else [None]
    found = []
    for target in targets:
        for second in seconds:
            alike = target is item or (second is not None and second in (item, target))
            kinds = () if alike else listed(relation["relation"])
            if any(has(kind, item, target, second, relation, view) for kind in kinds):
                found.append(target.name if target else "table")
    return found


def has(kind, item, target, second, relation, view) -> bool:
    names = (item.name, target and target.name, second and second.name)
    if kind != "distance" and not view.related(kind, *names):
        return False
    if "distance_cm" not in relation:
        return True
    return any(within(distance, relation["distance_cm"]) for distance in view.distances_cm(kind, names[0], names[1]))


def arrangement_complaints(group, cast, view) -> list:
    names = [item.name for item in cast.of({k: v for k, v in group.items() if k in ("category", "size", *QUALIFIERS)})]
    low, high = bounds(group["count"])
    for kind in listed(group["kind"]):
        for members, gap_cm in view.arranged(kind, names):
            spaced = "gap_cm" not in group or gap_cm is not None and within(gap_cm, group["gap_cm"])
            if low <= len(members) <= high and spaced:
                return []
    gap = f" with gaps of {group['gap_cm'][0]} to {group['gap_cm'][1]} cm" if "gap_cm" in group else ""
    return [f"no {'/'.join(listed(group['kind']))} of {in_words(group)}{gap}"]


def table_complaints(asked, view) -> list:
    wrong = []
    if "shape" in asked and view.table.get("shape") != asked["shape"]:
        wrong.append(f"a {view.table.get('shape')} table instead of a {asked['shape']} one")
    # A finished scene does not tell the material of its table.
    if "material" in asked and "material" in view.table and view.table["material"] not in WOODS:
        wrong.append(f"a table of {view.table['material']} instead of {asked['material']}")
    if "size_cm" in asked and not is_size(view.table.get("size_cm") or (0, 0, 0), asked["size_cm"]):
        wrong.append(f"a table of {view.table.get('size_cm')} cm")
    return wrong


def is_reported(asked, view) -> bool:
    """A part of the text that has no effect is reported, or stands on the table as what the entry allows."""
    for text, reason in view.reported:
        if any(overlap(text, words) for words in listed(asked["text"])):
            if "reason" not in asked or reason in listed(asked["reason"]):
                return True
    return any(plays_reported(item, asked) for item in view.objects if item.requested)


def is_reported_stand_in(item, expected) -> bool:
    return any(plays_reported(item, asked) for asked in expected.get("reported", ()))


def plays_reported(item, asked) -> bool:
    if item.category in asked.get("or_category", ()):
        return True
    heads = [words.split()[-1] for words in listed(asked["text"])]
    label = item.label.lower().split()
    return bool(asked.get("or_stand_in")) and item.stand_in and any(head in label for head in heads)


def overlap(reported: str, asked: str) -> bool:
    a, b = (set(re.findall(r"\w+", words.lower())) for words in (reported, asked))
    return bool(a) and (a <= b or b <= a)


def is_correction(asked, pair) -> bool:
    before, after = (words.lower() for words in pair)
    return asked["from"] in before.split() and (asked["to"] in after or after in asked["to"])


def fits(item, entry) -> bool:
    if item.category not in listed(entry["category"]):
        return False
    position = entry.get("position_cm", {})
    tests = (
        "color" not in entry or (item.color is not None and is_color(item.color, entry["color"])),
        "material" not in entry or item.material == entry["material"],
        "size_cm" not in entry or is_size(item.size_cm, entry["size_cm"]),
        "pose" not in entry or item.pose in listed(entry["pose"]),
        "state" not in entry or item.state == entry["state"],
        "mass_kg" not in entry or (item.mass_kg is not None and within(item.mass_kg, entry["mass_kg"])),
        "yaw_deg" not in entry or (item.yaw_deg is not None and is_angle(item.yaw_deg, entry["yaw_deg"])),
        all(item.position_cm is not None and within(item.position_cm["xy".index(k)], r) for k, r in position.items()),
    )
    return all(tests)


def is_size(size_cm, asked) -> bool:
    x, y, z = size_cm
    found = {"x": x, "y": y, "z": z, "height": z, "diameter": max(x, y), "length": max(x, y)}
    return all(within(found[axis], limits) for axis, limits in asked.items())


def is_angle(degrees, limits) -> bool:
    return any(within(degrees + turn, limits) for turn in (-360, 0, 360))


def within(value, limits) -> bool:
    return limits[0] - 1e-6 <= value <= limits[1] + 1e-6


def matching(partners) -> dict:
    """Target by subject, one of its own for as many subjects as possible."""
    of_target = {}

    def place(subject, tried) -> bool:
        for target in partners[subject]:
            if target not in tried:
                tried.add(target)
                if target not in of_target or place(of_target[target], tried):
                    of_target[target] = subject
                    return True
        return False

    for subject in partners:
        place(subject, set())
    return {subject: target for target, subject in of_target.items()}


def qualifiers(entry) -> list:
    return [name for name in (*QUALIFIERS, "size") if name in entry]


def listed(value) -> list:
    return list(value) if isinstance(value, (list, tuple)) else [value]


def bounds(count) -> tuple:
    return (count[0], count[1]) if isinstance(count, (list, tuple)) else (count, count)


def in_words(reference) -> str:
    """A reference in words."""
    if reference is None:
        return ""
    if not isinstance(reference, dict):
        return "/".join(listed(reference))
    words = [str(reference[name]) for name in ("size", "color", "material", "state", "pose") if name in reference]
    return " ".join(words + ["/".join(listed(reference["category"]))])
