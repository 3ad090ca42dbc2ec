"""Whether a scene is what a list of operations makes of its parent: the independent judge of edits.

The semantics are those of the doc comments of the operations: each does what it states, and everything else keeps its
exact pose unless the report lists its movement with a cause. Statements about single operations are in
`edit_statements.py`; here is what holds for the edit as a whole.
"""

from dataclasses import dataclass, field

from tabletopgen_checks.edits.statements import Context, statement
from tabletopgen_checks.scene.scene import Body, Scene, angle_rad, moved_m

# Operations that may move their targets.
MOVING = ("move", "rotate", "stack", "tidy", "resize")
# Those that carry what stands on or in their targets.
CARRYING = ("move", "rotate", "stack", "tidy")
# A reported movement agrees with the poses up to this.
REPORTED_M, REPORTED_RAD = 0.001, 0.01
KEPT = ("size_m", "mass_kg", "label", "category", "friction")


@dataclass
class Operation:
    """An operation in its wire form, and what its generator knows: which objects its words mean."""

    wire: dict
    # Names in the parent; `+k` are the objects that operation k adds.
    targets: list = field(default_factory=list)
    # The objects of a place, or the one to face.
    references: list = field(default_factory=list)
    # Categories that added objects may have; any where it is empty.
    categories: tuple = ()
    count: int = 0
    color: str | None = None

    @property
    def name(self) -> str:
        return self.wire["op"]


def complaints(parent: Scene, child: Scene, operations: list, document: dict | None = None) -> list:
    """What is not as stated; empty where the edit is right. `document` is what the command printed."""
    found = Comparison(parent, child, operations)
    wrong = found.wrong + found.certificate(document) + found.lineage() + found.unmentioned(document)
    for index, operation in enumerate(operations):
        later = found.later(index)
        earlier = set().union(*(found.touched(k) for k in range(index)))
        superseded = bool(found.about(index) & later)
        context = Context(parent, found.child_bodies, child, found.added, earlier, later, superseded)
        words_of = statement(operation, index, context)
        wrong += [f"operation {index + 1} ({operation.name}): {words}" for words in words_of]
    return wrong


class Comparison:
    """Which bodies of the child are which of the parent, and which are new."""

    def __init__(self, parent: Scene, child: Scene, operations: list):
        self.parent, self.child, self.operations, self.wrong = parent, child, operations, []
        self.child_bodies = dict(child.bodies)
        self.renames()
        self.gone, self.added = set(), {}
        self.removals()
        self.match()

    def renames(self):
        """A new label may come with a new name: the body is the one at the exact pose."""
        for operation in self.operations:
            if operation.name == "relabel":
                for name in set(operation.targets) & set(self.parent.bodies) - set(self.child_bodies):
                    same = [other for other, body in self.child_bodies.items()
                            if other not in self.parent.bodies and body.pose == self.parent.bodies[name].pose]
                    if same:
                        self.child_bodies[name] = self.child_bodies.pop(same[0])

    def removals(self):
        for operation in self.operations:
            if operation.name in ("remove", "replace"):
                for name in operation.targets:
                    self.gone.add(name)
                    if operation.wire.get("with_contents") and name in self.parent.bodies:
                        self.gone.update(self.parent.contents(name))

    def match(self):
        parents, children = set(self.parent.bodies), set(self.child_bodies)
        # A replacement may have the name of what it replaces; it is another object where the hulls differ.
        replaced = {name for operation in self.operations if operation.name == "replace" for name in operation.targets}
        renewed = {name for name in replaced & children & parents
                   if self.child_bodies[name].local_hulls != self.parent.bodies[name].local_hulls}
        vanished = parents - children | renewed
        free = sorted(children - parents | renewed)
        for name in sorted(vanished - self.gone):
            self.wrong.append(f"{name} vanished")
        for name in sorted(self.gone & parents - vanished):
            self.wrong.append(f"{name} is still there")
        # Operations that say what they add choose before those that do not.
        order = sorted(range(len(self.operations)), key=lambda k: not self.operations[k].categories)
        for k in order:
            operation = self.operations[k]
            if operation.count and f"+{k}" not in self.gone:
                fitting = [name for name in free if self.fits(name, operation)][: operation.count]
                self.added[k] = fitting
                free = [name for name in free if name not in fitting]
                if len(fitting) != operation.count:
                    counted = f"{len(fitting)} {' or '.join(operation.categories) or 'objects'}"
                    self.wrong.append(f"operation {k + 1} ({operation.name}) added {counted} instead of {operation.count}")
        for name in free:
            self.wrong.append(f"{name} ({self.child_bodies[name].category}) appeared, and no operation asks for it")

    def fits(self, name: str, operation: Operation) -> bool:
        return not operation.categories or self.child_bodies[name].category in operation.categories

    def names(self, words: list) -> list:
        """The bodies of the child that targets mean."""
        found = []
        for name in words:
            found += self.added.get(int(name[1:]), []) if name.startswith("+") else [name]
        return found

    def touched(self, index: int) -> set:
        """Everything that an operation may move without a report."""
        operation = self.operations[index]
        if operation.name == "tidy":
            return set(self.child_bodies)
        # A new material may settle by a hair.
        is_moving = operation.name in MOVING or (operation.name == "recolor" and operation.wire.get("material"))
        found = set(self.names(operation.targets)) if is_moving else set()
        found |= set(self.added.get(index, []))
        if operation.name in CARRYING:
            for scene in (self.parent, self.child):
                found |= {inner for name in list(found) if name in scene.bodies for inner in scene.contents(name)}
        return found

    def later(self, index: int) -> set:
        """What later operations move or remove."""
        found = set()
        for later in range(index + 1, len(self.operations)):
            operation = self.operations[later]
            found |= self.touched(later) | set(operation.targets if operation.name in ("remove", "replace") else ())
        return found

    def about(self, index: int) -> set:
        """The objects whose poses decide whether an operation did what it states."""
        operation = self.operations[index]
        if operation.name == "tidy":
            return set(self.child_bodies)
        words = operation.targets + operation.references
        return set(self.names(words)) | set(words) | set(self.added.get(index, []))

    def unmentioned(self, document) -> list:
        """Bodies that no operation is about: the same to the last bit, or a reported movement."""
        reported, wrong = self.reported_movements(document)
        touched = set().union(*(self.touched(k) for k in range(len(self.operations))))
        changed = {name for op in self.operations if op.name in ("resize", "recolor", "relabel") for name in op.targets}
        for name, before in self.parent.bodies.items():
            after = self.child_bodies.get(name)
            if after is None or name in self.gone:
                continue
            if name not in changed:
                wrong += kept_complaints(before, after)
            elif not any(op.name == "resize" and name in op.targets for op in self.operations):
                if after.local_hulls != before.local_hulls:
                    wrong.append(f"the shape of {name} changed")
            if name in touched:
                continue
            if before.pose != after.pose:
                wrong += movement_complaints(before, after, reported.get(name))
            if before.parent != after.parent and name not in reported and before.parent not in self.gone:
                wrong.append(f"{name} stands on {after.parent}, before on {before.parent}, and the report is silent")
        return wrong

    def reported_movements(self, document) -> tuple:
        """(name to movement, what is wrong with the lists)."""
        printed = document or {}
        # The command prints the account of the edit with the summary of the scene.
        written = self.child.report.get("edit") or self.child.scene.get("edit")
        accounts = [written, printed.get("edit") or (printed.get("summary") or {}).get("edit")]
        lists = [(account or {}).get("moved") or [] for account in accounts]
        wrong = []
        if document is not None and sorted(map(str, lists[0])) != sorted(map(str, lists[1])):
            wrong.append("the bundle and the printed document list different movements")
        return {movement["name"]: movement for movement in lists[0]}, wrong

    def certificate(self, document) -> list:
        wrong = []
        for what, content in (("report.json", self.child.report), ("the printed document", document)):
            if content is None:
                continue
            if content.get("verdict") != "pass":
                wrong.append(f"the verdict of {what} is {content.get('verdict')}: {'; '.join(reasons(content))}")
            if (content.get("metrics") or {}).get("col_s") != 0:
                wrong.append(f"col_s of {what} is {(content.get('metrics') or {}).get('col_s')}")
        return wrong

    def lineage(self) -> list:
        source = self.child.scene.get("request", {}).get("input", {})
        if source.get("kind") != "edit" or source.get("parent") != self.parent.id:
            return [f"the scene does not name its parent {self.parent.id}: {source}"]
        count, asked = len(source.get("operations", [])), len(self.operations)
        return [] if count == asked else [f"the scene names {count} operations of {asked}"]


def reasons(content: dict) -> list:
    return [reason["sentence"] if isinstance(reason, dict) else str(reason) for reason in content.get("reasons", [])]


def kept_complaints(before: Body, after: Body) -> list:
    wrong = [f"{key} of {before.name} changed from {before.instance[key]} to {after.instance[key]}"
             for key in KEPT if before.instance[key] != after.instance[key]]
    if before.local_hulls != after.local_hulls:
        wrong.append(f"the shape of {before.name} changed")
    return wrong


def movement_complaints(before: Body, after: Body, reported: dict | None) -> list:
    moved, turned = moved_m(before, after), angle_rad(before, after)
    words = f"{before.name} moved by {1e3 * moved:.3g} mm and {turned:.2g} rad"
    if reported is None:
        return [f"{words}, and the report is silent"]
    if not str(reported.get("cause") or "").strip():
        return [f"{words}, and the report gives no cause"]
    agrees = abs(reported["distance_m"] - moved) <= REPORTED_M and abs(reported["angle_rad"] - turned) <= REPORTED_RAD
    if not agrees:
        return [f"{words}; the report says {reported['distance_m']} m and {reported['angle_rad']} rad"]
    return []
