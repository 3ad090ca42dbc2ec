"""The report of a search for counterexamples: each failing scene, and the smallest change that fails on each axis."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from tabletopgen.env.counterexample_axes import AXES, Change
from tabletopgen.env.counterexample_scene import FAILS, REFUSED, SUCCEEDS, UNDONE
from tabletopgen.env.rollout_report import cell, counted, said

FORMAT = "tabletopgen-counterexamples/1"
# Failing scenes and draws that the text shows.
SHOWN = 20

Record = Mapping[str, Any]


def document_of(request: Mapping[str, Any], records: Sequence[Record], drawn: Sequence[Record]) -> dict[str, Any]:
    """The content of `counterexamples.json`."""
    failing = sorted((record for record in records if record["outcome"] == FAILS), key=lambda record: (record["distance"], record["scene"]))
    outcomes = Counter(record["outcome"] for record in records)
    return {
        "format": FORMAT,
        "policy": request["policy"],
        "vary": request["vary"],
        "asked": request["scenes"],
        "scenes": len(records),
        "outcomes": {outcome: outcomes[outcome] for outcome in (FAILS, SUCCEEDS, REFUSED, UNDONE)},
        "base_fails": bool(failing) and not failing[0]["change"],
        "smallest": {name: found for name in request["vary"] if (found := smallest(name, records)) is not None},
        "holds": {name: held for name in request["vary"] if (held := holding(name, records))},
        "combined": [counterexample(record) for record in failing if is_needed(record["change"], failing)],
        "counterexamples": [counterexample(record) for record in failing],
        "draws": drawn_document(drawn),
    }


def counterexample(record: Record) -> dict[str, Any]:
    """A failing scene, with its change in the units of its axes and the episode to replay."""
    base = {name: record[name] for name in ("scene", "distance", "change", "operations", "successes", "episodes")}
    values = {name: AXES[name].value(level) for name, level in record["change"].items()}
    base["base_moved_m"] = record.get("base_moved_m", 0.0)
    return {**base, "values": values, "rollout": f"scenes/{record['scene']:04d}/rollout", "record": record["record"]}


def smallest(name: str, records: Sequence[Record]) -> dict[str, Any] | None:
    """The smallest change of one axis alone that fails, and the largest one below it that does not."""
    alone = [record for record in records if list(record["change"]) == [name]]
    failing = min((one for one in alone if one["outcome"] == FAILS), key=lambda one: (one["distance"], one["scene"]), default=None)
    if failing is None:
        return None
    level = failing["change"][name]
    found = {"scene": failing["scene"], "level": level, "value": AXES[name].value(level), "distance": failing["distance"]}
    if isinstance(level, float):
        below = [one["change"][name] for one in alone if one["outcome"] == SUCCEEDS and 0 < one["change"][name] / level < 1]
        found["holds_at"] = AXES[name].value(max(below, key=abs, default=0.0))
    others = {one["change"][name] for one in alone if one["outcome"] == FAILS} - {level}
    return {**found, "also": sorted((AXES[name].value(other) for other in others), key=str)}


def holding(name: str, records: Sequence[Record]) -> list[float | str]:
    """Values of one axis alone at which the policy succeeds: the farthest to both sides, or all words."""
    levels = [one["change"][name] for one in records if list(one["change"]) == [name] and one["outcome"] == SUCCEEDS]
    words = sorted(level for level in levels if isinstance(level, str))
    numbers = [level for level in levels if isinstance(level, float)]
    ends = sorted({min([*numbers, 0.0]), max([*numbers, 0.0])} - {0.0})
    return [*words, *(AXES[name].value(level) for level in ends)]


def is_needed(change: Change, failing: Sequence[Record]) -> bool:
    """Whether a change has several parts, of which no smaller set failed, and no equal set with a smaller change."""
    names = set(change)
    own = sum(level**2 for level in change.values() if isinstance(level, float))
    if len(names) < 2 or any(set(one["change"]) < names and is_within(one["change"], change) for one in failing):
        return False
    alike = [one["change"] for one in failing if set(one["change"]) == names]
    return all(own <= sum(level**2 for level in one.values() if isinstance(level, float)) for one in alike)


def is_within(part: Change, change: Change) -> bool:
    """Whether a change goes as far as another, or farther, in each of the other's parts."""
    return all(
        part[name] == change[name] or (not isinstance(part[name], str) and 0 < float(part[name]) / float(change[name]) <= 1)
        for name in part
    )


def drawn_document(drawn: Sequence[Record]) -> dict[str, Any] | None:
    """Counts of the new starts, and those that fail."""
    if not drawn:
        return None
    failing = [{"episode": one["episode"], "start": one["start"], "reason": one["reason"]} for one in drawn if not one["success"]]
    return {**counted(drawn), "failing": failing}


def markdown(document: Mapping[str, Any]) -> str:
    """The content of `counterexamples.md`."""
    outcomes = document["outcomes"]
    lines = [f"# Counterexamples of `{document['policy']}`", ""]
    lines += [f"{document['scenes']} of {document['asked']} scenes were made. The policy failed in {outcomes[FAILS]} of them."]
    lines += [f"It succeeded in {outcomes[SUCCEEDS]}. Refused were {outcomes[REFUSED]}, which are not certified, or where the recorder"]
    lines += [f"cannot do the task. In {outcomes[UNDONE]}, the recorded actions failed in this simulation, too; they are not counted."]
    if document["base_fails"]:
        lines += ["", "**The policy fails in the scene as it is**, so no change is needed, and none was searched."]
    lines += smallest_lines(document)
    if document["combined"]:
        lines += ["", "## Changes that fail together", "", "Each part was needed: no scene with fewer of these changes failed.", ""]
        lines += scene_table(document["combined"])
    if document["counterexamples"]:
        lines += ["", "## Failing scenes", "", "The nearest to the base scene first. All are certified, and the recorder"]
        lines += ["does the task there.", ""]
        lines += scene_table(document["counterexamples"])
        lines += ["", "`python -m tabletopgen.env replay scenes/NNNN/rollout 0` repeats an episode; `scenes/NNNN/bundle` is the scene."]
        lines += ["The recorder chooses the place of the robot's base for each scene; where it moved, that may be the cause."]
    if (draws := document["draws"]) is not None:
        lines += ["", "## New starts in the scene as it is", "", f"{said(draws)}."]
        numbers = ", ".join(str(one["episode"]) for one in draws["failing"][:SHOWN])
        lines += ["", f"Failing episodes of `draws/rollout`, to replay: {numbers}."] if numbers else []
    return "\n".join(lines) + "\n"


def smallest_lines(document: Mapping[str, Any]) -> list[str]:
    """The table of axes."""
    lines = ["", "## The smallest change of each axis", ""]
    lines += ["| axis | fails at | holds just below | level | scene | also fails | farthest that holds |"]
    lines += ["| --- | --- | --- | ---: | ---: | --- | --- |"]
    for name in document["vary"]:
        found, holds = document["smallest"].get(name), ", ".join(map(short, document["holds"].get(name, []))) or "not tried"
        if found is None:
            lines.append(f"| {name} | no failure found | | | | | {holds} |")
            continue
        below = short(found["holds_at"]) if "holds_at" in found else ""
        also = ", ".join(map(short, found["also"]))
        lines.append(f"| {name} | {short(found['value'])} | {below} | {found['distance']:.3f} | {found['scene']} | {also} | {holds} |")
    return [
        *lines,
        "",
        "One axis was changed alone. Levels are shares of the way from the base scene to the end of an axis; of a color, the difference",
        "from that of the base scene as a share of white from black. No failure found is no proof that there is none.",
    ]


def scene_table(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    lines = ["| scene | distance | change | successes | base moved, m |", "| ---: | ---: | --- | ---: | ---: |"]
    for row in rows[:SHOWN]:
        change = ", ".join(f"{name} {short(value)}" for name, value in row["values"].items())
        counts = f"{row['successes']} of {row['episodes']} | {row['base_moved_m']:.2f}"
        lines.append(f"| {row['scene']} | {row['distance']:.3f} | {cell(change) or 'none'} | {counts} |")
    return lines


def short(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"
