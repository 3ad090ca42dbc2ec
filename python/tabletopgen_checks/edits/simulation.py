"""Edited scenes at rest in MuJoCo and without collisions, by the independent judges."""

import shutil
from pathlib import Path

from tabletopgen_checks.edits.runs import RIGHT, WRONG
from tabletopgen_checks.judges.judging import complaints, judge


def simulate(environment: Path, waiting: list):
    """Five seconds of MuJoCo, with the displacement of the certificate; Manifold and FCL search for collisions. A
    bundle with nothing wrong is removed."""
    if not waiting:
        return
    findings = judge(environment, [one.bundle for one in waiting], dss_bar=0.0, only=("mjcf", "collisions"))
    for one in waiting:
        wrong, verdicts = complaints(findings, one.bundle), findings["bundles"][str(one.bundle.resolve())]
        for name, (moved_mm, turned_deg) in verdicts["mjcf"]["facts"].get("unstable", {}).items():
            wrong.append(f"MuJoCo: {name} moves by {moved_mm} mm and {turned_deg} degrees")
        if wrong:
            one.outcome, one.words = WRONG, one.words + wrong
            print(f"   {one.case.name}: {'; '.join(wrong)}", flush=True)
        elif one.outcome == RIGHT:
            shutil.rmtree(one.bundle, ignore_errors=True)
