"""Edits to ask for: operations that fit a scene, chains of five, and what must be refused; a seed decides all."""

import random
from collections import Counter
from dataclasses import dataclass

from tabletopgen_checks.catalog import CATEGORIES
from tabletopgen_checks.edits.comparison import Operation
from tabletopgen_checks.edits.operations import PLANS, Planner
from tabletopgen_checks.edits.refused import REFUSED

CHAIN = 5
# Of twenty edits so many must be refused, and so many are chains; the others are single operations.
CYCLE, REFUSALS, CHAINS = 20, 3, 4


@dataclass
class Case:
    name: str
    parent: str
    seed: int
    operations: list
    # Empty, or the kind of refusal that is expected.
    refused: str = ""
    # Words that the message of the refusal must contain.
    names: tuple = ()

    def kind(self) -> str:
        return "chain" if len(self.operations) > 1 else self.operations[0].name

    def wire(self) -> list:
        return [operation.wire for operation in self.operations]


def cases(parents: list, count: int, seed: int) -> list:
    """`count` edits over the parents in turn. What is rare so far comes first, so that everything is covered."""
    chance, found = random.Random(f"edits {seed}"), []
    planned, refused, deck = Counter(), Counter(), []
    for number in range(count):
        if not deck:
            deck = [refusal] * REFUSALS + [chain] * CHAINS + [None] * (CYCLE - REFUSALS - CHAINS)
            chance.shuffle(deck)
        parent, plan = parents[number % len(parents)], deck.pop()
        made = plan(parent, refused, chance) if plan else None
        operations, why, names = made or (single(parent, planned, chance), "", ())
        if why:
            refused[why] += 1
        elif len(operations) == 1:
            planned[operations[0].name] += 1
        found.append(Case(f"edit_{number:03}", parent.name, chance.randrange(2**32), operations, why, names))
    return found


def rarest(kinds, counted: Counter, chance) -> list:
    """The kinds, those first that were planned the fewest times; equals in any order."""
    return sorted(kinds, key=lambda kind: (counted[kind], chance.random()))


def single(parent, counted, chance) -> list:
    for kind in rarest(PLANS, counted, chance):
        if operation := Planner(parent, chance).plan(kind):
            return [operation]
    raise AssertionError("restyling the table is always possible")


def chain(parent, _, chance):
    """Five operations about different objects; every other chain ends with something done to what it added."""
    planner, operations = Planner(parent, chance), []
    kinds = [kind for kind in PLANS if kind not in ("clutter",)] * 2
    chance.shuffle(kinds)
    # Tidying first, so that it does not undo what came before.
    kinds.sort(key=lambda kind: kind != "tidy" or chance.random() < 0.8)
    for kind in kinds:
        if len(operations) == CHAIN or (kind == "tidy" and operations):
            continue
        if operation := planner.plan(kind):
            operations.append(operation)
    if chance.random() < 0.5 and (last := follow_up(operations[: CHAIN - 1], parent, chance)):
        operations = operations[: CHAIN - 1] + [last]
    return (operations, "", ()) if len(operations) == CHAIN else None


def follow_up(operations, parent, chance):
    """An operation on an object that the chain added, by its label."""
    for index, operation in enumerate(operations):
        category = operation.categories[0] if operation.categories else None
        is_alone = category and not any(body.category == category for body in parent.scene.bodies.values())
        if operation.name == "add" and operation.count == 1 and is_alone:
            phrase = f"the {CATEGORIES[category].label}"
            wires = [
                {"op": "move", "target": phrase, "where": {"relation": chance.choice(["at_left", "at_right"])}},
                {"op": "rotate", "target": phrase, "to_rad": 0.0},
                {"op": "relabel", "target": phrase, "label": "keepsake"},
                {"op": "remove", "target": phrase},
            ]
            return Operation(chance.choice(wires), targets=[f"+{index}"])
    return None


def refusal(parent, counted, chance):
    for kind in rarest(REFUSED, counted, chance):
        if made := REFUSED[kind](parent, chance):
            operation, names = made
            return [operation], kind, names
    return None
