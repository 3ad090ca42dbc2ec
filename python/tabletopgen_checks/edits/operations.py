"""Plans operations for a scene. A planner remembers what its operations are about, so that a later one of a chain does
not undo an earlier one."""

from tabletopgen_checks.catalog import CATEGORIES
from tabletopgen_checks.edits.comparison import Operation
from tabletopgen_checks.edits.places import Choices, has_own_label, is_flat, is_upright
from tabletopgen_checks.scene.scene import TABLE

# Categories to add, with the words of a text.
ADDED = {
    "mug": "a mug", "book": "a book", "apple": "an apple", "candle": "a candle", "stapler": "a stapler",
    "salt_shaker": "a salt shaker", "bowl": "a bowl", "notebook": "a notebook", "jar": "a jar", "orange": "an orange",
    "soda_can": "a soda can", "coaster": "a coaster", "pencil": "a pencil", "desk_clock": "a desk clock",
    "calculator": "a calculator",
}
SEVERAL = {"apple": "apple", "dice": "dice", "marker": "marker", "candle": "candle", "coaster": "coaster"}
COLORED = ["mug", "book", "candle", "notebook", "vase", "bowl"]
COLORS = ["red", "blue", "green", "yellow", "white", "black"]
# What is small enough for a container.
SMALL = {"dice": "a die", "egg": "an egg", "lemon": "a lemon", "apple": "an apple"}
THEMES = ["office desk", "dining table", "workbench"]
METALS = ("steel", "aluminum", "brass", "cast_iron", "copper")
TABLE_MATERIALS = ["oak", "walnut", "marble", "glass", "steel"]


class Planner(Choices):
    """One method per operation; each gives an `Operation`, or `None` where the scene does not have what it takes."""

    def plan(self, kind: str):
        """One operation of that kind."""
        return PLANS[kind](self)

    def add(self):
        dice = self.chance.random()
        if dice < 0.25 and (made := self.add_hosted()):
            return made
        if dice < 0.4:
            return self.add_several()
        is_colored = dice < 0.6
        categories = self.fresh(COLORED if is_colored else ADDED)
        if not categories:
            return None
        category = categories[0]
        color = self.chance.choice(COLORS) if is_colored else None
        phrase = f"a {color} {CATEGORIES[category].label}" if color else ADDED[category]
        where, others = self.place() if self.chance.random() < 0.8 else (None, [])
        return self.added(category, 1, phrase, where, others, color)

    def add_hosted(self):
        for category in self.fresh(SMALL):
            size_m = CATEGORIES[category].high_m
            if made := self.inside(size_m) or self.upon(size_m):
                return self.added(category, 1, SMALL[category], *made)
        return None

    def add_several(self):
        categories = self.fresh(SEVERAL)
        if not categories:
            return None
        count = self.chance.randint(2, 3)
        where, others = self.region(None) if self.chance.random() < 0.5 else (None, [])
        label = CATEGORIES[categories[0]].label
        article = "an" if label[0] in "aeiou" else "a"
        return self.added(categories[0], count, f"{article} {label}", where, others)

    def added(self, category, count, phrase, where, others, color=None):
        wire = {"op": "add", "object": phrase}
        wire |= {"count": count} if count > 1 else {}
        wire |= {"where": where} if where else {}
        self.categories.add(category)
        for other in others:
            self.keep(other)
        return Operation(wire, [], [other.name for other in others], (category,), count, color)

    def remove(self):
        if len(self.scene.bodies) - len(self.used) < 3:
            return None
        if self.chance.random() < 0.25 and not self.used and (made := self.remove_all()):
            return made
        # What carries others is the interesting case.
        for body in sorted(self.targets(), key=lambda body: not self.scene.contents(body.name)):
            wire: dict = {"op": "remove", "target": self.refer(body)}
            if self.scene.contents(body.name) and self.chance.random() < 0.5:
                wire["with_contents"] = True
            self.take(body)
            return Operation(wire, [body.name])
        return None

    def remove_all(self):
        """All of a label, by a phrase in the plural."""
        for body in self.targets(lambda body: body.category in CATEGORIES and not self.scene.contents(body.name)):
            alike = [other for other in self.scene.bodies.values() if other.label == body.label]
            if has_own_label(body) and 2 <= len(alike) < len(self.scene.bodies) - 1 and not any(
                self.scene.contents(other.name) for other in alike
            ):
                for other in alike:
                    self.take(other)
                wire = {"op": "remove", "target": f"all {CATEGORIES[body.category].plural}"}
                return Operation(wire, [other.name for other in alike])
        return None

    def replace(self):
        for body in self.targets(lambda body: not self.scene.contents(body.name) and is_upright(body)):
            wide = max(body.size_m[:2])
            # Not wider than what it replaces, so that there is room on its supporter.
            fitting = [name for name in self.fresh(ADDED) if max(CATEGORIES[name].high_m[:2]) <= max(1.1 * wide, 0.1)]
            if fitting:
                wire = {"op": "replace", "target": self.refer(body), "object": ADDED[fitting[0]]}
                self.take(body)
                self.categories.add(fitting[0])
                return Operation(wire, [body.name], [], (fitting[0],), 1)
        return None

    def move(self):
        # Every other time something that carries others.
        found = self.targets()
        if self.chance.random() < 0.5:
            found.sort(key=lambda body: not self.scene.contents(body.name))
        for body in found[:1]:
            self.take(body)
            made = None
            if not self.scene.contents(body.name) and self.chance.random() < 0.4:
                made = self.inside(body.size_m) or self.upon(body.size_m)
            where, others = made or self.place(body)
            for other in others:
                self.keep(other)
            wire = {"op": "move", "target": self.refer(body), "where": where}
            return Operation(wire, [body.name], [other.name for other in others])
        return None

    def rotate(self):
        found = self.targets(lambda body: body.yaw_rad is not None and body.symmetry_order != 0)
        for body in found[:1]:
            self.take(body)
            wire, others = {"op": "rotate", "target": self.refer(body)}, []
            kind = self.chance.choice(["by_rad", "to_rad", "facing"])
            anchors = self.anchors(body)
            if kind == "facing" and anchors and not self.scene.supporters(body.name):
                others = anchors[:1]
                wire["facing"] = self.refer(others[0])
                self.keep(others[0])
            elif kind == "to_rad":
                wire["to_rad"] = round(self.chance.uniform(-3.1, 3.1), 2)
            else:
                wire["by_rad"] = round(self.chance.choice([-1, 1]) * self.chance.uniform(0.3, 1.6), 2)
            return Operation(wire, [body.name], [other.name for other in others])
        return None

    def resize(self):
        for body in self.targets(lambda body: not self.scene.contents(body.name)):
            factors = [factor for factor in (0.8, 0.85, 0.9, 1.1, 1.15, 1.25) if is_plausible(body, factor)]
            if factors:
                self.take(body)
                wire = {"op": "resize", "target": self.refer(body), "factor": self.chance.choice(factors)}
                return Operation(wire, [body.name])
        return None

    def recolor(self):
        for body in self.targets()[:1]:
            self.take(body)
            wire = {"op": "recolor", "target": self.refer(body)}
            kind = self.chance.choice(["color", "color", "material", "both"])
            if kind != "material":
                wire["color"] = self.chance.choice(COLORS)
            if kind != "color":
                # Another material than that of the category, so that the mass changes.
                substance = CATEGORIES[body.category].substance if body.category in CATEGORIES else ""
                wire["material"] = "wood" if substance in METALS else "steel"
            return Operation(wire, [body.name], color=wire.get("color"))
        return None

    def relabel(self):
        for body in self.free()[:1]:
            self.used.add(body.name)
            label = self.chance.choice(["keepsake", "sample", "exhibit", "souvenir"])
            return Operation({"op": "relabel", "target": self.refer(body), "label": label}, [body.name])
        return None

    def restyle_table(self):
        if self.is_table_used:
            return None
        self.is_table_used = True
        wire = {"op": "restyle_table"}
        if self.chance.random() < 0.6:
            wire["material"] = self.chance.choice(TABLE_MATERIALS)
        else:
            wire["color"] = self.chance.choice(COLORS)
        return Operation(wire)

    def stack(self):
        flat = self.targets(lambda body: is_flat(body) and not self.scene.contents(body.name) and body.parent == TABLE)
        for body in flat:
            alike = [other for other in self.scene.bodies.values() if other.label == body.label]
            are_flat = len(alike) >= 2 and all(other in flat for other in alike)
            if has_own_label(body) and are_flat and self.chance.random() < 0.7:
                for other in alike:
                    self.take(other)
                wire = {"op": "stack", "targets": [f"the {CATEGORIES[body.category].plural}"]}
                return Operation(wire, [other.name for other in alike])
        # The widest at the bottom.
        if len(flat) >= 2:
            two = sorted(flat[:2], key=lambda body: -min(body.size_m[:2]))
            words = [self.refer(body) for body in two]
            for body in two:
                self.take(body)
            return Operation({"op": "stack", "targets": words}, [body.name for body in two])
        return None

    def tidy(self):
        if self.used or self.kept:
            return None
        self.is_tidied = True
        return Operation({"op": "tidy"})

    def clutter(self):
        wire = {"op": "clutter", "count": self.chance.randint(1, 3)}
        if self.chance.random() < 0.5:
            wire["theme"] = self.chance.choice(THEMES)
        return Operation(wire, count=wire["count"])


def is_plausible(body, factor: float) -> bool:
    """Whether the catalog has the category in that size; an unknown category may have any."""
    if body.category not in CATEGORIES:
        return True
    low, high = CATEGORIES[body.category].low_m, CATEGORIES[body.category].high_m
    return max(low) <= factor * max(body.size_m) <= max(high)


PLANS = {
    "add": Planner.add, "remove": Planner.remove, "replace": Planner.replace, "move": Planner.move,
    "rotate": Planner.rotate, "resize": Planner.resize, "recolor": Planner.recolor, "relabel": Planner.relabel,
    "restyle_table": Planner.restyle_table, "stack": Planner.stack, "tidy": Planner.tidy, "clutter": Planner.clutter,
}
