"""Whether the goal of a task is right, and whether the scene is still before it. Predicates are those of
crates/base/scene/src/text_account.rs."""

from tabletopgen_checks.language.expectations import bounds, in_words, listed

SYMMETRIC = ("next_to", "swapped")
INVERSE = {"left_of": "right_of", "right_of": "left_of", "in_front_of": "behind", "behind": "in_front_of"}
SAME = {"on": ("stacked_on",), "stacked_on": ("on",)}
# Steps on the way to an end state; they may be stated beside it.
STEPS = ("lifted", "moved", "out_of", "off", "opened", "away_from")
# Conditions on a change, which no start satisfies.
CHANGES = ("away_from", "swapped", "lifted", "rotated", "moved", "poured_into", "used_on", "pressed")
# Categories that are open unless a text says otherwise.
OPEN = ("laptop",)
POSES = ("upright", "lying_on_side", "upside_down")


def goal_complaints(expected: list, cast, view) -> list:
    """What the goal has too little or too much."""
    wrong, used = [], []
    for asked in expected:
        subjects = cast.of(asked["object"])
        held = []
        for subject in subjects:
            stated = [predicate for predicate in view.goal if states(predicate, asked, subject, cast)]
            used += stated
            held += [subject] if stated else []
        low, high = bounds(asked.get("count", max(1, len(subjects))))
        if not low <= len(held) <= high:
            kinds = "/".join(listed(asked["predicate"]))
            words = f"{kinds} {in_words(asked['object'])} {in_words(asked.get('target'))}".strip()
            wrong.append(f"goal {words}: stated for {len(held)} of {len(subjects)}")
    with_goal = {name for asked in expected for name in names_of(asked, cast)}
    for predicate in view.goal:
        is_step = predicate["predicate"] in STEPS and predicate["object"] in with_goal
        if predicate not in used and not is_step:
            words = f"{predicate['predicate']} {predicate['object']} {predicate.get('target') or ''}".rstrip()
            wrong.append(f"goal {words} is not asked for")
    return wrong


def names_of(asked, cast) -> list:
    return [item.name for key in ("object", "target") if key in asked for item in cast.of(asked[key])]


def states(predicate: dict, asked: dict, subject, cast) -> bool:
    """Whether a stated predicate is an expected one of a subject."""
    kind, name, to = predicate["predicate"], predicate["object"], predicate.get("target")
    targets = {item.name for item in cast.of(asked["target"])} if "target" in asked else None
    kinds = {same for wanted in listed(asked["predicate"]) for same in (wanted, *SAME.get(wanted, ()))}

    def is_target(found) -> bool:
        if targets is None:
            return found is None or kind in CHANGES
        return found in targets or (found is None and asked.get("target_optional", False))

    if kind in kinds and name == subject.name and is_target(to):
        if "second" not in asked:
            return True
        return predicate.get("second_target") in {item.name for item in cast.of(asked["second"])} - {to}
    turned = {INVERSE[wanted] for wanted in kinds if wanted in INVERSE} | kinds & set(SYMMETRIC)
    return kind in turned and to == subject.name and is_target(name)


def is_satisfied(goal: list, view) -> bool:
    """Whether every predicate holds already."""
    return bool(goal) and all(holds(predicate, view) for predicate in goal)


def holds(predicate: dict, view) -> bool:
    kind, name = predicate["predicate"], predicate["object"]
    target, second = predicate.get("target"), predicate.get("second_target")
    if kind in CHANGES:
        return False
    item = view.by_name.get(name)
    if item is None:
        return False
    if kind in POSES:
        return item.pose == kind
    if kind in ("opened", "closed"):
        usual = "open" if item.category in OPEN else "closed"
        return (item.state or usual) == {"opened": "open", "closed": "closed"}[kind]
    if kind == "out_of":
        return not view.related("in", name, target)
    if kind == "off":
        return not view.related("on", name, target)
    return view.related(kind, name, target, second)
