"""Which objects of a scene an edit may be about, the words for them, and places to put them."""

from tabletopgen_checks.catalog import CATEGORIES
from tabletopgen_checks.scene.polygons import bounds, distance_m, outline_depth_m
from tabletopgen_checks.scene.relations import DIRECTIONS, REGIONS
from tabletopgen_checks.scene.scene import TABLE

ORDINALS = ["first", "second", "third", "fourth"]
# Neighbors of an ordinal are this far apart or more, so that the order is clear.
ORDINAL_GAP_M = 0.03


class Choices:
    """What a scene offers, less what the operations planned so far are about."""

    def __init__(self, parent, chance):
        self.parent, self.scene, self.chance = parent, parent.scene, chance
        # Objects that are moved, removed or changed, and those that others are placed by.
        self.used, self.kept, self.categories = set(), set(), set()
        self.is_table_used = self.is_tidied = False

    # What there is to choose from.

    def free(self, accepts=lambda body: True) -> list:
        """Bodies that no operation is about so far, in any order."""
        names = sorted(set(self.scene.bodies) - self.used - self.kept)
        found = [self.scene.bodies[name] for name in names if accepts(self.scene.bodies[name])]
        self.chance.shuffle(found)
        return found

    def targets(self, accepts=lambda body: True) -> list:
        """Free bodies whose contents and supporters are free as well."""
        def is_apart(body):
            related = {*self.scene.contents(body.name), *self.scene.supporters(body.name)}
            return not related & (self.used | self.kept)

        return self.free(lambda body: accepts(body) and is_apart(body))

    def take(self, body):
        self.used |= {body.name, *self.scene.contents(body.name)}

    def keep(self, body):
        self.kept |= {body.name, *self.scene.supporters(body.name)}

    def refer(self, body) -> str:
        """The name, or a phrase that fits this object only."""
        phrases = self.phrases(body)
        return self.chance.choice(phrases) if phrases and self.chance.random() < 0.5 else body.name

    def phrases(self, body) -> list:
        alike = [other for other in self.scene.bodies.values() if other.label == body.label]
        # A label that is a word of another one: "knife" of "utility knife".
        words = [other.label for other in self.scene.bodies.values() if other.label != body.label]
        is_inside = any(body.label in label.split() or label in body.label.split() for label in words)
        if is_inside or not has_own_label(body):
            return []
        # A chain may have added or removed one of the label.
        if body.category in self.categories or any(other.name in self.used for other in alike if other is not body):
            return []
        if len(alike) == 1:
            return [f"the {body.label}"]
        found, color = [], self.parent.colors.get(body.name)
        if color and sum(self.parent.colors.get(other.name) == color for other in alike) == 1:
            if all(other.name in self.parent.colors for other in alike):
                found.append(f"the {color} {body.label}")
        row = sorted(alike, key=lambda other: other.center[0])
        gaps = [b.center[0] - a.center[0] for a, b in zip(row, row[1:])]
        if not self.is_tidied and min(gaps) >= ORDINAL_GAP_M and len(row) <= len(ORDINALS):
            found.append(f"the {ORDINALS[row.index(body)]} {body.label} from the left")
            found.append(f"the {ORDINALS[len(row) - 1 - row.index(body)]} {body.label} from the right")
        return found

    def fresh(self, categories) -> list:
        """Categories that the scene does not have and no operation added, in any order."""
        there = {body.category for body in self.scene.bodies.values()} | self.categories
        # Nor one whose label is a word of the label of another object.
        labels = {word for body in self.scene.bodies.values() for word in body.label.split()}
        found = sorted(name for name in categories if name not in there and CATEGORIES[name].label not in labels)
        self.chance.shuffle(found)
        return found

    # The places.

    def place(self, body=None):
        """(where, referred bodies) beside an object, in a region, at coordinates, or at a distance from an edge."""
        kinds = [self.beside, self.beside, self.region, self.position, self.offset, self.edge, self.between]
        self.chance.shuffle(kinds)
        for kind in kinds:
            if made := kind(body):
                return made
        return self.region(body)

    def anchors(self, body) -> list:
        """Objects on the table that a place may refer to."""
        inner = {body.name, *self.scene.contents(body.name)} if body is not None else set()
        names = sorted(set(self.scene.bodies) - self.used - inner)
        found = [self.scene.bodies[name] for name in names if self.scene.bodies[name].parent == TABLE]
        self.chance.shuffle(found)
        return found

    def beside(self, body):
        if anchors := self.anchors(body):
            where = {"relation": self.chance.choice([*DIRECTIONS, "next_to"]), "target": self.refer(anchors[0])}
            if where["relation"] != "next_to" and self.chance.random() < 0.4:
                where["distance_m"] = self.chance.choice([0.03, 0.05, 0.1])
            return where, anchors[:1]
        return None

    def region(self, body):
        return {"relation": self.chance.choice(sorted(REGIONS))}, []

    def position(self, body):
        low, high = bounds(self.scene.outline)
        at = [round(0.5 * (low[k] + high[k]) + self.chance.uniform(-0.3, 0.3) * (high[k] - low[k]), 3) for k in (0, 1)]
        where = {"position_m": at}
        if self.chance.random() < 0.5:
            where["yaw_rad"] = round(self.chance.uniform(-3.1, 3.1), 2)
        return where, []

    def offset(self, body):
        """A few centimeters from where it is, on the table."""
        if body is None or body.parent != TABLE:
            return None
        by = [round(self.chance.choice([-1, 1]) * self.chance.uniform(0.03, 0.12), 3) for _ in (0, 1)]
        center = [body.center[k] + by[k] for k in (0, 1)]
        return ({"offset_m": by}, []) if outline_depth_m(self.scene.outline, center) > 0.1 else None

    def edge(self, body):
        if self.scene.table["shape"] not in ("rectangular", "square"):
            return None
        edge = self.chance.choice(["from_left_edge", "from_right_edge", "from_front_edge", "from_back_edge"])
        return {"relation": edge, "distance_m": self.chance.choice([0.02, 0.05, 0.1])}, []

    def between(self, body):
        anchors = self.anchors(body)
        size_m = max(body.size_m[:2]) if body is not None else 0.12
        for k, first in enumerate(anchors):
            for second in anchors[k + 1 :]:
                if distance_m(first.footprint, second.footprint) >= size_m + 0.04:
                    where = {"relation": "between", "target": self.refer(first), "second_target": self.refer(second)}
                    return where, [first, second]
        return None

    def inside(self, size_m):
        """In an object that is wide enough."""
        def holds_it(body):
            can = has_use(body, "container")
            room = 0.55 * min(body.size_m[:2])
            return can and body.category != "wine_glass" and max(size_m) <= room and is_upright(body)

        return self.hosted("in", self.hosts(holds_it))

    def upon(self, size_m):
        def carries_it(body):
            fits = all(side <= wide for side, wide in zip(sorted(size_m[:2]), sorted(body.size_m[:2])))
            return fits and is_flat(body)

        return self.hosted("on", self.hosts(carries_it))

    def hosts(self, accepts) -> list:
        names = sorted(set(self.scene.bodies) - self.used)
        found = [self.scene.bodies[name] for name in names if accepts(self.scene.bodies[name])]
        self.chance.shuffle(found)
        return found

    def hosted(self, relation, hosts):
        return ({"relation": relation, "target": self.refer(hosts[0])}, hosts[:1]) if hosts else None


def has_use(body, use: str) -> bool:
    return body.category in CATEGORIES and use in CATEGORIES[body.category].affordances


def has_own_label(body) -> bool:
    """Whether its label is the word of the catalog: "glass of water" and "balls of yarn" are others."""
    return body.category in CATEGORIES and body.label == CATEGORIES[body.category].label


def is_flat(body) -> bool:
    """Wide, low and with a level top: a book, a plate, a box."""
    return has_use(body, "support") and is_upright(body) and body.size_m[2] <= 0.6 * min(body.size_m[:2])


def is_upright(body) -> bool:
    x, y = body.pose[1][0], body.pose[1][1]
    return 1 - 2 * (x * x + y * y) > 0.99
