"""A few edits of three scenes, judged like the two hundred of `make bars BARS=editing`; takes less than a minute."""

from pathlib import Path

from tabletopgen_checks.edits.cases import cases
from tabletopgen_checks.edits.parents import text_parents
from tabletopgen_checks.edits.runs import WRONG, judged
from tabletopgen_checks.edits.simulation import simulate
from tabletopgen_checks.problem import Problem

SCENES, EDITS, SEED = 3, 9, 35


def check(lab: Path, binary: Path, folder: Path, environment: Path) -> str:
    """A line about the sample; a problem if one edit is wrong. `environment` is that of the judges."""
    parents = text_parents(lab, binary, folder, SCENES)
    by_name = {parent.name: parent for parent in parents}
    found = [judged(binary, by_name[case.parent], case, folder / "edits") for case in cases(parents, EDITS, SEED)]
    simulate(environment, [one for one in found if one.bundle])
    if wrong := [f"{one.command}: {'; '.join(one.words)}" for one in found if one.outcome == WRONG]:
        raise Problem("; ".join(wrong))
    return ", ".join(f"{one.case.kind()} {one.outcome}" for one in found)
